#pragma once

#include <grpcpp/grpcpp.h>

#include <atomic>
#include <cstddef>
#include <vector>

#include "core/base/result.h"
#include "pliant/v1/session.pb.h"
#include "server/call_counter.h"

namespace pliant::server {

/// Sends the messages of one GetMesh, one write in flight. Whoever made it calls Run exactly once,
/// from any thread; gRPC owns it from then on.
///
/// *Threads*: Run and the callbacks follow each other; nothing is shared.
class Download final : public grpc::ServerWriteReactor<v1::GetMeshResponse> {
 public:
  /// @param active  count of downloads, raised by the maker and lowered at the end.
  /// @param calls   counts this call. Both outlive it.
  Download(std::atomic<int>& active, CallCounter& calls) : active_(active), calls_(calls) {
    calls_.Begin();
  }

  /// Sends these messages and ends the call.
  void Run(std::vector<v1::GetMeshResponse> messages);
  /// Ends the call with an error.
  void Fail(const Error& error);

  void OnWriteDone(bool ok) override;
  void OnDone() override;

 private:
  void Next();

  std::atomic<int>& active_;
  CallCounter& calls_;
  std::vector<v1::GetMeshResponse> messages_;
  std::size_t next_ = 0;
};

}  // namespace pliant::server
