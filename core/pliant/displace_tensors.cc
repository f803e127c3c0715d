#include "core/pliant/displace_tensors.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "core/base/sort_unique.h"
#include "core/geometry/predicates.h"
#include "core/mesh/place_map.h"
#include "core/mesh/star.h"
#include "core/metric/background_field.h"
#include "core/pliant/displace.h"
#include "core/pliant/followed_metric.h"
#include "core/pliant/slide.h"

namespace pliant {
namespace {

/// A vertex has its own tensor if it lies no further than this, in metric length, from the place
/// that the tensor is of.
constexpr double kAtPlace = 0.1;

/// The tensors that were sent, by vertex of before, and the places that they are of.
class PlacedRows {
 public:
  /// @pre the request was checked
  /// @param vertices  whose tensors the request has
  PlacedRows(const Mesh& mesh, const TensorsAhead& request, std::span<const VertexId> vertices)
      : mesh_(mesh),
        tensors_(request.tensors),
        slots_(mesh.vertex_slots()),
        rows_(slots_),
        displaced_(slots_) {
    rows_.Reserve(vertices.size());
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      rows_.Add(vertices[i], static_cast<std::int32_t>(i));
    }
    displaced_.Reserve(request.displaced.size());
    for (std::size_t i = 0; i < request.displaced.size(); ++i) {
      if (request.by[i] == Vec2{}) continue;
      displaced_.Add(request.displaced[i], static_cast<std::int32_t>(movers_.size()));
      movers_.push_back(
          {request.displaced[i], mesh.position(request.displaced[i]) + request.by[i]});
    }
  }

  /// Who is displaced, and where to.
  [[nodiscard]] std::span<const Displacement> movers() const { return movers_; }

  /// The tensor that was sent for a vertex of before; null if there is none.
  [[nodiscard]] const Metric* Find(VertexId vertex) const {
    if (vertex.value() >= slots_) return nullptr;
    const std::int32_t row = rows_.At(vertex);
    return row == PlaceMap::kNone ? nullptr : &tensors_[static_cast<std::size_t>(row)];
  }

  /// The place that the tensor of a vertex is of. @pre nobody has moved
  [[nodiscard]] Vec2 PlaceOf(VertexId vertex) const {
    const std::int32_t place = displaced_.At(vertex);
    return place == PlaceMap::kNone ? mesh_.position(vertex)
                                    : movers_[static_cast<std::size_t>(place)].to;
  }

 private:
  const Mesh& mesh_;
  const std::span<const Metric> tensors_;
  const std::int32_t slots_;
  PlaceMap rows_;
  PlaceMap displaced_;
  std::vector<Displacement> movers_;
};

bool IsAt(Vec2 p, Vec2 place, const Metric& tensor) {
  return SquaredLength(tensor, p - place) <= kAtPlace * kAtPlace;
}

/// False if every displaced vertex with a tensor is sure to come to its place, unless the way is
/// blocked for all. @pre nobody has moved
bool SomeMayStay(const Mesh& mesh, const PlacedRows& rows, const Permissions& permissions) {
  std::vector<PlaceOnWall> on_walls;
  for (const auto& [vertex, to] : rows.movers()) {
    if (IsDisplaceable(mesh, vertex)) continue;
    const Metric* const tensor = rows.Find(vertex);
    const std::optional<Vec2> place = PlaceAfter(mesh, vertex, to - mesh.position(vertex));
    if (!place || !permissions.surface) {
      if (tensor != nullptr) return true;
      continue;
    }
    if (tensor != nullptr && !IsAt(*place, to, *tensor)) return true;
    on_walls.push_back({vertex, *place});
  }
  // Those that others run over are counted, too: that does no harm.
  return PlanSlides(mesh, on_walls).slides.size() < on_walls.size();
}

/// The field that the tensors are between the places, around displaced vertices; null if there is
/// none. Triangles that the displacement inverts are left out. @pre nobody has moved
std::unique_ptr<BackgroundField> FieldOfPlaces(const Mesh& mesh, const PlacedRows& rows) {
  std::vector<TriangleId> around;
  Star star;
  for (const Displacement& mover : rows.movers()) {
    star.Gather(mesh, mover.vertex);
    around.insert(around.end(), star.triangles().begin(), star.triangles().end());
  }
  SortUnique(around);
  std::vector<Vec2> points;
  std::vector<std::array<std::int32_t, 3>> triangles;
  std::vector<LogMetric> logs;
  PlaceMap numbers(mesh.vertex_slots());
  for (const TriangleId id : around) {
    const auto& v = mesh.triangle(id).vertices;
    if (std::ranges::any_of(v, [&](VertexId corner) { return rows.Find(corner) == nullptr; }) ||
        !(Orient2d(rows.PlaceOf(v[0]), rows.PlaceOf(v[1]), rows.PlaceOf(v[2])) > 0)) {
      continue;
    }
    std::array<std::int32_t, 3>& corners = triangles.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) {
      if (numbers.Add(v[k], static_cast<std::int32_t>(points.size()))) {
        points.push_back(rows.PlaceOf(v[k]));
        logs.push_back(Log(*rows.Find(v[k])));
      }
      corners[k] = numbers.At(v[k]);
    }
  }
  return BackgroundField::Restore(points, triangles, logs);
}

