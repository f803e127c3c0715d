#include "core/pliant/displace.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "core/base/sort_unique.h"
#include "core/delaunay/cavity.h"
#include "core/delaunay/overtaken.h"
#include "core/geometry/predicates.h"
#include "core/mesh/place_map.h"
#include "core/mesh/scan_pays.h"
#include "core/mesh/star.h"
#include "core/pliant/slide.h"

namespace pliant {
namespace {

/// A triangle that not all corners have moved with is left asleep if its edges are between these,
/// squared, and its Q is not below this: the loop would find nothing to do there.
constexpr double kSquaredShort = 0.8 * 0.8;
constexpr double kSquaredLong = 1.25 * 1.25;
constexpr double kQualityKept = 0.95;

/// A triangle lower than this, in metric length, that has lost half of its height is not kept.
constexpr double kLowAfterwards = 0.2;
constexpr double kHeightKept = 0.5;

class Displacer {
 public:
  Displacer(MeshEdit& edit, std::span<const Displacement> list, Behind behind)
      : edit_(edit),
        mesh_(edit.mesh()),
        behind_(behind),
        slots_(mesh_.vertex_slots()),
        place_of_(slots_) {
    std::vector<PlaceOnWall> on_walls;
    list_.reserve(list.size());
    for (const Displacement& one : list) {
      if (IsSlidable(mesh_, one.vertex)) {
        on_walls.push_back({one.vertex, one.to});
      } else {
        list_.push_back(one);
      }
    }
    SlidePlan plan = PlanSlides(mesh_, on_walls);
    slides_ = std::move(plan.slides);
    overtaken_ = std::move(plan.overtaken);
    for (const Slide& slide : slides_) {
      list_.push_back({slide.vertex, mesh_.PointOnSegment(SegmentOf(slide), slide.to)});
    }
    place_of_.Reserve(list_.size());
    before_.reserve(list_.size());
    for (std::size_t k = 0; k < list_.size(); ++k) {
      place_of_.Add(list_[k].vertex, static_cast<std::int32_t>(k));
      before_.push_back(mesh_.position(list_[k].vertex));
    }
  }

  std::optional<Displaced> Run() {
    for (const Displacement& one : list_) edit_.PlaceVertex(one.vertex, one.to);
    for (const Slide& slide : slides_) edit_.SetParameter(slide.vertex, slide.to);
    std::vector<TriangleId> spoiled = FindSpoiled();
    if (!spoiled.empty() && !FillAround(std::move(spoiled))) {
      for (std::size_t k = 0; k < list_.size(); ++k) edit_.PlaceVertex(list_[k].vertex, before_[k]);
      for (const Slide& slide : slides_) edit_.SetParameter(slide.vertex, slide.from);
      return std::nullopt;
    }
    if (behind_ == Behind::kRefilled) Refill();
    std::vector<VertexId>& all = displaced_.disturbed;
    SortUnique(all);
    std::erase_if(all, [&](VertexId vertex) { return !mesh_.IsLive(vertex); });
    return std::move(displaced_);
  }

 private:
  [[nodiscard]] std::int32_t SegmentOf(const Slide& slide) const {
    return mesh_.edge(mesh_.vertex(slide.vertex).edge).segment;
  }
  [[nodiscard]] bool Moves(VertexId vertex) const {
    return vertex.value() < slots_ && place_of_.At(vertex) != PlaceMap::kNone;
  }
  [[nodiscard]] Vec2 Before(VertexId vertex) const {
    const std::int32_t place = place_of_.At(vertex);
    return place == PlaceMap::kNone ? mesh_.position(vertex)
                                    : before_[static_cast<std::size_t>(place)];
  }

  void Refill() {
    const Gap gap{.triangles = torn_,
                  .before = [&](VertexId vertex) -> std::optional<Vec2> {
                    if (!Moves(vertex)) return std::nullopt;
                    return Before(vertex);
                  },
                  .count_max = static_cast<std::size_t>(displaced_.removed_count)};
    displaced_.fillers = RefillGap(edit_, gap);
    for (const GapVertex& filler : displaced_.fillers) displaced_.created.push_back(filler.vertex);
    std::sort(displaced_.created.begin(), displaced_.created.end());
    displaced_.disturbed.insert(displaced_.disturbed.end(), displaced_.created.begin(),
                                displaced_.created.end());
  }

  bool FillAround(std::vector<TriangleId> spoiled) {
    const SuddenMove move{
        .before = [&](VertexId vertex) { return Before(vertex); },
        .is_free = [&](VertexId vertex) { return IsDisplaceable(mesh_, vertex); }};
    std::vector<TriangleId> cavity =
        OvertakenCavity(mesh_, std::move(spoiled), move, Overtaking::kAllGo);
    return Fill(cavity) || Fill(WithRing(mesh_, std::move(cavity)));
  }

