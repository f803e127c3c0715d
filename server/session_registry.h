#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
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
  /// @param sessions_max  how many there may be at once.
  /// @param seed          of the ids that it makes up.
  SessionRegistry(std::size_t sessions_max, std::uint64_t seed);

  /// Takes an id; an empty wish gets a new one. Errors: kSessionExists, kResourceExhausted.
  Result<std::string> Reserve(const std::string& wished_id);
  /// Gives a reserved id its session. @pre Reserve gave the id, and neither Publish nor Remove
  /// came.
  void Publish(std::shared_ptr<Session> session);
  /// Frees an id; the session that had it, null if it was only reserved or unknown.
  std::shared_ptr<Session> Remove(const std::string& session_id);

  /// Error: kSessionNotFound.
  Result<std::shared_ptr<Session>> Find(const std::string& session_id) const;

  /// A page of sessions, oldest first, after the one with number `after`; 0: from the start.
  struct Page {
    std::vector<std::shared_ptr<Session>> sessions;
    std::int64_t next = 0;  ///< Number to go on after; 0 if that was the last page.
  };
  [[nodiscard]] Page List(std::int64_t after, std::size_t count_max) const;

  /// All published sessions, oldest first.
  [[nodiscard]] std::vector<std::shared_ptr<Session>> All() const;

 private:
  struct Entry {
    std::int64_t number = 0;
    std::shared_ptr<Session> session;  // Null while reserved.
  };

  const std::size_t sessions_max_;
  mutable std::mutex mutex_;  // Guards all below.
  Rng rng_;
  std::int64_t last_number_ = 0;
  std::map<std::string, Entry> entries_;
  std::map<std::int64_t, std::shared_ptr<Session>> by_number_;  // Published ones.
};

}  // namespace pliant::server
