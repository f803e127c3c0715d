#include "core/pliant/slide.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "core/mesh/place_map.h"
#include "core/metric/metric.h"

namespace pliant {
namespace {

/// A vertex follows if its segment leads it no further, in metric length, from where it is sent.
constexpr double kAside = 0.25;

/// Who stands still is overtaken by a vertex that comes nearer than this, in metric length.
constexpr double kRoomAhead = 0.6;

Vec2 DirectionOf(const Mesh& mesh, std::int32_t segment) {
  const SegmentRecord& line = mesh.segments()[static_cast<std::size_t>(segment)];
  return mesh.position(line.b) - mesh.position(line.a);
}

double ParameterOf(const Mesh& mesh, VertexId vertex) {
  return mesh.edge(mesh.SegmentEdges(vertex)[0]).parameters[1];
}

std::int32_t SegmentOf(const Mesh& mesh, VertexId vertex) {
  return mesh.edge(mesh.vertex(vertex).edge).segment;
}

double ParameterAfter(const Mesh& mesh, VertexId vertex, Vec2 by) {
  const Vec2 direction = DirectionOf(mesh, SegmentOf(mesh, vertex));
  return ParameterOf(mesh, vertex) + Dot(by, direction) / Dot(direction, direction);
}

/// The slides along one segment.
class OneSegment {
 public:
  OneSegment(const Mesh& mesh, std::span<const Slide> slides)
      : mesh_(mesh),
        slides_(slides),
        direction_(DirectionOf(mesh, SegmentOf(mesh, slides.front().vertex))),
        fates_(slides.size(), Fate::kStays) {}

  void AddTo(SlidePlan& plan) {
    for (std::size_t i = 1; i < slides_.size(); ++i) {
      if (!(slides_[i - 1].to < slides_[i].to)) return;
    }
    // Who goes first decides whether there is room for those behind.
    for (std::size_t i = slides_.size(); i-- > 0;) {
      if (slides_[i].to > slides_[i].from) MakeWay(i, 1);
    }
    for (std::size_t i = 0; i < slides_.size(); ++i) {
      if (slides_[i].to < slides_[i].from) MakeWay(i, 0);
    }
    for (std::size_t i = 0; i < slides_.size(); ++i) {
      if (fates_[i] == Fate::kStays) plan.slides.push_back(slides_[i]);
    }
    plan.overtaken.insert(plan.overtaken.end(), overtaken_.begin(), overtaken_.end());
  }

 private:
  enum class Fate : std::uint8_t { kStays, kGoes };

  /// Looks along the segment, to its end 0 or 1, for who is in the way of the i-th.
  void MakeWay(std::size_t i, std::size_t end) {
    const Slide& slide = slides_[i];
    VertexId vertex = slide.vertex;
    for (;;) {
      const EdgeRecord& edge = mesh_.edge(mesh_.SegmentEdges(vertex)[end]);
      vertex = edge.vertices[end];
      if (const Slide* const other = Find(vertex); other != nullptr) {
        if (fates_[static_cast<std::size_t>(other - slides_.data())] == Fate::kStays) return;
        continue;
      }
      const double room = (edge.parameters[end] - slide.to) * (end == 1 ? 1 : -1);
      const double wanted =
          kRoomAhead * kRoomAhead / SquaredLength(mesh_.metric(slide.vertex), direction_);
      if (room > 0 && room * room >= wanted) return;
      if (!IsSlidable(mesh_, vertex)) {
        fates_[i] = Fate::kGoes;
        Overtake(slide.vertex);
        return;
      }
      Overtake(vertex);
    }
  }

  void Overtake(VertexId vertex) {
    // The one behind may find out the same.
    if (is_overtaken_.Add(vertex, 0)) overtaken_.push_back(vertex);
  }

  /// The slide of a vertex, null if it stands still.
  [[nodiscard]] const Slide* Find(VertexId vertex) const {
    if (!IsSlidable(mesh_, vertex)) return nullptr;
    const auto at = std::ranges::lower_bound(slides_, ParameterOf(mesh_, vertex), {}, &Slide::from);
    return at != slides_.end() && at->vertex == vertex ? &*at : nullptr;
  }

  const Mesh& mesh_;
  const std::span<const Slide> slides_;
  const Vec2 direction_;
  std::vector<Fate> fates_;
  std::vector<VertexId> overtaken_;
  PlaceMap is_overtaken_;
};

}  // namespace

bool IsSlidable(const Mesh& mesh, VertexId vertex) {
  const VertexRecord& record = mesh.vertex(vertex);
  return record.edge.valid() && !record.fixed && !record.frozen && !record.pinched;
}

std::optional<Vec2> PlaceAlongWall(const Mesh& mesh, VertexId vertex, Vec2 by) {
  const std::int32_t segment = SegmentOf(mesh, vertex);
  const Vec2 place = mesh.PointOnSegment(segment, ParameterAfter(mesh, vertex, by));
  const Vec2 aside = mesh.position(vertex) + by - place;
  if (!(SquaredLength(mesh.metric(vertex), aside) <= kAside * kAside)) return std::nullopt;
  return place;
}

SlidePlan PlanSlides(const Mesh& mesh, std::span<const PlaceOnWall> list) {
  std::vector<Slide> slides;
  slides.reserve(list.size());
  for (const auto& [vertex, to] : list) {
    slides.push_back({vertex, ParameterOf(mesh, vertex),
                      ParameterAfter(mesh, vertex, to - mesh.position(vertex))});
  }
  std::ranges::sort(slides, {}, [&](const Slide& slide) {
    return std::pair(SegmentOf(mesh, slide.vertex), slide.from);
  });
  SlidePlan plan;
  for (std::size_t first = 0; first < slides.size();) {
    const std::int32_t segment = SegmentOf(mesh, slides[first].vertex);
    std::size_t last = first + 1;
    while (last < slides.size() && SegmentOf(mesh, slides[last].vertex) == segment) ++last;
    OneSegment(mesh, std::span(slides).subspan(first, last - first)).AddTo(plan);
    first = last;
  }
  return plan;
}

}  // namespace pliant
