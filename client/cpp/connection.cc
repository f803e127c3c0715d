#include "client/cpp/connection.h"

#include <grpcpp/create_channel.h>
#include <grpcpp/security/credentials.h>
#include <grpcpp/support/channel_arguments.h>

#include <algorithm>
#include <climits>
#include <thread>
#include <utility>

#include "client/cpp/convert.h"
#include "client/cpp/download.h"
#include "client/cpp/grpc_error.h"

namespace pliant::client {
namespace {

std::shared_ptr<grpc::ChannelCredentials> CredentialsOf(const ConnectOptions& options) {
  if (options.tls_roots.empty()) return grpc::InsecureChannelCredentials();
  return grpc::SslCredentials({.pem_root_certs = options.tls_roots,
                               .pem_private_key = options.tls_key,
                               .pem_cert_chain = options.tls_cert});
}

std::shared_ptr<grpc::Channel> MakeChannel(const std::string& address,
                                           const ConnectOptions& options) {
  grpc::ChannelArguments arguments;
  // A proxy for the web, set in the environment, is not meant for a server on this machine.
  arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
  // A server that is restarted is found again within a second, not after minutes.
  arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, 100);
  arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, 1000);
  // A machine that dies, or a firewall that forgets, closes no connection: it just says no more.
  const auto milliseconds = [](std::chrono::milliseconds time) {
    return static_cast<int>(std::min<std::int64_t>(time.count(), INT_MAX));
  };
  if (options.keepalive_interval.count() > 0) {
    arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, milliseconds(options.keepalive_interval));
    arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, milliseconds(options.keepalive_timeout));
    // Else it would stop asking after two times, while an advance runs in silence.
    arguments.SetInt(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);
  }
  return grpc::CreateCustomChannel(address, CredentialsOf(options), arguments);
}

}  // namespace

Connection::Connection(std::string address, const ConnectOptions& options)
    : address_(std::move(address)),
      options_(options),
      channel_(MakeChannel(address_, options_)),
      sessions_(v1::SessionService::NewStub(channel_)),
      jobs_(v1::JobService::NewStub(channel_)) {}

Status Connection::Handshake() {
  if (!WaitForConnected()) {
    return Error{.code = ErrorCode::kUnavailable,
                 .message = "no server answers at " + address_ +
                            "; check the address and that pliantd runs there",
                 .field = "address"};
  }
  const auto context = NewContext(options_.connect_timeout);
  v1::GetServerInfoResponse response;
  const auto status =
      v1::ServerService::NewStub(channel_)->GetServerInfo(context.get(), {}, &response);
  if (!status.ok()) return CallError(*this, status);
  server_info_.version = response.version();
  server_info_.capabilities.assign(response.capabilities().begin(), response.capabilities().end());
  for (const auto& [name, value] : response.limits()) server_info_.limits.emplace(name, value);
  return {};
}

/// Unlike grpc's own, not waiting on where nobody listens: a person wants to know at once.
bool Connection::WaitForConnected() {
  const auto deadline = std::chrono::system_clock::now() + options_.connect_timeout;
  while (true) {
    const grpc_connectivity_state state = channel_->GetState(/*try_to_connect=*/true);
    if (state == GRPC_CHANNEL_READY) return true;
    if (state == GRPC_CHANNEL_TRANSIENT_FAILURE || state == GRPC_CHANNEL_SHUTDOWN) return false;
    if (!channel_->WaitForStateChange(state, deadline)) return false;
  }
}

std::unique_ptr<EditCall> Connection::Edit(grpc::ClientContext& context) const {
  return sessions_->Edit(&context);
}

void Connection::Wait(std::unique_lock<std::mutex>& lock, std::condition_variable& wake,
                      std::chrono::milliseconds time, const std::function<bool()>& is_over) const {
  wake.wait_for(lock, time, is_over);
}

bool Connection::Pause(Outage& outage) const {
  const std::optional<std::chrono::milliseconds> pause = outage.NextPause();
  if (!pause) return false;
  std::this_thread::sleep_for(*pause);
  LookForServer(outage.end(), [] { return false; });
  return true;
}

void Connection::LookForServer(std::chrono::steady_clock::time_point end,
                               const std::function<bool()>& is_cancelled) const {
  constexpr std::chrono::milliseconds kSlice{50};  // So soon a cancel is seen.
  while (std::chrono::steady_clock::now() < end && !is_cancelled()) {
    const grpc_connectivity_state state = channel_->GetState(/*try_to_connect=*/true);
    if (state == GRPC_CHANNEL_READY) return;
    channel_->WaitForStateChange(state, std::chrono::system_clock::now() + kSlice);
  }
}

Result<MeshReplica> Connection::GetMesh(const std::string& session_id, Parts parts) {
  return Persist([&] { return GetMeshOnce(session_id, parts); });
}

Result<MeshReplica> Connection::GetMeshOnce(const std::string& session_id, Parts parts) {
  const auto context = NewContext(options_.transfer_timeout);
  v1::GetMeshRequest request;
  request.set_session_id(session_id);
  if (parts != Parts::kMesh) request.add_parts(v1::MESH_PART_METRIC);
  return ReceiveMesh(*this, *context, *sessions_->GetMesh(context.get(), request));
}

Result<Quality> Connection::GetQuality(const std::string& session_id) {
  return Persist([&] { return GetQualityOnce(session_id); });
}

Result<Quality> Connection::GetQualityOnce(const std::string& session_id) {
  const auto context = NewContext(options_.transfer_timeout);
  v1::GetQualityRequest request;
  request.set_session_id(session_id);
  v1::GetQualityResponse response;
  const auto status = sessions_->GetQuality(context.get(), request, &response);
  if (!status.ok()) return CallError(*this, status);
  return FromWire(response.quality());
}

std::unique_ptr<grpc::ClientContext> Connection::NewContext() const {
  auto context = std::make_unique<grpc::ClientContext>();
  if (!options_.token.empty()) context->AddMetadata("authorization", "Bearer " + options_.token);
  return context;
}

std::unique_ptr<grpc::ClientContext> Connection::NewContext(
    std::chrono::milliseconds timeout) const {
  auto context = NewContext();
  context->set_deadline(std::chrono::system_clock::now() + timeout);
  return context;
}

Error CallError(const Connection& connection, const grpc::Status& status) {
  Error error = ErrorFromStatus(status);
  if (error.code == ErrorCode::kUnavailable) {
    error.message = connection.address() + ": " + error.message;
  }
  return error;
}

}  // namespace pliant::client
