#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <optional>
#include <utility>

#include "core/base/rng.h"
#include "pliant/v1/edit.pb.h"
#include "pliant/v1/session.pb.h"
#include "server/clock.h"
#include "server/convert_reply.h"
#include "server/followers.h"
#include "server/session.h"

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

/// An edit stream: what is on its way in each direction, in order, and the server's end of it.
class EditLink final : public server::Editor {
 public:
  /// @param room  answers that may be on their way before the server stops taking commands.
  explicit EditLink(std::size_t room) : room_(room) {}

  std::optional<server::SessionCommand> NextCommand() override {
    if (is_dead || arrived.empty() || down.size() >= room_) return std::nullopt;
    server::SessionCommand command = std::move(arrived.front());
    arrived.pop_front();
    return command;
  }
  void CommandDone() override {}
  [[nodiscard]] bool HasRoom() const override { return !is_dead && down.size() < room_; }
  void Send(server::SessionEvent event) override {
    if (!is_dead) down.push_back(server::ToEditResponse(event, {}));
  }
  void Close(const Error&) override { is_dead = true; }

  std::deque<server::SessionCommand> up;       ///< On their way to the server.
  std::deque<server::SessionCommand> arrived;  ///< Wait there for the session.
  std::deque<v1::EditResponse> down;           ///< On their way to the client.
  bool is_dead = false;

 private:
  std::size_t room_;
};

/// A Subscribe call with at most one message on its way.
class SubscribeLink final : public server::Subscriber {
 public:
  [[nodiscard]] bool ready() const override { return !is_dead && down.empty(); }
  void Send(server::SessionEvent event) override {
    if (!is_dead) down.push_back(server::ToSubscribeResponse(event, {}));
  }
  void Close(const Error&) override { is_dead = true; }

  std::deque<v1::SubscribeResponse> down;
  bool is_dead = false;
};

}  // namespace pliant::simulation
