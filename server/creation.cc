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

Creation::Creation(const ServiceContext& context, grpc::CallbackServerContext* call,
                   v1::CreateSessionResponse* response)
    : context_(context),
      call_(call),
      response_(response),
      request_id_(RequestIdOf(*call)),
      tenant_(context.access->TenantOf(*call)) {
  context_.calls->Begin();
  // Nobody uploads anything before we know who it is.
  if (tenant_) {
    StartRead(&request_);
  } else {
    Finish(Access::Refusal());
  }
}

void Creation::OnDone() {
  context_.calls->End();
  delete this;
}

void Creation::OnReadDone(bool ok) {
  const Status status = ok ? Take(request_) : Begin();
  if (!status.ok()) {
    Finish(ToGrpcStatus(status.error()));
  } else if (ok) {
    StartRead(&request_);
  }
}

Status Creation::Take(v1::CreateSessionRequest& request) {
  if (create_) {
    return Error{ErrorCode::kProtocolOrder, "nothing may follow `create`", "create"};
  }
  switch (request.message_case()) {
    case v1::CreateSessionRequest::kChunk:
      return blobs_.Add(std::move(*request.mutable_chunk()));
    case v1::CreateSessionRequest::kCreate:
      create_ = std::move(*request.mutable_create());
      return {};
    case v1::CreateSessionRequest::MESSAGE_NOT_SET:
      break;
  }
  return Error{ErrorCode::kProtocolOrder, "the message is neither a chunk nor a create", "message"};
}

Status Creation::Begin() {
  if (!create_) {
    return Error{ErrorCode::kProtocolOrder, "the stream ended without `create`", "create"};
  }
  PLIANT_RETURN_IF_ERROR(blobs_.Resolve(*create_));
  PLIANT_ASSIGN_OR_RETURN(SessionInput input, ConvertCreate(*create_, context_.limits));
  PLIANT_ASSIGN_OR_RETURN(const Durability durability,
                          DurabilityOr(input.durability, context_, "options.durability"));
  Bytes form;
  if (durability != Durability::kNone) form = FormOf(*create_);
  create_.reset();
  PLIANT_ASSIGN_OR_RETURN(const std::string id,
                          context_.registry->Reserve(*tenant_, input.session_id));
  const auto session = std::make_shared<Session>(EnvironmentOf(context_, *tenant_, id, durability),
                                                 id, std::move(input.labels));
  // This object lives until Finish, which only Complete calls from here on.
  session->Start(
      std::move(input.engine), [this, session](const Status& status) { Complete(session, status); },
      std::move(form));
  return {};
}

void Creation::Complete(const std::shared_ptr<Session>& session, const Status& status) {
  const std::string& id = session->session_id();
  if (!status.ok()) {
    context_.registry->Remove(*tenant_, id);
    context_.session.log->Info("create_refused",
                               {{"session", id},
                                {"request", request_id_},
                                {"reason", std::string(ErrorCodeName(status.error().code))}});
    Finish(ToGrpcStatus(status.error()));
    return;
  }
  if (call_->IsCancelled()) {
    // Nobody knows the id, so nobody could ever delete the session.
    context_.registry->Remove(*tenant_, id);
    session->Delete({ErrorCode::kCancelled, "the creator is gone", {}}, [](const Status&) {});
    Finish(grpc::Status(grpc::StatusCode::CANCELLED, "the client is gone"));
    return;
  }
  context_.registry->Publish(*tenant_, session);
  *response_->mutable_session() = ToSession(session->info());
  context_.session.log->Info("create", {{"session", id}, {"request", request_id_}});
  Finish(grpc::Status::OK);
}

}  // namespace pliant::server
