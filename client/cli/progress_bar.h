#pragma once

#include <ostream>
#include <string>

#include "client/cpp/types.h"

namespace pliant::cli {

/// One line on a terminal that tells how far an advance is. The end of the loop cannot be known in
/// advance, so the bar is an estimate that never goes back.
class ProgressBar {
 public:
  enum class Target { kTerminal, kNothing };

  /// Writes to `out` if the target is a terminal, otherwise nothing at all.
  ProgressBar(std::ostream& out, Target target) : out_(out), target_(target) {}
  /// Clears the line.
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  void Show(const client::AdvanceProgress& progress);

  /// kTerminal if standard error is one.
  static Target OfStandardError();

 private:
  std::ostream& out_;
  Target target_;
  double share_ = 0;  ///< Estimated share of the work that is done, in [0, 1).
  std::size_t shown_width_ = 0;
};

/// 1234567 as "1,234,567".
[[nodiscard]] std::string Grouped(std::int64_t number);

}  // namespace pliant::cli
