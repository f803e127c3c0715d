#include "client/cli/progress_bar.h"

#include <unistd.h>

#include <algorithm>

namespace pliant::cli {
namespace {

constexpr int kBarWidth = 24;
/// Visits that an active vertex has still before it, on average over a first build: what turns
/// the count of active vertices into an estimate of the work that is left.
constexpr double kVisitsPerActive = 8;

std::string Seconds(std::chrono::milliseconds time) {
  const auto tenths = time.count() / 100;
  return std::to_string(tenths / 10).append(".").append(std::to_string(tenths % 10)).append(" s");
}

}  // namespace

ProgressBar::~ProgressBar() {
  if (shown_width_ > 0) out_ << '\r' << std::string(shown_width_, ' ') << '\r' << std::flush;
}

void ProgressBar::Show(const client::AdvanceProgress& progress) {
  if (target_ == Target::kNothing) return;
  const double done = static_cast<double>(progress.visits);
  const double left = kVisitsPerActive * static_cast<double>(progress.active_count);
  if (done + left > 0) share_ = std::max(share_, std::min(0.99, done / (done + left)));
  const auto filled = static_cast<std::size_t>(share_ * kBarWidth);
  std::string line = "[";
  line.append(filled, '#').append(kBarWidth - filled, '.').append("] ");
  line.append(Grouped(progress.vertex_count)).append(" vertices, ");
  line.append(Grouped(progress.active_count)).append(" active, ");
  line.append(Seconds(progress.elapsed));
  const std::size_t width = line.size();
  line.resize(std::max(width, shown_width_), ' ');
  shown_width_ = width;
  out_ << '\r' << line << std::flush;
}

ProgressBar::Target ProgressBar::OfStandardError() {
  return isatty(STDERR_FILENO) != 0 ? Target::kTerminal : Target::kNothing;
}

std::string Grouped(std::int64_t number) {
  std::string text = std::to_string(number);
  const std::size_t first = number < 0 ? 1 : 0;
  for (std::size_t i = text.size(); i > first + 3;) {
    i -= 3;
    text.insert(i, 1, ',');
  }
  return text;
}

}  // namespace pliant::cli
