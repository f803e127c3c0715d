#pragma once

#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "client/cpp/client.h"
#include "server/engine.h"
#include "server/server.h"

/// What the benchmarks of server and store have in common.
namespace pliant::bench {

using nlohmann::json;
using std::chrono::steady_clock;

inline constexpr double kIdealPerArea =
    1.1547;  // 2 / sqrt(3): vertices of a unit mesh per unit of area.

inline double Seconds(steady_clock::duration duration) {
  return std::chrono::duration<double>(duration).count();
}

inline Domain Square() {
  return {.points = {{0, 0}, {1, 0}, {1, 1}, {0, 1}},
          .segments = {{0, 1, 1}, {1, 2, 2}, {2, 3, 3}, {3, 0, 4}},
          .holes = {},
          .regions = {}};
}

/// The size with which the square has about so many vertices.
inline double SizeFor(double nodes) { return std::sqrt(kIdealPerArea / nodes); }

inline MetricSpec Uniform(double size) { return {.source = SizeMetric{std::to_string(size)}}; }

/// Stops the program on an error: a benchmark of what fails says nothing.
template <class T>
T Must(Result<T> result) {
  if (!result.ok()) {
    std::cerr << result.error().message << '\n';
    std::_Exit(1);
  }
  return std::move(result).value();
}
inline void Must(const Status& status) {
  if (!status.ok()) Must(Result<int>(status.error()));
}

/// A server in this process, of which only errors are heard.
class BenchServer {
 public:
  explicit BenchServer(const server::Config& config)
      : server_(Must(server::Server::Start(
            config,
            {.clock = &clock_, .log = &log_, .engine_factory = server::RemesherFactory()}))) {}

  [[nodiscard]] client::Client Connect() const {
    return Must(client::Client::Connect(server_->address()));
  }

 private:
  const server::SystemClock clock_;
  const server::Log log_{server::LogLevel::kError, server::LogFormat::kText};
  std::unique_ptr<server::Server> server_;
};

inline json Percentiles(std::vector<double> seconds) {
  std::sort(seconds.begin(), seconds.end());
  const auto at = [&](double share) {
    const auto rank = static_cast<std::size_t>(share * static_cast<double>(seconds.size() - 1));
    return 1e3 * seconds[rank];
  };
  return {{"count", seconds.size()},
          {"p50_ms", at(0.5)},
          {"p99_ms", at(0.99)},
          {"p999_ms", at(0.999)},
          {"max_ms", at(1.0)}};
}

inline double RssMiB() {
  std::ifstream file("/proc/self/statm");
  long pages = 0;
  long resident = 0;
  file >> pages >> resident;
  return static_cast<double>(resident) * static_cast<double>(sysconf(_SC_PAGESIZE)) / (1 << 20);
}

/// Of all threads of this process, in seconds: what other processes do to wall time is not in it.
inline double CpuSeconds() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// A session whose updates switch the size of a disc on and off.
class DiscSession {
 public:
  DiscSession(client::Client& client, double nodes, double disc_share,
              const client::SessionSettings& settings = {})
      : size_(SizeFor(nodes)),
        radius_squared_(disc_share / 3.14159),
        session_(Must(client.CreateSession(Square(), Uniform(size_), settings))) {
    Must(session_->Advance());
  }

  /// Takes up one that exists, where its last DiscSession left it.
  DiscSession(double nodes, double disc_share, std::unique_ptr<client::Session> session)
      : size_(SizeFor(nodes)),
        radius_squared_(disc_share / 3.14159),
        session_(std::move(session)),
        small_(static_cast<std::int64_t>(session_->replica().revision()) % 2 == 0) {}

  /// One update, end to end to the applied replica; its time in seconds.
  double Update() {
    small_ = !small_;
    const double size = small_ ? 0.8 * size_ : size_;
    FindDisc();
    tensors_.assign(ids_.size(), Metric::Isotropic(size));
    const double cpu_begin = CpuSeconds();
    const auto begin = steady_clock::now();
    Must(session_->UpdateTensors(ids_, tensors_));
    staging_ = Seconds(steady_clock::now() - begin);
    last_ = Must(session_->Advance());
    const double seconds = Seconds(steady_clock::now() - begin);
    cpu_ = CpuSeconds() - cpu_begin;
    return seconds;
  }

  void SetAnswers(client::Answers answers) { session_->SetAnswers(answers); }

  [[nodiscard]] const client::AdvanceReport& last() const { return last_; }
  /// Of the last update, the part until its tensors were answered, or sent, in seconds.
  [[nodiscard]] double staging() const { return staging_; }
  /// CPU time of the last update, both ends.
  [[nodiscard]] double cpu() const { return cpu_; }
  [[nodiscard]] const std::vector<VertexId>& ids() const { return ids_; }
  [[nodiscard]] const std::vector<Metric>& tensors() const { return tensors_; }

 private:
  /// The solver's own work, which is not timed.
  void FindDisc() {
    const client::MeshReplica& replica = session_->replica();
    const auto slots = static_cast<std::int32_t>(replica.positions().size());
    ids_.clear();
    for (std::int32_t i = 0; i < slots; ++i) {
      const Vec2 from_middle = replica.positions()[static_cast<std::size_t>(i)] - Vec2{0.5, 0.5};
      if (replica.IsLive(VertexId(i)) && Dot(from_middle, from_middle) <= radius_squared_) {
        ids_.emplace_back(i);
      }
    }
  }

  double size_;
  double radius_squared_;
  std::unique_ptr<client::Session> session_;
  std::vector<VertexId> ids_;
  std::vector<Metric> tensors_;
  client::AdvanceReport last_;
  double staging_ = 0;
  double cpu_ = 0;
  bool small_ = false;
};

}  // namespace pliant::bench
