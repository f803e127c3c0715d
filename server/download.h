#pragma once

#include <grpcpp/grpcpp.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/base/result.h"
#include "pliant/v1/mesh.pb.h"
#include "server/blobs.h"
#include "server/call_counter.h"
#include "server/error_status.h"

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

/// Sends the messages of one GetMesh or FetchResult, one write in flight. Whoever made it calls Run
/// or Fail exactly once, from any thread; gRPC owns it from then on.
///
/// *Threads*: Run and the callbacks follow each other; nothing is shared.
template <class Response>
class Download final : public grpc::ServerWriteReactor<Response> {
 public:
  /// @param active  count of downloads, raised by the maker and lowered at the end.
  /// @param calls   counts this call. Both outlive it.
  Download(std::atomic<int>& active, CallCounter& calls) : active_(active), calls_(calls) {
    calls_.Begin();
  }

  /// Sends these messages and ends the call.
  void Run(std::vector<Response> messages) {
    messages_ = std::move(messages);
    Next();
  }

  /// Ends the call with an error.
  void Fail(const Error& error) { this->Finish(ToGrpcStatus(error)); }

  void OnWriteDone(bool ok) override {
    if (!ok) {
      this->Finish(grpc::Status(grpc::StatusCode::CANCELLED, "the client is gone"));
      return;
    }
    messages_[next_ - 1].Clear();  // What is sent needs no memory any more.
    Next();
  }

  void OnDone() override {
    --active_;
    calls_.End();
    delete this;
  }

 private:
  void Next() {
    if (next_ == messages_.size()) {
      this->Finish(grpc::Status::OK);
      return;
    }
    this->StartWrite(&messages_[next_++]);
  }

  std::atomic<int>& active_;
  CallCounter& calls_;
  std::vector<Response> messages_;
  std::size_t next_ = 0;
};

}  // namespace pliant::server
