#include "client/cli/loop_options.h"

#include <algorithm>
#include <map>
#include <string>

namespace pliant::cli {

client::AdvanceOptions LoopOptions::advance() const {
  client::AdvanceOptions advance;
  if (visits_max > 0) advance.visits_max = visits_max;
  if (seconds_max > 0) {
    const auto ms = static_cast<std::int64_t>(seconds_max * 1000);
    advance.time_max = std::chrono::milliseconds(std::max<std::int64_t>(1, ms));
  }
  return advance;
}

void AddLoopOptions(CLI::App& command, LoopOptions& loop) {
  static const std::map<std::string, Variant> kVariants = {
      {"nested", Variant::kNested}, {"cooled", Variant::kCooled}, {"paper", Variant::kPaper}};
  static const std::map<std::string, Smoothing> kSmoothings = {
      {"pliant", Smoothing::kPliant},
      {"laplacian", Smoothing::kLaplacian},
      {"lennard-jones", Smoothing::kLennardJones},
      {"bubble", Smoothing::kBubble}};
  Options& options = loop.options;
  command.add_option("--variant", options.variant, "Which loop")
      ->transform(CLI::CheckedTransformer(kVariants).description(""))
      ->type_name("nested|cooled|paper")
      ->default_str("nested");
  command.add_option("--smoothing", options.smoothing, "Smoothing function")
      ->transform(CLI::CheckedTransformer(kSmoothings).description(""))
      ->type_name("pliant|laplacian|lennard-jones|bubble")
      ->default_str("pliant");
  command.add_option("--seed", options.seed, "Seed of random picking (variant paper)")
      ->capture_default_str();
  command.add_flag_callback(
      "--no-insert", [&options] { options.permissions.insert = false; },
      "Insert and delete no vertex");
  command.add_flag_callback(
      "--no-swap", [&options] { options.permissions.swap = false; }, "Swap no edge");
  command.add_flag_callback(
      "--no-move", [&options] { options.permissions.move = false; }, "Move no vertex");
  command.add_option("--vertices-max", options.vertices_max, "No more vertices than this")
      ->capture_default_str();
  command.add_option("--step", options.step, "Step of the smoothing; 0 suits the variant")
      ->capture_default_str();
  command
      .add_option("--speed-threshold", options.speed_threshold,
                  "A vertex that moves less rests, in wanted lengths; 0 suits the variant")
      ->capture_default_str();
  command.add_option("--visits-max", loop.visits_max, "Stop after this many visits; 0: never")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  command.add_option("--seconds-max", loop.seconds_max, "Stop after this time; 0: never")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
}

}  // namespace pliant::cli
