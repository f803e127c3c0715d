#pragma once

#include <grpcpp/client_context.h>

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "client/cpp/backoff.h"
#include "client/cpp/connection.h"
#include "client/cpp/mesh_replica.h"
#include "client/cpp/session.h"
#include "pliant/v1/session.grpc.pb.h"
#include "proto/columns.h"

namespace pliant::client {

/// One edit stream at a time and the replica that it feeds.
///
/// *Invariants*: whatever has no answer yet is kept as it was sent, in order, and the server
/// answers in that order; so a stream that breaks is followed by one on which all of it is sent
/// again. *Threads*: as Session: one for everything but Cancel. `write_mutex_` guards writing to
/// the stream, its existence and what Cancel uses, because that may come from elsewhere.
class Session::Impl {
 public:
  Impl(std::shared_ptr<Connection> connection, std::string session_id, Parts parts);
  ~Impl();

  /// Opens a stream at the replica's revision and reads until the replica is up to date.
  Status Open();
  /// The same for one that the caller has lost: what had no answer is the caller's again.
  Status Reopen();
  /// Ends the stream, if there is one.
  void Close();
  void ForgetReplica() { replica_ = {}; }
  void SetAnswers(Answers answers) { answers_ = answers; }
  /// Reads the answers to all that was sent ahead. In a callback, whose advance does that: nothing.
  Status Await();
  /// Refuses what a callback of a running advance must not do.
  [[nodiscard]] Status CheckFree() const;

  using OnProgress = std::function<void(const AdvanceProgress&)>;
  using OnChange = std::function<void(const MeshDiff&)>;
  /// Makes a command for a stream, whose writer takes the large arrays.
  using MakeRequest = std::function<v1::EditRequest(wire::ColumnWriter&)>;
  Status Update(const MakeRequest& make);
  Status Discard();
  Result<AdvanceReport> Rollback(Revision to_revision);
  Result<AdvanceReport> Advance(const AdvanceOptions& options, const OnProgress& on_progress,
                                const OnChange& on_change);
  void Cancel();

  [[nodiscard]] const std::string& id() const { return session_id_; }
  [[nodiscard]] const MeshReplica& replica() const { return replica_; }
  [[nodiscard]] Connection& connection() const { return *connection_; }
  [[nodiscard]] const MeshDiff& last_change() const { return last_change_; }
  [[nodiscard]] bool is_open() const { return stream_ != nullptr; }

 private:
  /// A command as it was sent: the pieces of its arrays, then itself.
  struct Sent {
    std::int64_t id = 0;
    bool is_ahead = false;  ///< Whoever sent it was told that it is well.
    std::vector<v1::EditRequest> messages;
  };

  Status OpenOnce();
  Result<AdvanceReport> AdvanceWithParts(const AdvanceOptions& options,
                                         const OnProgress& on_progress);
  Result<AdvanceReport> AdvanceOnce(const AdvanceOptions& options, const OnProgress& on_progress);
  /// Sends a command and returns the answer to it.
  Result<v1::EditResponse> Call(const MakeRequest& make, const OnProgress& on_progress);
  Status Send(const MakeRequest& make);
  Status EmptyStage();
  [[nodiscard]] std::int32_t StagedCountAt(const v1::Opened& opened) const;
  Status Write(const Sent& sent);
  Status Write(const v1::EditRequest& request);
  /// A call of the user begins: it has all its time to connect again, and what is left of a step
  /// that was lost is thrown away first.
  Status BeginCall();
  /// Waits before the next try to connect again. @return false if there is to be none
  bool Pause();
  /// Waits, but not for one who has cancelled.
  void Wait(std::chrono::milliseconds time);
  [[nodiscard]] bool is_cancelled();
  /// After the connection has broken: makes it again and repeats what has no answer.
  Status Repeat(Error lost);
  Status RepeatOnce();
  /// Reads on until no more than so many answers are missing, and takes note of refusals.
  Status AwaitAllBut(std::size_t count);
  /// The answer to the oldest command that has none.
  Result<v1::EditResponse> NextAnswer(const OnProgress& on_progress);
  Result<v1::EditResponse> ReadAnswer(const OnProgress& on_progress);
  /// The next message that is not a piece of an array. A broken stream or a damaged message ends
  /// the stream and is the error.
  Result<v1::EditResponse> Read();
  /// Brings the replica forward if the message is a diff or snapshot.
  Status Follow(const v1::EditResponse& response);
  /// Ends the stream without waiting for the server, for `error`.
  Error Abandon(Error error);
  /// Ends a stream that the server has ended, and says why it did.
  Error FinishError();

  std::shared_ptr<Connection> connection_;
  std::string session_id_;
  Parts parts_;
  MeshReplica replica_;
  MeshDiff last_change_;
  std::int64_t last_update_id_ = 0;
  std::int32_t staged_count_ = 0;  ///< As the server last said in an answer.
  std::int32_t staged_left_ = 0;   ///< As it said when the stream was opened...
  bool lost_stage_ = false;        ///< ...and that was not what we had staged.
  bool has_rejection_ = false;     ///< The server has refused an update of this step.
  bool must_discard_ = false;      ///< What is staged is no longer anybody's wish.
  bool tells_loss_ = false;        ///< Reopen has found that the stage is lost; to be said.
  Answers answers_ = Answers::kAtOnce;
  std::deque<Sent> unanswered_;
  std::optional<Error> refusal_;  ///< Of the first update of this step that was sent ahead in vain.
  OnChange on_change_;            ///< Of the running advance, or empty.
  bool advances_ = false;         ///< An advance runs; who calls is one of its callbacks.
  Outage outage_;
  Outage::Clock::time_point opened_at_;

  std::mutex write_mutex_;
  std::int64_t advance_id_ = 0;  ///< Of the running advance; 0: none.
  bool is_cancelled_ = false;    ///< That advance.
  bool is_ready_ = false;        ///< The stream is open: cancel may be sent.
  std::condition_variable cancelled_;
  std::unique_ptr<grpc::ClientContext> context_;
  std::unique_ptr<EditCall> stream_;
  std::unique_ptr<wire::ColumnWriter> writer_;
  std::unique_ptr<wire::ColumnReader> reader_;
};

}  // namespace pliant::client
