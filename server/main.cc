// pliantd: the server's program. Flags in, a Server until a signal, an exit status out.
#include <grpc/grpc.h>

#include <csignal>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <string>
#include <utility>
#include <vector>

#include "server/clock.h"
#include "server/config.h"
#include "server/log.h"
#include "server/server.h"
#include "server/store/maintenance.h"

namespace pliant::server {
namespace {

// Written next to the file and renamed, so that whoever waits for it never reads half of it.
Status WritePortFile(const std::string& path, const std::string& address) {
  const std::string draft = path + ".new";
  std::ofstream file(draft);
  file << address << "\n";
  file.close();
  if (!file || std::rename(draft.c_str(), path.c_str()) != 0) {
    return Error{ErrorCode::kFileUnwritable, "cannot write the port file " + path, "port-file"};
  }
  return {};
}

Status Serve(const Config& config, const sigset_t& signals) {
  const SystemClock clock;
  const Log log(config.log_level, config.log_format);
  ThreadPool mesh_threads(ThreadCount(config.mesh_threads));
  PLIANT_ASSIGN_OR_RETURN(const std::unique_ptr<Server> server,
                          Server::Start(config, {.clock = &clock,
                                                 .log = &log,
                                                 .engine_factory = RemesherFactory(&mesh_threads),
                                                 .engine_loader = RemesherLoader(&mesh_threads)}));
  log.Info("serving", {{"address", server->address()},
                       {"version", PLIANT_VERSION},
                       {"data", config.data.empty() ? "none, in memory only" : config.data}});
  if (!config.port_file.empty()) {
    PLIANT_RETURN_IF_ERROR(WritePortFile(config.port_file, server->address()));
  }
  int signal = 0;
  sigwait(&signals, &signal);
  server->Shutdown();
  return {};
}

/// @return the exit status
Result<int> Maintain(const Config& config) {
  PLIANT_RETURN_IF_ERROR(CheckConfig(config));
  if (config.maintenance == Config::Maintenance::kBackUp) {
    PLIANT_RETURN_IF_ERROR(BackUpStore({.directory = config.data, .vfs = {}}, config.backup));
    std::cout << config.data << " is copied to " << config.backup << "\n";
    return 0;
  }
  PLIANT_ASSIGN_OR_RETURN(const std::vector<std::string> faults,
                          CheckStore({.directory = config.data, .vfs = {}}));
  for (const std::string& fault : faults) std::cout << fault << "\n";
  if (faults.empty()) std::cout << config.data << " is as it was written\n";
  return faults.empty() ? 0 : 1;
}

Result<int> Run(const Config& config, const sigset_t& signals) {
  if (config.maintenance != Config::Maintenance::kNone) return Maintain(config);
  PLIANT_RETURN_IF_ERROR(Serve(config, signals));
  return 0;
}

int Main(int argc, const char* const* argv) {
  // Blocked before any thread starts, so that all threads inherit it and sigwait gets the signal.
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGTERM);
  sigaddset(&signals, SIGINT);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
  // Never given back: with its last user gone, gRPC 1.51 joins its threads, one of which may sit in
  // a poll of ten seconds for a connection that is already closed. The process ends anyway.
  grpc_init();

  const auto parsed = ParseConfig(argc, argv);
  if (!parsed.ok()) {
    std::cerr << "pliantd: " << parsed.error().message << "\n";
    return 2;
  }
  if (const auto* request = std::get_if<ExitRequest>(&*parsed)) {
    std::cout << request->text;
    return request->status;
  }
  const Result<int> status = Run(std::get<Config>(*parsed), signals);
  if (!status.ok()) {
    std::cerr << "pliantd: " << status.error().message << "\n";
    return 1;
  }
  return *status;
}

}  // namespace
}  // namespace pliant::server

int main(int argc, char** argv) { return pliant::server::Main(argc, argv); }
