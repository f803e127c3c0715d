// Sessions as files; see client.h.
#include <cstdint>
#include <utility>

#include "client/cpp/client.h"
#include "client/cpp/connection.h"
#include "client/cpp/convert.h"
#include "proto/columns.h"

namespace pliant::client {

namespace {

Result<Bytes> ExportOnce(const Connection& connection, const std::string& session_id) {
  const auto context = connection.NewContext(connection.options().transfer_timeout);
  v1::ExportSessionRequest request;
  request.set_session_id(session_id);
  const auto reader = connection.sessions().ExportSession(context.get(), request);
  wire::ColumnReader columns(kBlobBytesMax);
  Result<Bytes> file = Error{.code = ErrorCode::kInternal,
                             .message = "the server ended the download without a file"};
  v1::ExportSessionResponse response;
  Status received;
  while (received.ok() && reader->Read(&response)) {
    if (response.has_chunk()) {
      received = columns.Add(response.chunk());
    } else if (response.has_file()) {
      file = columns.Read<std::uint8_t, 1, std::byte>(response.file().data(), "file.data");
      if (!file.ok()) received = file.error();
    }
  }
  if (!received.ok()) {
    context->TryCancel();
    static_cast<void>(reader->Finish());  // What was received is the reason, not the cancel.
    return received.error();
  }
  if (const auto status = reader->Finish(); !status.ok()) return CallError(connection, status);
  return file;
}

}  // namespace

Result<Bytes> Client::ExportSession(const std::string& session_id) {
  return connection_->Persist([&] { return ExportOnce(*connection_, session_id); });
}

Result<SessionInfo> Client::ImportSession(std::span<const std::byte> file,
                                          const std::string& session_id) {
  const auto context = connection_->NewContext(connection_->options().transfer_timeout);
  v1::ImportSessionResponse response;
  const auto writer = connection_->sessions().ImportSession(context.get(), &response);
  // A failed write means that the server has answered already: Finish has the reason.
  wire::ColumnWriter columns([&](v1::BlobChunk chunk) {
    v1::ImportSessionRequest request;
    *request.mutable_chunk() = std::move(chunk);
    writer->Write(request);
  });
  v1::ImportSessionRequest request;
  v1::ImportSession& import = *request.mutable_import();
  import.set_session_id(session_id);
  *import.mutable_file()->mutable_data() = columns.Write<std::uint8_t, 1>(file);
  writer->Write(request);
  writer->WritesDone();
  if (const auto status = writer->Finish(); !status.ok()) return CallError(*connection_, status);
  return FromWire(response.session());
}

}  // namespace pliant::client
