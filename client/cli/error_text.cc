#include "client/cli/error_text.h"

namespace pliant::cli {

std::string ErrorText(const Error& error) {
  std::string text(ErrorCodeName(error.code));
  // Errors of files name the file in both.
  if (!error.field.empty() && !error.message.starts_with(error.field)) {
    text += " at " + error.field;
    if (error.index >= 0) text.append("[").append(std::to_string(error.index)).append("]");
    if (error.other_index >= 0) {
      text.append(" and [").append(std::to_string(error.other_index)).append("]");
    }
  }
  return text + ": " + error.message;
}

ExitCode ExitCodeOf(const Error& error) {
  switch (error.code) {
    case ErrorCode::kUnavailable:
      return ExitCode::kUnreachable;
    case ErrorCode::kCancelled:
      return ExitCode::kInterrupted;
    default:
      return ExitCode::kRefused;
  }
}

}  // namespace pliant::cli
