#include "server/importing.h"

#include <utility>

#include "server/convert.h"
#include "server/convert_array.h"
#include "server/convert_reply.h"
#include "server/creation.h"
#include "server/error_status.h"
#include "server/session_file.h"

namespace pliant::server {

Importing::Importing(const ServiceContext& context, grpc::CallbackServerContext* call,
                     v1::ImportSessionResponse* response)
    : context_(context),
      call_(call),
      response_(response),
      tenant_(context.access->TenantOf(*call)) {
  context_.calls->Begin();
  // Nobody uploads anything before we know who it is.
  if (tenant_) {
    StartRead(&request_);
  } else {
    Finish(Access::Refusal());
  }
}

void Importing::OnDone() {
  context_.calls->End();
  delete this;
}

void Importing::OnReadDone(bool ok) {
  const Status status = ok ? Take(request_) : Begin();
  if (!status.ok()) {
    Finish(ToGrpcStatus(status.error()));
  } else if (ok) {
    StartRead(&request_);
  }
}

Status Importing::Take(v1::ImportSessionRequest& request) {
  if (import_) return Error{ErrorCode::kProtocolOrder, "nothing may follow `import`", "import"};
  switch (request.message_case()) {
    case v1::ImportSessionRequest::kChunk:
      return blobs_.Add(std::move(*request.mutable_chunk()));
    case v1::ImportSessionRequest::kImport:
      import_ = std::move(*request.mutable_import());
      return {};
    case v1::ImportSessionRequest::MESSAGE_NOT_SET:
      break;
  }
  return Error{ErrorCode::kProtocolOrder, "the message is neither a chunk nor an import",
               "message"};
}

Status Importing::Begin() {
  if (!import_) {
    return Error{ErrorCode::kProtocolOrder, "the stream ended without `import`", "import"};
  }
  PLIANT_RETURN_IF_ERROR(blobs_.Resolve(*import_));
  if (!import_->session_id().empty()) PLIANT_RETURN_IF_ERROR(CheckSessionId(import_->session_id()));
  std::optional<Durability> wished;
  if (import_->has_durability()) {
    PLIANT_ASSIGN_OR_RETURN(wished, ConvertDurability(import_->durability(), "durability"));
  }
  PLIANT_ASSIGN_OR_RETURN(const Durability durability,
                          DurabilityOr(wished, context_, "durability"));
  PLIANT_RETURN_IF_ERROR(CheckArray(import_->file().data(), v1::DTYPE_UINT8, 1, "file"));
  const auto bytes = std::make_shared<const std::string>(
      std::move(*import_->mutable_file()->mutable_data()->mutable_data()));
  PLIANT_ASSIGN_OR_RETURN(SessionFile file, OpenSessionFile(std::as_bytes(std::span(*bytes))));
  PLIANT_RETURN_IF_ERROR(CheckLabels(file.labels));
  PLIANT_ASSIGN_OR_RETURN(const std::string id,
                          context_.registry->Reserve(*tenant_, import_->session_id()));
  const auto session = std::make_shared<Session>(EnvironmentOf(context_, *tenant_, id, durability),
                                                 id, std::move(file.labels));
  // This object lives until Finish, which only Complete calls from here on.
  session->Start(
      [this, bytes, memory = file.memory] {
        return ReadSessionFile({.labels = {}, .memory = memory},
                               {.factory = context_.session.factory,
                                .loader = context_.session.loader,
                                .codec = nullptr,
                                .history_bytes_max = context_.session.history_bytes_max},
                               context_.limits.vertices_max);
      },
      [this, session](const Status& status) { Complete(session, status); });
  return {};
}

void Importing::Complete(const std::shared_ptr<Session>& session, const Status& status) {
  const std::string& id = session->session_id();
  if (!status.ok()) {
    context_.registry->Remove(*tenant_, id);
    context_.session.log->Info(
        "import_refused",
        {{"session", id}, {"reason", std::string(ErrorCodeName(status.error().code))}});
    Finish(ToGrpcStatus(status.error()));
    return;
  }
  if (call_->IsCancelled()) {
    // Nobody knows the id, so nobody could ever delete the session.
    context_.registry->Remove(*tenant_, id);
    session->Delete({ErrorCode::kCancelled, "the importer is gone", {}}, [](const Status&) {});
    Finish(grpc::Status(grpc::StatusCode::CANCELLED, "the client is gone"));
    return;
  }
  context_.registry->Publish(*tenant_, session);
  *response_->mutable_session() = ToSession(session->info());
  context_.session.log->Info("import", {{"session", id}});
  Finish(grpc::Status::OK);
}

}  // namespace pliant::server
