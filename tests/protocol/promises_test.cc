// Goal: the promises of proto/README.md, seen from a client with nothing but the wire and the real
// engine behind it. A failure prints the promise. Durable comes with the store; Valid, Terminating
// and Bounded have their own tests in tests/core and tests/server besides.
#include "tests/protocol/promises.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "tests/protocol/follow.h"
#include "tests/support/in_process_server.h"
#include "tests/support/mirror.h"
#include "tests/support/subscribe_client.h"

namespace pliant::test {
namespace {

constexpr const char* kLocal =
    "What I pay for an update grows with what I changed, not with the size of my mesh.";
constexpr const char* kStable =
    "What my update did not touch keeps its id, its coordinates to the last bit, and its tag.";
constexpr const char* kValid =
    "Whatever I send, every mesh I get is a proper triangulation of my domain: no inverted "
    "triangle, every boundary and internal line there with its tag.";
constexpr const char* kTerminating =
    "Every advance ends, and tells me whether it converged or how many vertices it left "
    "unfinished.";

// Applies what an advance brought; its result.
v1::AdvanceResult ApplyUntil(EditClient& edit, std::int64_t update_id, Mirror& mirror) {
  v1::AdvanceResult result;
  for (const v1::EditResponse& response : edit.Until(update_id)) {
    if (response.has_diff()) {
      EXPECT_EQ(mirror.Apply(response.diff()), "") << kComplete;
    }
    if (response.has_rejected()) {
      ADD_FAILURE() << response.rejected().error().message();
    }
    if (response.has_advanced()) result = response.advanced();
  }
  EXPECT_EQ(result.revision(), mirror.revision) << kComplete;
  EXPECT_EQ(result.state_hash(), mirror.Hash()) << kComplete;
  return result;
}

void SendTensors(EditClient& edit, std::int64_t update_id, std::int64_t revision,
                 const std::vector<std::int32_t>& ids, const std::vector<double>& tensors) {
  v1::EditRequest request;
  request.set_update_id(update_id);
  v1::VertexMetric& vertices = *request.mutable_metric()->add_sources()->mutable_vertices();
  vertices.set_revision(revision);
  if (!ids.empty()) *vertices.mutable_vertex_ids() = Ints(ids);
  *vertices.mutable_tensors() = Doubles(tensors, 3);
  edit.Send(request);
}

// Signed area of a triangle, twice; the meshes here are far from degenerate.
double TwiceArea(const Mirror& mirror, const std::array<std::int32_t, 4>& t) {
  const auto& a = mirror.vertices.at(t[0]);
  const auto& b = mirror.vertices.at(t[1]);
  const auto& c = mirror.vertices.at(t[2]);
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

// The square, covered once, its four sides there from end to end with their tags.
void ExpectValidUnitSquare(const Mirror& mirror) {
  double area = 0;
  for (const auto& [slot, triangle] : mirror.triangles) {
    EXPECT_GT(TwiceArea(mirror, triangle), 0) << kValid;
    area += TwiceArea(mirror, triangle) / 2;
  }
  EXPECT_NEAR(area, 1, 1e-12) << kValid;
  double length[5] = {};
  for (const auto& [slot, edge] : mirror.edges) {
    ASSERT_TRUE(edge[2] >= 1 && edge[2] <= 4) << kValid;
    const auto& a = mirror.vertices.at(edge[0]);
    const auto& b = mirror.vertices.at(edge[1]);
    length[edge[2]] += std::abs(b[0] - a[0]) + std::abs(b[1] - a[1]);
  }
  for (int side = 1; side <= 4; ++side) EXPECT_NEAR(length[side], 1, 1e-12) << kValid;
}

// Method: expressions, tensors of all and of some vertices, and a background mesh, in turn; after
// each advance the mirror is compared with what GetMesh returns, and must be a valid mesh.
TEST(Promises, OrderedAtomicCompleteAndValid) {
  InProcessServer server;
  std::string id;
  ASSERT_TRUE(server.Create(UnitSquare("0.05"), &id).ok());
  EditClient edit(server, id);
  Mirror mirror;
  edit.Advance(1);
  ApplyUntil(edit, 1, mirror);
  EXPECT_TRUE(mirror == Fetch(server, id)) << kComplete;
  ExpectValidUnitSquare(mirror);

  std::mt19937_64 rng(/*seed=*/2);
  std::int64_t update = 1;
  for (int step = 0; step < 12; ++step) {
    SCOPED_TRACE(step);
    if (step % 3 == 0) {
      edit.Size(++update, "0.03 + 0.1*abs(x - 0." + std::to_string(step) + ")");
    } else if (step % 3 == 1) {
      std::vector<double> tensors;
      for (std::size_t i = 0; i < mirror.vertices.size(); ++i) {
        const double m = 300 + static_cast<double>(rng() % 200);
        tensors.insert(tensors.end(), {m, 0, 2 * m});
      }
      SendTensors(edit, ++update, mirror.revision, {}, tensors);
    } else {
      std::vector<std::int32_t> ids;
      std::vector<double> tensors;
      for (const auto& [slot, position] : mirror.vertices) {
        if (position[0] > 0.3 || position[1] > 0.3) continue;
        ids.push_back(slot);
        tensors.insert(tensors.end(), {2000, 0, 2000});
      }
      SendTensors(edit, ++update, mirror.revision, ids, tensors);
    }
    edit.Advance(++update);
    ApplyUntil(edit, update, mirror);
    EXPECT_TRUE(mirror == Fetch(server, id)) << kComplete;
    ExpectValidUnitSquare(mirror);
  }
  EXPECT_TRUE(edit.Finish().ok());
}

// Method: one subscriber reads everything, one reads now and then, one comes again and again with
// the revision that it had; in the end all three have the editor's mesh.
TEST(Promises, EverySubscriberIsOrderedAtomicAndComplete) {
  InProcessServer server;
  std::string id;
  ASSERT_TRUE(server.Create(UnitSquare("0.05"), &id).ok());
  EditClient edit(server, id);
  SubscribeClient steady(server, id);
  SubscribeClient lazy(server, id);
  Mirror editor;
  Mirror steady_mirror;
  Mirror lazy_mirror;
  Mirror visitor_mirror;
  std::int64_t update = 0;
  for (int step = 0; step < 10; ++step) {
    edit.Size(++update, "0.03 + 0.1*abs(x - 0." + std::to_string(step) + ")");
    edit.Advance(++update);
    ApplyUntil(edit, update, editor);
    EXPECT_EQ(steady.Follow(steady_mirror, editor.revision), "") << kComplete;
    EXPECT_TRUE(steady_mirror == editor) << kComplete;
    if (step % 4 == 3) {
      EXPECT_EQ(lazy.Follow(lazy_mirror, editor.revision), "") << kComplete;
      EXPECT_TRUE(lazy_mirror == editor) << kComplete;
    }
    if (step % 3 == 0) {
      SubscribeClient visitor(server, id, visitor_mirror.revision);
      EXPECT_EQ(visitor.Follow(visitor_mirror, editor.revision), "") << kResumable;
      EXPECT_TRUE(visitor_mirror == editor) << kResumable;
    }
  }
  EXPECT_TRUE(edit.Finish().ok());
}

TEST(Promises, DeterministicHoweverTheWorkIsCut) {
  InProcessServer server;
  std::vector<std::uint64_t> hashes;
  for (const std::int64_t budget : {std::int64_t{0}, std::int64_t{1234}}) {
    std::string id;
    ASSERT_TRUE(server.Create(UnitSquare("0.02 + 0.1*x"), &id).ok());
    EditClient edit(server, id);
    Mirror mirror;
    edit.Advance(1);
    ApplyUntil(edit, 1, mirror);
    edit.Size(2, "0.02 + 0.1*y");
    // The same work in one advance, with progress looked at or not.
    v1::Advance advance;
    if (budget > 0) advance.set_progress_interval_ms(10);
    edit.Advance(3, advance);
    hashes.push_back(ApplyUntil(edit, 3, mirror).state_hash());
  }
  EXPECT_EQ(hashes[0], hashes[1]) << kDeterministic;
}

// Method: the same metric again; then a disc of the same number of vertices gets half its size, in
// a mesh and in one with four times as many vertices: the work must be the same.
TEST(Promises, LocalAndStable) {
  InProcessServer server;
  std::vector<double> visits;
  for (const double size : {0.02, 0.01}) {
    SCOPED_TRACE(size);
    std::string id;
    ASSERT_TRUE(server.Create(UnitSquare(std::to_string(size)), &id).ok());
    EditClient edit(server, id);
    Mirror mirror;
    edit.Advance(1);
    const v1::AdvanceResult built = ApplyUntil(edit, 1, mirror);
    const Mirror before = mirror;

    edit.Size(2, std::to_string(size));
    edit.Advance(3);
    const v1::AdvanceResult same = ApplyUntil(edit, 3, mirror);
    EXPECT_EQ(same.visit_count(), 0) << kLocal;
    EXPECT_EQ(same.state_hash(), built.state_hash()) << kLocal;
    EXPECT_EQ(mirror.vertices, before.vertices) << kStable;

    std::vector<std::int32_t> ids;
    std::vector<double> tensors;
    for (const auto& [slot, position] : mirror.vertices) {
      if (std::hypot(position[0] - 0.5, position[1] - 0.5) > 5 * size) continue;
      ids.push_back(slot);
      tensors.insert(tensors.end(), {4 / (size * size), 0, 4 / (size * size)});
    }
    SendTensors(edit, 4, mirror.revision, ids, tensors);
    edit.Advance(5);
    visits.push_back(static_cast<double>(ApplyUntil(edit, 5, mirror).visit_count()));
    EXPECT_GT(visits.back(), 0);
    std::size_t far = 0;
    for (const auto& [slot, position] : before.vertices) {
      // Twice eight rings of neighbours beyond the disc.
      if (std::hypot(position[0] - 0.5, position[1] - 0.5) < 21 * size) continue;
      ++far;
      ASSERT_TRUE(mirror.vertices.contains(slot)) << kStable;
      EXPECT_EQ(mirror.vertices.at(slot), position) << kStable;
    }
    EXPECT_GT(far, before.vertices.size() / 4);
  }
  EXPECT_LT(visits[1], 1.5 * visits[0]) << kLocal;
}

TEST(Promises, ResumableAfterABrokenConnection) {
  InProcessServer server;
  std::string id;
  ASSERT_TRUE(server.Create(UnitSquare("0.05"), &id).ok());
  Mirror mirror;
  {
    EditClient edit(server, id);
    edit.Advance(1);
    ApplyUntil(edit, 1, mirror);
    edit.Size(2, "0.04");
    edit.Advance(3);
    edit.Until(3);  // Its diff is lost with the connection.
    EXPECT_TRUE(edit.Finish().ok());
  }
  EditClient edit(server, id, mirror.revision);
  EXPECT_EQ(edit.Next().opened().last_update_id(), 3) << kResumable;
  const v1::EditResponse missed = edit.Next();
  ASSERT_TRUE(missed.has_diff()) << kResumable;
  EXPECT_EQ(mirror.Apply(missed.diff()), "") << kResumable;
  edit.Size(2, "0.04");
  EXPECT_TRUE(edit.Until(2).back().has_accepted()) << kResumable;
  edit.Advance(3);
  const v1::EditResponse repeated = edit.Until(3).back();
  EXPECT_EQ(repeated.advanced().revision(), 2) << kResumable;
  EXPECT_EQ(Fetch(server, id).revision, 2) << kResumable;
  edit.Advance(4);
  ApplyUntil(edit, 4, mirror);
  EXPECT_TRUE(mirror == Fetch(server, id)) << kResumable;
}

// Method: a solver goes back a step and takes it again with the same input: the same mesh.
TEST(Promises, DeterministicAfterGoingBack) {
  InProcessServer server;
  std::string id;
  ASSERT_TRUE(server.Create(UnitSquare("0.05"), &id).ok());
  EditClient edit(server, id);
  Mirror mirror;
  edit.Advance(1);
  ApplyUntil(edit, 1, mirror);
  std::vector<std::uint64_t> hashes;
  std::int64_t update = 1;
  for (int time = 0; time < 3; ++time) {
    edit.Size(++update, "0.03 + 0.1*abs(x - 0.3)");
    edit.Advance(++update);
    hashes.push_back(ApplyUntil(edit, update, mirror).state_hash());
    v1::EditRequest rollback;
    rollback.set_update_id(++update);
    rollback.mutable_rollback()->set_to_revision(1);
    edit.Send(rollback);
    ApplyUntil(edit, update, mirror);
  }
  EXPECT_EQ(hashes[0], hashes[1]) << kDeterministic;
  EXPECT_EQ(hashes[0], hashes[2]) << kDeterministic;
}

TEST(Promises, TerminatingWithABudgetAndGoingOnToTheSameEnd) {
  InProcessServer server;
  std::string id;
  ASSERT_TRUE(server.Create(UnitSquare("0.03"), &id).ok());
  EditClient edit(server, id);
  Mirror mirror;
  v1::Advance advance;
  advance.set_budget_visits(500);
  std::int64_t update = 0;
  v1::AdvanceResult result;
  do {
    edit.Advance(++update, advance);
    result = ApplyUntil(edit, update, mirror);
    EXPECT_LE(result.visit_count(), 500) << kTerminating;
    EXPECT_EQ(result.stop_reason() == v1::STOP_REASON_CONVERGED, result.active_count() == 0)
        << kTerminating;
    ExpectValidUnitSquare(mirror);
    ASSERT_LT(update, 1000) << kTerminating;
  } while (result.stop_reason() == v1::STOP_REASON_VISIT_BUDGET);
  EXPECT_EQ(result.stop_reason(), v1::STOP_REASON_CONVERGED) << kTerminating;
  EXPECT_GT(update, 3) << "the budget was not felt";
}

// Method: one session gets every kind of bad input while another one works; both must be as if
// nothing had been.
TEST(Promises, IsolatedFromBadInput) {
  InProcessServer server;
  std::string bad_id;
  std::string good_id;
  ASSERT_TRUE(server.Create(UnitSquare("0.1"), &bad_id).ok());
  ASSERT_TRUE(server.Create(UnitSquare("0.1"), &good_id).ok());
  EditClient bad(server, bad_id);
  EditClient good(server, good_id);
  Mirror bad_mirror;
  Mirror good_mirror;
  bad.Advance(1);
  ApplyUntil(bad, 1, bad_mirror);
  const Mirror before = bad_mirror;

  const auto refusal = [&](std::int64_t update_id) {
    const v1::EditResponse response = bad.Until(update_id).back();
    EXPECT_TRUE(response.has_rejected());
    return response.rejected().error();
  };
  SendTensors(bad, 2, 1, {0, 1}, {1, 0, 1, 1, 2, 1});
  v1::ErrorDetail error = refusal(2);
  EXPECT_EQ(error.reason(), "NOT_POSITIVE_DEFINITE");
  EXPECT_EQ(error.index(), 1);
  SendTensors(bad, 3, 1, {0, 1}, {1, 0, 1, NAN, 0, 1});
  error = refusal(3);
  EXPECT_EQ(error.reason(), "NOT_FINITE");
  EXPECT_EQ(error.index(), 1);
  SendTensors(bad, 4, 1, {0, 1'000'000}, {1, 0, 1, 1, 0, 1});
  error = refusal(4);
  EXPECT_EQ(error.reason(), "INDEX_OUT_OF_RANGE");
  EXPECT_EQ(error.index(), 1);
  SendTensors(bad, 5, 1, {2, 2}, {1, 0, 1, 1, 0, 1});
  EXPECT_EQ(refusal(5).reason(), "DUPLICATE_ID");
  SendTensors(bad, 6, 7, {0}, {1, 0, 1});
  EXPECT_EQ(refusal(6).reason(), "REVISION_MISMATCH");
  SendTensors(bad, 7, 1, {}, {1, 0, 1});
  EXPECT_EQ(refusal(7).reason(), "ARRAY_LENGTH");
  bad.Size(8, "0.1 +");
  EXPECT_EQ(refusal(8).reason(), "EXPRESSION_SYNTAX");
  bad.Size(9, "-1");
  EXPECT_EQ(refusal(9).reason(), "EXPRESSION_VALUE");
  bad.Advance(10);
  EXPECT_EQ(refusal(10).reason(), "UPDATE_REJECTED") << kIsolated;

  good.Advance(1);
  ApplyUntil(good, 1, good_mirror);
  EXPECT_EQ(good_mirror.Hash(), before.Hash()) << kIsolated;
  EXPECT_TRUE(Fetch(server, bad_id) == before) << kIsolated;
  bad.Size(11, "0.08");
  bad.Advance(12);
  ApplyUntil(bad, 12, bad_mirror);
  good.Size(2, "0.08");
  good.Advance(3);
  ApplyUntil(good, 3, good_mirror);
  EXPECT_EQ(good_mirror.Hash(), bad_mirror.Hash()) << kIsolated;
}

TEST(Promises, AnUploadAndADownloadInChunks) {
  // A grid of 70,000 points: every array is larger than one chunk.
  constexpr int kColumns = 280;
  constexpr int kRows = 250;
  std::vector<double> points;
  std::vector<std::int32_t> triangles;
  for (int j = 0; j < kRows; ++j) {
    for (int i = 0; i < kColumns; ++i) points.insert(points.end(), {i * 0.01, j * 0.01});
  }
  for (int j = 0; j + 1 < kRows; ++j) {
    for (int i = 0; i + 1 < kColumns; ++i) {
      const std::int32_t a = j * kColumns + i;
      triangles.insert(triangles.end(),
                       {a, a + 1, a + kColumns + 1, a, a + kColumns + 1, a + kColumns});
    }
  }
  v1::CreateSession create;
  *create.mutable_mesh()->mutable_points() = Doubles(points, 2);
  *create.mutable_mesh()->mutable_triangles() = Ints(triangles, 3);
  create.mutable_metric()->add_sources()->mutable_size()->set_size("0.01");
  InProcessServer server;
  std::string id;
  const grpc::Status status = server.Create(create, &id);
  ASSERT_TRUE(status.ok()) << status.error_message();
  EditClient edit(server, id);
  v1::Advance advance;
  advance.set_budget_visits(1);
  edit.Advance(1, advance);
  Mirror mirror;
  ApplyUntil(edit, 1, mirror);
  EXPECT_GT(edit.chunk_count, 4);
  EXPECT_TRUE(mirror == Fetch(server, id)) << kComplete;
  for (const std::int32_t slot : {0, 12345, 69999}) {
    // The input's points keep their slots; one vertex at most has moved.
    EXPECT_NEAR(mirror.vertices.at(slot)[0], points[2 * static_cast<std::size_t>(slot)], 0.01);
  }
}

TEST(Promises, TensorsOfAnImportedMeshKeepItsTags) {
  InProcessServer server;
  std::string id;
  ASSERT_TRUE(server.Create(TwoTriangles(), &id).ok());
  EditClient edit(server, id);
  edit.Advance(1);
  Mirror mirror;
  ApplyUntil(edit, 1, mirror);
  int tagged_edges = 0;
  for (const auto& [slot, edge] : mirror.edges) tagged_edges += edge[2] == 5;
  EXPECT_GE(tagged_edges, 3) << "the side with tag 5, at a wanted size of 0.2";
  double area_of_region_7 = 0;
  for (const auto& [slot, triangle] : mirror.triangles) {
    if (triangle[3] == 7) area_of_region_7 += TwiceArea(mirror, triangle) / 2;
  }
  EXPECT_NEAR(area_of_region_7, 0.5, 1e-9) << kValid;
}

}  // namespace
}  // namespace pliant::test
