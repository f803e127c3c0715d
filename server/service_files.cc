// The calls that take a session out of a server as a file and put it in again; see service.h.
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/download.h"
#include "server/errand.h"
#include "server/importing.h"
#include "server/service.h"
#include "server/session_file.h"

namespace pliant::server {
namespace {

std::vector<v1::ExportSessionResponse> FileMessages(const Bytes& bytes, Revision revision) {
  v1::SessionFile file;
  v1::Array& data = *file.mutable_data();
  data.set_dtype(v1::DTYPE_UINT8);
  data.add_shape(static_cast<std::int64_t>(bytes.size()));
  data.set_data(bytes.data(), bytes.size());
  std::int64_t last_blob_id = 0;
  std::vector<v1::ExportSessionResponse> messages;
  for (v1::BlobChunk& chunk : TakeLargeArrays(file, last_blob_id)) {
    *messages.emplace_back().mutable_chunk() = std::move(chunk);
  }
  *messages.emplace_back().mutable_file() = std::move(file);
  for (v1::ExportSessionResponse& message : messages) {
    message.set_revision(static_cast<std::int64_t>(revision));
  }
  return messages;
}

}  // namespace

// Writes the file and sends it; not on a thread on which somebody waits.
void SessionServiceImpl::SendFile(Download<v1::ExportSessionResponse>* download,
                                  const std::map<std::string, std::string>& labels,
                                  Result<SessionMemory> memory) {
  if (!memory.ok()) {
    download->Fail(memory.error());
    return;
  }
  const Revision revision = memory->revision;
  const Result<Bytes> file = WriteSessionFile(labels, std::move(memory).value());
  if (file.ok()) {
    download->Run(FileMessages(*file, revision));
  } else {
    download->Fail(file.error());
  }
}

// On the session's worker, which does as little of it as possible: what is stored is read from the
// store beside the session; what is not is copied, and written elsewhere.
Status SessionServiceImpl::BeginExport(const Result<const CommittedState*>& result,
                                       const std::string& tenant,
                                       Download<v1::ExportSessionResponse>* download) {
  PLIANT_ASSIGN_OR_RETURN(const CommittedState* state, result);
  PLIANT_RETURN_IF_ERROR(CheckNothingStaged(*state));
  Session& session = *state->session;
  const SessionInfo info = session.info();
  if (session.is_stored()) {
    session.WhenStored([this, download, tenant, info](const Status& status) {
      if (!status.ok()) {
        download->Fail(status.error());
        return;
      }
      context_.keeper->Recall(tenant, info.session_id,
                              [download, labels = info.labels](Result<SessionMemory> memory) {
                                SendFile(download, labels, std::move(memory));
                              });
    });
    return {};
  }
  PLIANT_ASSIGN_OR_RETURN(SessionMemory copy, session.Copy());
  const auto memory = std::make_shared<SessionMemory>(std::move(copy));
  context_.session.scheduler->Wake(
      std::make_shared<Errand>([download, memory, labels = info.labels] {
        SendFile(download, labels, std::move(*memory));
      }));
  return {};
}

grpc::ServerWriteReactor<v1::ExportSessionResponse>* SessionServiceImpl::ExportSession(
    grpc::CallbackServerContext* call, const v1::ExportSessionRequest* request) {
  using FileDownload = Download<v1::ExportSessionResponse>;
  const auto begin = [&](FileDownload* download, const std::string& tenant) -> Status {
    PLIANT_ASSIGN_OR_RETURN(const std::shared_ptr<Session> session,
                            context_.registry->Find(tenant, request->session_id()));
    return session->Post([this, download, tenant](const Result<const CommittedState*>& state) {
      const Status begun = BeginExport(state, tenant, download);
      if (!begun.ok()) download->Fail(begun.error());
    });
  };
  return OpenDownload<v1::ExportSessionResponse>(downloads_, *context_.calls,
                                                 context_.access->TenantOf(*call), begin);
}

grpc::ServerReadReactor<v1::ImportSessionRequest>* SessionServiceImpl::ImportSession(
    grpc::CallbackServerContext* call, v1::ImportSessionResponse* response) {
  return new Importing(context_, call, response);
}

}  // namespace pliant::server
