#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "pliant/v1/edit.pb.h"
#include "server/session_messages.h"

namespace pliant::simulation {

/// What one session has answered, whoever asked: kept beside it, by the rules of proto/README.md
/// alone. Finds a number that has two first answers, a command that is applied twice, a step of
/// which a part is committed, a revision too many or too few, and a rollback that leads elsewhere.
class Ledger {
 public:
  /// A command as the session took it.
  struct Command {
    std::int64_t update_id = 0;
    server::Fingerprint fingerprint = {};
    std::int64_t to_revision = 0;  ///< Of a rollback.
  };

  /// A session that goes on from a revision of another one.
  void BeginAt(std::int64_t revision, std::uint64_t state_hash);

  /// The session has answered; anything but accepted, rejected and advanced is passed over.
  void Answered(const Command& command, const v1::EditResponse& response);
  /// A commit on the way of an advance, or one that a call has made.
  void Saw(std::int64_t revision, std::uint64_t state_hash);

  /// Takes note of what a checker says; the first one counts.
  void Check(const std::string& wrong) {
    if (wrong_.empty()) wrong_ = wrong;
  }
  [[nodiscard]] const std::string& wrong() const { return wrong_; }

  /// Whether an update was staged and not discarded when this revision was committed.
  [[nodiscard]] bool WasCommitted(std::uint64_t update_hash, std::int64_t revision) const;
  /// Whether a revision that was seen has this hash; true for others.
  [[nodiscard]] bool MayHave(std::int64_t revision, std::uint64_t state_hash) const;
  [[nodiscard]] std::int64_t revision() const { return revision_; }
  [[nodiscard]] std::int64_t last_update_id() const { return last_update_id_; }
  /// Numbers that were refused because another command had used them.
  [[nodiscard]] std::int64_t collision_count() const { return collision_count_; }
  [[nodiscard]] std::int64_t repeat_count() const { return repeat_count_; }
  [[nodiscard]] std::int64_t rollback_count() const { return rollback_count_; }
  /// Advances that were answered while their updates were still being staged.
  [[nodiscard]] std::int64_t put_off_count() const { return put_off_count_; }

 private:
  struct First {
    server::Fingerprint fingerprint = {};
    std::string essence = {};
  };

  void AnsweredAgain(const Command& command, const First& first, const v1::EditResponse& response);
  void RefuseNumber(const Command& command);
  void Staging(const Command& command, const v1::EditResponse& response);
  void Committing(const Command& command, const v1::EditResponse& response);

  std::map<std::int64_t, First> first_;  // By the number of the command.
  std::vector<std::uint64_t> staged_;    // Updates, by their hash.
  bool tainted_ = false;                 // One that was to be staged was refused...
  bool step_refused_ = false;            // ...because its number was used, in this stream.
  std::map<std::int64_t, std::vector<std::uint64_t>> committed_;  // Updates by revision.
  std::map<std::int64_t, std::uint64_t> hashes_;                  // Of meshes, by revision.
  std::int64_t revision_ = 0;
  std::int64_t last_update_id_ = 0;
  std::int64_t collision_count_ = 0;
  std::int64_t repeat_count_ = 0;
  std::int64_t rollback_count_ = 0;
  std::int64_t put_off_count_ = 0;
  std::string wrong_;
};

}  // namespace pliant::simulation
