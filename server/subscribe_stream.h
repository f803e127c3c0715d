#pragma once

#include <grpcpp/alarm.h>
#include <grpcpp/grpcpp.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "pliant/v1/session.pb.h"
#include "server/call_counter.h"
#include "server/convert_subscribe.h"
#include "server/followers.h"
#include "server/log.h"
#include "server/mesh_view.h"
#include "server/session.h"
#include "server/session_registry.h"

namespace pliant::server {

/// One Subscribe call: the gRPC side of a subscriber. It holds one message and its chunks at a
/// time, writes them one by one, and is ready for the next when the last is written.
///
/// *Invariants*: one write in flight at most; nothing is started after Finish.
/// *Threads*: gRPC calls the On... functions, a worker the Subscriber's. `mutex_` guards what is
/// below its declaration; no lock is taken under it.
class SubscribeStream final : public grpc::ServerWriteReactor<v1::SubscribeResponse>,
                              public Subscriber,
                              public std::enable_shared_from_this<SubscribeStream> {
 public:
  /// What a call uses of its server; the pointers outlive it.
  struct Environment {
    const SessionRegistry* registry = nullptr;
    std::optional<std::string> tenant = {};  ///< Of the caller; nothing: refused.
    CallCounter* calls = nullptr;
    const Log* log = nullptr;
    std::string request_id;
    std::chrono::milliseconds bookmark_interval{0};
  };
  /// Begins to serve a call. The result belongs to gRPC until OnDone; sessions may share it.
  static grpc::ServerWriteReactor<v1::SubscribeResponse>* Begin(
      Environment environment, const v1::SubscribeRequest& request);

  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;

  [[nodiscard]] bool ready() const override;
  [[nodiscard]] bool wants_transfer() const override {
    return spec_.parts.transfer && wants_mesh();
  }
  [[nodiscard]] bool wants_mesh() const override { return spec_.mirror != Mirror::kNone; }
  [[nodiscard]] bool Follows(const MeshDiff& diff) override;
  void Send(SessionEvent event) override;
  void Close(const Error& error) override;

 private:
  explicit SubscribeStream(Environment environment);
  Status Open(const v1::SubscribeRequest& request);
  void Write(SessionEvent event);
  void End(grpc::Status status);
  void Pump();
  void SetAlarm();
  void OnAlarm();

  const Environment environment_;
  SubscribeSpec spec_;  // Set before the session knows of this.
  // Used by one worker at a time: the part of the mesh that is wanted, if it is not the whole, and
  // the diff of it that is to be sent.
  std::optional<MeshView> view_;
  std::optional<MeshDiff> seen_;
  std::int64_t last_blob_id_ = 0;  // Used by Write alone.

  mutable std::mutex mutex_;
  std::shared_ptr<SubscribeStream> self_;  // Keeps this alive until OnDone.
  std::shared_ptr<Session> session_;
  std::vector<v1::SubscribeResponse> messages_;  // Of the event that is being written.
  std::size_t next_ = 0;
  std::optional<v1::SubscribeResponse> last_word_;  // Why it ends; after `messages_`.
  bool converting_ = false;                         // A worker is making messages.
  bool writing_ = false;
  bool finished_ = false;
  std::optional<grpc::Status> end_;  // Set: nothing more is taken.
  // Bookmarks: the revision that the client has, and whether anything was written since the alarm
  // was set.
  std::int64_t revision_ = 0;
  bool is_quiet_ = false;
  std::shared_ptr<grpc::Alarm> alarm_;
};

}  // namespace pliant::server