/// Who has which tensor afterwards.
class Arrivals {
 public:
  Arrivals(const Mesh& mesh, const PlacedRows& rows) : mesh_(mesh), rows_(rows) {}

  /// Displaced vertices with a tensor of another place than where they are now.
  [[nodiscard]] std::vector<VertexId> Elsewhere(std::span<const GapVertex> fillers) const {
    const std::vector<VertexId> created = VerticesOf(fillers);
    std::vector<VertexId> elsewhere;
    for (const auto& [vertex, place] : rows_.movers()) {
      const Metric* const tensor = rows_.Find(vertex);
      if (tensor == nullptr || !mesh_.IsLive(vertex) || std::ranges::binary_search(created, vertex))
        continue;
      if (!IsAt(mesh_.position(vertex), place, *tensor)) elsewhere.push_back(vertex);
    }
    return elsewhere;
  }

  /// Gives vertices what the tensors are where they are; without an answer they keep their own.
  void Ask(std::span<const VertexId> elsewhere, const BackgroundField* field) {
    if (field == nullptr) return;
    for (const VertexId vertex : elsewhere) {
      std::int32_t hint = MetricField::kNoHint;
      Give(vertex, field->At(mesh_.position(vertex), hint));
    }
  }

  /// Gives new vertices the mean of the corners that they were put between.
  void Fill(std::span<const GapVertex> fillers) {
    created_ = VerticesOf(fillers);
    for (const GapVertex& filler : fillers) {
      LogMetric sum;
      double known = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        const Metric* const tensor = Find(filler.corners[k]);
        if (tensor == nullptr) continue;
        sum = sum + filler.shares[k] * Log(*tensor);
        known += filler.shares[k];
      }
      if (known > 0) Give(filler.vertex, Exp((1 / known) * sum));
    }
  }

  /// What all live vertices want. @pre all of before have a tensor
  [[nodiscard]] WantedTensors OfAll() {
    std::ranges::sort(given_, {}, &Given::vertex);
    WantedTensors wanted{LiveVertices(mesh_), {}};
    wanted.tensors.reserve(wanted.vertices.size());
    auto given = given_.begin();
    for (const VertexId vertex : wanted.vertices) {
      while (given != given_.end() && given->vertex < vertex) ++given;
      const bool is_given = given != given_.end() && given->vertex == vertex;
      wanted.tensors.push_back(is_given ? given->tensor : *rows_.Find(vertex));
    }
    return wanted;
  }

  /// What those want that have a tensor, of these and the new ones.
  [[nodiscard]] WantedTensors OfSome(std::span<const VertexId> senders) const {
    WantedTensors wanted;
    const auto add = [&](VertexId vertex, const Metric& tensor) {
      wanted.vertices.push_back(vertex);
      wanted.tensors.push_back(tensor);
    };
    for (const VertexId vertex : senders) {
      const Metric* const tensor = mesh_.IsLive(vertex) ? Find(vertex) : nullptr;
      if (tensor != nullptr) add(vertex, *tensor);
    }
    for (const auto& [vertex, tensor] : given_) {
      if (rows_.Find(vertex) == nullptr) add(vertex, tensor);
    }
    return wanted;
  }

 private:
  struct Given {
    VertexId vertex;
    Metric tensor;
  };

  /// The tensor of a live vertex; null if it keeps that of before.
  [[nodiscard]] const Metric* Find(VertexId vertex) const {
    const std::int32_t place = given_places_.At(vertex);
    if (place != PlaceMap::kNone) return &given_[static_cast<std::size_t>(place)].tensor;
    return std::ranges::binary_search(created_, vertex) ? nullptr : rows_.Find(vertex);
  }

  static std::vector<VertexId> VerticesOf(std::span<const GapVertex> fillers) {
    std::vector<VertexId> vertices;
    for (const GapVertex& filler : fillers) vertices.push_back(filler.vertex);
    std::ranges::sort(vertices);
    return vertices;
  }
  void Give(VertexId vertex, const Metric& tensor) {
    given_places_.Add(vertex, static_cast<std::int32_t>(given_.size()));
    given_.push_back({vertex, tensor});
  }

  const Mesh& mesh_;
  const PlacedRows& rows_;
  std::vector<Given> given_;
  PlaceMap given_places_;  // Never an array: knows new slots, too.
  std::vector<VertexId> created_;
};

}  // namespace

