#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "server/jobs/jobs.h"
#include "server/jobs/memory_job_store.h"
#include "tests/support/fake_server_parts.h"

/// The jobs of a server with fake engines on a scheduler without threads: a test runs their slices
/// by hand.
namespace pliant::server {

inline Bytes BytesOf(std::string_view text) {
  const auto* begin = reinterpret_cast<const std::byte*>(text.data());
  return {begin, begin + text.size()};
}

inline std::string TextOf(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// Inputs are texts: "budget N" or anything. Outcomes are texts too.
inline JobCodec TextCodec() {
  return {.read_input = [](std::span<const std::byte> bytes) -> Result<JobInput> {
            const std::string text = TextOf(bytes);
            if (text == "bad") return Error{ErrorCode::kDataCorrupt, "bad", "input"};
            JobInput input;
            if (text.starts_with("budget ")) input.advance.visits_max = std::stoll(text.substr(7));
            if (text == "time") input.advance.time_max = std::chrono::milliseconds(5);
            return input;
          },
          .write_result =
              [](const JobResult& result) {
                const AdvancedEvent& advanced = result.advanced;
                return BytesOf("revision " +
                               std::to_string(static_cast<std::int64_t>(result.revision)) +
                               " visits " + std::to_string(advanced.progress.counts.visits) +
                               " active " + std::to_string(advanced.progress.active_count) +
                               " troubles " + std::to_string(advanced.troubles.size()) +
                               " vertices " + std::to_string(result.quality.vertex_count) +
                               (advanced.end == AdvanceEnd::kTimeBudget ? " late" : ""));
              },
          .write_error =
              [](const Error& error) {
                return BytesOf(std::string(ErrorCodeName(error.code)) + " " + error.field);
              }};
}

/// A store that a test makes fail, or durable.
class ScriptedJobStore final : public JobStore {
 public:
  [[nodiscard]] bool durable() const override { return is_durable; }
  void Create(const JobInfo& info, Bytes input, Done done) override {
    if (create_error) return done(*create_error);
    kept.Create(info, std::move(input), std::move(done));
  }
  void End(const JobInfo& ended, Bytes mesh, Done done) override {
    if (end_error) return done(*end_error);
    kept.End(ended, std::move(mesh), std::move(done));
  }
  void Delete(const JobKey& key, Done done) override { kept.Delete(key, std::move(done)); }
  Result<SharedBytes> LoadInput(const JobKey& key) override { return kept.LoadInput(key); }
  Result<SharedBytes> LoadMesh(const JobKey& key) override { return kept.LoadMesh(key); }
  Result<std::vector<JobInfo>> List() override {
    if (list_error) return *list_error;
    return kept.List();
  }

  bool is_durable = false;
  std::optional<Error> create_error;
  std::optional<Error> end_error;
  std::optional<Error> list_error;
  MemoryJobStore kept;
};

struct JobHarness {
  explicit JobHarness(FakeEngineScript first = {}, std::size_t running_max = 1)
      : script(std::make_shared<FakeEngineScript>(std::move(first))),
        bounds({.jobs_max = 100,
                .jobs_per_tenant_max = 100,
                .bytes_max = 10'000,
                .bytes_per_tenant_max = 10'000,
                .running_max = running_max}) {
    script->clock = &clock;
    Restart();
  }

  /// A new server on the same store.
  void Restart() {
    scheduler = std::make_unique<Scheduler>(/*worker_count=*/0, clock);
    jobs = std::make_unique<Jobs>(Jobs::Environment{.clock = &clock,
                                                    .log = &log,
                                                    .scheduler = scheduler.get(),
                                                    .store = &store,
                                                    .accounts = accounts.get(),
                                                    .factory = FakeFactory(script),
                                                    .codec = TextCodec()},
                                  bounds, /*seed=*/1);
  }

  /// Limits for all tenants, from the next Restart on.
  void Limit(const TenantLimits& limits) {
    accounts = std::make_unique<TenantAccounts>(limits);
    Restart();
  }

  Result<JobInfo> Submit(const std::string& id, std::string_view input = "", int priority = 0) {
    std::optional<Result<JobInfo>> answer;
    jobs->Submit({.key = {"t", id},
                  .priority = priority,
                  .keep = std::chrono::hours(1),
                  .input_size = input.size()},
                 BytesOf(input), [&](const Result<JobInfo>& job) { answer = job; });
    return answer.value();
  }
  Result<JobInfo> Cancel(const std::string& id) {
    std::optional<Result<JobInfo>> answer;
    jobs->Cancel({"t", id}, [&](const Result<JobInfo>& job) { answer = job; });
    return answer.value();
  }
  Result<MeshDiff> Fetch(const std::string& id) {
    std::optional<Result<MeshDiff>> answer;
    jobs->Fetch({"t", id}, [&](const Result<MeshDiff>& mesh) { answer = mesh; });
    RunAll();
    return answer.value();
  }
  JobInfo Get(const std::string& id) { return jobs->Get({"t", id}).value(); }
  std::string OutcomeOf(const std::string& id) { return TextOf(*Get(id).outcome); }

  /// Runs slices until nobody wants one.
  void RunAll() {
    while (scheduler->RunOne()) {
    }
  }

  ManualClock clock;
  Log log{LogLevel::kError, LogFormat::kText};
  std::shared_ptr<FakeEngineScript> script;
  JobBoard::Bounds bounds;
  ScriptedJobStore store;
  std::unique_ptr<Scheduler> scheduler;
  std::unique_ptr<TenantAccounts> accounts;  // Null: nobody counts.
  std::unique_ptr<Jobs> jobs;
};

}  // namespace pliant::server
