#pragma once

#include <grpcpp/grpcpp.h>

#include <optional>
#include <string>
#include <utility>

#include "core/base/result.h"
#include "server/access.h"
#include "server/blobs.h"
#include "server/call_counter.h"
#include "server/error_status.h"

namespace pliant::server {

/// A call that uploads large arrays in chunks and then one message that names them: CreateSession,
/// ImportSession, SubmitJob. Whoever derives from it says what to do with that message, `Last`.
///
/// It lives until Finish, which is called here when the upload is refused, and else by what Begin
/// set going. gRPC owns it.
///
/// *Threads*: gRPC's callbacks follow each other, and Begin is called in the last of them.
template <class Request, class Last>
class Upload : public grpc::ServerReadReactor<Request> {
 public:
  void OnReadDone(bool ok) final {
    const Status status = ok ? Take(request_) : End();
    if (!status.ok()) {
      this->Finish(ToGrpcStatus(status.error()));
    } else if (ok) {
      this->StartRead(&request_);
    }
  }

  void OnDone() final {
    calls_.End();
    delete this;
  }

 protected:
  /// @param tenant  of the caller; nothing: it is refused, as nobody uploads before we know who it
  /// is.
  /// @param calls   counts this call, and outlives it.
  /// @param name    of `Last` in `Request`.
  Upload(std::optional<std::string> tenant, CallCounter& calls, std::string name)
      : tenant_(std::move(tenant)), calls_(calls), name_(std::move(name)) {
    calls_.Begin();
  }

  /// What a constructor ends with: begins to read, or refuses the call.
  void Start() {
    if (tenant_) {
      this->StartRead(&request_);
    } else {
      this->Finish(Access::Refusal());
    }
  }

  /// The `Last` that `request` holds; nullptr: it holds something else.
  virtual Last* LastIn(Request& request) = 0;

  /// Sets the work going, its arrays being complete. An error ends the call.
  virtual Status Begin(Last last) = 0;

  /// Of the caller; only once the upload has begun.
  [[nodiscard]] const std::string& tenant() const { return *tenant_; }

 private:
  Status Take(Request& request) {
    if (last_) return Refusal("nothing may follow `" + name_ + "`", name_);
    if (request.has_chunk()) return blobs_.Add(std::move(*request.mutable_chunk()));
    Last* last = LastIn(request);
    if (last == nullptr) {
      return Refusal("the message is neither a `chunk` nor a `" + name_ + "`", "message");
    }
    last_ = std::move(*last);
    return {};
  }

  Status End() {
    if (!last_) return Refusal("the stream ended without `" + name_ + "`", name_);
    PLIANT_RETURN_IF_ERROR(blobs_.Resolve(*last_));
    return Begin(std::move(*last_));
  }

  static Error Refusal(std::string message, std::string field) {
    return {ErrorCode::kProtocolOrder, std::move(message), std::move(field)};
  }

  const std::optional<std::string> tenant_;
  CallCounter& calls_;
  const std::string name_;
  Request request_;
  BlobAssembler blobs_;
  std::optional<Last> last_;
};

}  // namespace pliant::server
