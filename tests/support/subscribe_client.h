#pragma once

#include <memory>
#include <string>

#include "tests/support/in_process_server.h"
#include "tests/support/mirror.h"

namespace pliant::test {

/// One Subscribe call, message by message.
class SubscribeClient {
 public:
  SubscribeClient(InProcessServer& server, const std::string& session_id,
                  std::int64_t mirror_revision = 0, v1::SubscribeRequest request = {}) {
    request.set_session_id(session_id);
    request.set_mirror_revision(mirror_revision);
    stream_ = server.sessions->Subscribe(&context_, request);
  }

  /// The next message that is no chunk, its arrays put in place; one without an event at the end.
  v1::SubscribeResponse Next() {
    v1::SubscribeResponse response;
    while (stream_->Read(&response)) {
      saw_closing = saw_closing || response.has_closing();
      if (!response.has_chunk()) {
        if (!blobs_.Resolve(response).ok()) break;
        return response;
      }
      if (!blobs_.Add(response.chunk()).ok()) break;
    }
    return {};
  }
  /// The same, applied to a mirror; `wrong` says what did not fit.
  v1::SubscribeResponse Next(Mirror* mirror) {
    v1::SubscribeResponse response = Next();
    if (response.event_case() == v1::SubscribeResponse::EVENT_NOT_SET) wrong = "the stream ended";
    if (response.has_diff()) wrong = mirror->Apply(response.diff());
    if (response.has_snapshot()) wrong = mirror->Take(response.snapshot());
    return response;
  }
  /// Reads until the mirror has a revision; what was wrong, or nothing.
  std::string Follow(Mirror& mirror, std::int64_t revision) {
    while (mirror.revision < revision && wrong.empty()) Next(&mirror);
    return wrong;
  }
  /// The status of a call that the server ends.
  grpc::Status End() {
    while (Next().event_case() != v1::SubscribeResponse::EVENT_NOT_SET) {
    }
    return stream_->Finish();
  }
  ~SubscribeClient() { context_.TryCancel(); }

  std::string wrong;
  bool saw_closing = false;

 private:
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReader<v1::SubscribeResponse>> stream_;
  server::BlobAssembler blobs_;
};

}  // namespace pliant::test
