#pragma once

#include <grpcpp/grpcpp.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/result.h"
#include "pliant/v1/mesh.pb.h"
#include "server/access.h"
#include "server/blobs.h"
#include "server/call_counter.h"
#include "server/error_status.h"
#include "server/limits.h"

namespace pliant::server {

/// The messages of a download: the snapshot's large arrays in chunks, then itself.
template <class Response>
[[nodiscard]] std::vector<Response> InMessages(v1::MeshSnapshot snapshot) {
  std::int64_t last_blob_id = 0;
  std::vector<Response> messages;
  for (v1::BlobChunk& chunk : TakeLargeArrays(snapshot, last_blob_id)) {
    *messages.emplace_back().mutable_chunk() = std::move(chunk);
  }
  *messages.emplace_back().mutable_snapshot() = std::move(snapshot);
  return messages;
}

/// Sends the messages of one GetMesh, ExportSession or FetchResult, one write in flight. Whoever
/// made it calls Run or Fail exactly once, from any thread; gRPC owns it from then on.
///
/// *Threads*: Run and the callbacks follow each other; nothing is shared.
template <class Response>
class Download final : public grpc::ServerWriteReactor<Response> {
 public:
  /// @param active  count of downloads, lowered at the end.
  /// @param calls   counts this call. Both outlive it.
  Download(std::atomic<int>& active, CallCounter& calls) : active_(active), calls_(calls) {
    ++active_;
    calls_.Begin();
  }

  /// Sends these messages and ends the call.
  void Run(std::vector<Response> messages) {
    messages_ = std::move(messages);
    Next();
  }

  /// Ends the call with an error.
  void Fail(const Error& error) { End(ToGrpcStatus(error)); }

  /// Ends the call of somebody whom the server does not know.
  void Refuse() { End(Access::Refusal()); }

  void OnWriteDone(bool ok) override {
    if (!ok) {
      End(grpc::Status(grpc::StatusCode::CANCELLED, "the client is gone"));
      return;
    }
    messages_[next_ - 1].Clear();  // What is sent needs no memory any more.
    Next();
  }

  void OnDone() override {
    calls_.End();
    delete this;
  }

 private:
  void Next() {
    if (next_ == messages_.size()) {
      End(grpc::Status::OK);
      return;
    }
    this->StartWrite(&messages_[next_++]);
  }

  void End(const grpc::Status& status) {
    --active_;  // Before the client knows: it may begin the next one at once.
    this->Finish(status);
  }

  std::atomic<int>& active_;
  CallCounter& calls_;
  std::vector<Response> messages_;
  std::size_t next_ = 0;
};

/// Opens a download for a caller that we know, unless kDownloadsMax are open, and has
/// `begin(download, tenant)` see to what it sends; what that returns ends it if it is an error.
/// @param active, calls  as for Download.
template <class Response, class Begin>
[[nodiscard]] Download<Response>* OpenDownload(std::atomic<int>& active, CallCounter& calls,
                                               const std::optional<std::string>& tenant,
                                               const Begin& begin) {
  auto* download = new Download<Response>(active, calls);
  if (!tenant) {
    download->Refuse();
    return download;
  }
  if (active > kDownloadsMax) {
    download->Fail({.code = ErrorCode::kResourceExhausted,
                    .message = "this server is sending " + std::to_string(kDownloadsMax) +
                               " meshes already; try again later",
                    .retry_after_ms = kCallRetryMs});
    return download;
  }
  const Status begun = begin(download, *tenant);
  if (!begun.ok()) download->Fail(begun.error());
  return download;
}

}  // namespace pliant::server
