// Goal: a frozen thing is never changed, seen from a client with nothing but the wire; and the
// other words of constraints and options: staged with a step or not at all, undone by a rollback.
#include <gtest/gtest.h>

#include <map>
#include <string>
#include <vector>

#include "tests/support/in_process_server.h"
#include "tests/support/mirror.h"

namespace pliant::test {
namespace {

/// An editor and its mirror, with the calls that these tests make.
class ConstrainedEditor {
 public:
  ConstrainedEditor(InProcessServer& server, const std::string& id) : edit_(server, id) {}

  v1::AdvanceResult Advance() {
    edit_.Advance(++update_);
    return Apply();
  }
  void Size(const std::string& size) { edit_.Size(++update_, size); }
  /// The reason of the refusal; empty if there was none.
  std::string Constrain(const v1::ConstraintUpdate& constraints) {
    v1::EditRequest request;
    *request.mutable_constraints() = constraints;
    return SendAndHear(request);
  }
  std::string SetOptions(const v1::SessionOptions& options) {
    v1::EditRequest request;
    *request.mutable_options() = options;
    return SendAndHear(request);
  }
  std::string MoveTag(std::int32_t tag, double x) {
    v1::EditRequest request;
    v1::TagMotion& motion = *request.mutable_boundary()->add_tags();
    motion.add_tags(tag);
    motion.mutable_translation()->set_x(x);
    return SendAndHear(request);
  }
  v1::AdvanceResult RollBack(std::int64_t to_revision) {
    v1::EditRequest request;
    request.mutable_rollback()->set_to_revision(to_revision);
    request.set_update_id(++update_);
    edit_.Send(request);
    return Apply();
  }
  [[nodiscard]] const Mirror& mirror() const { return mirror_; }

 private:
  std::string SendAndHear(v1::EditRequest& request) {
    request.set_update_id(++update_);
    edit_.Send(request);
    const v1::EditResponse answer = edit_.Until(update_).back();
    return answer.has_rejected() ? answer.rejected().error().reason() : "";
  }
  v1::AdvanceResult Apply() {
    v1::AdvanceResult result;
    for (const v1::EditResponse& response : edit_.Until(update_)) {
      if (response.has_diff()) {
        EXPECT_EQ(mirror_.Apply(response.diff()), "");
      }
      if (response.has_advanced()) result = response.advanced();
    }
    return result;
  }

  EditClient edit_;
  Mirror mirror_;
  std::int64_t update_ = 0;
};

/// Two rooms with tags 1 and 2, left and right of x = 0.5; the wall between them has tag 9.
v1::CreateSession TwoRooms(const std::string& size) {
  v1::CreateSession create;
  v1::Domain& domain = *create.mutable_domain();
  *domain.mutable_points() = Doubles({0, 0, 0.5, 0, 1, 0, 1, 1, 0.5, 1, 0, 1}, 2);
  *domain.mutable_segments() = Ints({0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5, 0, 1, 4}, 2);
  *domain.mutable_segment_tags() = Ints({1, 1, 2, 3, 3, 4, 9});
  *domain.mutable_region_points() = Doubles({0.25, 0.5, 0.75, 0.5}, 2);
  *domain.mutable_region_tags() = Ints({1, 2});
  create.mutable_metric()->add_sources()->mutable_size()->set_size(size);
  return create;
}

/// Everything of a mirror that lies in the right room, to the last bit.
struct RightRoom {
  explicit RightRoom(const Mirror& mirror) {
    for (const auto& [slot, triangle] : mirror.triangles) {
      if (triangle[3] != 2) continue;
      triangles.emplace(slot, triangle);
      for (std::size_t k = 0; k < 3; ++k) {
        vertices.emplace(triangle[k], mirror.vertices.at(triangle[k]));
      }
    }
  }
  bool operator==(const RightRoom&) const = default;
  std::map<std::int32_t, std::array<std::int32_t, 4>> triangles;
  std::map<std::int32_t, std::array<double, 2>> vertices;
};

class ConstraintsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const grpc::Status status = server_.Create(TwoRooms("0.2"), &id_);
    ASSERT_TRUE(status.ok()) << status.error_message();
  }
  InProcessServer server_;
  std::string id_;
};

