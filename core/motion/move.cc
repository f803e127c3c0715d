#include "core/motion/move.h"

#include <algorithm>
#include <iomanip>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "core/motion/advance.h"
#include "core/motion/contact.h"
#include "core/motion/plan.h"
#include "core/pliant/mesh_change.h"

namespace pliant {
namespace {

class Motion final : public MeshChange {
 public:
  Motion(const MotionRequest& request, const std::function<void(const Mesh&)>& observer)
      : request_(request), observer_(observer) {}

  Result<Outcome> Apply(MeshEdit& edit) override {
    const Mesh& mesh = edit.mesh();
    report_ = {};
    PLIANT_ASSIGN_OR_RETURN(MotionPlan plan, MotionPlan::Make(mesh, request_, stop()));
    edit.CutSegments(plan.cuts());
    plan.FindRiders(mesh);
    double limit = 1;
    if (const std::optional<Contact> contact = FindContact(mesh, plan)) {
      report_.first_edge = contact->first;
      report_.second_edge = contact->second;
      report_.fraction = contact->time;
      if (request_.on_impossible == ImpossibleMotion::kRefuse) return Refusal();
      limit = FreeTimeBefore(*contact, mesh, plan);
    }
    plan.AddFollowers(mesh);
    if (stop_asked()) return Stopped();
    Advance advance(edit, plan, [&](double) {
      if (observer_) observer_(mesh);
    });
    const double reached = limit > 0 ? advance.RunTo(limit) : 0;
    if (stop_asked()) return Stopped();
    const EdgeId first = report_.first_edge;
    const EdgeId second = report_.second_edge;
    report_ = advance.report();
    report_.fraction = reached;
    report_.first_edge = first;
    report_.second_edge = second;
    if (reached < limit && advance.Misplaced() &&
        request_.on_impossible == ImpossibleMotion::kRefuse) {
      return Misplaced(*advance.Misplaced());
    }
    if (reached < limit) {
      report_.first_edge = advance.Blockers().first;
      report_.second_edge = advance.Blockers().second;
      if (request_.on_impossible == ImpossibleMotion::kRefuse) return Refusal();
    }
    return OutcomeOf(edit, plan, advance);
  }

  [[nodiscard]] const MotionReport& report() const { return report_; }

 private:
  /// @param why  has vertices for indices
  [[nodiscard]] Error Misplaced(const Error& why) const {
    const auto entry_of = [&](std::int64_t vertex) {
      const auto& all = request_.vertices;
      const auto at =
          std::find(all.begin(), all.end(), VertexId(static_cast<std::int32_t>(vertex)));
      return at == all.end() ? std::int64_t{-1} : std::int64_t{at - all.begin()};
    };
    std::int64_t vertex = why.index;
    std::int64_t other = why.other_index;
    if (entry_of(vertex) < 0) std::swap(vertex, other);
    Error error{why.code, "", "motion.positions"};
    error.index = entry_of(vertex);
    std::string where = "outside of the domain";
    if (why.code == ErrorCode::kPointOnSegment) where = "on a constrained edge";
    if (why.code == ErrorCode::kDuplicatePoint) {
      where = "where vertex " + std::to_string(other) + " comes to be";
      error.other_index = entry_of(other);
    }
    error.message = "entry " + std::to_string(error.index) + " of motion.positions, for vertex " +
                    std::to_string(vertex) + " in the interior, lies " + where +
                    "; send positions inside the domain, no two alike, or ask to stop before that";
    return error;
  }

  [[nodiscard]] Error Refusal() const {
    std::ostringstream message;
    const bool edges_meet = report_.second_edge.valid();
    // Enough digits to tell the last share that is tried from the whole.
    message << std::setprecision(10)
            << (edges_meet ? "boundaries would cross" : "triangles would turn over")
            << ": the motion can go as far as " << report_.fraction << " of its way";
    if (edges_meet) {
      message << ", where edges " << report_.first_edge << " and " << report_.second_edge
              << " meet";
    }
    message << "; send a motion that avoids this, or ask to stop there";
    Error error{ErrorCode::kCrossingSegments, message.str(), edges_meet ? "edges" : "motion"};
    error.index = report_.first_edge.value();
    error.other_index = report_.second_edge.value();
    return error;
  }

  Result<Outcome> OutcomeOf(MeshEdit& edit, const MotionPlan& plan, Advance& advance) const {
    const Mesh& mesh = edit.mesh();
    Outcome outcome;
    Advance::Disturbance disturbance = advance.Disturbed();
    outcome.disturbed = std::move(disturbance.all);
    outcome.drifting = std::move(disturbance.strained);
    const bool follows = request_.follow_length > 0;
    StopPoll stopped(stop());
    for (const Mover& mover : plan.movers()) {
      if (stopped()) return Stopped();
      if (!mesh.IsLive(mover.vertex)) continue;
      if (!follows) {
        outcome.moved.push_back(mover.vertex);
        continue;
      }
      edit.SetMetric(mover.vertex,
                     plan.Carried(mover, mesh.metric(mover.vertex), report_.fraction));
      outcome.carriers.push_back(mover.vertex);
    }
    for (const Rider& rider : plan.riders()) {
      if (mesh.IsLive(rider.vertex)) outcome.moved.push_back(rider.vertex);
    }
    if (stop_asked()) return Stopped();  // Before the whole of it is looked at once more.
    return outcome;
  }

  const MotionRequest& request_;
  const std::function<void(const Mesh&)>& observer_;
  MotionReport report_;
};

}  // namespace

Result<MotionReport> MoveVertices(Remesher& remesher, const MotionRequest& request) {
  return MoveVertices(remesher, request, nullptr);
}

Result<MotionReport> MoveVertices(Remesher& remesher, const MotionRequest& request,
                                  const std::function<void(const Mesh&)>& after_sub_step) {
  Motion motion(request, after_sub_step);
  PLIANT_RETURN_IF_ERROR(remesher.Apply(motion));
  return motion.report();
}

}  // namespace pliant
