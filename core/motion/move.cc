#include "core/motion/move.h"

#include <algorithm>
#include <iomanip>
#include <sstream>
#include <utility>
#include <vector>

#include "core/motion/advance.h"
#include "core/motion/contact.h"
#include "core/motion/plan.h"
#include "core/pliant/mesh_change.h"

namespace pliant {
namespace {

/// A motion that is to stop at a contact ends this share before it: there must be room for
/// triangles in between.
constexpr double kShyOfContact = 1e-3;

class Motion final : public MeshChange {
 public:
  Motion(const MotionRequest& request, const std::function<void(const Mesh&)>& observer)
      : request_(request), observer_(observer) {}

  Result<Outcome> Apply(MeshEdit& edit) override {
    const Mesh& mesh = edit.mesh();
    report_ = {};
    PLIANT_ASSIGN_OR_RETURN(MotionPlan plan, MotionPlan::Make(mesh, request_, stop()));
    for (const VertexId vertex : plan.cuts()) edit.CutSegment(vertex);
    plan.FindRiders(mesh);
    double limit = 1;
    if (const std::optional<Contact> contact = FindContact(mesh, plan)) {
      report_.first_edge = contact->first;
      report_.second_edge = contact->second;
      report_.fraction = contact->time;
      if (request_.on_impossible == ImpossibleMotion::kRefuse) return Refusal();
      limit = (1 - kShyOfContact) * contact->time;
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
    if (reached < limit) {
      report_.first_edge = advance.Blockers().first;
      report_.second_edge = advance.Blockers().second;
      if (request_.on_impossible == ImpossibleMotion::kRefuse) return Refusal();
    }
    return OutcomeOf(edit, plan, advance);
  }

  [[nodiscard]] const MotionReport& report() const { return report_; }

 private:
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
    Error error{ErrorCode::kCrossingSegments, message.str(), "motion"};
    error.index = report_.first_edge.value();
    error.other_index = report_.second_edge.value();
    return error;
  }

  Result<Outcome> OutcomeOf(MeshEdit& edit, const MotionPlan& plan, const Advance& advance) const {
    const Mesh& mesh = edit.mesh();
    Outcome outcome;
    outcome.disturbed = advance.Disturbed();
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
