#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tests/support/fake_server_parts.h"

/// One session with a fake engine on a scheduler without threads: a test runs its slices by hand.
namespace pliant::server {

struct SessionHarness {
  /// @param real  what a real engine starts from; absent: a fake one that follows `first`
  explicit SessionHarness(FakeEngineScript first = {}, const std::optional<EngineInput>& real = {})
      : script(std::make_shared<FakeEngineScript>(std::move(first))),
        scheduler(/*worker_count=*/0, clock) {
    session = std::make_shared<Session>(
        Session::Environment{.clock = &clock,
                             .scheduler = &scheduler,
                             .log = &log,
                             .factory = real ? RemesherFactory() : FakeFactory(script),
                             .on_broken = [this](const std::string& id) { broken.push_back(id); }},
        "s1", std::map<std::string, std::string>{{"case", "7"}});
    session->Start(real.value_or(EngineInput{}),
                   [this](const Status& status) { start_status = status; });
    RunAll();
  }

  /// Runs slices until nobody wants one.
  void RunAll() {
    while (scheduler.RunOne()) {
    }
  }

  /// A new editor with these commands, run to the end.
  std::shared_ptr<FakeEditor> Edit(std::vector<SessionCommand> commands) {
    auto editor = std::make_shared<FakeEditor>();
    editor->commands.assign(commands.begin(), commands.end());
    attach_status = session->Attach(editor);
    session->Wake();
    RunAll();
    return editor;
  }

  static UpdateCommand MetricAtTime(std::int64_t update_id, double time) {
    return {.update_id = update_id, .body = MetricUpdate{.source = {}, .time = time}};
  }
  static UpdateCommand AdvanceOf(std::int64_t update_id, AdvanceSpec spec = {}) {
    return {.update_id = update_id, .body = spec};
  }

  ManualClock clock;
  Log log{LogLevel::kError, LogFormat::kText};
  std::shared_ptr<FakeEngineScript> script;
  Scheduler scheduler;
  std::vector<std::string> broken;
  std::optional<Status> start_status;
  Status attach_status;
  std::shared_ptr<Session> session;
};

inline constexpr auto kMetric = &SessionHarness::MetricAtTime;

inline UpdateCommand Advance(std::int64_t update_id, AdvanceSpec spec = {}) {
  return SessionHarness::AdvanceOf(update_id, spec);
}

/// What the editor was told at this place, which must be a `Body`.
template <class Body>
const Body& BodyOf(const FakeEditor& editor, std::size_t index) {
  return std::get<Body>(editor.events.at(index).body);
}

}  // namespace pliant::server
