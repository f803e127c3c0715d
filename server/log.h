#pragma once

#include <initializer_list>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

namespace spdlog {
class logger;
}

namespace pliant::server {

enum class LogLevel { kDebug, kInfo, kWarning, kError };
enum class LogFormat { kText, kJson };

/// A named value of a log line: {"session", id}.
using LogField = std::pair<std::string_view, std::string>;

/// Structured log to standard error: an event's name and fields, as text (key=value) or as one
/// JSON object a line. Events are fixed names, so that one can search for them; what varies is in
/// the fields.
///
/// *Threads*: all functions from any thread.
class Log {
 public:
  Log(LogLevel level, LogFormat format);
  ~Log();

  void Debug(std::string_view event, std::initializer_list<LogField> fields) const {
    Write(LogLevel::kDebug, event, fields);
  }
  void Info(std::string_view event, std::initializer_list<LogField> fields) const {
    Write(LogLevel::kInfo, event, fields);
  }
  void Warning(std::string_view event, std::initializer_list<LogField> fields) const {
    Write(LogLevel::kWarning, event, fields);
  }
  void Error(std::string_view event, std::initializer_list<LogField> fields) const {
    Write(LogLevel::kError, event, fields);
  }

 private:
  void Write(LogLevel level, std::string_view event, std::initializer_list<LogField> fields) const;

  LogFormat format_;
  std::shared_ptr<spdlog::logger> logger_;
};

/// A log line as it is written: the part after the time. For tests too.
[[nodiscard]] std::string FormatLogLine(LogFormat format, std::string_view event,
                                        std::initializer_list<LogField> fields);

}  // namespace pliant::server