TEST_F(ConstraintsTest, AFrozenRegionIsNeverChangedAndItsCostIsReported) {
  ConstrainedEditor editor(server_, id_);
  editor.Advance();
  v1::ConstraintUpdate frozen;
  frozen.add_frozen_regions(2);
  EXPECT_EQ(editor.Constrain(frozen), "");
  const RightRoom before(editor.mirror());
  ASSERT_GT(before.triangles.size(), 20U);
  v1::AdvanceResult result;
  for (const char* size : {"0.05", "0.3", "0.04+0.2*y"}) {
    editor.Size(size);
    result = editor.Advance();
    EXPECT_EQ(result.stop_reason(), v1::STOP_REASON_CONVERGED);
    EXPECT_TRUE(RightRoom(editor.mirror()) == before)
        << "A frozen thing is never changed, and what that costs in quality is reported.";
  }
  ASSERT_GT(result.troubles_size(), 0);
  EXPECT_EQ(result.troubles(0).kind(), v1::TROUBLE_KIND_FROZEN);
  EXPECT_GT(result.troubles(0).q_min(), 0);
  EXPECT_GE(result.troubles(0).vertex_count(), 3) << "corners of one triangle at least";

  EXPECT_EQ(editor.Constrain({}), "");
  result = editor.Advance();
  EXPECT_EQ(result.troubles_size(), 0);
  EXPECT_FALSE(RightRoom(editor.mirror()) == before) << "it may change again";
}

TEST_F(ConstraintsTest, AFrozenWallIsNotMovedAndTheRefusalLeavesTheSessionAsItWas) {
  ConstrainedEditor editor(server_, id_);
  editor.Advance();
  std::vector<std::int32_t> wall;
  for (const auto& [slot, edge] : editor.mirror().edges) {
    if (edge[2] == 9) wall.push_back(slot);
  }
  v1::ConstraintUpdate frozen;
  *frozen.mutable_frozen_edges() = Ints(wall);
  EXPECT_EQ(editor.Constrain(frozen), "REVISION_MISMATCH") << "of which revision?";
  frozen.set_revision(1);
  editor.Advance();  // Refused, because of the update before; empties the stage.
  EXPECT_EQ(editor.Constrain(frozen), "");
  EXPECT_EQ(editor.Advance().revision(), 2);
  EXPECT_EQ(editor.MoveTag(9, 0.1), "FROZEN");
  EXPECT_EQ(editor.Advance().revision(), 0) << "the step was refused as a whole";
  const Mirror before = editor.mirror();
  EXPECT_EQ(editor.Advance().state_hash(), before.Hash());
}

TEST_F(ConstraintsTest, ConstraintsAndOptionsGoBackWithTheRevision) {
  ConstrainedEditor editor(server_, id_);
  editor.Advance();
  v1::ConstraintUpdate frozen;
  frozen.add_restrictions(v1::RESTRICTION_NO_INSERT);
  EXPECT_EQ(editor.Constrain(frozen), "");
  v1::SessionOptions options;
  options.set_metric_tolerance(0.9);
  EXPECT_EQ(editor.SetOptions(options), "");
  editor.Size("0.1");
  v1::AdvanceResult result = editor.Advance();
  EXPECT_EQ(result.insertion_count() + result.deletion_count(), 0);
  editor.RollBack(1);
  editor.Size("0.1");
  EXPECT_GT(editor.Advance().insertion_count(), 50);
}

TEST_F(ConstraintsTest, SeedAndVariantStay) {
  ConstrainedEditor editor(server_, id_);
  v1::SessionOptions options;
  options.set_seed(12);
  EXPECT_EQ(editor.SetOptions(options), "PROTOCOL_ORDER");
}

}  // namespace
}  // namespace pliant::test
