#include "client/cpp/client.h"

#include <utility>

#include "client/cpp/connection.h"
#include "client/cpp/convert.h"
#include "client/cpp/convert_job.h"
#include "client/cpp/session_impl.h"
#include "client/cpp/subscription_impl.h"

namespace pliant::client {
namespace {

using CreateWriter = grpc::ClientWriter<v1::CreateSessionRequest>;

v1::Durability WireDurability(Durability durability) {
  switch (durability) {
    case Durability::kNone:
      return v1::DURABILITY_NONE;
    case Durability::kRelaxed:
      return v1::DURABILITY_RELAXED;
    case Durability::kStrict:
      return v1::DURABILITY_STRICT;
  }
  return v1::DURABILITY_UNSPECIFIED;
}

v1::CreateSession CreateMessage(const Start& start, const MetricSpec& metric,
                                const SessionSettings& settings, wire::ColumnWriter& columns) {
  v1::CreateSession create = InputToWire(start, metric, settings.options, columns);
  create.set_session_id(settings.session_id);
  if (settings.durability) {
    create.mutable_options()->set_durability(WireDurability(*settings.durability));
  }
  if (settings.history_bytes_max) {
    create.mutable_options()->set_history_bytes_max(*settings.history_bytes_max);
  }
  for (const auto& [key, value] : settings.labels) (*create.mutable_labels())[key] = value;
  return create;
}

}  // namespace

Client::Client(std::shared_ptr<Connection> connection) : connection_(std::move(connection)) {}

Result<Client> Client::Connect(const std::string& address, const ConnectOptions& options) {
  auto connection = std::make_shared<Connection>(address, options);
  PLIANT_RETURN_IF_ERROR(connection->Handshake());
  return Client(std::move(connection));
}

const std::string& Client::address() const { return connection_->address(); }
const ServerInfo& Client::server_info() const { return connection_->server_info(); }

Result<std::unique_ptr<Session>> Client::CreateSession(const Start& start, const MetricSpec& metric,
                                                       const SessionSettings& settings) {
  const auto context = connection_->NewContext(connection_->options().transfer_timeout);
  v1::CreateSessionResponse response;
  const std::unique_ptr<CreateWriter> writer =
      connection_->sessions().CreateSession(context.get(), &response);
  // A failed write means that the server has answered already: Finish has the reason.
  wire::ColumnWriter columns([&](v1::BlobChunk chunk) {
    v1::CreateSessionRequest request;
    *request.mutable_chunk() = std::move(chunk);
    writer->Write(request);
  });
  v1::CreateSessionRequest request;
  *request.mutable_create() = CreateMessage(start, metric, settings, columns);
  writer->Write(request);
  writer->WritesDone();
  if (const auto status = writer->Finish(); !status.ok()) return CallError(*connection_, status);
  return OpenSession(response.session().session_id(), settings.parts);
}

Result<std::unique_ptr<Session>> Client::OpenSession(const std::string& session_id, Parts parts) {
  auto impl = std::make_unique<Session::Impl>(connection_, session_id, parts);
  PLIANT_RETURN_IF_ERROR(impl->Open());
  return std::unique_ptr<Session>(new Session(std::move(impl)));
}

std::unique_ptr<Subscription> Client::Subscribe(const std::string& session_id,
                                                const SubscribeOptions& options) {
  return std::unique_ptr<Subscription>(
      new Subscription(std::make_unique<Subscription::Impl>(connection_, session_id, options)));
}

Result<SessionInfo> Client::GetSession(const std::string& session_id) {
  return connection_->Persist([&]() -> Result<SessionInfo> {
    const auto context = connection_->NewContext(connection_->options().call_timeout);
    v1::GetSessionRequest request;
    request.set_session_id(session_id);
    v1::GetSessionResponse response;
    const auto status = connection_->sessions().GetSession(context.get(), request, &response);
    if (!status.ok()) return CallError(*connection_, status);
    return FromWire(response.session());
  });
}

Result<std::vector<SessionInfo>> Client::ListSessions() {
  std::vector<SessionInfo> sessions;
  v1::ListSessionsRequest request;
  do {
    v1::ListSessionsResponse response;
    PLIANT_RETURN_IF_ERROR(connection_->Persist([&]() -> Status {
      const auto context = connection_->NewContext(connection_->options().call_timeout);
      const auto status = connection_->sessions().ListSessions(context.get(), request, &response);
      return status.ok() ? Status() : Status(CallError(*connection_, status));
    }));
    for (const v1::Session& session : response.sessions()) sessions.push_back(FromWire(session));
    request.set_page_token(response.next_page_token());
  } while (!request.page_token().empty());
  return sessions;
}

Result<Revision> Client::DeleteSession(const std::string& session_id) {
  const auto context = connection_->NewContext(connection_->options().call_timeout);
  v1::DeleteSessionRequest request;
  request.set_session_id(session_id);
  v1::DeleteSessionResponse response;
  const auto status = connection_->sessions().DeleteSession(context.get(), request, &response);
  if (!status.ok()) return CallError(*connection_, status);
  return Revision{response.revision()};
}

Result<MeshReplica> Client::GetMesh(const std::string& session_id, Parts parts) {
  return connection_->GetMesh(session_id, parts);
}

Result<Quality> Client::GetQuality(const std::string& session_id) {
  return connection_->GetQuality(session_id);
}

}  // namespace pliant::client
