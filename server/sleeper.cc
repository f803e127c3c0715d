#include "server/sleeper.h"

#include <algorithm>
#include <utility>

#include "core/base/freed_memory.h"

namespace pliant::server {
namespace {

constexpr std::chrono::seconds kInterval{1};
/// Between two glances at what the process holds, which cost microseconds.
constexpr std::chrono::milliseconds kGlanceInterval{100};
/// Share of the limit that is freed besides, where it was exceeded: the choice looks at every
/// session, so that it should be made once for many that grow.
constexpr std::int64_t kSpareShare = 16;

/// Share of the limit that is left to what comes between two measurements: sessions that wake and
/// grow, and the holes that they leave in the allocator's memory.
constexpr std::int64_t kMarginShare = 4;
/// Share of the limit within which the process is so near to it that it does not wait for the next
/// measurement.
constexpr std::int64_t kNearShare = 8;

std::int64_t UsableOf(const Sleeper::Policy& policy) {
  const std::int64_t limit = policy.memory_bytes_max;
  return policy.resident ? limit - limit / kMarginShare : limit;
}

}  // namespace

Sleeper::Sleeper(const Policy& policy, const SessionRegistry& registry, const Clock& clock)
    : policy_(policy), registry_(registry), clock_(clock), budget_(UsableOf(policy), [this] {
        {
          const std::lock_guard lock(mutex_);
          is_over_ = true;
        }
        wake_.notify_all();
      }) {}

void Sleeper::Start() {
  thread_ = std::thread([this] { Work(); });
}

Sleeper::~Sleeper() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_all();
  if (thread_.joinable()) thread_.join();
}

std::vector<std::shared_ptr<Session>> Sleeper::Choose() const {
  std::vector<std::pair<Session::Rest, std::shared_ptr<Session>>> awake;
  for (std::shared_ptr<Session>& session : registry_.All()) {
    const Session::Rest usage = session->rest();
    if (usage.may_sleep) awake.emplace_back(usage, std::move(session));
  }
  std::stable_sort(awake.begin(), awake.end(), [](const auto& a, const auto& b) {
    return a.first.last_used < b.first.last_used;
  });
  std::vector<std::shared_ptr<Session>> chosen;
  std::int64_t excess = budget_.excess();
  if (excess > 0) excess += policy_.memory_bytes_max / kSpareShare;
  const Clock::Time now = clock_.Now();
  for (auto& [usage, session] : awake) {
    const bool is_idle = policy_.idle_max.count() > 0 && now - usage.last_used >= policy_.idle_max;
    if (!is_idle && excess <= 0) break;
    excess -= usage.bytes;
    chosen.push_back(std::move(session));
  }
  return chosen;
}

void Sleeper::Measure() {
  if (!policy_.resident) return;
  budget_.SetBesides(std::max<std::int64_t>(policy_.resident() - budget_.used(), 0));
}

bool Sleeper::IsNearLimit() const {
  const std::int64_t limit = policy_.memory_bytes_max;
  return limit > 0 && policy_.resident && policy_.resident() > limit - limit / kNearShare;
}

void Sleeper::Look() {
  // What was chosen before sleeps by now, or nearly. It is no reason to send more to sleep as long
  // as the allocator has it.
  if (has_freed_) {
    ReturnFreedMemory();
    has_freed_ = false;
  }
  Measure();
  SendToSleep();
}

void Sleeper::SendToSleep() {
  for (const std::shared_ptr<Session>& session : Choose()) {
    session->RequestSleep();
    has_freed_ = true;
  }
}

void Sleeper::Work() {
  std::unique_lock lock(mutex_);
  Clock::Time looked{};
  while (!stopping_) {
    wake_.wait_for(lock, kGlanceInterval, [this] { return stopping_ || is_over_; });
    if (stopping_) return;
    const bool is_over = std::exchange(is_over_, false);
    lock.unlock();
    const Clock::Time now = clock_.Now();
    // Seldom, because it goes through all memory and all sessions.
    if (now - looked >= (IsNearLimit() ? kGlanceInterval : kInterval)) {
      Look();
      looked = now;
    } else if (is_over) {
      SendToSleep();
    }
    lock.lock();
  }
}

}  // namespace pliant::server
