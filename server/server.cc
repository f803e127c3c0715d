#include "server/server.h"

#include <grpc/grpc.h>
#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/health_check_service_interface.h>
#include <grpcpp/security/tls_certificate_provider.h>
#include <grpcpp/security/tls_credentials_options.h>

#include <chrono>
#include <random>
#include <utility>

#include "server/jobs/durable_job_store.h"
#include "server/jobs/memory_job_store.h"
#include "server/limits.h"
#include "server/record.h"
#include "server/resident_memory.h"
#include "server/store/sqlite_store.h"

namespace pliant::server {
namespace {

// Between two looks at the files of certificates: far below the time for which an old and a new
// one are both good.
constexpr unsigned kCertificateRefreshS = 1;

// Certificates are watched: one that is replaced, say before it expires, holds for new connections.
std::shared_ptr<grpc::ServerCredentials> CredentialsOf(const Config& config) {
  if (config.tls_cert.empty()) return grpc::InsecureServerCredentials();
  const auto files = std::make_shared<grpc::experimental::FileWatcherCertificateProvider>(
      config.tls_key, config.tls_cert, config.tls_client_ca, kCertificateRefreshS);
  grpc::experimental::TlsServerCredentialsOptions options(files);
  options.watch_identity_key_cert_pairs();
  if (!config.tls_client_ca.empty()) {
    options.watch_root_certs();
    options.set_cert_request_type(GRPC_SSL_REQUEST_AND_REQUIRE_CLIENT_CERTIFICATE_AND_VERIFY);
  }
  return grpc::experimental::TlsServerCredentials(options);
}

/// @param keeper  null: in memory only.
std::unique_ptr<JobStore> MakeJobStore(Keeper* keeper, const Log& log) {
  if (keeper == nullptr) return std::make_unique<MemoryJobStore>();
  return std::make_unique<DurableJobStore>(keeper->store(), log);
}

std::uint64_t RandomSeed() {
  std::random_device device;
  return (std::uint64_t{device()} << 32) | device();
}

}  // namespace

Result<std::unique_ptr<Server>> Server::Start(const Config& config, Parts parts) {
  PLIANT_RETURN_IF_ERROR(CheckConfig(config));
  Access access;
  if (!config.tokens.empty()) {
    PLIANT_ASSIGN_OR_RETURN(access, Access::FromFile(config.tokens));
  }
  std::unique_ptr<Store> store;
  if (!config.data.empty()) {
    PLIANT_ASSIGN_OR_RETURN(store, SqliteStore::Open({.directory = config.data, .vfs = {}}));
  }
  std::unique_ptr<Server> server(
      new Server(config, std::move(parts), std::move(access), std::move(store)));
  PLIANT_RETURN_IF_ERROR(server->Restore());
  PLIANT_RETURN_IF_ERROR(server->jobs_.Load());
  PLIANT_RETURN_IF_ERROR(server->Bind());
  if (server->sleeper_ != nullptr) server->sleeper_->Start();
  return server;
}

Server::Server(const Config& config, Parts parts, Access access, std::unique_ptr<Store> store)
    : config_(config),
      parts_(std::move(parts)),
      access_(std::move(access)),
      registry_({.sessions_max = config.sessions_max,
                 .sessions_per_tenant_max = config.sessions_per_tenant_max},
                RandomSeed()),
      accounts_({.vertices_max = config.tenant_vertices_max,
                 .bytes_max = config.tenant_bytes_max,
                 .compute_percent = config.tenant_compute_percent,
                 .compute_burst = std::chrono::milliseconds(config.tenant_compute_burst_ms)}),
      scheduler_(ThreadCount(config.workers), *parts_.clock),
      keeper_(store == nullptr
                  ? nullptr
                  : std::make_unique<Keeper>(std::move(store),
                                             SessionMakers{.factory = parts_.engine_factory,
                                                           .loader = parts_.engine_loader,
                                                           .codec = &codec_},
                                             *parts_.log)),
      sleeper_(keeper_ == nullptr
                   ? nullptr
                   : std::make_unique<Sleeper>(
                         Sleeper::Policy{
                             .idle_max = std::chrono::seconds(config.sleep_after_s),
                             .memory_bytes_max = config.memory_limit_mib * (std::int64_t{1} << 20),
                             .resident = ResidentBytes},
                         registry_, *parts_.clock)),
      context_{.keeper = keeper_.get(),
               .registry = &registry_,
               .access = &access_,
               .calls = &calls_,
               .session = {.clock = parts_.clock,
                           .scheduler = &scheduler_,
                           .log = parts_.log,
                           .factory = parts_.engine_factory,
                           .loader = parts_.engine_loader,
                           .codec = &codec_,
                           .budget = sleeper_ == nullptr ? nullptr : &sleeper_->budget(),
                           .on_broken = nullptr},
               .accounts = &accounts_,
               .limits = {.vertices_max = config.vertices_max},
               .sessions_max = config.sessions_max,
               .jobs_max = config.jobs.jobs_max,
               .bookmark_interval = std::chrono::milliseconds(config.bookmark_ms)},
      sessions_(context_),
      info_(context_),
      job_store_(MakeJobStore(keeper_.get(), *parts_.log)),
      jobs_({.clock = parts_.clock,
             .log = parts_.log,
             .scheduler = &scheduler_,
             .store = job_store_.get(),
             .accounts = &accounts_,
             .factory = parts_.engine_factory,
             .codec = WireJobCodec(context_.limits)},
            JobBoundsOf(config.jobs, ThreadCount(config.workers)), RandomSeed()),
      job_service_({.jobs = &jobs_,
                    .access = &access_,
                    .calls = &calls_,
                    .limits = context_.limits,
                    .keep = JobKeepOf(config.jobs)}) {}

Server::~Server() {
  Shutdown();
  scheduler_.Stop();  // Also where it never served: no task outlives what it uses.
}

// Sessions that are stored are there at once; each is loaded when somebody needs it.
Status Server::Restore() {
  if (keeper_ == nullptr) return {};
  PLIANT_ASSIGN_OR_RETURN(const std::vector<StoredHead> heads,
                          keeper_->store().List(DocumentKind::kSession));
  for (const StoredHead& head : heads) {
    Result<StoredInfo> stored = ReadInfo(head.head);
    if (!stored.ok()) {
      // It is there all the same: whoever uses it is told, and may delete it.
      parts_.log->Error("damaged", {{"session", head.key.name}, {"what", stored.error().message}});
      stored = StoredInfo{};
    }
    stored->info.session_id = head.key.name;
    registry_.Restore(head.key.tenant,
                      std::make_shared<Session>(EnvironmentOf(context_, head.key.tenant,
                                                              head.key.name, stored->durability),
                                                std::move(stored->info)));
  }
  if (!heads.empty()) {
    parts_.log->Info("restored", {{"sessions", std::to_string(heads.size())}});
  }
  return {};
}

Status Server::Bind() {
  // Never given back: whoever gives back the last reference to gRPC's library joins its threads,
  // and one that covers a blocked write polls for 10 s. A process that ends need not wait for that.
  grpc_init();
  grpc::EnableDefaultHealthCheckService(true);
  grpc::reflection::InitProtoReflectionServerBuilderPlugin();
  grpc::ServerBuilder builder;
  int port = 0;
  builder.AddListeningPort(config_.listen, CredentialsOf(config_), &port);
  builder.SetMaxReceiveMessageSize(kMessageBytesMax);
  // Two servers on one port would share its clients at random.
  builder.AddChannelArgument(GRPC_ARG_ALLOW_REUSEPORT, 0);
  // A client that vanished without a word is noticed, and its session freed, within a minute.
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, 30'000);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 20'000);
  // Clients that follow a session may look that often whether the server is there.
  builder.AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS, 10'000);
  if (config_.connection_age_max_s > 0) {
    // Calls that last are ended by the client's library, which connects again and resumes.
    builder.AddChannelArgument(GRPC_ARG_MAX_CONNECTION_AGE_MS,
                               static_cast<int>(config_.connection_age_max_s * 1000));
    builder.AddChannelArgument(GRPC_ARG_MAX_CONNECTION_AGE_GRACE_MS,
                               static_cast<int>(config_.drain_ms));
  }
  builder.RegisterService(&sessions_);
  builder.RegisterService(&info_);
  builder.RegisterService(&job_service_);
  grpc_ = builder.BuildAndStart();
  const bool is_unix = config_.listen.starts_with("unix:");
  if (grpc_ == nullptr || (!is_unix && port == 0)) {
    grpc_ = nullptr;
    return Error{ErrorCode::kUnavailable,
                 "cannot listen at " + config_.listen + "; is another server there?", "listen"};
  }
  job_sweeper_.emplace(std::chrono::milliseconds(kIdleCheckMs), [this] { jobs_.Sweep(); });
  if (config_.idle_close_s > 0) {
    sweeper_.emplace(registry_, *parts_.clock, *parts_.log,
                     std::chrono::seconds(config_.idle_close_s));
  }
  address_ = is_unix
                 ? config_.listen
                 : config_.listen.substr(0, config_.listen.rfind(':')) + ":" + std::to_string(port);
  return {};
}

void Server::Shutdown() {
  if (grpc_ == nullptr) return;
  parts_.log->Info("drain", {{"address", address_}});
  sweeper_.reset();
  job_sweeper_.reset();
  grpc_->GetHealthCheckService()->SetServingStatus(false);
  for (const std::shared_ptr<Session>& session : registry_.All()) {
    session->Drain({ErrorCode::kUnavailable, "the server shuts down; connect again later", {}});
  }
  jobs_.Stop();
  // Workers go on while calls end.
  calls_.WaitForNone(std::chrono::milliseconds(config_.drain_ms));
  grpc_->Shutdown(std::chrono::system_clock::now() + std::chrono::milliseconds(kLastWordsMs));
  scheduler_.Stop();
  grpc_ = nullptr;
  parts_.log->Info("stopped", {{"address", address_}});
}

}  // namespace pliant::server
