#include "server/session_registry.h"

#include <array>
#include <cstdio>
#include <utility>

#include "core/base/check.h"
#include "server/limits.h"

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

SessionRegistry::SessionRegistry(const Bounds& bounds, std::uint64_t seed)
    : bounds_(bounds), rng_(seed) {}

Result<std::string> SessionRegistry::Reserve(const std::string& tenant,
                                             const std::string& wished_id) {
  const std::lock_guard lock(mutex_);
  if (!wished_id.empty() && entries_.contains({tenant, wished_id})) {
    return Error{ErrorCode::kSessionExists, "a session " + wished_id + " exists already",
                 "session_id"};
  }
  if (entries_.size() >= bounds_.sessions_max) {
    return Error{.code = ErrorCode::kResourceExhausted,
                 .message = "this server has its " + std::to_string(bounds_.sessions_max) +
                            " sessions already; delete one or try again later",
                 .retry_after_ms = kSessionRetryMs};
  }
  std::size_t& count = counts_[tenant];
  if (count >= bounds_.sessions_per_tenant_max) {
    return Error{ErrorCode::kResourceExhausted,
                 "you have your " + std::to_string(bounds_.sessions_per_tenant_max) +
                     " sessions already: delete one; waiting frees none",
                 {}};
  }
  ++count;
  std::string id = wished_id;
  while (id.empty() || entries_.contains({tenant, id})) id = RandomId(rng_);
  entries_[{tenant, id}].number = ++last_number_;
  return id;
}

void SessionRegistry::Restore(const std::string& tenant, std::shared_ptr<Session> session) {
  {
    const std::lock_guard lock(mutex_);
    ++counts_[tenant];
    entries_[{tenant, session->session_id()}].number = ++last_number_;
  }
  Publish(tenant, std::move(session));
}

void SessionRegistry::Publish(const std::string& tenant, std::shared_ptr<Session> session) {
  const std::lock_guard lock(mutex_);
  const auto found = entries_.find({tenant, session->session_id()});
  PLIANT_CHECK(found != entries_.end() && found->second.session == nullptr);
  by_number_[tenant][found->second.number] = session;
  found->second.session = std::move(session);
}

std::shared_ptr<Session> SessionRegistry::Remove(const std::string& tenant,
                                                 const std::string& session_id) {
  const std::lock_guard lock(mutex_);
  const auto found = entries_.find({tenant, session_id});
  if (found == entries_.end()) return nullptr;
  std::shared_ptr<Session> session = std::move(found->second.session);
  by_number_[tenant].erase(found->second.number);
  entries_.erase(found);
  --counts_[tenant];
  return session;
}

Result<std::shared_ptr<Session>> SessionRegistry::Find(const std::string& tenant,
                                                       const std::string& session_id) const {
  const std::lock_guard lock(mutex_);
  const auto found = entries_.find({tenant, session_id});
  if (found == entries_.end() || found->second.session == nullptr) {
    return Error{ErrorCode::kSessionNotFound,
                 "there is no session '" + session_id + "'; it may have been deleted",
                 "session_id"};
  }
  return found->second.session;
}

SessionRegistry::Page SessionRegistry::List(const std::string& tenant, std::int64_t after,
                                            std::size_t count_max) const {
  const std::lock_guard lock(mutex_);
  Page page;
  const auto own = by_number_.find(tenant);
  if (own == by_number_.end()) return page;
  for (auto it = own->second.upper_bound(after); it != own->second.end(); ++it) {
    if (page.sessions.size() == count_max) return page;
    page.sessions.push_back(it->second);
    page.next = it->first;
  }
  page.next = 0;
  return page;
}

std::size_t SessionRegistry::CloseIdle(Clock::Time before, const Error& error) {
  std::vector<std::pair<std::string, std::shared_ptr<Session>>> published;
  {
    const std::lock_guard lock(mutex_);
    for (const auto& [name, entry] : entries_) {
      if (entry.session != nullptr) published.emplace_back(name.first, entry.session);
    }
  }
  std::size_t closed = 0;
  for (const auto& [tenant, session] : published) {
    if (!session->CloseIfIdle(before, error)) continue;
    Remove(tenant, session->session_id());
    ++closed;
  }
  return closed;
}

std::vector<std::shared_ptr<Session>> SessionRegistry::All() const {
  const std::lock_guard lock(mutex_);
  std::map<std::int64_t, std::shared_ptr<Session>> all;
  for (const auto& [tenant, own] : by_number_) all.insert(own.begin(), own.end());
  std::vector<std::shared_ptr<Session>> sessions;
  sessions.reserve(all.size());
  for (const auto& [number, session] : all) sessions.push_back(session);
  return sessions;
}

}  // namespace pliant::server
