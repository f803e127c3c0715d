#include "tests/simulation/ledger.h"

#include <algorithm>
#include <utility>

#include "tests/protocol/promises.h"

namespace pliant::simulation {
namespace {

using test::Broken;
using test::Text;

// Everything that a repeated answer must say again.
std::string EssenceOf(const v1::EditResponse& response) {
  if (response.has_rejected()) return "rejected " + response.rejected().error().reason();
  if (response.has_advanced()) {
    return "advanced " + Text(response.advanced().revision()) + " " +
           std::to_string(response.advanced().state_hash());
  }
  return "accepted";
}

bool IsRefused(const v1::EditResponse& response, const char* reason) {
  return response.has_rejected() && response.rejected().error().reason() == reason;
}

bool Commits(server::UpdateKind kind) {
  return kind == server::UpdateKind::kAdvance || kind == server::UpdateKind::kRollback;
}

bool Stages(server::UpdateKind kind) {
  return !Commits(kind) && kind != server::UpdateKind::kDiscard;
}

}  // namespace

void Ledger::BeginAt(std::int64_t revision, std::uint64_t state_hash) {
  revision_ = revision;
  hashes_[revision] = state_hash;
}

void Ledger::Answered(const Command& command, const v1::EditResponse& response) {
  if (response.has_opened()) step_refused_ = false;
  if (response.has_diff()) Saw(response.diff().revision(), response.diff().state_hash());
  if (!response.has_accepted() && !response.has_rejected() && !response.has_advanced()) return;
  const auto found = first_.find(command.update_id);
  if (found != first_.end()) return AnsweredAgain(command, found->second, response);
  if (command.update_id <= last_update_id_) {
    if (!IsRefused(response, "PROTOCOL_ORDER")) {
      Check(Broken(test::kOrdered, "number " + Text(command.update_id) + " was taken after " +
                                       Text(last_update_id_)));
    }
    ++collision_count_;
    RefuseNumber(command);
    return;
  }
  last_update_id_ = command.update_id;
  step_refused_ = false;
  first_[command.update_id] = {command.fingerprint, EssenceOf(response)};
  if (Commits(command.fingerprint.kind)) {
    Committing(command, response);
  } else {
    Staging(command, response);
  }
}

// A number that has an answer already.
void Ledger::AnsweredAgain(const Command& command, const First& first,
                           const v1::EditResponse& response) {
  if (command.fingerprint != first.fingerprint) {
    ++collision_count_;
    if (!IsRefused(response, "PROTOCOL_ORDER")) {
      Check(Broken(test::kAtomic, "update " + Text(command.update_id) +
                                      " is another one's and was answered with '" +
                                      EssenceOf(response) + "'"));
    }
    return RefuseNumber(command);
  }
  ++repeat_count_;
  if (command.fingerprint.kind == server::UpdateKind::kAdvance && step_refused_) {
    if (!IsRefused(response, "UPDATE_REJECTED")) {
      Check(Broken(test::kAtomic, "advance " + Text(command.update_id) +
                                      " was answered, but a part of its step was refused"));
    }
    return RefuseNumber(command);
  }
  if (EssenceOf(response) != first.essence) {
    Check(Broken(test::kResumable, "update " + Text(command.update_id) + " was answered with '" +
                                       first.essence + "' and then with '" + EssenceOf(response) +
                                       "'"));
  }
  if (command.fingerprint.kind == server::UpdateKind::kAdvance) step_refused_ = false;
}

// It counts as any other one that is refused: its step is not committed.
void Ledger::RefuseNumber(const Command& command) {
  if (Stages(command.fingerprint.kind)) {
    step_refused_ = step_refused_ || !tainted_;
    tainted_ = true;
  }
  if (command.fingerprint.kind != server::UpdateKind::kAdvance) return;
  if (step_refused_) {
    staged_.clear();
    tainted_ = false;
  }
  step_refused_ = false;
}

void Ledger::Staging(const Command& command, const v1::EditResponse& response) {
  if (command.fingerprint.kind == server::UpdateKind::kDiscard) {
    staged_.clear();
    tainted_ = false;
  } else if (response.has_accepted()) {
    staged_.push_back(command.fingerprint.hash);
  } else {
    tainted_ = true;
  }
}

void Ledger::Committing(const Command& command, const v1::EditResponse& response) {
  const bool is_rollback = command.fingerprint.kind == server::UpdateKind::kRollback;
  if (!response.has_advanced()) {
    // A refused advance empties the stage; a refused rollback leaves it.
    if (!is_rollback) {
      staged_.clear();
      tainted_ = false;
    }
    return;
  }
  const v1::AdvanceResult& advanced = response.advanced();
  const std::string name = "update " + Text(command.update_id);
  if (tainted_ && !is_rollback) {
    Check(Broken(test::kAtomic, name + " committed a step of which a part was refused"));
  }
  const bool is_put_off = advanced.stop_reason() == v1::STOP_REASON_STAGING;
  if (is_put_off) ++put_off_count_;
  if (advanced.base_revision() != revision_ ||
      (is_put_off ? advanced.revision() != revision_ : advanced.revision() <= revision_)) {
    Check(Broken(test::kOrdered, name + " led from " + Text(advanced.base_revision()) + " to " +
                                     Text(advanced.revision()) + ", after revision " +
                                     Text(revision_)));
  }
  if (is_rollback) {
    ++rollback_count_;
    if (!staged_.empty()) Check(Broken(test::kAtomic, name + " went back over what was staged"));
    if (!MayHave(command.to_revision, advanced.state_hash())) {
      Check(Broken(test::kComplete,
                   name + " did not lead back to revision " + Text(command.to_revision)));
    }
  }
  if (is_put_off) {
    if (staged_.empty()) Check(Broken(test::kAtomic, name + " had nothing to wait for"));
    return;
  }
  revision_ = advanced.revision();
  Saw(revision_, advanced.state_hash());
  committed_[revision_] = std::exchange(staged_, {});
}

void Ledger::Saw(std::int64_t revision, std::uint64_t state_hash) {
  if (!MayHave(revision, state_hash)) {
    Check(Broken(test::kOrdered, "there are two revisions " + Text(revision)));
  }
  hashes_[revision] = state_hash;
}

bool Ledger::WasCommitted(std::uint64_t update_hash, std::int64_t revision) const {
  const auto found = committed_.find(revision);
  return found != committed_.end() &&
         std::find(found->second.begin(), found->second.end(), update_hash) != found->second.end();
}

bool Ledger::MayHave(std::int64_t revision, std::uint64_t state_hash) const {
  const auto found = hashes_.find(revision);
  return found == hashes_.end() || found->second == state_hash;
}

}  // namespace pliant::simulation
