#include "server/session_journal.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/limits.h"

namespace pliant::server {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

// A journal whose writes are done when the test says so.
class FakeJournal final : public Journal {
 public:
  void Create(Bytes, Bytes, Done done) override { waiting.push_back(std::move(done)); }
  void Append(std::vector<Bytes> records, Bytes, Done done) override {
    counts.push_back(records.size());
    waiting.push_back(std::move(done));
  }
  Result<Contents> Load() override { return Contents{}; }
  void Delete(Done done) override { done({}); }

  void Finish(const Status& status = {}) {
    const Done done = std::move(waiting.front());
    waiting.erase(waiting.begin());
    done(status);
  }

  std::vector<Done> waiting;
  std::vector<std::size_t> counts;
};

class SessionJournalTest : public testing::Test {
 protected:
  SessionJournal Make(Durability durability) {
    return SessionJournal(fake_, durability, [this] { return [this] { ++wake_count_; }; });
  }
  void Hold(SessionJournal& journal, const std::string& name) {
    journal.Hold([this, name](const Status& status) {
      done_.push_back(status.ok() ? name : name + " failed");
    });
  }
  static CommitRecord Commit(int revision) { return {.revision = Revision(revision)}; }
  static Bytes Head() { return {}; }

  const std::shared_ptr<FakeJournal> fake_ = std::make_shared<FakeJournal>();
  int wake_count_ = 0;
  std::vector<std::string> done_;
};

TEST_F(SessionJournalTest, StrictHoldsAnswersUntilTheirRecordsAreDurable) {
  SessionJournal journal = Make(Durability::kStrict);
  Hold(journal, "before");
  journal.Add(SavedRecord{});
  Hold(journal, "saved");
  EXPECT_FALSE(journal.waits()) << "nobody sees what is staged";
  journal.AddCommit(Commit(4));
  Hold(journal, "commit");
  EXPECT_TRUE(journal.waits());
  journal.Submit(Head);
  EXPECT_THAT(fake_->counts, ElementsAre(2u)) << "what gathered goes together";
  EXPECT_THAT(done_, ElementsAre("before"));
  EXPECT_FALSE(journal.Settle().has_value());
  EXPECT_TRUE(journal.waits());

  fake_->Finish();
  EXPECT_EQ(wake_count_, 1);
  EXPECT_EQ(journal.durable_revision(), Revision(4));
  EXPECT_FALSE(journal.Settle().has_value());
  EXPECT_FALSE(journal.waits());
  EXPECT_FALSE(journal.is_clean());
  journal.Release();
  EXPECT_THAT(done_, ElementsAre("before", "saved", "commit"));
  EXPECT_TRUE(journal.is_clean());
}

TEST_F(SessionJournalTest, AnswersKeepTheirOrderAcrossBatches) {
  SessionJournal journal = Make(Durability::kStrict);
  journal.Add(SavedRecord{});
  Hold(journal, "1");
  journal.Submit(Head);
  journal.Submit(Head);
  EXPECT_EQ(fake_->counts.size(), 1u) << "nothing is not written";
  journal.Add(SavedRecord{});
  Hold(journal, "2");
  journal.Submit(Head);
  fake_->Finish();
  EXPECT_FALSE(journal.Settle().has_value());
  journal.Release();
  EXPECT_THAT(done_, ElementsAre("1"));
  Hold(journal, "3");
  fake_->Finish();
  EXPECT_FALSE(journal.Settle().has_value());
  journal.Release();
  EXPECT_THAT(done_, ElementsAre("1", "2", "3"));
}

TEST_F(SessionJournalTest, RelaxedHoldsNothingBackButWaitsBeyondItsBound) {
  SessionJournal journal = Make(Durability::kRelaxed);
  journal.AddCommit(Commit(1));
  Hold(journal, "commit");
  EXPECT_THAT(done_, ElementsAre("commit"));
  EXPECT_FALSE(journal.waits());
  journal.Submit(Head);
  EXPECT_EQ(journal.durable_revision(), Revision::kNone) << "it trails";
  CommitRecord large = Commit(2);
  large.change.emplace<0>(Bytes(kJournalPendingBytesMax - 10'000));
  journal.AddCommit(large);
  EXPECT_FALSE(journal.waits());
  CommitRecord more = Commit(3);
  more.change.emplace<0>(Bytes(10'000));
  journal.AddCommit(more);
  EXPECT_TRUE(journal.waits());
  journal.Submit(Head);
  fake_->Finish();
  fake_->Finish();
  EXPECT_FALSE(journal.Settle().has_value());
  EXPECT_FALSE(journal.waits());
  EXPECT_EQ(journal.durable_revision(), Revision(3));
}

// Goal: when a write fails, so does everything after it, and the session learns it once, when
// nothing is on its way any more.
// Goal: who has to know that something is on disk is told then, and what comes after it in order.
TEST_F(SessionJournalTest, RelaxedCanBeAskedToWait) {
  SessionJournal journal = Make(Durability::kRelaxed);
  const auto hold_until_stored = [&] {
    journal.HoldUntilStored([this](const Status& status) {
      done_.push_back(status.ok() ? "stored" : "stored failed");
    });
  };
  hold_until_stored();
  EXPECT_THAT(done_, ElementsAre("stored")) << "there is nothing to wait for";
  journal.AddCommit(Commit(1));
  hold_until_stored();
  Hold(journal, "later");
  journal.Submit(Head);
  EXPECT_FALSE(journal.Settle().has_value());
  journal.Release();
  EXPECT_EQ(done_.size(), 1U);
  fake_->Finish();
  EXPECT_FALSE(journal.Settle().has_value());
  journal.Release();
  EXPECT_THAT(done_, ElementsAre("stored", "stored", "later"));
}

TEST_F(SessionJournalTest, AFailureTakesEverythingAfterItWithIt) {
  SessionJournal journal = Make(Durability::kStrict);
  journal.Add(SavedRecord{});
  Hold(journal, "1");
  journal.Submit(Head);
  journal.Add(SavedRecord{});
  Hold(journal, "2");
  journal.Submit(Head);
  journal.Add(SavedRecord{});
  Hold(journal, "3");
  fake_->Finish(Error{ErrorCode::kResourceExhausted, "full", {}});
  EXPECT_FALSE(journal.Settle().has_value()) << "one is on its way";
  EXPECT_TRUE(journal.waits());
  journal.Submit(Head);
  EXPECT_EQ(fake_->counts.size(), 2u) << "nothing more is written";
  fake_->Finish(Error{ErrorCode::kInternal, "a gap", {}});
  const std::optional<Error> error = journal.Settle();
  ASSERT_TRUE(error.has_value());
  EXPECT_EQ(error->code, ErrorCode::kResourceExhausted) << "the first one says why";
  EXPECT_THAT(done_, ElementsAre("1 failed", "2 failed", "3 failed"));
  EXPECT_TRUE(journal.is_clean());
  EXPECT_FALSE(journal.Settle().has_value());
  journal.Add(SavedRecord{});
  journal.Submit(Head);
  EXPECT_EQ(fake_->counts.size(), 3u) << "and it goes on";
}

TEST_F(SessionJournalTest, TheEndOfTheSessionFailsWhatIsHeld) {
  SessionJournal journal = Make(Durability::kStrict);
  journal.Create({}, {});
  Hold(journal, "created");
  EXPECT_THAT(done_, IsEmpty());
  journal.Drop({ErrorCode::kSessionNotFound, "deleted", {}});
  EXPECT_THAT(done_, ElementsAre("created failed"));
  journal.SetDurable(Revision(7));
  EXPECT_EQ(journal.durable_revision(), Revision(7));
}

}  // namespace
}  // namespace pliant::server
