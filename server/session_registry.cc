#include "server/session_registry.h"

#include <array>
#include <cstdio>
#include <utility>

#include "core/base/check.h"

namespace pliant::server {
namespace {

// 48 random bits: no two of a server's sessions meet by chance, and a person can read it out.
std::string RandomId(Rng& rng) {
  std::array<char, 16> text{};
  const int length = std::snprintf(text.data(), text.size(), "s-%012llx",
                                   static_cast<unsigned long long>(rng.Next() >> 16));
  return std::string(text.data(), static_cast<std::size_t>(length));
}

}  // namespace

SessionRegistry::SessionRegistry(std::size_t sessions_max, std::uint64_t seed)
    : sessions_max_(sessions_max), rng_(seed) {}

Result<std::string> SessionRegistry::Reserve(const std::string& wished_id) {
  const std::lock_guard lock(mutex_);
  if (!wished_id.empty() && entries_.contains(wished_id)) {
    return Error{ErrorCode::kSessionExists, "a session " + wished_id + " exists already",
                 "session_id"};
  }
  if (entries_.size() >= sessions_max_) {
    return Error{ErrorCode::kResourceExhausted,
                 "this server has its " + std::to_string(sessions_max_) +
                     " sessions already; delete one or try again later",
                 {}};
  }
  std::string id = wished_id;
  while (id.empty() || entries_.contains(id)) id = RandomId(rng_);
  entries_[id].number = ++last_number_;
  return id;
}

void SessionRegistry::Publish(std::shared_ptr<Session> session) {
  const std::lock_guard lock(mutex_);
  const auto found = entries_.find(session->session_id());
  PLIANT_CHECK(found != entries_.end() && found->second.session == nullptr);
  by_number_[found->second.number] = session;
  found->second.session = std::move(session);
}

std::shared_ptr<Session> SessionRegistry::Remove(const std::string& session_id) {
  const std::lock_guard lock(mutex_);
  const auto found = entries_.find(session_id);
  if (found == entries_.end()) return nullptr;
  std::shared_ptr<Session> session = std::move(found->second.session);
  by_number_.erase(found->second.number);
  entries_.erase(found);
  return session;
}

Result<std::shared_ptr<Session>> SessionRegistry::Find(const std::string& session_id) const {
  const std::lock_guard lock(mutex_);
  const auto found = entries_.find(session_id);
  if (found == entries_.end() || found->second.session == nullptr) {
    return Error{ErrorCode::kSessionNotFound,
                 "there is no session '" + session_id + "'; it may have been deleted",
                 "session_id"};
  }
  return found->second.session;
}

SessionRegistry::Page SessionRegistry::List(std::int64_t after, std::size_t count_max) const {
  const std::lock_guard lock(mutex_);
  Page page;
  for (auto it = by_number_.upper_bound(after); it != by_number_.end(); ++it) {
    if (page.sessions.size() == count_max) return page;
    page.sessions.push_back(it->second);
    page.next = it->first;
  }
  page.next = 0;
  return page;
}

std::vector<std::shared_ptr<Session>> SessionRegistry::All() const {
  const std::lock_guard lock(mutex_);
  std::vector<std::shared_ptr<Session>> sessions;
  sessions.reserve(by_number_.size());
  for (const auto& [number, session] : by_number_) sessions.push_back(session);
  return sessions;
}

}  // namespace pliant::server
