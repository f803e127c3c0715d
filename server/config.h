#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <variant>

#include "core/base/result.h"
#include "server/config_jobs.h"
#include "server/limits.h"
#include "server/log.h"

namespace pliant::server {

/// Whether an address that other machines can reach is accepted without encryption: that must be
/// asked for by name.
enum class Exposure { kLocalOnly, kAnyAddress };

/// How a server runs. Each field is a flag (`--listen`) and a key of the YAML file (`listen`).
struct Config {
  /// "127.0.0.1:7447", "[::1]:7447", "localhost:0" (0: a free port) or "unix:/path".
  std::string listen = "127.0.0.1:7447";
  Exposure exposure = Exposure::kLocalOnly;
  /// Written with the bound address once the server answers; empty: none.
  std::string port_file = {};
  /// Worker threads; 0: one for each core.
  int workers = 0;
  /// Threads that work on one large mesh, the worker included; 0: one for each core.
  int mesh_threads = 0;
  std::size_t sessions_max = kSessionsMaxDefault;
  std::size_t sessions_per_tenant_max = kSessionsMaxDefault;
  /// PEM files: certificate chain and key of the server; empty: no encryption. They are read again
  /// when they change.
  std::string tls_cert = {};
  std::string tls_key = {};
  /// PEM file: who signs the certificates that clients must have; empty: they need none.
  std::string tls_client_ca = {};
  /// File of tokens (Access::FromFile); empty: everybody may call.
  std::string tokens = {};
  /// What to do with the data instead of serving them, also while another server does.
  enum class Maintenance { kNone, kCheck, kBackUp };
  Maintenance maintenance = Maintenance::kNone;
  /// Directory of the copy that kBackUp makes.
  std::string backup = {};
  std::int32_t vertices_max = kVerticesMaxDefault;
  /// What the sessions of one tenant may use together, as TenantLimits; 0: no limit.
  std::int64_t tenant_vertices_max = 0;
  std::int64_t tenant_bytes_max = 0;
  int tenant_compute_percent = 0;
  std::int64_t tenant_compute_burst_ms = kTenantBurstMsDefault;
  /// A session that nobody has used for so long is closed; 0: never.
  std::int64_t idle_close_s = 0;
  std::int64_t drain_ms = kDrainMsDefault;
  /// Connections older than that are closed, after --drain-ms of grace; 0: never.
  std::int64_t connection_age_max_s = 0;
  /// Time without news after which a subscriber gets a bookmark.
  std::int64_t bookmark_ms = kBookmarkMsDefault;
  JobConfig jobs = {};
  /// Directory where sessions are kept; empty: in memory only.
  std::string data = {};
  /// Sessions that are stored leave memory when nobody has used them for so long, in s; 0: never.
  std::int64_t sleep_after_s = kSleepAfterSDefault;
  /// ...and when the process would hold more memory than that, in MiB; 0: no limit.
  std::int64_t memory_limit_mib = 0;
  LogLevel log_level = LogLevel::kInfo;
  LogFormat log_format = LogFormat::kText;
};

/// A configured number of threads; 0: one for each core.
[[nodiscard]] int ThreadCount(int configured);

/// Text to print and an exit status: --help, --version.
struct ExitRequest {
  std::string text;
  int status = 0;
};

/// Reads flags, and the YAML file that --config names; a flag wins over the file.
///
/// Errors: kOutOfRange, kFileNotFound, kFileSyntax (with `field` = the key), kFileUnsupported for a
/// key that is none.
[[nodiscard]] Result<std::variant<Config, ExitRequest>> ParseConfig(int argc,
                                                                    const char* const* argv);

/// The same from the text of a YAML file, over the given values.
[[nodiscard]] Result<Config> ParseYaml(const std::string& text, Config config);

/// Checks what no single value shows: ranges, and that the address is local unless exposure says
/// otherwise. Error: kOutOfRange.
[[nodiscard]] Status CheckConfig(const Config& config);

}  // namespace pliant::server
