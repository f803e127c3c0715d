#pragma once

#include <grpcpp/grpcpp.h>

#include <memory>
#include <optional>
#include <string>

#include "core/base/result.h"
#include "server/access.h"
#include "server/call_counter.h"
#include "server/clock.h"
#include "server/config.h"
#include "server/engine.h"
#include "server/idle_sweeper.h"
#include "server/job_service.h"
#include "server/jobs/jobs.h"
#include "server/keeper.h"
#include "server/log.h"
#include "server/scheduler.h"
#include "server/service.h"
#include "server/session_registry.h"
#include "server/sleeper.h"
#include "server/stored_form.h"
#include "server/tenant_account.h"
#include "server/ticker.h"

namespace pliant::server {

/// A whole pliantd inside a process: what main() runs, and what tests start.
///
/// *Threads*: Start and the destructor from one thread; Shutdown from any, once.
class Server {
 public:
  /// What a server needs from outside; clock and log outlive it.
  struct Parts {
    const Clock* clock = nullptr;
    const Log* log = nullptr;
    EngineFactory engine_factory;
    /// What brings back stored sessions; the real thing unless a test has another.
    EngineLoader engine_loader = RemesherLoader();
  };

  /// Serves when it returns. Errors: kUnavailable if the address cannot be bound.
  static Result<std::unique_ptr<Server>> Start(const Config& config, Parts parts);

  /// As Shutdown, if that has not been.
  ~Server();

  /// The address that clients can connect to, with the port that was really bound.
  [[nodiscard]] const std::string& address() const { return address_; }

  /// Drains: health says NOT_SERVING, running advances commit what they have, streams are told and
  /// end; calls that are not done after Config::drain_ms are cancelled.
  void Shutdown();

 private:
  Server(const Config& config, Parts parts, Access access, std::unique_ptr<Store> store);
  Status Restore();
  Status Bind();

  const Config config_;
  const Parts parts_;
  const Access access_;
  SessionRegistry registry_;
  TenantAccounts accounts_;
  CallCounter calls_;
  const WireCodec codec_;
  Scheduler scheduler_;
  const std::unique_ptr<Keeper> keeper_;    // Null: in memory only.
  const std::unique_ptr<Sleeper> sleeper_;  // With it.
  const ServiceContext context_;
  SessionServiceImpl sessions_;
  ServerServiceImpl info_;
  const std::unique_ptr<JobStore> job_store_;
  Jobs jobs_;
  JobServiceImpl job_service_;
  std::unique_ptr<grpc::Server> grpc_;
  std::string address_;
  std::optional<IdleSweeper> sweeper_;
  std::optional<Ticker> job_sweeper_;
};

}  // namespace pliant::server
