#pragma once

#include <grpcpp/grpcpp.h>

#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "client/cpp/backoff.h"
#include "client/cpp/connection.h"
#include "client/cpp/subscription.h"
#include "pliant/v1/session.grpc.pb.h"
#include "proto/columns.h"

namespace pliant::client {

/// The call behind a Subscription. `mutex_` guards the context, for Cancel, and what it says.
class Subscription::Impl {
 public:
  Impl(std::shared_ptr<Connection> connection, std::string session_id, SubscribeOptions options)
      : connection_(std::move(connection)),
        session_id_(std::move(session_id)),
        options_(std::move(options)) {}
  ~Impl();

  Result<MeshDiff> Next();
  void Cancel();
  [[nodiscard]] const MeshReplica& replica() const { return replica_; }
  [[nodiscard]] const std::vector<std::int32_t>& absent_region_tags() const {
    return absent_region_tags_;
  }

 private:
  void Connect();
  /// The error of a stream that has ended.
  Error End();
  /// Waits unless cancelled. @return false if it is.
  bool Pause(std::chrono::milliseconds time);
  [[nodiscard]] bool is_cancelled();
  Result<MeshDiff> Follow(const v1::SubscribeResponse& response);

  std::shared_ptr<Connection> connection_;
  std::string session_id_;
  SubscribeOptions options_;
  MeshReplica replica_;
  std::vector<std::int32_t> absent_region_tags_;
  std::unique_ptr<grpc::ClientReader<v1::SubscribeResponse>> stream_;
  std::unique_ptr<wire::ColumnReader> reader_;

  std::mutex mutex_;
  std::condition_variable cancelled_;
  std::unique_ptr<grpc::ClientContext> context_;  // Outlives the stream.
  bool is_cancelled_ = false;
};

}  // namespace pliant::client