  bool Fill(const std::vector<TriangleId>& cavity) {
    const bool is_frozen = std::any_of(cavity.begin(), cavity.end(),
                                       [&](TriangleId id) { return mesh_.triangle(id).frozen; });
    if (is_frozen) return false;
    const auto filled = RetriangulateCavity(
        edit_, cavity, [&](VertexId vertex) { return !IsDisplaceable(mesh_, vertex); }, overtaken_);
    if (!filled.ok()) return false;
    displaced_.disturbed.insert(displaced_.disturbed.end(), filled->corners.begin(),
                                filled->corners.end());
    displaced_.removed_count = std::ssize(filled->removed);
    // The new triangles have the slots of the old ones.
    torn_.insert(torn_.end(), cavity.begin(), cavity.end());
    SortUnique(torn_);
    return true;
  }

  /// Triangles that are inverted now, or much flatter, and those at overtaken vertices. Notes the
  /// corners of those that have lost their shape because not all of them moved.
  std::vector<TriangleId> FindSpoiled() {
    std::vector<TriangleId> spoiled;
    ForEachMoved([&](TriangleId id, bool together) {
      const TriangleRecord& triangle = mesh_.triangle(id);
      const auto& v = triangle.vertices;
      const bool positive =
          Orient2d(mesh_.position(v[0]), mesh_.position(v[1]), mesh_.position(v[2])) > 0;
      if (!together && !(positive && IsGood(triangle)))
        displaced_.disturbed.insert(displaced_.disturbed.end(), v.begin(), v.end());
      if (!positive || (!together && IsFlattened(triangle))) spoiled.push_back(id);
      if (!together) torn_.push_back(id);
    });
    for (const VertexId vertex : overtaken_) {
      star_.Gather(mesh_, vertex);
      spoiled.insert(spoiled.end(), star_.triangles().begin(), star_.triangles().end());
    }
    SortUnique(spoiled);
    return spoiled;
  }

  /// Calls visit(triangle, whether all corners have moved) for every triangle that has a corner
  /// that has, once. Of many vertices, reading all triangles in order takes an eighth of the time.
  template <class Visit>
  void ForEachMoved(Visit visit) {
    const auto look = [&](TriangleId id) {
      const auto& v = mesh_.triangle(id).vertices;
      const int moving = (Moves(v[0]) ? 1 : 0) + (Moves(v[1]) ? 1 : 0) + (Moves(v[2]) ? 1 : 0);
      if (moving > 0) visit(id, moving == 3);
    };
    if (ScanPays(mesh_, std::ssize(list_))) {
      for (std::int32_t t = 0; t < mesh_.triangle_slots(); ++t) {
        if (mesh_.triangle(TriangleId(t)).live) look(TriangleId(t));
      }
      return;
    }
    for (const Displacement& one : list_) {
      star_.Gather(mesh_, one.vertex);
      for (const TriangleId id : star_.triangles()) {
        const auto& v = mesh_.triangle(id).vertices;
        const bool is_first = std::none_of(v.begin(), v.end(), [&](VertexId corner) {
          return corner < one.vertex && Moves(corner);
        });
        if (is_first) look(id);
      }
    }
  }

  [[nodiscard]] bool IsFlattened(const TriangleRecord& triangle) const {
    const auto& v = triangle.vertices;
    const Metric sum = mesh_.metric(v[0]) + mesh_.metric(v[1]) + mesh_.metric(v[2]);
    const auto height = [&](const std::array<Vec2, 3>& p) {
      const double longest =
          std::max({SquaredLength(sum, p[1] - p[0]), SquaredLength(sum, p[2] - p[1]),
                    SquaredLength(sum, p[0] - p[2])});
      return Cross(p[1] - p[0], p[2] - p[0]) * std::sqrt(Determinant(sum) / (3 * longest));
    };
    const double now = height({mesh_.position(v[0]), mesh_.position(v[1]), mesh_.position(v[2])});
    return now < kLowAfterwards &&
           now < kHeightKept * height({Before(v[0]), Before(v[1]), Before(v[2])});
  }

