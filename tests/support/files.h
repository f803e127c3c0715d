#pragma once

#include <gtest/gtest.h>

#include <string>

#include "server/limits.h"
#include "tests/support/in_process_server.h"

/// Sessions as files, over the wire.
namespace pliant::test {

/// The file of a session; empty, with the status, where the server refuses.
inline std::string ExportFile(InProcessServer& server, const std::string& id,
                              grpc::Status* status = nullptr) {
  grpc::ClientContext context;
  v1::ExportSessionRequest request;
  request.set_session_id(id);
  const auto reader = server.sessions->ExportSession(&context, request);
  server::BlobAssembler blobs;
  v1::ExportSessionResponse response;
  v1::SessionFile file;
  while (reader->Read(&response)) {
    EXPECT_LE(response.ByteSizeLong(), static_cast<std::size_t>(server::kMessageBytesMax));
    EXPECT_GT(response.revision(), 0);
    if (response.has_chunk()) {
      EXPECT_TRUE(blobs.Add(response.chunk()).ok());
    } else {
      file = response.file();
    }
  }
  EXPECT_TRUE(blobs.Resolve(file).ok());
  const grpc::Status end = reader->Finish();
  if (status != nullptr) {
    *status = end;
  } else {
    EXPECT_TRUE(end.ok()) << end.error_message();
  }
  return file.data().data();
}

inline v1::ImportSession ImportOf(const std::string& file, const std::string& id) {
  v1::ImportSession import;
  import.set_session_id(id);
  v1::Array& data = *import.mutable_file()->mutable_data();
  data.set_dtype(v1::DTYPE_UINT8);
  data.add_shape(static_cast<std::int64_t>(file.size()));
  data.set_data(file);
  return import;
}

inline grpc::Status Import(InProcessServer& server, v1::ImportSession import,
                           v1::Session* session = nullptr, grpc::ClientContext* with = nullptr) {
  grpc::ClientContext own;
  v1::ImportSessionResponse response;
  const auto writer = server.sessions->ImportSession(with != nullptr ? with : &own, &response);
  std::int64_t last_blob_id = 0;
  for (v1::BlobChunk& chunk : server::TakeLargeArrays(import, last_blob_id)) {
    v1::ImportSessionRequest request;
    *request.mutable_chunk() = std::move(chunk);
    writer->Write(request);
  }
  v1::ImportSessionRequest request;
  *request.mutable_import() = std::move(import);
  writer->Write(request);
  writer->WritesDone();
  const grpc::Status status = writer->Finish();
  if (session != nullptr) *session = response.session();
  return status;
}

inline grpc::Status ImportFile(InProcessServer& server, const std::string& file,
                               const std::string& id, v1::Session* session = nullptr) {
  return Import(server, ImportOf(file, id), session);
}

}  // namespace pliant::test
