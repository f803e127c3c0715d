#pragma once

#include <memory>
#include <string>

#include "core/base/rng.h"
#include "tests/simulation/simulated_network.h"

namespace pliant::simulation {

class SimulatedServer;

/// What the clients of a schedule see of it.
class World {
 public:
  virtual ~World() = default;
  /// A new connection, on which nothing has been sent yet.
  virtual std::shared_ptr<EditLink> Connect() = 0;
  /// A client lets a connection go, or has lost it: the server notices some time later.
  virtual void Leave(const std::shared_ptr<EditLink>& link) = 0;
  /// Something happens that the client who waits has no part in.
  virtual void Meanwhile() = 0;
  /// The network is well, and only those who are asked to do something do it.
  [[nodiscard]] virtual bool is_settling() const = 0;
  [[nodiscard]] virtual Rng& rng() = 0;
  [[nodiscard]] virtual SimulatedServer& server() = 0;
  /// The schedule has shown a fault; the first one counts.
  virtual void Fail(const std::string& what) = 0;
};

}  // namespace pliant::simulation
