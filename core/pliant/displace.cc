#include "core/pliant/displace.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "core/delaunay/cavity.h"
#include "core/delaunay/overtaken.h"
#include "core/geometry/predicates.h"
#include "core/mesh/place_map.h"
#include "core/mesh/star.h"

namespace pliant {
namespace {

/// A triangle that not all corners have moved with is left asleep if its edges are between these,
/// squared, and its Q is not below this: the loop would find nothing to do there.
constexpr double kSquaredShort = 0.8 * 0.8;
constexpr double kSquaredLong = 1.25 * 1.25;
constexpr double kQualityKept = 0.95;

/// A triangle lower than this, in metric length, that has lost half of its height is not kept.
constexpr double kLowHeight = 0.2;
constexpr double kHeightLost = 0.5;

class Displacer {
 public:
  Displacer(MeshEdit& edit, std::span<const Displacement> list)
      : edit_(edit), mesh_(edit.mesh()), list_(list), place_of_(edit.mesh().vertex_slots()) {
    place_of_.Reserve(list.size());
    before_.reserve(list.size());
    for (std::size_t k = 0; k < list.size(); ++k) {
      place_of_.Add(list[k].vertex, static_cast<std::int32_t>(k));
      before_.push_back(mesh_.position(list[k].vertex));
    }
  }

  std::optional<Displaced> Run() {
    for (const Displacement& one : list_) edit_.PlaceVertex(one.vertex, one.to);
    std::vector<TriangleId> spoiled = FindSpoiled();
    if (!spoiled.empty() && !FillAround(std::move(spoiled))) {
      for (std::size_t k = 0; k < list_.size(); ++k) edit_.PlaceVertex(list_[k].vertex, before_[k]);
      return std::nullopt;
    }
    std::vector<VertexId>& all = displaced_.disturbed;
    std::sort(all.begin(), all.end());
    all.erase(std::unique(all.begin(), all.end()), all.end());
    std::erase_if(all, [&](VertexId vertex) { return !mesh_.IsLive(vertex); });
    return std::move(displaced_);
  }

 private:
  [[nodiscard]] bool Moves(VertexId vertex) const {
    return place_of_.At(vertex) != PlaceMap::kNone;
  }
  [[nodiscard]] Vec2 Before(VertexId vertex) const {
    const std::int32_t place = place_of_.At(vertex);
    return place == PlaceMap::kNone ? mesh_.position(vertex)
                                    : before_[static_cast<std::size_t>(place)];
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
        edit_, cavity, [&](VertexId vertex) { return !IsDisplaceable(mesh_, vertex); });
    if (!filled) return false;
    displaced_.disturbed.insert(displaced_.disturbed.end(), filled->corners.begin(),
                                filled->corners.end());
    displaced_.removed_count = std::ssize(filled->removed);
    return true;
  }

  /// Triangles that are inverted now, or much flatter. Notes the corners of those that have lost
  /// their shape because not all of them moved.
  std::vector<TriangleId> FindSpoiled() {
    std::vector<TriangleId> spoiled;
    for (const Displacement& one : list_) {
      star_.Gather(mesh_, one.vertex);
      for (const TriangleId id : star_.triangles()) {
        const TriangleRecord& triangle = mesh_.triangle(id);
        const auto& v = triangle.vertices;
        const bool together = Moves(v[0]) && Moves(v[1]) && Moves(v[2]);
        // Of three that have it, the lowest looks at a triangle.
        if (together && one.vertex != std::min({v[0], v[1], v[2]})) continue;
        const bool positive =
            Orient2d(mesh_.position(v[0]), mesh_.position(v[1]), mesh_.position(v[2])) > 0;
        if (!together && !(positive && IsGood(triangle)))
          displaced_.disturbed.insert(displaced_.disturbed.end(), v.begin(), v.end());
        if (!positive || (!together && IsFlattened(triangle))) spoiled.push_back(id);
      }
    }
    std::sort(spoiled.begin(), spoiled.end());
    spoiled.erase(std::unique(spoiled.begin(), spoiled.end()), spoiled.end());
    return spoiled;
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
    return now < kLowHeight &&
           now < kHeightLost * height({Before(v[0]), Before(v[1]), Before(v[2])});
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
  const std::span<const Displacement> list_;
  std::vector<Vec2> before_;  // Positions, by place in list_.
  PlaceMap place_of_;
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

std::optional<Displaced> Displace(MeshEdit& edit, std::span<const Displacement> list) {
  return Displacer(edit, list).Run();
}

Status DisplaceVertices::Check(const Mesh& mesh) const {
  if (vertices_.size() != by_.size()) {
    return Error{ErrorCode::kArrayLength,
                 "there are " + std::to_string(by_.size()) + " displacements for " +
                     std::to_string(vertices_.size()) + " vertices; send one for each",
                 "metric.displacements"};
  }
  PlaceMap seen(mesh.vertex_slots());
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
  for (std::size_t i = 0; i < vertices_.size(); ++i) {
    if (by_[i] == Vec2{} || !IsDisplaceable(mesh, vertices_[i])) continue;
    list.push_back({vertices_[i], mesh.position(vertices_[i]) + by_[i]});
  }
  Outcome outcome;
  std::optional<Displaced> displaced = Displace(edit, list);
  if (!displaced) return outcome;
  displaced_count_ = std::ssize(list);
  outcome.disturbed = std::move(displaced->disturbed);
  for (const Displacement& one : list) {
    if (mesh.IsLive(one.vertex)) outcome.carriers.push_back(one.vertex);
  }
  return outcome;
}

}  // namespace pliant
