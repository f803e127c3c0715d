// What a server with many sessions costs, seen from its clients over loopback: JSON to standard
// output. tests/bench/README.md has the rows; timings here decide no test.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "client/cpp/client.h"
#include "core/base/rng.h"
#include "core/base/stop_signal.h"
#include "core/pliant/remesher.h"
#include "server/engine.h"
#include "server/limits.h"
#include "server/server.h"
#include "tests/bench/client_bench.h"

namespace pliant::bench {
namespace {

BenchServer ServerWith(int workers) {
  server::Config config;
  config.listen = "127.0.0.1:0";
  config.workers = workers;
  return BenchServer(config);
}

/// Updates of a small session on an idle server, and beside a large one that converges.
json Fairness(int workers, double large_nodes, int updates) {
  const BenchServer run = ServerWith(workers);
  client::Client client = run.Connect();
  DiscSession small(client, 1'000, 0.5);
  const auto measure = [&](int count, const std::atomic<bool>* until) {
    std::vector<double> seconds;
    for (int i = 0; i < count && (until == nullptr || !*until); ++i) {
      seconds.push_back(small.Update());
    }
    return seconds;
  };
  measure(20, nullptr);
  const json idle = Percentiles(measure(updates, nullptr));

  client::Client other = run.Connect();
  const auto large = Must(other.CreateSession(Square(), Uniform(SizeFor(large_nodes))));
  std::atomic<bool> done = false;
  double build_seconds = 0;
  std::thread builder([&] {
    const auto begin = steady_clock::now();
    Must(large->Advance());
    build_seconds = Seconds(steady_clock::now() - begin);
    done = true;
  });
  const std::vector<double> seconds = measure(1'000'000, &done);
  builder.join();
  const json busy = Percentiles(seconds);
  return {{"large_nodes", large->replica().summary().vertex_count},
          {"large_build_s", build_seconds},
          {"idle", idle},
          {"beside", busy},
          {"p99_ratio", busy["p99_ms"].get<double>() / idle["p99_ms"].get<double>()}};
}

/// Many sessions, each updated once a second by a few client threads.
json Sessions(int workers, int count, int seconds, int threads) {
  const BenchServer run = ServerWith(workers);
  std::vector<std::unique_ptr<DiscSession>> sessions(static_cast<std::size_t>(count));
  std::vector<client::Client> clients;
  for (int t = 0; t < threads; ++t) clients.push_back(run.Connect());
  const auto share_out = [&](auto&& work) {
    std::vector<std::thread> pool;
    for (int t = 0; t < threads; ++t) pool.emplace_back([&, t] { work(t); });
    for (std::thread& thread : pool) thread.join();
  };
  const auto first = steady_clock::now();
  share_out([&](int t) {
    for (int i = t; i < count; i += threads) {
      sessions[static_cast<std::size_t>(i)] =
          std::make_unique<DiscSession>(clients[static_cast<std::size_t>(t)], 1'000, 0.05);
    }
  });
  const double create_seconds = Seconds(steady_clock::now() - first);
  std::vector<double> rss;
  std::vector<std::vector<double>> latencies(static_cast<std::size_t>(threads));
  std::atomic<std::int64_t> late = 0;
  const auto begin = steady_clock::now();
  for (int second = 0; second < seconds; ++second) {
    share_out([&](int t) {
      for (int i = t; i < count; i += threads) {
        // Spread over the second, each at its own moment.
        const auto due = begin + std::chrono::seconds(second) +
                         std::chrono::microseconds(std::int64_t{1'000'000} * i / count);
        std::this_thread::sleep_until(due);
        sessions[static_cast<std::size_t>(i)]->Update();
        // From when it was due: a server that falls behind shows.
        const double latency = Seconds(steady_clock::now() - due);
        if (latency > 1) ++late;
        latencies[static_cast<std::size_t>(t)].push_back(latency);
      }
    });
    rss.push_back(RssMiB());
  }
  std::vector<double> all;
  for (const auto& part : latencies) all.insert(all.end(), part.begin(), part.end());
  const double wall = Seconds(steady_clock::now() - begin);
  return {{"sessions", count},
          {"create_s", create_seconds},
          {"latency", Percentiles(all)},
          {"updates_per_s", static_cast<double>(all.size()) / wall},
          {"later_than_1s", late.load()},
          {"rss_mib_first", rss.front()},
          {"rss_mib_middle", rss[rss.size() / 2]},
          {"rss_mib_last", rss.back()}};
}

/// What updates of one kind cost, against the core alone.
struct OverheadSamples {
  std::vector<double> ratios;
  std::vector<double> cpu_ratios;
  std::vector<double> totals;
  std::vector<double> staging;
  std::vector<double> around;  ///< From the advance to the applied replica, less loop and commit.

  [[nodiscard]] json Summary() const {
    return {{"end_to_end", Percentiles(totals)},
            {"staging", Percentiles(staging)},
            {"around_advance", Percentiles(around)},
            {"ratio_median", Percentiles(ratios)["p50_ms"].get<double>() * 1e-3},
            {"cpu_ratio_median", Percentiles(cpu_ratios)["p50_ms"].get<double>() * 1e-3}};
  }
};

/// End to end to the applied replica, in turns with the same updates in this process, which give
/// the same bits. Two updates, there and back, wait for every answer, the next two are sent ahead.
/// @param share  of the area, in which tensors change
/// @param updates  of each of the two ways; one more if that is odd
json Overhead(int workers, double nodes, double share, int updates) {
  const BenchServer run = ServerWith(workers);
  client::Client client = run.Connect();
  DiscSession session(client, nodes, share);
  const auto twin = Must(Remesher::Create(Square(), Uniform(SizeFor(nodes)), {}));
  Must(twin->Step({}));
  twin->Commit();
  OverheadSamples waiting;
  OverheadSamples ahead;
  std::vector<double> core;
  std::vector<double> core_staging;
  constexpr int kWarmUps = 4;
  for (int i = 0; i < kWarmUps + 2 * (updates + updates % 2); ++i) {
    const bool waits = i / 2 % 2 == 0;
    session.SetAnswers(waits ? client::Answers::kAtOnce : client::Answers::kWithAdvance);
    const double total = session.Update();
    const double cpu_begin = CpuSeconds();
    const auto begin = steady_clock::now();
    Must(twin->SetTensors(session.ids(), session.tensors()));
    const double staged = Seconds(steady_clock::now() - begin);
    Must(twin->Step({}));
    const MeshDiff diff = twin->Commit();
    const double alone = Seconds(steady_clock::now() - begin);
    const double cpu_alone = CpuSeconds() - cpu_begin;
    if (diff.summary != session.last().summary) Must(Error{ErrorCode::kReplicaMismatch, "twins"});
    if (i < kWarmUps) continue;
    core.push_back(alone);
    core_staging.push_back(staged);
    OverheadSamples& samples = waits ? waiting : ahead;
    samples.totals.push_back(total);
    samples.staging.push_back(session.staging());
    samples.around.push_back(total - session.staging() - Seconds(session.last().compute_time));
    samples.ratios.push_back(total / alone);
    samples.cpu_ratios.push_back(session.cpu() / cpu_alone);
  }
  return {{"nodes", session.last().summary.vertex_count},
          {"changed", session.ids().size()},
          {"core", Percentiles(core)},
          {"core_staging", Percentiles(core_staging)},
          {"waiting", waiting.Summary()},
          {"ahead", ahead.Summary()}};
}

MetricSpec DentedFormula(double nodes) {
  const std::string size = std::to_string(SizeFor(nodes));
  return {.source = SizeMetric{size + "*(1 - 0.2*exp(-400*((x-0.5)^2 + (y-0.5)^2)))"}};
}

std::unique_ptr<server::Engine> NewEngine(double nodes) {
  return Must(server::RemesherFactory()(
      {.start = Square(), .metric = Uniform(SizeFor(nodes)), .options = {}}));
}

/// Steps as a session does, until there is nothing left to do or somebody asks to stop.
void StepToTheEnd(server::Engine& engine, const StopSignal* stop) {
  StopReason reason = StopReason::kVisitBudget;
  while (reason == StopReason::kVisitBudget) {
    reason = Must(engine.Step({.visits_max = server::kVisitsPerStep, .stop = stop})).stop_reason;
  }
}

/// Never asks anybody to stop, and takes the time between two looks: what a cancel would wait for.
class LongestSilence final : public StopSignal {
 public:
  [[nodiscard]] bool asked() const override {
    End();
    return false;
  }
  void Begin() const { last_ = steady_clock::now(); }
  void End() const {
    const auto now = steady_clock::now();
    longest_ = std::max(longest_, now - last_);
    last_ = now;
  }
  /// The longest of all, in ms.
  [[nodiscard]] double longest_ms() const { return 1e3 * Seconds(longest_); }

 private:
  mutable steady_clock::time_point last_;
  mutable steady_clock::duration longest_{0};
};

/// Has some work stopped at random moments. @return how long it took from each request to the end
/// of the work, where it had not ended before; `undo` is called after each time
template <class Work, class Undo>
json StopAtRandom(double duration, int trials, Rng& rng, const Work& work, const Undo& undo) {
  std::vector<double> latencies;
  for (int i = 0; i < trials; ++i) {
    StopFlag stop;
    steady_clock::time_point asked;
    const auto wait = std::chrono::duration<double>(duration * rng.Unit());
    std::thread stopper([&] {
      std::this_thread::sleep_for(wait);
      asked = steady_clock::now();
      stop.Set(true);
    });
    work(&stop);
    const auto end = steady_clock::now();
    stopper.join();
    undo();
    if (end > asked) latencies.push_back(Seconds(end - asked));
  }
  return latencies.empty() ? json{{"count", 0}} : Percentiles(latencies);
}

MetricSpec Limited(MetricSpec spec) {
  spec.gradation.gradation = 1.05;
  return spec;
}

/// Every vertex inside the square goes a little way, each another one.
MotionRequest Shake(const MeshDiff& snapshot, double by) {
  MotionRequest request;
  for (std::size_t i = 0; i < snapshot.vertex_ids.size(); ++i) {
    const Vec2 p = snapshot.vertex_positions[i];
    if (p.x <= 0 || p.x >= 1 || p.y <= 0 || p.y >= 1) continue;
    const double phase = 0.7 * static_cast<double>(i);
    request.vertices.push_back(snapshot.vertex_ids[i]);
    request.positions.push_back(p + by * Vec2{std::sin(phase), std::cos(phase)});
  }
  return request;
}

/// One side goes inwards, with a layer of a tenth of the square.
MotionRequest PushedSide(double nodes) {
  MotionRequest request;
  request.tags = {{{4}, Translation{{10 * SizeFor(nodes), 0}}}};
  request.follow_length = 0.1 / SizeFor(nodes);
  return request;
}

/// With a hole that takes a quarter of it.
Domain SquareWithHole() {
  Domain domain = Square();
  constexpr int kCorners = 64;
  for (int i = 0; i < kCorners; ++i) {
    const double angle = 6.283185307179586 * i / kCorners;
    domain.points.push_back(Vec2{0.5, 0.5} + 0.28 * Vec2{std::cos(angle), std::sin(angle)});
    domain.segments.push_back({4 + i, 4 + (i + 1) % kCorners, 5});
  }
  domain.holes.push_back({0.5, 0.5});
  return domain;
}

/// How soon advances end that follow a motion: a cancelled one commits what it has.
json CancelAdvances(server::Engine& engine, const MotionRequest& motion, int trials, Rng& rng) {
  std::int64_t revision = static_cast<std::int64_t>(engine.revision());
  double commit = 0;
  const auto advance = [&](const StopSignal* stop) {
    StepToTheEnd(engine, stop);
    const auto begin = steady_clock::now();
    (void)engine.Commit();
    commit = Seconds(steady_clock::now() - begin);
  };
  const auto go_back = [&] {
    revision += 2;
    const std::optional<RevisionDelta> way = engine.TakeUndo();
    (void)Must(engine.Apply(*way, Revision(revision)));
    (void)Must(engine.Move(motion));
  };
  (void)Must(engine.Move(motion));
  const LongestSilence silence;
  silence.Begin();
  const auto begin = steady_clock::now();
  advance(&silence);
  const double duration = Seconds(steady_clock::now() - begin);
  const double whole_commit = commit;
  go_back();
  json result = StopAtRandom(duration, trials, rng, advance, go_back);
  result["whole_ms"] = 1e3 * duration;
  result["commit_ms"] = 1e3 * whole_commit;
  result["longest_unasked_ms"] = silence.longest_ms();
  engine.Rollback();
  return result;
}

/// How soon a first build and the staging of updates end when they are told to.
json Cancels(double nodes, int trials) {
  Rng rng(/*seed=*/5);
  json result;
  const auto time = [](const auto& work) {
    const auto begin = steady_clock::now();
    work();
    return Seconds(steady_clock::now() - begin);
  };
  std::unique_ptr<server::Engine> engine = NewEngine(nodes);
  const double build = time([&] { StepToTheEnd(*engine, nullptr); });
  (void)engine->Commit();
  std::unique_ptr<server::Engine> other;
  result["build"] = StopAtRandom(
      build, trials, rng,
      [&](const StopSignal* stop) {
        other = NewEngine(nodes);
        StepToTheEnd(*other, stop);
      },
      [&] { other = nullptr; });
  const std::vector<VertexId> vertices = engine->Vertices();
  const std::vector<Metric> tensors(vertices.size(), Metric::Isotropic(0.9 * SizeFor(nodes)));
  const auto stage = [&](const std::string& name, const auto& update) {
    const LongestSilence silence;
    engine->ListenTo(&silence);
    const double duration = time([&] {
      silence.Begin();
      Must(update());
      silence.End();
    });
    const auto undo = [&] {
      engine->ListenTo(nullptr);
      engine->Rollback();
    };
    undo();
    const auto work = [&](const StopSignal* stop) {
      engine->ListenTo(stop);
      (void)update();
    };
    result[name] = StopAtRandom(duration, trials, rng, work, undo);
    result[name]["whole_ms"] = 1e3 * duration;
    result[name]["longest_unasked_ms"] = silence.longest_ms();
  };
  stage("stage_formula", [&] { return engine->SetMetric(DentedFormula(nodes)); });
  stage("stage_limits", [&] { return engine->SetMetric(Limited(DentedFormula(nodes))); });
  stage("stage_all_tensors",
        [&] { return engine->SetTensors(vertices, tensors, {engine->limits()}); });
  const MotionRequest shake = Shake(engine->Snapshot(), 0.05 * SizeFor(nodes));
  stage("move_nodes", [&] { return engine->Move(shake); });
  stage("move_boundary", [&] { return engine->Move(PushedSide(nodes)); });
  stage("replace_domain", [&] { return engine->ReplaceDomain(SquareWithHole()); });
  Must(engine->SetMetric(Limited(Uniform(SizeFor(nodes)))));
  StepToTheEnd(*engine, nullptr);
  (void)engine->Commit();
  stage("stage_formula_under_limits",
        [&] { return engine->SetMetric(Limited(DentedFormula(nodes))); });
  result["advance_under_limits"] = CancelAdvances(*engine, shake, trials, rng);
  result["build"]["whole_ms"] = 1e3 * build;
  return {{"nodes", vertices.size()}, {"phases", result}};
}

/// How long a worker is busy without a look at the clock: a first build and two
/// updates as a session runs them, step by step.
json Stretches(double nodes) {
  json phases;
  const auto time = [&](const std::string& phase, const auto& work) {
    const auto begin = steady_clock::now();
    work();
    phases[phase] = 1e3 * Seconds(steady_clock::now() - begin);
  };
  std::unique_ptr<server::Engine> engine;
  time("read_input_ms", [&] { engine = NewEngine(nodes); });
  const auto run = [&](const std::string& phase) {
    std::vector<double> steps;
    const LongestSilence silence;
    for (bool more = true; more;) {
      const auto begin = steady_clock::now();
      silence.Begin();
      const Progress progress =
          Must(engine->Step({.visits_max = server::kVisitsPerStep, .stop = &silence}));
      silence.End();
      steps.push_back(Seconds(steady_clock::now() - begin));
      more = progress.stop_reason == StopReason::kVisitBudget;
    }
    phases[phase] = Percentiles(steps);
    phases[phase]["longest_unasked_ms"] = silence.longest_ms();
    phases[phase]["longer_than_10_ms"] =
        std::count_if(steps.begin(), steps.end(), [](double step) { return step > 0.01; });
    TroubleSearch search;
    time(phase + "_commit_ms", [&] {
      search = engine->WhereTroublesMayBe();
      (void)engine->Commit();
    });
    time(phase + "_troubles_ms", [&] { (void)engine->FindTroubles(search); });
    time(phase + "_undo_ms", [&] { (void)engine->TakeUndo(); });
  };
  run("build");
  time("stage_formula_ms", [&] { Must(engine->SetMetric(DentedFormula(nodes))); });
  run("formula");
  const std::vector<VertexId> vertices = engine->Vertices();
  const std::vector<Metric> tensors(vertices.size(), Metric::Isotropic(0.98 * SizeFor(nodes)));
  time("stage_all_tensors_ms",
       [&] { Must(engine->SetTensors(vertices, tensors, {engine->limits()})); });
  run("tensors");
  time("snapshot_ms", [&] { (void)engine->Snapshot(); });
  return {{"phases", phases}};
}

}  // namespace

int Main(int argc, char** argv) {
  CLI::App app("What a server with many sessions costs, as JSON", "server_bench");
  std::string what;
  int workers = 2;
  double nodes = 0;
  double share = 0.01;
  int updates = 300;
  int count = 1'000;
  int seconds = 20;
  int threads = 8;
  app.add_option("what", what, "fairness, sessions, overhead, stretches or cancels")
      ->required()
      ->check(CLI::IsMember({"fairness", "sessions", "overhead", "stretches", "cancels"}));
  app.add_option("--workers", workers, "Of the server")->capture_default_str();
  app.add_option("--nodes", nodes, "Of the large mesh; 0: 1,000,000, for overhead 100,000");
  app.add_option("--share", share, "Of the area, whose tensors change, for overhead")
      ->check(CLI::Range(1e-6, 1.0))
      ->capture_default_str();
  app.add_option("--updates", updates, "To measure")->capture_default_str();
  app.add_option("--count", count, "Sessions")->capture_default_str();
  app.add_option("--seconds", seconds, "Each session is updated so often")->capture_default_str();
  app.add_option("--threads", threads, "Client threads")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  json result;
  if (what == "fairness") {
    result = Fairness(workers, nodes > 0 ? nodes : 1e6, updates);
  } else if (what == "stretches") {
    result = Stretches(nodes > 0 ? nodes : 1e6);
  } else if (what == "cancels") {
    result = Cancels(nodes > 0 ? nodes : 1e6, updates);
  } else if (what == "sessions") {
    result = Sessions(workers, count, seconds, threads);
  } else {
    result = Overhead(workers, nodes > 0 ? nodes : 1e5, share, updates);
  }
  result["bench"] = what;
  result["workers"] = workers;
  std::cout << result.dump(2) << '\n';
  return 0;
}

}  // namespace pliant::bench

int main(int argc, char** argv) { return pliant::bench::Main(argc, argv); }
