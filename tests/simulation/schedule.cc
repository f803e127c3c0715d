#include "tests/simulation/schedule.h"

#include <algorithm>
#include <utility>

#include "tests/protocol/promises.h"

namespace pliant::simulation {
namespace {

constexpr int kEvents = 400;
constexpr int kLibraryEditors = 2;
constexpr int kFollowers = 2;
constexpr int kForksMax = 1;
constexpr int kFinishTries = 60;
constexpr int kSettleMax = 20'000;

}  // namespace

void Tally::Add(const Tally& other) {
  commits += other.commits;
  refusals += other.refusals;
  reopens += other.reopens;
  deaths += other.deaths;
  repeats += other.repeats;
  collisions += other.collisions;
  rollbacks += other.rollbacks;
  put_off += other.put_off;
  saved += other.saved;
  forks += other.forks;
  unfinished += other.unfinished;
  merged += other.merged;
  snapshots += other.snapshots;
  busy += other.busy;
}

Schedule::Schedule(std::uint64_t seed)
    : rng_(seed), server_(rng_, seed + 1), imitation_(*this), followers_(kFollowers) {
  for (int i = 0; i < kLibraryEditors; ++i) {
    library_.push_back(std::make_unique<LibraryEditor>(*this));
  }
  for (Follower& follower : followers_) follower.place = &server_.places()[rng_.Below(2)];
}

// Editors go first: those of the library end their streams.
Schedule::~Schedule() { library_.clear(); }

std::string Schedule::Run() {
  while (event_count_ < kEvents && wrong_.empty()) Happens();
  if (wrong_.empty()) Settle();
  if (wrong_.empty()) CheckEnd();
  return wrong_;
}

void Schedule::Fail(const std::string& what) {
  if (wrong_.empty()) wrong_ = what;
}

// Somebody waits for something. Beyond the length of the schedule only what helps him happens.
void Schedule::Meanwhile() {
  if (event_count_ < kEvents && !is_settling_) return Happens();
  ++event_count_;
  Deliver();
  imitation_.Receive();
  ServerNotices();
}

void Schedule::Happens() {
  ++event_count_;
  switch (rng_.Below(24)) {
    case 0:
    case 1:
      return imitation_.Act();
    case 2:
    case 3:
    case 4:
      return imitation_.Receive();
    case 5:
    case 6:
    case 7:
      return library_[rng_.Below(library_.size())]->Act();
    case 8:
      return library_[rng_.Below(library_.size())]->Cancel();
    case 9:
      return imitation_.Cancel();
    case 10:
      return LoseConnection();
    case 11:
      return ServerNotices();
    case 12:
      return SomebodyCalls();
    case 13:
    case 14:
      return FollowerActs(followers_[rng_.Below(followers_.size())]);
    default:
      return Deliver();
  }
}

// A message arrives, or the server works.
void Schedule::Deliver() {
  if (!links_.empty() && rng_.Below(2) == 0) {
    server_.Receive(links_[rng_.Below(links_.size())]);
  } else {
    server_.RunOne();
  }
  Fail(server_.wrong());
}

// --- Connections --------------------------------------------------------------------------------

std::shared_ptr<EditLink> Schedule::Connect() {
  return links_.emplace_back(std::make_shared<EditLink>(1 + rng_.Below(6)));
}

// Whatever was on its way is lost.
void Schedule::Leave(const std::shared_ptr<EditLink>& link) {
  if (std::erase(links_, link) == 0) return;
  link->is_lost = true;
  unnoticed_.push_back(link);
  if (is_settling_ || rng_.Below(2) == 0) ServerNotices();
}

void Schedule::LoseConnection() {
  if (links_.empty() || rng_.Below(2) == 0) return;
  ++tally_.deaths;
  const std::size_t index = rng_.Below(links_.size() + 1);
  // The imitation finds out at once; the library when it reads or writes.
  if (index == links_.size()) return imitation_.Lose();
  Leave(std::shared_ptr<EditLink>(links_[index]));
}

void Schedule::ServerNotices() {
  for (const auto& link : std::exchange(unnoticed_, {})) server_.Drop(*link);
}

// --- Callers and subscribers --------------------------------------------------------------------

void Schedule::SomebodyCalls() {
  std::deque<Place>& places = server_.places();
  Place& place = places[rng_.Below(places.size())];
  const std::int64_t revision = place.ledger.revision();
  switch (rng_.Below(8)) {
    case 0:
      if (places.size() < 2 + kForksMax) server_.Fork(place);
      return;
    case 1:
    case 2:
      return server_.Save(place);
    case 3:
      return server_.Release(place);
    default:
      if (revision == 0) return;
      // Not the editor: it takes a number that an editor may have in mind.
      return server_.RollbackTo(
          place, 1 + static_cast<std::int64_t>(rng_.Below(static_cast<std::uint64_t>(revision))),
          place.ledger.last_update_id() + static_cast<std::int64_t>(rng_.Below(2)));
  }
}

void Schedule::FollowerActs(Follower& follower) {
  if (follower.link == nullptr || follower.link->is_dead) {
    follower.link = std::make_shared<SubscribeLink>(follower.place);
    if (!follower.place->session->Subscribe(follower.link, Revision(follower.mirror.revision))
             .ok()) {
      follower.link = nullptr;
    }
  } else if (rng_.Below(8) == 0) {
    follower.place->session->Unsubscribe(follower.link.get());
    follower.link = nullptr;
  } else {
    FollowerReceives(follower);
  }
}

void Schedule::FollowerReceives(Follower& follower) {
  if (follower.link == nullptr || follower.link->down.empty()) return;
  const v1::SubscribeResponse response = std::move(follower.link->down.front());
  follower.link->down.pop_front();
  follower.place->session->WakeForSubscriber();
  const std::int64_t before = follower.mirror.revision;
  std::string wrong;
  if (response.has_diff()) {
    if (response.diff().revision() - response.diff().base_revision() > 1) ++tally_.merged;
    wrong = follower.mirror.Apply(response.diff());
  }
  if (response.has_snapshot()) {
    ++tally_.snapshots;
    wrong = follower.mirror.Take(response.snapshot());
  }
  if (!wrong.empty()) Fail("a subscriber: " + test::Broken(test::kComplete, wrong));
  if (follower.mirror.revision < before) {
    Fail("a subscriber: " + test::Broken(test::kOrdered, "its mirror went back"));
  }
}

// --- The end ------------------------------------------------------------------------------------

// The network is well from now on: everything must be answered.
void Schedule::Settle() {
  is_settling_ = true;
  imitation_.Lose();
  ServerNotices();
  while (server_.RunOne()) {  // Calls that wait, above all.
  }
  for (int tries = 0; !library_.empty() && wrong_.empty(); ++tries) {
    if (tries > kFinishTries) Fail("the client library does not get through any more");
    std::erase_if(library_, [&](const auto& editor) {
      if (!wrong_.empty() || !editor->Finish()) return false;
      Count(*editor);
      return true;
    });
  }
  for (int round = 0; round < kSettleMax && wrong_.empty(); ++round) {
    const bool is_done = imitation_.Finish();
    Deliver();
    ServerNotices();
    for (Follower& follower : followers_) {
      if (follower.link == nullptr || follower.link->is_dead) FollowerActs(follower);
      FollowerReceives(follower);
    }
    if (is_done && AllFollow()) return;
  }
  Fail("the schedule does not settle");
}

bool Schedule::AllFollow() {
  const bool editor_does =
      imitation_.mirror().revision == server_.places().front().ledger.revision();
  return editor_does &&
         std::all_of(followers_.begin(), followers_.end(), [](const Follower& follower) {
           return follower.mirror.revision == follower.place->ledger.revision();
         });
}

void Schedule::CheckEnd() {
  for (const Place& place : server_.places()) {
    const server::SessionInfo info = place.session->info();
    const auto revision = static_cast<std::int64_t>(info.revision);
    if (revision != place.ledger.revision()) {
      Fail(test::Broken(test::kOrdered, "a session is at revision " + test::Text(revision) +
                                            "; its answers said " +
                                            test::Text(place.ledger.revision())));
    }
  }
  const auto hash_of = [](const Place& place) {
    const server::SessionInfo info = place.session->info();
    return info.summary ? info.summary->state_hash : 0;
  };
  const Place& first = server_.places().front();
  if (imitation_.mirror().revision > 0 && imitation_.mirror().Hash() != hash_of(first)) {
    Fail(test::Broken(test::kComplete, "the editor's mirror differs by its hash"));
  }
  Fail(test::CheckOrdered(imitation_.transcript()));
  Fail(test::CheckComplete(imitation_.transcript(), imitation_.mirror()));
  for (const Follower& follower : followers_) {
    if (follower.mirror.revision > 0 && follower.mirror.Hash() != hash_of(*follower.place)) {
      Fail(test::Broken(test::kComplete, "a subscriber's mirror differs by its hash"));
    }
  }
}

void Schedule::Count(const LibraryEditor& editor) {
  tally_.commits += editor.commit_count();
  tally_.refusals += editor.refusal_count();
  tally_.reopens += editor.reopen_count();
}

Tally Schedule::tally() {
  Tally tally = tally_;
  for (const Place& place : server_.places()) {
    tally.repeats += place.ledger.repeat_count();
    tally.collisions += place.ledger.collision_count();
    tally.rollbacks += place.ledger.rollback_count();
    tally.put_off += place.ledger.put_off_count();
  }
  tally.saved = server_.saved_count();
  tally.forks = static_cast<std::int64_t>(server_.places().size()) - 2;
  tally.unfinished += imitation_.unfinished_count();
  tally.merged += imitation_.merged_count();
  tally.snapshots += imitation_.snapshot_count();
  tally.busy += imitation_.busy_count();
  return tally;
}

}  // namespace pliant::simulation
