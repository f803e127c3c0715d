#include "server/undo_history.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "core/pliant/remesher.h"

namespace pliant::server {
namespace {

MetricSpec Size(double size) {
  MetricSpec spec;
  spec.source = SizeMetric{std::to_string(size)};
  return spec;
}

// A small square whose metric changes with every revision; hashes[r] is revision r's.
class UndoHistoryTest : public testing::Test {
 protected:
  UndoHistoryTest() {
    const Domain square{.points = {{0, 0}, {1, 0}, {1, 1}, {0, 1}},
                        .segments = {{0, 1, 1}, {1, 2, 2}, {2, 3, 3}, {3, 0, 4}},
                        .holes = {},
                        .regions = {}};
    remesher = Remesher::Create(square, Size(0.3), Options{}).value();
    Commit(nullptr);
  }

  void Commit(UndoHistory* history) {
    EXPECT_TRUE(remesher->Step({}).ok());
    hashes.push_back(remesher->Commit().summary.state_hash);
    auto undo = remesher->TakeUndo();
    if (history != nullptr) history->Add({std::move(undo).value(), nullptr, 0});
  }
  void Update(UndoHistory& history) {
    const double sizes[] = {0.2, 0.25, 0.15, 0.3};
    ASSERT_TRUE(remesher->SetMetric(Size(sizes[hashes.size() % 4])).ok());
    Commit(&history);
  }
  // Whether the chain leads to a revision, and to its very mesh.
  void ExpectLeadsTo(const UndoHistory& history, std::int64_t revision) {
    SCOPED_TRACE(revision);
    const auto bytes = remesher->Save();
    ASSERT_TRUE(bytes.ok());
    const auto copy = Remesher::Load(*bytes).value();
    const auto way = history.WayTo(Revision(revision), remesher->revision());
    ASSERT_TRUE(way.ok()) << way.error().message;
    const auto diff = copy->Apply(way->delta, Revision(99));
    ASSERT_TRUE(diff.ok()) << diff.error().message;
    EXPECT_EQ(diff->summary.state_hash, hashes[static_cast<std::size_t>(revision)]);
  }

  std::unique_ptr<Remesher> remesher;
  std::vector<std::uint64_t> hashes = {0};
};

TEST_F(UndoHistoryTest, LeadsBackToEveryRevisionThatIsKept) {
  UndoHistory history({.bytes_max = 100 << 20, .saved_max = 4});
  for (int i = 0; i < 6; ++i) Update(history);
  for (std::int64_t revision = 1; revision < 7; ++revision) ExpectLeadsTo(history, revision);
  EXPECT_EQ(history.Oldest(Revision(7)), Revision(1));
  EXPECT_EQ(history.WayTo(Revision(9), Revision(7)).error().code, ErrorCode::kRevisionNotFound);
  EXPECT_NE(history.WayTo(Revision(7), Revision(7)).error().message.find("at revision 7 already"),
            std::string::npos);
}

TEST_F(UndoHistoryTest, IsBoundedByBytesAndNamesTheOldest) {
  UndoHistory history({.bytes_max = 40'000, .saved_max = 4});
  for (int i = 0; i < 12; ++i) {
    Update(history);
    EXPECT_LE(history.bytes(), 40'000U);
  }
  const Revision oldest = history.Oldest(Revision(13));
  EXPECT_GT(oldest, Revision(1));
  ExpectLeadsTo(history, static_cast<std::int64_t>(oldest));
  const auto refused = history.WayTo(Revision(1), Revision(13));
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().message.find(std::to_string(static_cast<std::int64_t>(oldest))),
            std::string::npos);
}

TEST_F(UndoHistoryTest, TakesAnotherBound) {
  UndoHistory history({.bytes_max = 100 << 20, .saved_max = 4});
  for (int i = 0; i < 12; ++i) Update(history);
  ASSERT_GT(history.bytes(), 40'000U);
  history.SetBytesMax(40'000);
  Update(history);
  EXPECT_LE(history.bytes(), 40'000U);
}

// Goal: saved revisions outlive the bound; what lies between them is merged away.
TEST_F(UndoHistoryTest, LetsGoOfWhatNobodySaved) {
  UndoHistory history({.bytes_max = 100 << 20, .saved_max = 4});
  for (int i = 0; i < 6; ++i) Update(history);
  EXPECT_TRUE(history.Save(Revision(3), Revision(7)).ok());
  EXPECT_TRUE(history.Save(Revision(7), Revision(7)).ok());
  history.KeepSavedOnly();
  EXPECT_EQ(history.steps().size(), 1U);
  ExpectLeadsTo(history, 3);
  EXPECT_FALSE(history.WayTo(Revision(5), Revision(7)).ok());
  Update(history);
  EXPECT_EQ(history.steps().size(), 2U) << "the bound is what it was";
  EXPECT_TRUE(history.Release({3, 7}).ok());
  history.KeepSavedOnly();
  EXPECT_EQ(history.bytes(), 0U);
}

TEST_F(UndoHistoryTest, KeepsWhatIsSaved) {
  UndoHistory history({.bytes_max = 1, .saved_max = 2});
  EXPECT_TRUE(history.Save(Revision(1), Revision(1)).ok());
  for (int i = 0; i < 5; ++i) Update(history);
  EXPECT_TRUE(history.Save(Revision(6), Revision(6)).ok());
  EXPECT_TRUE(history.Save(Revision(6), Revision(6)).ok()) << "again";
  EXPECT_EQ(history.Save(Revision(1), Revision(6)).ok(), true);
  const std::size_t one_mesh = history.bytes();
  for (int i = 0; i < 20; ++i) Update(history);
  EXPECT_EQ(history.saved(), (std::vector<std::int64_t>{1, 6}));
  ExpectLeadsTo(history, 1);
  ExpectLeadsTo(history, 6);
  EXPECT_FALSE(history.WayTo(Revision(3), Revision(26)).ok());
  EXPECT_LT(history.bytes(), 5 * one_mesh);
  const Error full = history.Save(Revision(26), Revision(26)).error();
  EXPECT_EQ(full.code, ErrorCode::kResourceExhausted);
  EXPECT_EQ(full.retry_after_ms, 0);
  EXPECT_NE(full.message.find("release one, such as revision 1;"), std::string::npos)
      << full.message;
  EXPECT_EQ(history.Save(Revision(3), Revision(26)).error().code, ErrorCode::kRevisionNotFound);

  const Status refused = history.Release({6, 7});
  EXPECT_EQ(refused.error().index, 1);
  EXPECT_EQ(history.saved().size(), 2U);
  EXPECT_TRUE(history.Release({6, 1}).ok());
  EXPECT_EQ(history.bytes(), 0U);
  EXPECT_EQ(history.Oldest(Revision(26)), Revision(26));
}

}  // namespace
}  // namespace pliant::server
