#include <sys/utsname.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <fstream>
#include <string>
#include <string_view>
#include <thread>

#include "tests/bench/commit.h"
#include "tests/bench/workload_run.h"

namespace pliant::bench {
namespace {

double CpuSeconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

std::string Processor() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  }
  return "unknown";
}

/// An entry of this process's status, in MiB. Not getrusage: that also counts the memory of the
/// process that started this one.
double StatusMib(std::string_view entry) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with(entry)) return std::stod(line.substr(entry.size())) / 1024;
  }
  return 0;
}

nlohmann::json JsonOf(const LengthStatistics& lengths) {
  return {{"mean", lengths.mean}, {"min", lengths.min}, {"max", lengths.max}};
}

}  // namespace

Duration TimeOf(const std::function<void()>& action) {
  const auto wall = std::chrono::steady_clock::now();
  const double cpu = CpuSeconds();
  action();
  return {.wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - wall).count(),
          .cpu = CpuSeconds() - cpu};
}

double Median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[(values.size() - 1) / 2];
}

nlohmann::json JsonOf(const std::vector<Duration>& durations) {
  std::vector<double> wall;
  std::vector<double> cpu;
  for (const Duration& duration : durations) {
    wall.push_back(duration.wall);
    cpu.push_back(duration.cpu);
  }
  return {{"wall_s", Median(wall)}, {"cpu_s", Median(cpu)}, {"cpu_s_all", cpu}};
}

nlohmann::json QualityOf(const Mesh& mesh, const MetricField& field) {
  const Quality quality = MeasureQuality(mesh, field);
  return {{"triangles", quality.triangle_count},
          {"edges", quality.edge_count},
          {"q_mean", quality.q_mean},
          {"q_min", quality.q_min},
          {"q_percentile_1", quality.q_percentile_1},
          {"integrated", JsonOf(quality.integrated)},
          {"integrated_sqrt2", quality.integrated.share_sqrt2},
          {"integrated_125", quality.integrated.share_125},
          {"averaged", JsonOf(quality.averaged)},
          {"averaged_sqrt2", quality.averaged.share_sqrt2},
          {"averaged_125", quality.averaged.share_125},
          {"complexity", quality.complexity}};
}

nlohmann::json Machine() {
  utsname system{};
  uname(&system);
  return {{"processor", Processor()},
          {"cores", std::thread::hardware_concurrency()},
          {"system", std::string(system.sysname) + " " + system.release},
          {"compiler", kCompiler},
          {"flags", kFlags},
          {"commit", kCommit}};
}

double PeakMemoryMib() { return StatusMib("VmHWM:"); }
double ResidentMemoryMib() { return StatusMib("VmRSS:"); }

}  // namespace pliant::bench
