#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "pliant/v1/edit.pb.h"
#include "tests/support/mirror.h"

/// The promises of proto/README.md that a client can check by what it sees, each with the sentence
/// that stands there and one checker, whose failure is that sentence and what broke it. They know
/// nothing of server or client: they read what came over the wire.
namespace pliant::test {

inline constexpr const char* kOrdered =
    "My mirror gets revisions in the order in which they were made, and none twice.";
inline constexpr const char* kAtomic =
    "What I send as one step takes effect as a whole, in one revision, or not at all.";
inline constexpr const char* kComplete =
    "My mirror gets every revision whole, without gaps, and can prove it by counts and hash.";
inline constexpr const char* kResumable =
    "When my connection breaks I name my last revision and go on; nothing I sent is applied twice.";
inline constexpr const char* kDeterministic =
    "The same input and seed give me the same mesh to the last bit, here and through the server.";
inline constexpr const char* kIsolated =
    "Nobody else's bad input, bug or huge mesh ends, corrupts or endlessly delays my session.";
inline constexpr const char* kBounded =
    "The server's memory for me is bounded, however slowly I read.";

/// What one client sent on a session and what it saw, blobs in place.
struct Transcript {
  std::set<std::int64_t> updates;   ///< update_ids of what was staged...
  std::set<std::int64_t> advances;  ///< ...and of advances.
  std::vector<v1::EditResponse> seen;
};

/// What a session is, beside a bad neighbour or alone.
struct Share {
  std::uint64_t state_hash = 0;
  std::int64_t revision = 0;
  bool ended = false;
};

// Each checker returns nothing, or the promise and what broke it.

inline std::string Broken(const char* promise, const std::string& how) {
  return std::string(promise) + " Broken: " + how;
}

inline std::string Text(std::int64_t number) { return std::to_string(number); }

/// No diff or snapshot leads back or stands still, and `revision` never falls, but in answers that
/// are repeated on another stream: those say what they said first.
inline std::string CheckOrdered(const Transcript& transcript) {
  std::int64_t mirror = 0;
  std::int64_t session = 0;
  int stream_count = 0;
  for (const v1::EditResponse& response : transcript.seen) {
    if (response.has_opened()) ++stream_count;
    const bool may_be_repeated =
        stream_count > 1 &&
        (response.has_accepted() || response.has_rejected() || response.has_advanced());
    if (response.revision() < session && !may_be_repeated) {
      return Broken(kOrdered, "revision " + Text(response.revision()) + " after " + Text(session));
    }
    session = std::max(session, response.revision());
    if (!response.has_diff() && !response.has_snapshot()) continue;
    const std::int64_t next =
        response.has_diff() ? response.diff().revision() : response.snapshot().revision();
    if (next <= mirror) {
      return Broken(kOrdered, "a mirror at " + Text(mirror) + " got revision " + Text(next));
    }
    mirror = next;
  }
  return "";
}

/// Every advance makes exactly one revision, or is refused and makes none; one with a refused
/// update since the advance before is refused.
inline std::string CheckAtomic(const Transcript& transcript) {
  bool step_is_bad = false;
  std::int64_t revision = 0;
  std::map<std::int64_t, int> made;  // Diffs by the revision that they lead to.
  for (const v1::EditResponse& response : transcript.seen) {
    const std::int64_t id = response.update_id();
    if (response.has_opened()) revision = response.revision();
    if (response.has_diff()) ++made[response.diff().revision()];
    if (response.has_rejected() && transcript.updates.contains(id)) step_is_bad = true;
    if (!transcript.advances.contains(id)) continue;
    if (response.has_rejected()) {
      if (response.revision() != revision) {
        return Broken(kAtomic, "advance " + Text(id) + " was refused and made a revision");
      }
      step_is_bad = false;
    } else if (response.has_advanced()) {
      const v1::AdvanceResult& advanced = response.advanced();
      if (step_is_bad) {
        return Broken(kAtomic, "advance " + Text(id) +
                                   " committed a step of which a part was "
                                   "refused");
      }
      // One that was due while its step was being staged commits nothing of it.
      const bool is_staging = advanced.stop_reason() == v1::STOP_REASON_STAGING;
      const std::int64_t next = is_staging ? revision : revision + 1;
      if (advanced.base_revision() != revision || advanced.revision() != next ||
          (!is_staging && made[next] != 1)) {
        return Broken(kAtomic, "advance " + Text(id) + " led from " +
                                   Text(advanced.base_revision()) + " to " +
                                   Text(advanced.revision()) + " with " +
                                   Text(made[advanced.revision()]) + " diffs, after revision " +
                                   Text(revision));
      }
      revision = advanced.revision();
    }
  }
  return "";
}

/// The diffs lead without a gap from nothing to `truth`, each with its counts and hash.
inline std::string CheckComplete(const Transcript& transcript, const Mirror& truth) {
  Mirror mirror;
  for (const v1::EditResponse& response : transcript.seen) {
    std::string wrong;
    if (response.has_diff()) wrong = mirror.Apply(response.diff());
    if (response.has_snapshot()) wrong = mirror.Take(response.snapshot());
    if (!wrong.empty()) return Broken(kComplete, wrong);
  }
  if (!(mirror == truth)) {
    return Broken(kComplete, "the mirror at revision " + Text(mirror.revision) +
                                 " is not the mesh that the server has at " + Text(truth.revision));
  }
  return "";
}

/// A client whose connection broke, and one with the same requests whose did not, end with the same
/// mesh at the same revision.
inline std::string CheckResumable(const Mirror& broken, const Mirror& whole) {
  if (broken.revision != whole.revision) {
    return Broken(kResumable, "revision " + Text(broken.revision) +
                                  " where an unbroken client has " + Text(whole.revision));
  }
  if (!(broken == whole)) return Broken(kResumable, "the mesh is another one");
  return "";
}

/// A session beside a bad neighbour, and alone.
inline std::string CheckIsolated(const Share& beside, const Share& alone) {
  if (beside.ended && !alone.ended) return Broken(kIsolated, "the session has ended");
  if (beside.revision != alone.revision || beside.state_hash != alone.state_hash) {
    return Broken(kIsolated, "the session is not what it would be alone");
  }
  return "";
}

/// Bytes held for one reader.
inline std::string CheckBounded(std::int64_t bytes_held, std::int64_t bytes_max) {
  if (bytes_held <= bytes_max) return "";
  return Broken(kBounded, Text(bytes_held) + " bytes are held; the bound is " + Text(bytes_max));
}

}  // namespace pliant::test
