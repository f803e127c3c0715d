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
    : Upload(context.access->TenantOf(*call), *context.calls, "import"),
      context_(context),
      call_(call),
      response_(response) {
  Start();
}

v1::ImportSession* Importing::LastIn(v1::ImportSessionRequest& request) {
  return request.has_import() ? request.mutable_import() : nullptr;
}

Status Importing::Begin(v1::ImportSession import) {
  if (!import.session_id().empty()) PLIANT_RETURN_IF_ERROR(CheckSessionId(import.session_id()));
  std::optional<Durability> wished;
  if (import.has_durability()) {
    PLIANT_ASSIGN_OR_RETURN(wished, ConvertDurability(import.durability(), "durability"));
  }
  PLIANT_ASSIGN_OR_RETURN(const Durability durability,
                          DurabilityOr(wished, context_, "durability"));
  PLIANT_RETURN_IF_ERROR(CheckArray(import.file().data(), v1::DTYPE_UINT8, 1, "file"));
  const auto bytes = std::make_shared<const std::string>(
      std::move(*import.mutable_file()->mutable_data()->mutable_data()));
  PLIANT_ASSIGN_OR_RETURN(SessionFile file, OpenSessionFile(std::as_bytes(std::span(*bytes))));
  PLIANT_RETURN_IF_ERROR(CheckLabels(file.labels));
  PLIANT_ASSIGN_OR_RETURN(const std::string id,
                          context_.registry->Reserve(tenant(), import.session_id()));
  const auto session = std::make_shared<Session>(EnvironmentOf(context_, tenant(), id, durability),
                                                 id, std::move(file.labels));
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
  const grpc::Status admitted = Admit(context_, tenant(), session, status, *call_);
  if (admitted.ok()) *response_->mutable_session() = ToSession(session->info());
  if (!status.ok()) {
    context_.session.log->Info("import_refused",
                               {{"session", session->session_id()},
                                {"reason", std::string(ErrorCodeName(status.error().code))}});
  } else if (admitted.ok()) {
    context_.session.log->Info("import", {{"session", session->session_id()}});
  }
  Finish(admitted);
}

}  // namespace pliant::server
