// Takes one first build apart: visits and CPU time of every level of the nested build, of the
// refinements between them and of the first commit, and the memory. The same calls as a Remesher
// makes; limit.py runs it, also under valgrind. tests/bench/README.md, "How far from the limit".
#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "core/base/freed_memory.h"
#include "core/delaunay/import_mesh.h"
#include "core/mesh/mesh_edit.h"
#include "core/pliant/loop.h"
#include "core/pliant/nested_build.h"
#include "tests/bench/workload_run.h"

namespace {

using pliant::bench::TimeOf;

/// Turns of a chain of dependent additions take one cycle each: the clock that this core has now.
double ClockGhz() {
  constexpr long kTurns = 200'000'000;
  long sum = 1;
  const auto time = TimeOf([&] {
    for (long i = 0; i < kTurns; ++i) asm volatile("add $1, %0" : "+r"(sum));
  });
  return 1e-9 * static_cast<double>(kTurns) / time.cpu;
}

/// One build, each of whose phases takes its time from the one before.
class Phases {
 public:
  explicit Phases(const pliant::bench::BenchCase& instance) : edit_(mesh_), loop_(edit_, options_) {
    const double before = pliant::bench::ResidentMemoryMib();
    const auto start = TimeOf([&] {
      BuildFromPlan(*pliant::PlanDomain(instance.domain), edit_);
      nested_.emplace(edit_, loop_, std::shared_ptr(instance.field()), options_);
    });
    report_["start_cpu_s"] = start.cpu;
    RunLevels();
    const auto commit = TimeOf([&] {
      edit_.Compact();
      (void)edit_.Commit(pliant::Revision(1));
      pliant::ReturnFreedMemory();  // As Remesher does.
    });
    report_["commit_cpu_s"] = commit.cpu;
    const double mib_per_node = 1048576.0 / mesh_.vertex_count();
    report_["peak_bytes_per_node"] = mib_per_node * (pliant::bench::PeakMemoryMib() - before);
    report_["bytes_per_node"] = mib_per_node * (pliant::bench::ResidentMemoryMib() - before);
  }

  [[nodiscard]] const nlohmann::json& report() const { return report_; }

 private:
  void RunLevels() {
    for (;;) {
      const auto visits_before = loop_.counts().visits;
      const auto run = TimeOf([&] { (void)nested_->Run({}, alone_); });
      nlohmann::json level = {{"nodes", mesh_.vertex_count()},
                              {"visits", loop_.counts().visits - visits_before},
                              {"loop_cpu_s", run.cpu}};
      if (nested_->levels_left() > 0) {
        level["refine_cpu_s"] = TimeOf([&] { (void)nested_->NextLevel(alone_, nullptr); }).cpu;
        report_["levels"].push_back(level);
        continue;
      }
      report_["levels"].push_back(level);
      return;
    }
  }

  const pliant::Options options_;
  const pliant::Helpers alone_;  // None: one thread.
  pliant::Mesh mesh_;
  pliant::MeshEdit edit_;
  pliant::PliantLoop loop_;
  std::optional<pliant::NestedBuild> nested_;
  nlohmann::json report_;
};

}  // namespace

int main(int argc, char** argv) {
  pliant::bench::CaseRequest request;
  CLI::App app("Times the phases of a first build; the report is JSON.");
  app.add_option("--case", request.name, "A, B, C, C1000, E or F");
  app.add_option("--nodes", request.node_count, "wanted nodes")->check(CLI::PositiveNumber);
  CLI11_PARSE(app, argc, argv);
  const auto instance = MakeCase(request);
  if (!instance.ok()) {
    std::cerr << instance.error().message << '\n';
    return 1;
  }
  nlohmann::json report = Phases(*instance).report();
  report["clock_ghz"] = ClockGhz();
  std::cout << report.dump(2) << '\n';
  return 0;
}
