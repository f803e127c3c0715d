#pragma once

#include <grpcpp/support/status.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "core/base/rng.h"
#include "pliant/v1/edit.pb.h"
#include "pliant/v1/session.pb.h"
#include "server/clock.h"
#include "server/convert_reply.h"
#include "server/error_status.h"
#include "server/followers.h"
#include "server/session.h"
#include "tests/protocol/promises.h"
#include "tests/simulation/ledger.h"

/// Connections that exist only as queues: a schedule decides when a message arrives and whether it
/// ever does.
namespace pliant::simulation {

/// Time that goes on by a random bit whenever somebody looks, so that slices and deadlines end at
/// random places, and the same ones for the same seed.
class RandomClock final : public server::Clock {
 public:
  explicit RandomClock(std::uint64_t seed) : rng_(seed) {}
  [[nodiscard]] Time Now() const override {
    ticks_ += static_cast<Duration::rep>(rng_.Below(300'000));
    return Time(Duration(ticks_));
  }
  [[nodiscard]] WallTime WallNow() const override { return WallTime(std::chrono::hours(1)); }

 private:
  mutable Rng rng_;
  mutable Duration::rep ticks_ = 0;
};

/// A session, and what it has answered to anybody.
struct Place {
  std::string id = {};
  std::shared_ptr<server::Session> session = {};
  Ledger ledger = {};
};

/// An edit stream: what is on its way in each direction, in order, and the server's end of it.
class EditLink final : public server::Editor {
 public:
  /// Messages that may be made beyond `room`: the answer to one command is up to two.
  static constexpr std::size_t kAnswerCount = 2;

  /// @param room  answers that may be on their way before the server stops taking commands.
  explicit EditLink(std::size_t room) : room_(room) {}

  std::optional<server::SessionCommand> NextCommand() override {
    if (is_dead || arrived.empty() || down.size() >= room_) return std::nullopt;
    server::SessionCommand command = std::move(arrived.front());
    arrived.pop_front();
    if (const auto* update = std::get_if<server::UpdateCommand>(&command)) {
      taken_ = {.update_id = update->update_id, .fingerprint = update->fingerprint};
      if (const auto* rollback = std::get_if<server::RollbackUpdate>(&update->body)) {
        taken_.to_revision = static_cast<std::int64_t>(rollback->to_revision);
      }
    }
    return command;
  }
  void LookAhead(const std::function<bool(const server::SessionCommand&)>& look) const override {
    if (!HasRoom()) return;
    for (const server::SessionCommand& command : arrived) {
      if (!look(command)) return;
    }
  }
  void CommandDone() override {}
  [[nodiscard]] bool HasRoom() const override { return !is_dead && down.size() < room_; }
  void Send(server::SessionEvent event) override {
    if (std::holds_alternative<server::ProgressEvent>(event.body) && !HasRoom()) return;
    v1::EditResponse response = server::ToEditResponse(event, {});
    if (response.update_id() == taken_.update_id) place->ledger.Answered(taken_, response);
    if (is_dead) return;
    down.push_back(std::move(response));
    place->ledger.Check(test::CheckBounded(static_cast<std::int64_t>(down.size()),
                                           static_cast<std::int64_t>(room_ + kAnswerCount)));
  }
  void Close(const Error& error) override { End(server::ToGrpcStatus(error)); }
  /// The server has ended the call.
  void End(grpc::Status status) {
    is_dead = true;
    if (!end) end = std::move(status);
  }

  Place* place = nullptr;                      ///< Whose session it edits; null: not open yet.
  std::deque<v1::EditRequest> up;              ///< On their way to the server.
  std::deque<server::SessionCommand> arrived;  ///< Wait there for the session.
  std::deque<v1::EditResponse> down;           ///< On their way to the client.
  bool is_dead = false;                        ///< For the server.
  bool is_lost = false;                        ///< For the client: nothing comes through any more.
  std::optional<grpc::Status> end;

 private:
  std::size_t room_;
  Ledger::Command taken_;  // The command that is being handled.
};

/// A Subscribe call with at most one message on its way.
class SubscribeLink final : public server::Subscriber {
 public:
  explicit SubscribeLink(Place* place) : place_(place) {}
  [[nodiscard]] bool ready() const override { return !is_dead && down.empty(); }
  void Send(server::SessionEvent event) override {
    if (!is_dead) down.push_back(server::ToSubscribeResponse(event, {}));
    place_->ledger.Check(test::CheckBounded(static_cast<std::int64_t>(down.size()), 1));
  }
  void Close(const Error&) override { is_dead = true; }

  std::deque<v1::SubscribeResponse> down;
  bool is_dead = false;

 private:
  Place* place_;
};

}  // namespace pliant::simulation
