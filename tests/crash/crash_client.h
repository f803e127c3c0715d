#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "pliant/v1/edit.pb.h"
#include "pliant/v1/session.grpc.pb.h"
#include "server/blobs.h"
#include "tests/support/mirror.h"

/// Clients of a server that is killed under them, written from proto/README.md alone.
namespace pliant::test {

/// What one editor sends: update k is the same in every run. Commits and only they make revisions,
/// so that an update that is applied twice shows in the number of the next revision.
class CrashScript {
 public:
  explicit CrashScript(std::uint64_t seed) : seed_(seed) {}
  v1::EditRequest Next();

 private:
  std::uint64_t seed_;
  std::int64_t update_id_ = 0;
  std::int64_t commits_ = 0;
};

/// What several clients found wrong; the first few sentences.
class Faults {
 public:
  void Add(const std::string& sentence);
  [[nodiscard]] std::vector<std::string> all() const;
  [[nodiscard]] bool any() const { return count_ > 0; }

 private:
  mutable std::mutex mutex_;  // Guards sentences_.
  std::vector<std::string> sentences_;
  std::atomic<int> count_ = 0;
};

/// One editor: keeps a few updates under way, and after every crash opens its stream again, names
/// its mirror's revision and repeats what was not answered.
class CrashEditor {
 public:
  CrashEditor(std::string address, std::string session_id, std::uint64_t seed, Faults& faults)
      : address_(std::move(address)),
        session_id_(std::move(session_id)),
        script_(seed),
        faults_(faults) {}

  /// Makes the session, however often it takes.
  /// @param durability  what it asks for; the editor counts on STRICT whatever it is
  void Create(const std::atomic<bool>& stop, v1::Durability durability);
  /// Edits until told to stop and everything that was sent is answered, or `updates_max` are.
  void Run(const std::atomic<bool>& stop, std::int64_t updates_max);

  /// The state hash that was acknowledged for each revision.
  [[nodiscard]] const std::map<std::int64_t, std::uint64_t>& hashes() const { return hashes_; }
  [[nodiscard]] std::int64_t answered() const { return answered_; }
  [[nodiscard]] int streams() const { return streams_; }

 private:
  void RunStream(const std::atomic<bool>& stop, std::int64_t updates_max);
  void TakeOpened(const v1::EditResponse& response);
  void TakeAnswer(const v1::EditResponse& response);
  void TakeMesh(const v1::EditResponse& response);
  void Fault(const std::string& what);

  const std::string address_;
  const std::string session_id_;
  CrashScript script_;
  Faults& faults_;
  Mirror mirror_;
  std::deque<v1::EditRequest> unanswered_;
  std::map<std::int64_t, std::uint64_t> hashes_;
  std::atomic<std::int64_t> answered_ = 0;
  std::int64_t sent_ = 0;
  int streams_ = 0;
};

/// One reader that follows a session across crashes; its mirror must never go back.
class CrashSubscriber {
 public:
  CrashSubscriber(std::string address, std::string session_id, Faults& faults)
      : address_(std::move(address)), session_id_(std::move(session_id)), faults_(faults) {}

  void Run(const std::atomic<bool>& stop);

  /// The hash of its mirror at each revision that it had.
  [[nodiscard]] const std::map<std::int64_t, std::uint64_t>& hashes() const { return hashes_; }

 private:
  void RunStream(const std::atomic<bool>& stop);

  const std::string address_;
  const std::string session_id_;
  Faults& faults_;
  Mirror mirror_;
  std::map<std::int64_t, std::uint64_t> hashes_;
};

/// A connection of its own; null if nobody answers within a second.
[[nodiscard]] std::shared_ptr<grpc::Channel> Connect(const std::string& address);

}  // namespace pliant::test