Result<MeshChange::Outcome> DisplaceWithTensors::Apply(MeshEdit& edit) {
  const Mesh& mesh = edit.mesh();
  DisplaceVertices displacement(request_.displaced, request_.by);
  displacement.Permit(permissions_);
  PLIANT_RETURN_IF_ERROR(displacement.Check(mesh));
  const bool is_of_all = request_.vertices.empty();
  const std::vector<VertexId> all = is_of_all ? LiveVertices(mesh) : std::vector<VertexId>();
  const std::span<const VertexId> senders = is_of_all ? std::span(all) : request_.vertices;
  PLIANT_RETURN_IF_ERROR(CheckTensorsAt(mesh, senders, request_.tensors));

  const PlacedRows rows(mesh, request_, senders);
  std::unique_ptr<BackgroundField> field;
  if (SomeMayStay(mesh, rows, permissions_)) field = FieldOfPlaces(mesh, rows);
  Result<Outcome> outcome = displacement.Apply(edit);
  if (!outcome.ok()) return outcome;

  Arrivals arrivals(mesh, rows);
  const std::vector<VertexId> elsewhere = arrivals.Elsewhere(displacement.fillers());
  if (field == nullptr && !elsewhere.empty() && displacement.displaced_count() == 0) {
    field = FieldOfPlaces(mesh, rows);  // The way was blocked: nobody has moved.
  }
  arrivals.Ask(elsewhere, field.get());
  arrivals.Fill(displacement.fillers());
  wanted_ = is_of_all ? arrivals.OfAll() : arrivals.OfSome(senders);
  return outcome;
}

Status SetTensorsAhead(Remesher& remesher, const TensorsAhead& request,
                       const TensorsBeside& terms) {
  DisplaceWithTensors change(request);
  PLIANT_RETURN_IF_ERROR(remesher.Apply(change));
  const bool is_of_all = request.vertices.empty();
  // No vertices would mean all of them.
  if (!is_of_all && change.vertices().empty()) {
    return terms.functions != nullptr ? remesher.SetFunctions(*terms.functions, terms.limits)
                                      : remesher.SetLimits(terms.limits);
  }
  const std::span<const VertexId> vertices =
      is_of_all ? std::span<const VertexId>() : change.vertices();
  if (terms.functions == nullptr) {
    return remesher.SetTensors(vertices, change.tensors(), terms.limits);
  }
  return remesher.SetTensors(vertices, change.tensors(), terms.limits, *terms.functions);
}

}  // namespace pliant
