#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "core/base/result.h"
#include "core/base/rng.h"
#include "server/session.h"

namespace pliant::server {

/// The sessions of a server, by id and by age.
///
/// An id is taken while its session is being built, but the session is found only once it is
/// published, so that nobody sees one that may still fail.
///
/// *Threads*: all functions from any thread. `mutex_` is a leaf lock.
class SessionRegistry {
 public:
  /// How many sessions there may be at once.
  struct Bounds {
    std::size_t sessions_max = 0;
    std::size_t sessions_per_tenant_max = 0;
  };
  /// @param seed  of the ids that it makes up.
  SessionRegistry(const Bounds& bounds, std::uint64_t seed);

  /// Takes an id; an empty wish gets a new one. Errors: kSessionExists, kResourceExhausted.
  Result<std::string> Reserve(const std::string& tenant, const std::string& wished_id);
  /// Gives a reserved id its session. @pre Reserve gave the id, and neither Publish nor Remove
  /// came.
  void Publish(const std::string& tenant, std::shared_ptr<Session> session);
  /// Takes in a session that was stored, whatever the bounds say. @pre its id is not taken
  void Restore(const std::string& tenant, std::shared_ptr<Session> session);
  /// Frees an id; the session that had it, null if it was only reserved or unknown.
  std::shared_ptr<Session> Remove(const std::string& tenant, const std::string& session_id);

  /// Error: kSessionNotFound, also for the session of another tenant.
  Result<std::shared_ptr<Session>> Find(const std::string& tenant,
                                        const std::string& session_id) const;

  /// A page of a tenant's sessions, oldest first, after the one with number `after`; 0: from the
  /// start.
  struct Page {
    std::vector<std::shared_ptr<Session>> sessions;
    std::int64_t next = 0;  ///< Number to go on after; 0 if that was the last page.
  };
  [[nodiscard]] Page List(const std::string& tenant, std::int64_t after,
                          std::size_t count_max) const;

  /// Ends and removes the sessions that nobody has used since `before`, as Session::CloseIfIdle has
  /// it, with this error. @return how many
  std::size_t CloseIdle(Clock::Time before, const Error& error);

  /// All published sessions of all tenants, oldest first.
  [[nodiscard]] std::vector<std::shared_ptr<Session>> All() const;

 private:
  struct Entry {
    std::int64_t number = 0;
    std::shared_ptr<Session> session;  // Null while reserved.
  };

  // Tenant and id.
  using Name = std::pair<std::string, std::string>;

  const Bounds bounds_;
  mutable std::mutex mutex_;  // Guards all below.
  Rng rng_;
  std::int64_t last_number_ = 0;
  std::map<Name, Entry> entries_;
  std::map<std::string, std::size_t> counts_;  // Entries of each tenant.
  std::map<std::string, std::map<std::int64_t, std::shared_ptr<Session>>>
      by_number_;  // Published ones of each tenant.
};

}  // namespace pliant::server
