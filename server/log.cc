#include "server/log.h"

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <nlohmann/json.hpp>

namespace pliant::server {
namespace {

spdlog::level::level_enum ToSpdlog(LogLevel level) {
  switch (level) {
    case LogLevel::kDebug:
      return spdlog::level::debug;
    case LogLevel::kInfo:
      return spdlog::level::info;
    case LogLevel::kWarning:
      return spdlog::level::warn;
    case LogLevel::kError:
      return spdlog::level::err;
  }
  return spdlog::level::err;
}

}  // namespace

// The logger is not registered by name: several servers may live in one process (tests do that).
Log::Log(LogLevel level, LogFormat format)
    : format_(format),
      logger_(std::make_shared<spdlog::logger>(
          "pliantd", std::make_shared<spdlog::sinks::stderr_color_sink_mt>())) {
  logger_->set_level(ToSpdlog(level));
  logger_->flush_on(spdlog::level::info);
  logger_->set_pattern(format == LogFormat::kJson
                           ? R"({"time":"%Y-%m-%dT%H:%M:%S.%e%z","level":"%l",%v})"
                           : "%Y-%m-%d %H:%M:%S.%e %^%l%$ %v");
}

Log::~Log() = default;

void Log::Write(LogLevel level, std::string_view event,
                std::initializer_list<LogField> fields) const {
  if (!logger_->should_log(ToSpdlog(level))) return;
  logger_->log(ToSpdlog(level), FormatLogLine(format_, event, fields));
}

std::string FormatLogLine(LogFormat format, std::string_view event,
                          std::initializer_list<LogField> fields) {
  // Values can come from clients; what is not UTF-8 must not throw.
  const auto quoted = [](std::string_view text) {
    return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  };
  const bool json = format == LogFormat::kJson;
  std::string line = json ? "\"event\":" : "";
  line += json ? quoted(event) : std::string(event);
  for (const auto& [name, value] : fields) {
    if (json) {
      line.append(",").append(quoted(name)).append(":").append(quoted(value));
      continue;
    }
    const bool plain = !value.empty() && value.find_first_of(" \"=\n\t\\") == std::string::npos;
    line.append(" ").append(name).append("=").append(plain ? value : quoted(value));
  }
  return line;
}

}  // namespace pliant::server
