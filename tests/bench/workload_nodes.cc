#include <cmath>
#include <functional>
#include <utility>
#include <vector>

#include "core/base/rng.h"
#include "core/motion/move.h"
#include "tests/bench/workload_step.h"

namespace pliant::bench {
namespace {

constexpr double kSwirlAngle = 6;      // In the middle of the domain; radians.
constexpr double kSwirlRadius = 0.15;  // In widths of the domain.

/// Where a solver that moves every node sends one.
using Target = std::function<Vec2(const VertexRecord&)>;

MotionRequest Everybody(const Mesh& mesh, const Target& target) {
  MotionRequest request;
  for (std::int32_t slot = 0; slot < mesh.vertex_slots(); ++slot) {
    const VertexId vertex(slot);
    const VertexRecord& record = mesh.vertex(vertex);
    if (!record.live) continue;
    request.vertices.push_back(vertex);
    request.positions.push_back(record.edge.valid() ? record.position : target(record));
  }
  return request;
}

/// A rectangle, and what nodes do in it.
struct Room {
  Vec2 low;
  Vec2 high;

  [[nodiscard]] Vec2 Swirled(Vec2 p, double angle) const {
    const Vec2 center = 0.5 * (low + high);
    const Vec2 arm = p - center;
    const double radius = kSwirlRadius * (high.x - low.x);
    const double turn = angle * std::exp(-Dot(arm, arm) / (radius * radius));
    return center + Vec2{std::cos(turn) * arm.x - std::sin(turn) * arm.y,
                         std::sin(turn) * arm.x + std::cos(turn) * arm.y};
  }

  /// Back inside, once.
  [[nodiscard]] Vec2 Reflected(Vec2 p) const {
    const auto back = [](double x, double from, double to) {
      return x < from ? 2 * from - x : x > to ? 2 * to - x : x;
    };
    return {back(p.x, low.x, high.x), back(p.y, low.y, high.y)};
  }
};

}  // namespace

/// All nodes of a rectangle are sent elsewhere: around its middle and back, and by one wanted
/// length at random.
Result<nlohmann::json> RunNodes(Remesher& remesher, const Request& request) {
  PLIANT_ASSIGN_OR_RETURN(const BenchCase instance, MakeCase(request.instance));
  const Room room{instance.domain.points[0], instance.domain.points[2]};
  std::vector<Update> swirls;
  std::vector<Update> shakes;
  double sub_steps = 0;
  Rng rng(1);
  for (int run = 0; run < request.repeat; ++run) {
    const double angle = run % 2 == 0 ? kSwirlAngle : -kSwirlAngle;
    const Target swirl = [&](const VertexRecord& record) {
      return room.Swirled(record.position, angle);
    };
    const Target shake = [&](const VertexRecord& record) {
      const double length = AxesFromMetric(record.metric).minor_radius;
      const Vec2 by{rng.Uniform(-length, length), rng.Uniform(-length, length)};
      return room.Reflected(record.position + by);
    };
    for (const auto& [target, updates] : {std::pair(&swirl, &swirls), std::pair(&shake, &shakes)}) {
      const MotionRequest motion = Everybody(remesher.mesh(), *target);
      PLIANT_ASSIGN_OR_RETURN(Update update, RunOne(remesher, [&]() -> Status {
                                PLIANT_ASSIGN_OR_RETURN(const MotionReport report,
                                                        MoveVertices(remesher, motion));
                                sub_steps += static_cast<double>(report.sub_step_count);
                                return {};
                              }));
      updates->push_back(std::move(update));
    }
  }
  return nlohmann::json{{"swirl", JsonOf(swirls)},
                        {"shake", JsonOf(shakes)},
                        {"sub_steps_per_step", sub_steps / (2 * request.repeat)},
                        {"quality_last", QualityOf(remesher.mesh(), remesher.field())}};
}

}  // namespace pliant::bench
