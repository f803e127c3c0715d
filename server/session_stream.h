#pragma once

#include <grpcpp/grpcpp.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "pliant/v1/edit.pb.h"
#include "server/blobs.h"
#include "server/call_counter.h"
#include "server/convert.h"
#include "server/inbox.h"
#include "server/log.h"
#include "server/outbox.h"
#include "server/session.h"
#include "server/session_registry.h"

namespace pliant::server {

/// One edit stream: the gRPC side of a session's editor. Reads while there is room for commands,
/// writes while there is something to write, and ends when the client has half-closed and every
/// command is answered, or at the first error that is not one update's.
///
/// *Invariants*: one read and one write in flight at most; nothing is started after Finish; the
/// session is free for the next editor before the client can see the end of this stream.
/// *Threads*: gRPC calls the On... functions, a worker the Editor's. `mutex_` guards what is below
/// its declaration; it may be held while Session::mutex_ is taken, never the other way round.
/// gRPC runs callbacks on threads of its own, never inside Start... or Finish, so those are called
/// with the lock held.
class EditStream final : public grpc::ServerBidiReactor<v1::EditRequest, v1::EditResponse>,
                         public Editor,
                         public std::enable_shared_from_this<EditStream> {
 public:
  /// What a stream uses of its server; the pointers outlive it.
  struct Environment {
    const SessionRegistry* registry = nullptr;
    std::optional<std::string> tenant = {};  ///< Of the caller; nothing: refused.
    CallCounter* calls = nullptr;
    const Log* log = nullptr;
    const Clock* clock = nullptr;
    RequestLimits limits = {};
    std::string request_id;
  };
  /// Begins to serve a stream. The result belongs to gRPC until OnDone; sessions may share it.
  static grpc::ServerBidiReactor<v1::EditRequest, v1::EditResponse>* Begin(Environment environment);

  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;

  std::optional<SessionCommand> NextCommand() override;
  void LookAhead(const std::function<bool(const SessionCommand&)>& look) const override;
  void CommandDone() override;
  [[nodiscard]] bool HasRoom() const override;
  void Send(SessionEvent event) override;
  void Close(const Error& error) override;

 private:
  explicit EditStream(Environment environment);
  Result<std::optional<SessionCommand>> Handle(v1::EditRequest& request);
  Result<SessionCommand> HandleOpen(const v1::EditRequest& request);
  void End(grpc::Status status);
  void Pump();
  void Queue(v1::EditResponse response);
  void WakeSession();

  const Environment environment_;

  // Used by OnReadDone alone, of which one runs at a time.
  v1::EditRequest request_;
  BlobAssembler blobs_;
  // Used by Send alone, which one worker at a time calls.
  std::int64_t last_blob_id_ = 0;

  mutable std::mutex mutex_;
  std::shared_ptr<EditStream> self_;  // Keeps this alive until OnDone.
  std::shared_ptr<Session> session_;  // Set once, by the first message.
  WantedParts parts_;                 // Set with it.
  Inbox<SessionCommand> inbox_;
  Outbox<v1::EditResponse> outbox_;
  v1::EditResponse response_;  // The one that is being written.
  int commands_taken_ = 0;     // By the session, and not done.
  bool awaits_room_ = false;   // The session has asked for a command while there was no room.
  bool reading_ = true;        // A read is in flight or being handled.
  bool writing_ = false;
  bool client_is_done_ = false;
  bool finished_ = false;
  std::optional<grpc::Status> end_;  // Set: nothing more is taken or queued.
};

}  // namespace pliant::server
