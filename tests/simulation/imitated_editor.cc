#include "tests/simulation/imitated_editor.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>
#include <vector>

#include "tests/simulation/simulated_server.h"
#include "tests/support/wire_arrays.h"

namespace pliant::simulation {
namespace {

constexpr std::size_t kUnansweredMax = 5;

}  // namespace

void ImitatedEditor::Act() {
  if (link_ == nullptr) return Connect();
  if (!is_open_ || unanswered_.size() >= kUnansweredMax) return;
  Send(RandomUpdate());
}

void ImitatedEditor::Connect() {
  link_ = world_.Connect();
  is_open_ = false;
  v1::EditRequest request;
  request.mutable_open()->set_session_id(world_.server().places().front().id);
  request.mutable_open()->set_mirror_revision(mirror_.revision);
  link_->up.push_back(std::move(request));
}

void ImitatedEditor::Send(v1::EditRequest request) {
  link_->up.push_back(request);
  unanswered_.emplace(request.update_id(), std::move(request));
}

void ImitatedEditor::Cancel() {
  if (link_ == nullptr || !is_open_) return;
  v1::EditRequest request;
  request.mutable_cancel()->set_advance_update_id(last_update_id_);
  link_->up.push_back(std::move(request));
}

v1::EditRequest ImitatedEditor::RandomUpdate() {
  Rng& rng = world_.rng();
  v1::EditRequest request;
  request.set_update_id(++last_update_id_);
  const std::uint64_t kind = rng.Below(11);
  if (kind < 5) {
    v1::Advance& advance = *request.mutable_advance();
    if (rng.Below(2) == 0) advance.set_budget_visits(1 + static_cast<int>(rng.Below(60)));
    if (rng.Below(2) == 0) advance.set_budget_ms(1 + static_cast<int>(rng.Below(5) / 3));
    if (rng.Below(3) == 0) advance.set_commit_interval_ms(10);
  } else if (kind < 7) {
    request.mutable_metric()->add_sources()->mutable_size()->set_size(
        rng.Below(6) == 0 ? "-1" : std::to_string(rng.Uniform(0.2, 0.6)));
  } else if (kind < 9) {
    const double m = 1 / rng.Uniform(0.04, 0.36);
    std::vector<double> tensors;
    for (std::size_t i = 0; i < mirror_.vertices.size(); ++i) {
      tensors.insert(tensors.end(), {m, 0, m});
    }
    v1::VertexMetric& vertices = *request.mutable_metric()->add_sources()->mutable_vertices();
    vertices.set_revision(mirror_.revision);
    *vertices.mutable_tensors() = test::Doubles(tensors, 3);
  } else if (kind < 10) {
    request.mutable_discard();
  } else {
    request.mutable_rollback()->set_to_revision(
        std::max<std::int64_t>(1, mirror_.revision - static_cast<std::int64_t>(rng.Below(4))));
  }
  return request;
}

void ImitatedEditor::Receive() {
  if (link_ == nullptr) return;
  if (link_->down.empty()) {
    if (!link_->end && !link_->is_dead) return;
    if (link_->end && link_->end->error_code() == grpc::StatusCode::ABORTED) ++busy_count_;
    return Lose();
  }
  const v1::EditResponse response = std::move(link_->down.front());
  link_->down.pop_front();
  link_->place->session->Wake();  // There is room for answers again.
  Take(response);
}

void ImitatedEditor::Take(const v1::EditResponse& response) {
  transcript_.seen.push_back(response);
  if (response.has_opened()) {
    is_open_ = true;
    last_update_id_ = std::max(last_update_id_, response.opened().last_update_id());
    for (const auto& [id, request] : unanswered_) link_->up.push_back(request);
  } else if (response.has_diff()) {
    if (response.diff().revision() - response.diff().base_revision() > 1) ++merged_count_;
    if (const std::string wrong = mirror_.Apply(response.diff()); !wrong.empty()) {
      world_.Fail(test::Broken(test::kComplete, wrong));
    }
  } else if (response.has_snapshot()) {
    ++snapshot_count_;
    if (const std::string wrong = mirror_.Take(response.snapshot()); !wrong.empty()) {
      world_.Fail(test::Broken(test::kComplete, wrong));
    }
  } else if (!response.has_progress()) {
    const std::int64_t id = response.update_id();
    if (unanswered_.empty() || unanswered_.begin()->first != id) {
      world_.Fail("the answer to update " + std::to_string(id) + " came out of order");
    }
    unanswered_.erase(id);
    unfinished_count_ += response.advanced().active_count() > 0;
  }
}

void ImitatedEditor::Lose() {
  if (link_ == nullptr) return;
  is_open_ = false;
  world_.Leave(std::exchange(link_, nullptr));
}

bool ImitatedEditor::Finish() {
  if (link_ == nullptr) Connect();
  Receive();
  if (link_ == nullptr || !is_open_ || !unanswered_.empty()) return false;
  if (is_last_sent_) return link_->down.empty();
  is_last_sent_ = true;
  v1::EditRequest discard;
  discard.set_update_id(++last_update_id_);
  discard.mutable_discard();
  Send(std::move(discard));
  return false;
}

}  // namespace pliant::simulation
