#pragma once

#include <grpcpp/client_context.h>
#include <grpcpp/support/sync_stream.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>

#include "client/cpp/connection.h"
#include "client/cpp/mesh_replica.h"
#include "client/cpp/session.h"
#include "pliant/v1/session.grpc.pb.h"
#include "proto/columns.h"

namespace pliant::client {

/// One edit stream at a time and the replica that it feeds.
///
/// *Threads*: as Session: one for everything but Cancel. `write_mutex_` guards writing to the
/// stream, its existence and `advance_id_`, because Cancel may come from elsewhere.
class Session::Impl {
 public:
  Impl(std::shared_ptr<Connection> connection, std::string session_id, Parts parts);
  ~Impl();

  /// Opens a stream at the replica's revision and reads until the replica is up to date.
  Status Open();
  /// Ends the stream, if there is one.
  void Close();
  void ForgetReplica() { replica_ = {}; }

  using OnProgress = std::function<void(const AdvanceProgress&)>;
  /// Makes a command for a stream, whose writer takes the large arrays.
  using MakeRequest = std::function<v1::EditRequest(wire::ColumnWriter&)>;
  Status Update(const MakeRequest& make);
  Result<AdvanceReport> Rollback(Revision to_revision);
  Result<AdvanceReport> Advance(const AdvanceOptions& options, const OnProgress& on_progress);
  void Cancel();

  [[nodiscard]] const std::string& id() const { return session_id_; }
  [[nodiscard]] const MeshReplica& replica() const { return replica_; }
  [[nodiscard]] Connection& connection() const { return *connection_; }
  [[nodiscard]] const MeshDiff& last_change() const { return last_change_; }
  [[nodiscard]] bool is_open() const { return stream_ != nullptr; }

 private:
  Status OpenOnce();
  Result<v1::EditResponse> Call(const MakeRequest& make, const OnProgress& on_progress);
  Result<v1::EditResponse> CallOnce(std::int64_t id, const MakeRequest& make,
                                    const OnProgress& on_progress);
  Status Write(const v1::EditRequest& request);
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
  std::int32_t staged_count_ = 0;  ///< As the server last said.
  bool lost_stage_ = false;        ///< When the stream was opened, the server had less.

  std::mutex write_mutex_;
  std::int64_t advance_id_ = 0;  ///< Of the running advance; 0: none.
  std::unique_ptr<grpc::ClientContext> context_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::EditRequest, v1::EditResponse>> stream_;
  std::unique_ptr<wire::ColumnWriter> writer_;
  std::unique_ptr<wire::ColumnReader> reader_;
};

}  // namespace pliant::client
