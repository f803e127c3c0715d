#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "client/cpp/session.h"
#include "core/base/result.h"
#include "tests/simulation/world.h"

namespace pliant::simulation {

/// An editor that uses the client library as it is: client::Session, whose network and clock are
/// the schedule's. A call of it waits by letting the rest of the world go on, other editors too.
class LibraryEditor {
 public:
  explicit LibraryEditor(World& world);
  ~LibraryEditor();
  LibraryEditor(const LibraryEditor&) = delete;
  LibraryEditor& operator=(const LibraryEditor&) = delete;

  /// Does something at random; nothing while a call of it waits.
  void Act();
  /// Ends the call that waits, as another thread would.
  void Cancel();
  /// Takes up its session, commits, compares meshes and lets go of it. @return false if it has to
  /// be tried again: the session may have another editor, or the number be used.
  bool Finish();

  /// What the network tells: an update is on its way.
  void Sent(std::uint64_t update_hash) { sent_hash_ = update_hash; }

  [[nodiscard]] std::int64_t commit_count() const { return commit_count_; }
  [[nodiscard]] std::int64_t refusal_count() const { return refusal_count_; }
  [[nodiscard]] std::int64_t reopen_count() const { return reopen_count_; }

 private:
  void ActOnce();
  void Open();
  void Close();
  void Reopen();
  void Update();
  void Advance();
  void Discard();
  void Rollback();
  Status StageSomething();
  /// What a call has said; the session is to be opened again if its stream is gone.
  void Note(const Error& error);
  void CheckCommit(const client::AdvanceReport& report);
  void CheckReplica();

  World& world_;
  Place* place_ = nullptr;
  std::unique_ptr<client::Session> session_;
  client::Answers answers_ = client::Answers::kAtOnce;
  bool waits_ = false;    ///< In a call of the session.
  bool is_lost_ = false;  ///< Its stream: Reopen comes next.
  std::uint64_t sent_hash_ = 0;
  std::vector<std::uint64_t> staged_;  ///< What the library said was accepted, or will see to.
  bool has_refusal_ = false;           ///< One of this step was not.
  std::int64_t commit_count_ = 0;
  std::int64_t refusal_count_ = 0;
  std::int64_t reopen_count_ = 0;
};

}  // namespace pliant::simulation