  /// Whether edges and shape of a triangle are good, now.
  [[nodiscard]] bool IsGood(const TriangleRecord& triangle) const {
    const auto& v = triangle.vertices;
    double sum = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t j = (i + 1) % 3;
      const double squared = SquaredLength(0.5 * (mesh_.metric(v[i]) + mesh_.metric(v[j])),
                                           mesh_.position(v[j]) - mesh_.position(v[i]));
      if (!(kSquaredShort <= squared && squared <= kSquaredLong)) return false;
      sum += squared;
    }
    const Metric all = mesh_.metric(v[0]) + mesh_.metric(v[1]) + mesh_.metric(v[2]);
    const double area = Cross(mesh_.position(v[1]) - mesh_.position(v[0]),
                              mesh_.position(v[2]) - mesh_.position(v[0])) *
                        std::sqrt(Determinant(all)) / 3;
    // Q of eq. 5.
    return 2 * std::sqrt(3.0) * area >= kQualityKept * sum;
  }

  MeshEdit& edit_;
  const Mesh& mesh_;
  const Behind behind_;
  std::vector<Displacement> list_;
  std::vector<Slide> slides_;  // Of those at the end of list_.
  std::vector<VertexId> overtaken_;
  std::vector<Vec2> before_;  // Positions, by place in list_.
  const std::int32_t slots_;  // Before there were new vertices.
  PlaceMap place_of_;
  std::vector<TriangleId> torn_;  // Or only bent: not all corners have moved.
  Displaced displaced_;
  Star star_;
};

Error DisplacementError(ErrorCode code, std::size_t index, const std::string& what) {
  return {code, "entry " + std::to_string(index) + " of metric.displacements " + what,
          "metric.displacements", static_cast<std::int64_t>(index)};
}

}  // namespace

bool IsDisplaceable(const Mesh& mesh, VertexId vertex) {
  const VertexRecord& record = mesh.vertex(vertex);
  return !record.fixed && !record.frozen && !record.edge.valid() && !record.pinched;
}

std::optional<Vec2> PlaceAfter(const Mesh& mesh, VertexId vertex, Vec2 by) {
  if (IsDisplaceable(mesh, vertex)) return mesh.position(vertex) + by;
  if (IsSlidable(mesh, vertex)) return PlaceAlongWall(mesh, vertex, by);
  return std::nullopt;
}

std::optional<Displaced> Displace(MeshEdit& edit, std::span<const Displacement> list,
                                  Behind behind) {
  return Displacer(edit, list, behind).Run();
}

Status DisplaceVertices::Check(const Mesh& mesh) const {
  if (vertices_.size() != by_.size()) {
    return Error{ErrorCode::kArrayLength,
                 "there are " + std::to_string(by_.size()) + " displacements for " +
                     std::to_string(vertices_.size()) + " vertices; send one for each",
                 "metric.displacements"};
  }
  PlaceMap seen(mesh.vertex_slots());
  seen.Reserve(vertices_.size());
  for (std::size_t i = 0; i < vertices_.size(); ++i) {
    const VertexId vertex = vertices_[i];
    if (!mesh.IsLive(vertex)) {
      return DisplacementError(
          ErrorCode::kIndexOutOfRange, i,
          "is of " + std::to_string(vertex.value()) + ", which is no vertex of this revision");
    }
    if (!seen.Add(vertex, 0)) {
      return DisplacementError(ErrorCode::kDuplicateId, i,
                               "names vertex " + std::to_string(vertex.value()) + " a second time");
    }
    if (!IsFinite(by_[i])) {
      return DisplacementError(ErrorCode::kNotFinite, i, "has a number that is NaN or infinite");
    }
  }
  return {};
}

Result<MeshChange::Outcome> DisplaceVertices::Apply(MeshEdit& edit) {
  const Mesh& mesh = edit.mesh();
  PLIANT_RETURN_IF_ERROR(Check(mesh));
  std::vector<Displacement> list;
  list.reserve(vertices_.size());
  for (std::size_t i = 0; i < vertices_.size(); ++i) {
    if (by_[i] == Vec2{}) continue;
    const std::optional<Vec2> place = PlaceAfter(mesh, vertices_[i], by_[i]);
    if (!place || (!slides_ && mesh.vertex(vertices_[i]).edge.valid())) continue;
    list.push_back({vertices_[i], *place});
  }
  Outcome outcome;
  displaced_count_ = 0;
  fillers_.clear();
  std::optional<Displaced> displaced = Displace(edit, list, behind_);
  if (!displaced) return outcome;
  fillers_ = std::move(displaced->fillers);
  outcome.follows_front = true;
  outcome.disturbed = std::move(displaced->disturbed);
  for (const Displacement& one : list) {
    if (mesh.IsLive(one.vertex) && mesh.position(one.vertex) != one.to) continue;  // Was blocked.
    ++displaced_count_;
    if (mesh.IsLive(one.vertex)) outcome.carriers.push_back(one.vertex);
  }
  outcome.carriers.insert(outcome.carriers.end(), displaced->created.begin(),
                          displaced->created.end());
  return outcome;
}

}  // namespace pliant
