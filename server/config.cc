#include "server/config.h"

#include <yaml-cpp/yaml.h>

#include <CLI/CLI.hpp>
#include <fstream>
#include <map>
#include <sstream>
#include <thread>
#include <utility>

namespace pliant::server {
namespace {

const std::map<std::string, LogLevel> kLogLevels = {{"debug", LogLevel::kDebug},
                                                    {"info", LogLevel::kInfo},
                                                    {"warning", LogLevel::kWarning},
                                                    {"error", LogLevel::kError}};
const std::map<std::string, LogFormat> kLogFormats = {{"text", LogFormat::kText},
                                                      {"json", LogFormat::kJson}};

// `none` stands for no directory; one of that name is `./none`.
std::string DirectoryOf(const std::string& data) { return data == "none" ? "" : data; }

// Sets the field of a key from YAML; false if there is no such key. Throws YAML's exceptions.
bool SetKey(const std::string& key, const YAML::Node& value, Config& config) {
  if (key == "listen") {
    config.listen = value.as<std::string>();
  } else if (key == "insecure-any-address") {
    config.exposure = value.as<bool>() ? Exposure::kAnyAddress : Exposure::kLocalOnly;
  } else if (key == "port-file") {
    config.port_file = value.as<std::string>();
  } else if (key == "workers") {
    config.workers = value.as<int>();
  } else if (key == "mesh-threads") {
    config.mesh_threads = value.as<int>();
  } else if (key == "sessions-max") {
    config.sessions_max = value.as<std::size_t>();
  } else if (key == "sessions-per-tenant-max") {
    config.sessions_per_tenant_max = value.as<std::size_t>();
  } else if (key == "tls-cert") {
    config.tls_cert = value.as<std::string>();
  } else if (key == "tls-key") {
    config.tls_key = value.as<std::string>();
  } else if (key == "tls-client-ca") {
    config.tls_client_ca = value.as<std::string>();
  } else if (key == "tokens") {
    config.tokens = value.as<std::string>();
  } else if (key == "vertices-max") {
    config.vertices_max = value.as<std::int32_t>();
  } else if (key == "tenant-vertices-max") {
    config.tenant_vertices_max = value.as<std::int64_t>();
  } else if (key == "tenant-bytes-max") {
    config.tenant_bytes_max = value.as<std::int64_t>();
  } else if (key == "tenant-compute-percent") {
    config.tenant_compute_percent = value.as<int>();
  } else if (key == "tenant-compute-burst-ms") {
    config.tenant_compute_burst_ms = value.as<std::int64_t>();
  } else if (key == "idle-close-s") {
    config.idle_close_s = value.as<std::int64_t>();
  } else if (key == "drain-ms") {
    config.drain_ms = value.as<std::int64_t>();
  } else if (key == "connection-age-max-s") {
    config.connection_age_max_s = value.as<std::int64_t>();
  } else if (key == "bookmark-ms") {
    config.bookmark_ms = value.as<std::int64_t>();
  } else if (key == "log-level" && kLogLevels.contains(value.as<std::string>())) {
    config.log_level = kLogLevels.at(value.as<std::string>());
  } else if (key == "log-format" && kLogFormats.contains(value.as<std::string>())) {
    config.log_format = kLogFormats.at(value.as<std::string>());
  } else if (key == "sleep-after-s") {
    config.sleep_after_s = value.as<std::int64_t>();
  } else if (key == "memory-limit-mib") {
    config.memory_limit_mib = value.as<std::int64_t>();
  } else if (key == "data") {
    config.data = DirectoryOf(value.as<std::string>());
  } else {
    return SetJobKey(key, value, config.jobs);
  }
  return true;
}

Result<std::string> ReadFile(const std::string& path) {
  std::ifstream file(path);
  if (!file) {
    return Error{ErrorCode::kFileNotFound, "cannot open the configuration file " + path, "config"};
  }
  std::ostringstream text;
  text << file.rdbuf();
  return std::move(text).str();
}

bool IsLoopback(const std::string& listen) {
  if (listen.starts_with("unix:")) return true;
  const std::size_t colon = listen.rfind(':');
  const std::string host = listen.substr(0, colon);
  return host == "localhost" || host == "[::1]" || host.starts_with("127.");
}

void AddStoreFlags(CLI::App& app, Config& config) {
  app.add_option_function<std::string>(
         "--data", [&config](const std::string& data) { config.data = DirectoryOf(data); },
         "Directory where sessions are kept, so that they survive the server; none: they are in "
         "memory only and end with it")
      ->default_str("none");
  app.add_flag_callback(
      "--check-data", [&config] { config.maintenance = Config::Maintenance::kCheck; },
      "Serve nothing: read all of --data, say what is damaged, and exit with 0 if nothing is. A "
      "server may be using it");
  app.add_option_function<std::string>(
      "--backup-data",
      [&config](const std::string& directory) {
        config.maintenance = Config::Maintenance::kBackUp;
        config.backup = directory;
      },
      "Serve nothing: copy --data into this directory, as of one moment, and exit. A server may be "
      "using it");
  app.add_option("--sleep-after-s", config.sleep_after_s,
                 "With --data: sessions that nobody used for so long leave memory, in s; 0: never")
      ->capture_default_str();
  app.add_option(
         "--memory-limit-mib", config.memory_limit_mib,
         "With --data: of the whole process, in MiB; the least recently used sessions leave "
         "memory to keep it; 0: no limit")
      ->capture_default_str();
}

void AddFlags(CLI::App& app, Config& config, std::string& config_path) {
  app.add_option("--config", config_path, "YAML file with these options as keys; flags win");
  app.add_option("--listen", config.listen,
                 "Address to serve: HOST:PORT (port 0: a free one) or unix:/path")
      ->capture_default_str();
  app.add_flag_callback(
      "--insecure-any-address", [&config] { config.exposure = Exposure::kAnyAddress; },
      "Allow an address that other machines reach without encryption");
  app.add_option("--tls-cert", config.tls_cert, "PEM file: the server's certificate chain");
  app.add_option("--tls-key", config.tls_key, "PEM file: its private key");
  app.add_option("--tls-client-ca", config.tls_client_ca,
                 "PEM file: who signs the certificates that clients must have; none: no need");
  app.add_option("--tokens", config.tokens,
                 "File with a token and a tenant on each line: who may call");
  app.add_option("--port-file", config.port_file,
                 "Write the bound address into this file once the server answers");
  app.add_option("--workers", config.workers, "Worker threads; 0: one for each core")
      ->capture_default_str();
  app.add_option("--mesh-threads", config.mesh_threads,
                 "Threads that work on one large mesh; 0: one for each core")
      ->capture_default_str();
  app.add_option("--sessions-max", config.sessions_max, "Sessions at once")->capture_default_str();
  app.add_option("--sessions-per-tenant-max", config.sessions_per_tenant_max,
                 "Sessions of one tenant at once")
      ->capture_default_str();
  app.add_option("--vertices-max", config.vertices_max, "Vertices of one session")
      ->capture_default_str();
  app.add_option("--tenant-vertices-max", config.tenant_vertices_max,
                 "Vertices of all sessions of one tenant; 0: no limit")
      ->capture_default_str();
  app.add_option("--tenant-bytes-max", config.tenant_bytes_max,
                 "Memory of all sessions of one tenant, in bytes, roughly; 0: no limit")
      ->capture_default_str();
  app.add_option(
         "--tenant-compute-percent", config.tenant_compute_percent,
         "Compute time of one tenant over the long run, in percent of a worker; 0: no limit")
      ->capture_default_str();
  app.add_option("--tenant-compute-burst-ms", config.tenant_compute_burst_ms,
                 "That much of it may be used at once after a rest, in ms")
      ->capture_default_str();
  app.add_option("--idle-close-s", config.idle_close_s,
                 "Close sessions that nobody has used for so long, in s; 0: never")
      ->capture_default_str();
  app.add_option("--drain-ms", config.drain_ms,
                 "At SIGTERM: time for running work and streams to end, in ms")
      ->capture_default_str();
  app.add_option("--connection-age-max-s", config.connection_age_max_s,
                 "Close connections that are older, in s, after --drain-ms of grace; 0: never")
      ->capture_default_str();
  app.add_option("--bookmark-ms", config.bookmark_ms,
                 "Time without news after which a subscriber gets a bookmark, in ms")
      ->capture_default_str();
  AddJobFlags(app, config.jobs);
  AddStoreFlags(app, config);
  app.add_option("--log-level", config.log_level, "debug, info, warning or error")
      ->transform(CLI::CheckedTransformer(kLogLevels).description(""))
      ->default_str("info");
  app.add_option("--log-format", config.log_format, "text or json (one object a line)")
      ->transform(CLI::CheckedTransformer(kLogFormats).description(""))
      ->default_str("text");
}

Status CheckNumbers(const Config& config) {
  struct Range {
    const char* key;
    std::int64_t value;
    std::int64_t low;
    std::int64_t high;
  };
  constexpr std::int64_t kMost = INT64_MAX;
  constexpr std::int64_t kHourMs = 3'600'000;
  const auto sessions = static_cast<std::int64_t>(config.sessions_max);
  const auto per_tenant = static_cast<std::int64_t>(config.sessions_per_tenant_max);
  for (const Range& range :
       {Range{"workers", config.workers, 0, kWorkersMax},
        Range{"mesh-threads", config.mesh_threads, 0, kWorkersMax},
        Range{"sessions-max", sessions, 1, kMost},
        Range{"sessions-per-tenant-max", per_tenant, 1, kMost},
        Range{"tenant-vertices-max", config.tenant_vertices_max, 0, kMost},
        Range{"tenant-bytes-max", config.tenant_bytes_max, 0, kMost},
        Range{"tenant-compute-percent", config.tenant_compute_percent, 0, kMost},
        Range{"tenant-compute-burst-ms", config.tenant_compute_burst_ms, 0, kMost},
        Range{"idle-close-s", config.idle_close_s, 0, kMost},
        Range{"vertices-max", config.vertices_max, 3, 100'000'000},
        Range{"drain-ms", config.drain_ms, 0, kHourMs},
        Range{"connection-age-max-s", config.connection_age_max_s, 0, 1'000'000},
        Range{"sleep-after-s", config.sleep_after_s, 0, 1'000'000'000},
        Range{"memory-limit-mib", config.memory_limit_mib, 0, 1'000'000'000},
        Range{"bookmark-ms", config.bookmark_ms, 1, kHourMs}}) {
    if (range.low <= range.value && range.value <= range.high) continue;
    const std::string allowed =
        range.high == kMost ? "at least " + std::to_string(range.low)
                            : std::to_string(range.low) + " to " + std::to_string(range.high);
    return Error{ErrorCode::kOutOfRange,
                 std::string("--") + range.key + " is " + std::to_string(range.value) +
                     "; expected is " + allowed,
                 range.key};
  }
  return {};
}

}  // namespace

int ThreadCount(int configured) {
  if (configured > 0) return configured;
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

Result<std::variant<Config, ExitRequest>> ParseConfig(int argc, const char* const* argv) {
  // Twice: first to learn the file's name, then, over the file's values, for good.
  Config config;
  for (int pass = 0; pass < 2; ++pass) {
    CLI::App app("pliantd: keeps triangle meshes and adapts them to what clients send", "pliantd");
    app.set_version_flag("--version", "pliantd " PLIANT_VERSION);
    app.footer(
        "Without --data sessions live in memory and end with the server; with it, what was "
        "acknowledged survives a crash.");
    std::string config_path;
    AddFlags(app, config, config_path);
    try {
      app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
      if (error.get_exit_code() == 0) {
        std::ostringstream out;
        app.exit(error, out, out);
        return std::variant<Config, ExitRequest>(ExitRequest{std::move(out).str(), 0});
      }
      return Error{ErrorCode::kOutOfRange,
                   std::string(error.what()) + "; pliantd --help lists the options", "argv"};
    }
    if (pass == 1 || config_path.empty()) break;
    PLIANT_ASSIGN_OR_RETURN(const std::string text, ReadFile(config_path));
    PLIANT_ASSIGN_OR_RETURN(config, ParseYaml(text, Config{}));
  }
  PLIANT_RETURN_IF_ERROR(CheckConfig(config));
  return std::variant<Config, ExitRequest>(std::move(config));
}

Result<Config> ParseYaml(const std::string& text, Config config) {
  std::string key;
  try {
    const YAML::Node root = YAML::Load(text);
    if (root.IsNull()) return config;
    if (!root.IsMap()) {
      return Error{ErrorCode::kFileSyntax, "the configuration file is not a map of keys", "config"};
    }
    for (const auto& entry : root) {
      key = entry.first.as<std::string>();
      if (!SetKey(key, entry.second, config)) {
        return Error{ErrorCode::kFileUnsupported,
                     "the configuration file has an unknown key or value at '" + key +
                         "'; pliantd --help lists the options, which are the keys",
                     key};
      }
    }
  } catch (const YAML::Exception& error) {
    return Error{ErrorCode::kFileSyntax, std::string("the configuration file: ") + error.what(),
                 key};
  }
  return config;
}

Status CheckConfig(const Config& config) {
  const auto out_of_range = [](std::string message, std::string key) {
    return Error{ErrorCode::kOutOfRange, std::move(message), std::move(key)};
  };
  if (!config.listen.starts_with("unix:") && config.listen.rfind(':') == std::string::npos) {
    return out_of_range("--listen " + config.listen + " is neither HOST:PORT nor unix:/path",
                        "listen");
  }
  if (config.tls_cert.empty() != config.tls_key.empty()) {
    return out_of_range("--tls-cert and --tls-key belong together", "tls-cert");
  }
  if (!config.tls_client_ca.empty() && config.tls_cert.empty()) {
    return out_of_range("--tls-client-ca needs --tls-cert and --tls-key", "tls-client-ca");
  }
  if (config.exposure == Exposure::kLocalOnly && config.tls_cert.empty() &&
      !IsLoopback(config.listen)) {
    return out_of_range("--listen " + config.listen +
                            " can be reached from other machines, without encryption; give "
                            "--tls-cert and --tls-key, or --insecure-any-address if that is meant",
                        "listen");
  }
  if (config.maintenance != Config::Maintenance::kNone && config.data.empty()) {
    return out_of_range("--check-data and --backup-data need --data: whose?", "data");
  }
  PLIANT_RETURN_IF_ERROR(CheckNumbers(config));
  return CheckJobConfig(config.jobs);
}

}  // namespace pliant::server
