#pragma once

#include <grpcpp/channel.h>
#include <grpcpp/client_context.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

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

/// A channel and its stubs, shared by Client and Session. *Threads*: any number.
class Connection {
 public:
  Connection(std::string address, const ConnectOptions& options);

  /// Waits for the server and learns who it is. Called once, before anything else.
  Status Handshake();

  /// After a lost connection: waits until the server is in reach, or until `end`, or cancelled.
  /// gRPC looks at a connection that nobody waits for every 5 s only.
  void LookForServer(std::chrono::steady_clock::time_point end,
                     const std::function<bool()>& is_cancelled) const;

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

 private:
  [[nodiscard]] bool WaitForConnected();

  std::string address_;
  ConnectOptions options_;
  std::shared_ptr<grpc::Channel> channel_;
  std::unique_ptr<v1::SessionService::Stub> sessions_;
  std::unique_ptr<v1::JobService::Stub> jobs_;
  ServerInfo server_info_;
};

/// The error of a call, with the address where the server cannot be reached. @pre !status.ok()
[[nodiscard]] Error CallError(const Connection& connection, const grpc::Status& status);

}  // namespace pliant::client
