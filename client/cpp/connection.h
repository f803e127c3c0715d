#pragma once

#include <grpcpp/channel.h>
#include <grpcpp/client_context.h>
#include <grpcpp/support/sync_stream.h>

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "client/cpp/backoff.h"
#include "client/cpp/mesh_replica.h"
#include "client/cpp/types.h"
#include "core/base/result.h"
#include "core/pliant/quality.h"
#include "pliant/v1/job.grpc.pb.h"
#include "pliant/v1/session.grpc.pb.h"

namespace pliant::client {

/// Largest blob that is read, in bytes: no column of the largest mesh that a session may have
/// (2e8 triangles) needs more.
inline constexpr std::int64_t kBlobBytesMax = std::int64_t{1} << 32;

/// One call of Edit.
using EditCall = grpc::ClientReaderWriterInterface<v1::EditRequest, v1::EditResponse>;

/// A channel and its stubs, shared by Client and Session. What a Session does with the world is
/// virtual, so that a simulation can be its network and its clock. *Threads*: any number.
class Connection {
 public:
  Connection(std::string address, const ConnectOptions& options);
  virtual ~Connection() = default;
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  /// Waits for the server and learns who it is. Called once, before anything else.
  Status Handshake();

  /// Begins an edit stream.
  [[nodiscard]] virtual std::unique_ptr<EditCall> Edit(grpc::ClientContext& context) const;
  /// Waits for `time`, or until `wake` is notified and `is_over` says true.
  virtual void Wait(std::unique_lock<std::mutex>& lock, std::condition_variable& wake,
                    std::chrono::milliseconds time, const std::function<bool()>& is_over) const;
  /// After a lost connection: waits until the server is in reach, or until `end`, or cancelled.
  /// gRPC looks at a connection that nobody waits for every 5 s only.
  virtual void LookForServer(std::chrono::steady_clock::time_point end,
                             const std::function<bool()>& is_cancelled) const;

  /// What `attempt` returns, a Result of a call that does no harm twice: made again while the
  /// server is out of reach, for ConnectOptions::reconnect_max at most.
  template <class Attempt>
  [[nodiscard]] auto Persist(const Attempt& attempt) const;

  [[nodiscard]] const std::string& address() const { return address_; }
  [[nodiscard]] const ConnectOptions& options() const { return options_; }
  [[nodiscard]] const ServerInfo& server_info() const { return server_info_; }
  [[nodiscard]] v1::SessionService::Stub& sessions() const { return *sessions_; }

  [[nodiscard]] v1::JobService::Stub& jobs() const { return *jobs_; }

  /// A context for one call, with the token if there is one.
  [[nodiscard]] std::unique_ptr<grpc::ClientContext> NewContext() const;
  /// The same for a call that fails with DEADLINE_EXCEEDED after `timeout`.
  [[nodiscard]] std::unique_ptr<grpc::ClientContext> NewContext(
      std::chrono::milliseconds timeout) const;

  /// Downloads the current mesh.
  Result<MeshReplica> GetMesh(const std::string& session_id, Parts parts);
  Result<Quality> GetQuality(const std::string& session_id);

 protected:
  /// Without a channel: for who brings his own network.
  explicit Connection(const ConnectOptions& options) : options_(options) {}

 private:
  [[nodiscard]] bool WaitForConnected();
  Result<MeshReplica> GetMeshOnce(const std::string& session_id, Parts parts);
  Result<Quality> GetQualityOnce(const std::string& session_id);
  /// Sleeps before the next try. @return false if there is to be none
  [[nodiscard]] bool Pause(Outage& outage) const;

  std::string address_;
  ConnectOptions options_;
  std::shared_ptr<grpc::Channel> channel_;
  std::unique_ptr<v1::SessionService::Stub> sessions_;
  std::unique_ptr<v1::JobService::Stub> jobs_;
  ServerInfo server_info_;
};

/// The error of a call, with the address where the server cannot be reached. @pre !status.ok()
[[nodiscard]] Error CallError(const Connection& connection, const grpc::Status& status);

template <class Attempt>
auto Connection::Persist(const Attempt& attempt) const {
  Outage outage(options_.reconnect_max);
  auto result = attempt();
  while (!result.ok() && result.error().code == ErrorCode::kUnavailable && Pause(outage)) {
    result = attempt();
  }
  return result;
}

}  // namespace pliant::client
