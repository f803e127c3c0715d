#include "server/download.h"

#include <utility>

#include "server/error_status.h"

namespace pliant::server {

void Download::Run(std::vector<v1::GetMeshResponse> messages) {
  messages_ = std::move(messages);
  Next();
}

void Download::Fail(const Error& error) { Finish(ToGrpcStatus(error)); }

void Download::OnWriteDone(bool ok) {
  if (!ok) {
    Finish(grpc::Status(grpc::StatusCode::CANCELLED, "the client is gone"));
    return;
  }
  messages_[next_ - 1].Clear();  // What is sent needs no memory any more.
  Next();
}

void Download::OnDone() {
  --active_;
  calls_.End();
  delete this;
}

void Download::Next() {
  if (next_ == messages_.size()) {
    Finish(grpc::Status::OK);
    return;
  }
  StartWrite(&messages_[next_++]);
}

}  // namespace pliant::server
