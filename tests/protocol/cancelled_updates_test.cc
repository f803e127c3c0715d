// Goal: whatever update is cancelled, and whenever, it is taken over whole or not at all, and the
// session goes on as if it had never come.
// Method: twins on a real server, of which one has its updates cancelled: before they begin, where
// that must work, and at random moments, where either may come.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstdint>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/base/rng.h"
#include "tests/protocol/updates.h"
#include "tests/support/in_process_server.h"
#include "tests/support/mirror.h"
#include "tests/support/seed.h"

namespace pliant::test {
namespace {

v1::EditRequest Limited(Rng& rng) {
  v1::EditRequest request = Size("0.02 + 0.3*abs(x - " + std::to_string(rng.Unit()) + ")");
  v1::MetricLimits& limits = *request.mutable_metric()->mutable_limits();
  limits.set_size_max(0.04);
  limits.set_gradation(rng.Uniform(1.1, 1.4));
  limits.set_smoothing_count(static_cast<std::int32_t>(rng.Below(2)));
  return request;
}

/// Every vertex inside goes a little way.
v1::EditRequest Shake(const Mirror& mirror, Rng& rng) {
  std::vector<std::int32_t> ids;
  std::vector<double> positions;
  for (const auto& [slot, p] : mirror.vertices) {
    if (p[0] <= 0.01 || p[0] >= 0.99 || p[1] <= 0.01 || p[1] >= 0.99) continue;
    if (std::hypot(p[0] - 0.53, p[1] - 0.5) < 0.2) continue;  // There may be a hole.
    ids.push_back(slot);
    positions.push_back(p[0] + rng.Uniform(-1e-4, 1e-4));
    positions.push_back(p[1] + rng.Uniform(-1e-4, 1e-4));
  }
  v1::EditRequest request;
  v1::VertexPositions& vertices = *request.mutable_nodes()->mutable_vertices();
  vertices.set_revision(mirror.revision);
  *vertices.mutable_vertex_ids() = Ints(ids);
  *vertices.mutable_positions() = Doubles(positions, 2);
  return request;
}

v1::EditRequest AnyUpdate(const Mirror& mirror, Rng& rng) {
  switch (rng.Below(5)) {
    case 0:
      return Limited(rng);
    case 1:
      return Tensors(mirror, rng.Uniform(500, 1500));
    case 2:
      return Shake(mirror, rng);
    case 3:
      return SquareWithHole();
    default:
      return Size(std::to_string(rng.Uniform(0.02, 0.03)));
  }
}

/// A session with its one editor, whose mirror follows it.
class Twin {
 public:
  explicit Twin(InProcessServer& server, const std::string& id)
      : edit_(server, Create(server, id)) {
    EXPECT_TRUE(edit_.Next().has_opened());
    Advance();
  }

  void Send(v1::EditRequest request) {
    request.set_update_id(++update_);
    edit_.Send(std::move(request));
  }
  /// @return true if what was sent is accepted; else it was cancelled, and the stage is empty
  bool IsAccepted() {
    const v1::EditResponse answer = edit_.Until(update_).back();
    if (answer.has_accepted()) return true;
    EXPECT_EQ(answer.rejected().error().reason(), "CANCELLED") << answer.ShortDebugString();
    Send(Discard());
    EXPECT_TRUE(edit_.Until(update_).back().has_accepted());
    return false;
  }
  /// Cancels the update that was sent last, or one that is still to come.
  void Cancel(std::int64_t later = 0) {
    v1::EditRequest cancel;
    cancel.mutable_cancel()->set_advance_update_id(update_ + later);
    edit_.Send(cancel);
  }
  void Advance() {
    edit_.Advance(++update_);
    for (const v1::EditResponse& response : edit_.Until(update_)) {
      if (!response.has_diff()) continue;
      EXPECT_EQ(mirror.Apply(response.diff()), "");
    }
  }

  Mirror mirror;

 private:
  static std::string Create(InProcessServer& server, const std::string& id) {
    v1::CreateSession create = UnitSquare("0.02");
    create.set_session_id(id);
    EXPECT_TRUE(server.Create(std::move(create), nullptr).ok());
    return id;
  }

  EditClient edit_;
  std::int64_t update_ = 0;
};

TEST(CancelledUpdates, AreTakenOverWholeOrNotAtAll) {
  InProcessServer server;
  constexpr Seeds kSeeds{.count = 4, .long_count = 400};
  for (const std::uint64_t seed : kSeeds.OfPart(0)) {
    SCOPED_TRACE(Replay(seed, "protocol_tests", "CancelledUpdates.*"));
    Rng rng(seed);
    Twin cancelled(server, "a" + std::to_string(seed));
    Twin undisturbed(server, "b" + std::to_string(seed));
    for (int step = 0; step < 12; ++step) {
      const v1::EditRequest update = AnyUpdate(undisturbed.mirror, rng);
      const bool before = rng.Below(3) == 0;
      const auto wait = std::chrono::microseconds(rng.Below(6'000));
      if (before) cancelled.Cancel(/*later=*/1);
      cancelled.Send(update);
      if (!before) {
        // How far it has come is a matter of luck, and whatever follows from that is right.
        const auto due = std::chrono::steady_clock::now() + wait;
        while (std::chrono::steady_clock::now() < due) std::this_thread::yield();
        cancelled.Cancel();
      }
      const bool accepted = cancelled.IsAccepted();
      SCOPED_TRACE("step " + std::to_string(step) + ": " + update.ShortDebugString().substr(0, 80) +
                   (accepted ? " accepted" : " cancelled"));
      EXPECT_FALSE(before && accepted);
      if (accepted) {
        undisturbed.Send(update);
        EXPECT_TRUE(undisturbed.IsAccepted());
      }
      cancelled.Advance();
      undisturbed.Advance();
      ASSERT_EQ(cancelled.mirror.vertices, undisturbed.mirror.vertices);
      ASSERT_EQ(cancelled.mirror.triangles, undisturbed.mirror.triangles);
      ASSERT_EQ(cancelled.mirror.edges, undisturbed.mirror.edges);
    }
  }
}

}  // namespace
}  // namespace pliant::test
