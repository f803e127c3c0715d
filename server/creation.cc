#include "server/creation.h"

#include <utility>

#include "server/convert_reply.h"
#include "server/error_status.h"
#include "server/request_id.h"
#include "server/stored_form.h"

namespace pliant::server {

Result<Durability> DurabilityOr(const std::optional<Durability>& wished,
                                const ServiceContext& context, const std::string& field) {
  const bool has_store = context.keeper != nullptr;
  if (!wished) return has_store ? Durability::kStrict : Durability::kNone;
  if (has_store || *wished == Durability::kNone) return *wished;
  return Error{ErrorCode::kUnimplemented,
               "this server keeps sessions in memory only (--data none), so none is durable; ask "
               "for DURABILITY_NONE or leave it to the server",
               field};
}

grpc::Status Admit(const ServiceContext& context, const std::string& tenant,
                   const std::shared_ptr<Session>& session, const Status& started,
                   const grpc::CallbackServerContext& call) {
  if (!started.ok()) {
    context.registry->Remove(tenant, session->session_id());
    return ToGrpcStatus(started.error());
  }
  if (call.IsCancelled()) {
    // Nobody knows the id, so nobody could ever delete the session.
    context.registry->Remove(tenant, session->session_id());
    session->Delete({ErrorCode::kCancelled, "the client is gone", {}}, [](const Status&) {});
    return {grpc::StatusCode::CANCELLED, "the client is gone"};
  }
  context.registry->Publish(tenant, session);
  return grpc::Status::OK;
}

Creation::Creation(const ServiceContext& context, grpc::CallbackServerContext* call,
                   v1::CreateSessionResponse* response)
    : Upload(context.access->TenantOf(*call), *context.calls, "create"),
      context_(context),
      call_(call),
      response_(response),
      request_id_(RequestIdOf(*call)) {
  Start();
}

v1::CreateSession* Creation::LastIn(v1::CreateSessionRequest& request) {
  return request.has_create() ? request.mutable_create() : nullptr;
}

Status Creation::Begin(v1::CreateSession create) {
  PLIANT_ASSIGN_OR_RETURN(SessionInput input, ConvertCreate(create, context_.limits));
  PLIANT_ASSIGN_OR_RETURN(const Durability durability,
                          DurabilityOr(input.durability, context_, "options.durability"));
  Bytes form;
  if (durability != Durability::kNone) form = FormOf(create);
  PLIANT_ASSIGN_OR_RETURN(const std::string id,
                          context_.registry->Reserve(tenant(), input.session_id));
  Session::Environment environment = EnvironmentOf(context_, tenant(), id, durability);
  environment.history_bytes_asked = input.history_bytes_max;
  const auto session =
      std::make_shared<Session>(std::move(environment), id, std::move(input.labels));
  session->Start(
      std::move(input.engine), [this, session](const Status& status) { Complete(session, status); },
      std::move(form));
  return {};
}

void Creation::Complete(const std::shared_ptr<Session>& session, const Status& status) {
  const grpc::Status admitted = Admit(context_, tenant(), session, status, *call_);
  if (admitted.ok()) *response_->mutable_session() = ToSession(session->info());
  if (!status.ok()) {
    context_.session.log->Info("create_refused",
                               {{"session", session->session_id()},
                                {"request", request_id_},
                                {"reason", std::string(ErrorCodeName(status.error().code))}});
  } else if (admitted.ok()) {
    context_.session.log->Info("create",
                               {{"session", session->session_id()}, {"request", request_id_}});
  }
  Finish(admitted);
}

}  // namespace pliant::server
