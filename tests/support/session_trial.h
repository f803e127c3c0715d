#pragma once

#include <algorithm>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "pliant/v1/edit.pb.h"
#include "server/blobs.h"
#include "server/convert.h"
#include "server/convert_reply.h"
#include "server/session.h"
#include "tests/support/fake_server_parts.h"
#include "tests/support/mirror.h"
#include "tests/support/pieces.h"

namespace pliant::test {

/// A real session, on a scheduler without threads, with a small square in it.
class SessionTrial {
 public:
  SessionTrial() : scheduler_(/*worker_count=*/0, clock_) {
    session_ = std::make_shared<server::Session>(
        server::Session::Environment{
            .clock = &clock_,
            .scheduler = &scheduler_,
            .log = &log_,
            .factory = server::RemesherFactory(),
            .on_broken = [this](const std::string&) { is_broken_ = true; }},
        "s1", std::map<std::string, std::string>());
    Domain square{.points = {{0, 0}, {1, 0}, {1, 1}, {0, 1}},
                  .segments = {{0, 1, 1}, {1, 2, 2}, {2, 3, 3}, {3, 0, 4}},
                  .holes = {},
                  .regions = {}};
    session_->Start({.start = std::move(square),
                     .metric = {.source = SizeMetric{"0.3"}},
                     .options = {.vertices_max = kVerticesMax}},
                    [](const Status&) {});
    editor_->commands.emplace_back(server::OpenCommand{});
    static_cast<void>(session_->Attach(editor_));
    RunAll();
  }

  /// One command, run to its answer; what is wrong, or nothing.
  std::string Run(v1::EditRequest request) {
    server::BlobAssembler blobs;
    server::UpdateCommand command{.update_id = request.update_id()};
    if (const Status status = blobs.Resolve(request); !status.ok()) {
      command.body = server::BadUpdate{status.error()};
    } else {
      command = server::ConvertUpdate(request, {.vertices_max = kVerticesMax});
    }
    if (auto* advance = std::get_if<server::AdvanceSpec>(&command.body)) {
      advance->visits_max = std::min<std::int64_t>(advance->visits_max, kVisitsMax);
    }
    const std::size_t first = editor_->events.size();
    const int done = editor_->done_count;
    editor_->commands.emplace_back(std::move(command));
    session_->Wake();
    RunAll();
    if (is_broken_) return "a bug was met";
    if (editor_->done_count != done + 1) return "a command was not answered";
    return Check(first, request.update_id());
  }

  /// Commands that were not refused.
  [[nodiscard]] int accepted_count() const { return accepted_count_; }

  /// What the last refusal said, or nothing.
  [[nodiscard]] const std::string& last_refusal() const { return last_refusal_; }

  /// What is wrong with the session's mesh, or nothing.
  std::string CheckMesh() {
    std::string wrong;
    const auto call = [&](const Result<const server::CommittedState*>& state) {
      if (!state.ok()) return;  // Nothing was committed.
      if ((*state)->staged_count == 0) {
        for (const std::string& fault : (*state)->engine.Validate()) wrong = fault;
      }
      Mirror fresh;
      const v1::MeshSnapshot snapshot =
          server::ToMeshSnapshot((*state)->engine.Snapshot(), server::ReplyContext{});
      if (wrong.empty()) wrong = fresh.Take(snapshot);
      if (wrong.empty() && !(fresh == mirror_)) wrong = "the mirror is not the server's mesh";
    };
    if (!session_->Post(call).ok()) return "a call was refused";
    RunAll();
    return wrong;
  }

 private:
  static constexpr std::int32_t kVerticesMax = 1'000;
  static constexpr std::int64_t kVisitsMax = 3'000;

  void RunAll() {
    while (scheduler_.RunOne()) {
    }
  }

  /// Exactly one answer, with a reason if it is a refusal, and diffs that fit the mirror.
  std::string Check(std::size_t first, std::int64_t update_id) {
    int answers = 0;
    for (std::size_t i = first; i < editor_->events.size(); ++i) {
      const server::SessionEvent& event = editor_->events[i];
      if (const auto* diff = std::get_if<server::DiffEvent>(&event.body)) {
        const std::string wrong = mirror_.Apply(server::ToMeshDiff(*diff->diff, {}));
        if (!wrong.empty()) return wrong;
        continue;
      }
      if (std::holds_alternative<server::ProgressEvent>(event.body)) continue;
      ++answers;
      if (event.update_id != update_id) return "the answer has another number";
      if (const auto* rejected = std::get_if<server::RejectedEvent>(&event.body)) {
        last_refusal_ = rejected->error.message;
        if (last_refusal_.empty()) return "a refusal says nothing";
        if (rejected->error.code == ErrorCode::kInternal) return rejected->error.message;
      } else {
        ++accepted_count_;
      }
    }
    editor_->events.clear();
    return answers == 1 ? "" : std::to_string(answers) + " answers";
  }

  server::ManualClock clock_;
  server::Log log_{server::LogLevel::kError, server::LogFormat::kText};
  server::Scheduler scheduler_;
  std::shared_ptr<server::Session> session_;
  std::shared_ptr<server::FakeEditor> editor_ = std::make_shared<server::FakeEditor>();
  Mirror mirror_;
  int accepted_count_ = 0;
  std::string last_refusal_;
  bool is_broken_ = false;
};

/// True for the kinds of command that a stream hands to ConvertUpdate.
inline bool IsUpdate(const v1::EditRequest& request) {
  return !request.has_open() && !request.has_chunk() && !request.has_cancel() &&
         !request.has_acknowledge() && request.command_case() != v1::EditRequest::COMMAND_NOT_SET;
}

/// Pieces are the commands of an edit stream, in order. A command without a number gets the next
/// one, and so does one whose choice is even: mutations would hardly find growing numbers.
inline std::string TrySession(std::string_view bytes) {
  constexpr std::size_t kCommandsMax = 24;
  SessionTrial trial;
  std::int64_t last_id = 0;
  std::size_t count = 0;
  for (const Piece& piece : Cut(bytes)) {
    v1::EditRequest request;
    if (!request.ParseFromString(piece.bytes) || !IsUpdate(request)) continue;
    if (++count > kCommandsMax) break;
    if (request.update_id() <= 0 || piece.choice % 2 == 0) request.set_update_id(last_id + 1);
    last_id = std::max(last_id, request.update_id());
    if (last_id == INT64_MAX) break;
    if (const std::string wrong = trial.Run(std::move(request)); !wrong.empty()) return wrong;
  }
  return trial.CheckMesh();
}

}  // namespace pliant::test
