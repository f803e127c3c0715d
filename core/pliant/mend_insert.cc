// Mender, the part that puts nodes between given vertices that are crowded and what lies beyond.

#include <algorithm>
#include <array>

#include "core/geometry/predicates.h"
#include "core/pliant/mend.h"
#include "core/pliant/merit.h"

namespace pliant {
namespace {

/// Where the search for a place begins, on the way from what lies around to the center.
constexpr std::array kStarts = {0.15, 0.3, 0.45};

/// A single triangle is not worth a node, and many are no better than a few.
constexpr std::size_t kRowMin = 2;
constexpr std::size_t kRowMax = 6;

/// Of all rows so many, those that look best, are tried.
constexpr std::size_t kTriedMax = 4;

}  // namespace

/// Some triangles of the star, one after the other, and a place for a new node among them.
struct Mender::Row {
  std::size_t first = 0;  ///< In the ring.
  std::size_t last = 0;   ///< May be beyond the end of the ring, which then goes on at its begin.
  double gain = 0;
  Vec2 place;
};

bool Mender::IsCrowdedLink(std::span<const MeritCorner> ring, std::size_t k) const {
  const TriangleId id = star_.triangles()[k];
  const TriangleRecord& triangle = mesh_.triangle(id);
  const int side = mesh_.CornerOf(id, star_.center());
  return triangle.IsConstrained(side) && IsCrowded(ring[k]) && IsCrowded(ring[k + 1]);
}

/// All rows with a given edge that is crowded, best first by what a node at once would gain.
std::vector<Mender::Row> Mender::RowsAtCrowd(std::span<const MeritCorner> ring) const {
  const std::size_t count = star_.triangles().size();
  const MeritCorner center = MeritCornerAt(mesh_, star_.center());
  std::vector<Row> rows;
  std::vector<MeritCorner> around;
  for (std::size_t first = 0; first < count; ++first) {
    around = {center, ring[first]};
    double before = 0;
    bool is_crowded = false;
    Vec2 sum = ring[first].position;
    for (std::size_t k = first; k + 2 < first + count && k < first + kRowMax; ++k) {
      if (mesh_.triangle(star_.triangles()[k % count]).frozen) break;
      is_crowded = is_crowded || IsCrowdedLink(ring, k % count);
      const MeritCorner& end = ring[k % count + 1];
      before += ShortfallOf(center, ring[k % count], end);
      around.push_back(end);
      sum += end.position;
      const std::size_t length = k + 1 - first;
      if (!is_crowded || length < kRowMin || before < kGainMin) continue;
      around.push_back(center);
      Row row{first, k + 1, -before, {}};
      const Vec2 foot = 0.5 * (ring[first].position + end.position);
      const Vec2 mean = (1.0 / static_cast<double>(length + 1)) * sum;
      for (const Vec2 from : {foot, mean}) {
        for (const double share : kStarts) {
          const Vec2 place = from + share * (center.position - from);
          const Metric metric =
              (0.5 * (1 - share)) * (ring[first].metric + end.metric) + share * center.metric;
          const double gain = before - ShortfallAround(around, BornBesideCrowd(place, metric));
          if (gain > row.gain) row = {first, k + 1, gain, place};
        }
      }
      around.pop_back();
      if (row.gain > -before) rows.push_back(row);
    }
  }
  std::stable_sort(rows.begin(), rows.end(),
                   [](const Row& a, const Row& b) { return a.gain > b.gain; });
  return rows;
}

bool Mender::Insert(const MetricField& field) {
  const bool may = permissions_.insert && mesh_.vertex_count() < vertices_max_;
  if (!may || !star_.closed()) return false;
  const std::vector<MeritCorner> ring = RingCorners();
  bool any = false;
  for (std::size_t k = 0; k + 1 < ring.size(); ++k) any = any || IsCrowdedLink(ring, k);
  if (!any) return false;
  const std::vector<Row> rows = RowsAtCrowd(ring);
  for (std::size_t i = 0; i < std::min(kTriedMax, rows.size()); ++i) {
    if (InsertBeside(rows[i], field)) return true;
  }
  return false;
}

bool Mender::InsertBeside(const Row& row, const MetricField& field) {
  const VertexId beyond = star_.center();
  const std::size_t count = star_.triangles().size();
  std::vector<VertexId> corners{beyond};
  std::vector<TriangleId> cavity;
  for (std::size_t k = row.first; k <= row.last; ++k) {
    corners.push_back(star_.ring()[k % count]);
    if (k < row.last) cavity.push_back(star_.triangles()[k % count]);
  }
  corners.push_back(beyond);
  std::vector<MeritCorner> around;
  around.reserve(corners.size());
  for (const VertexId corner : corners) around.push_back(MeritCornerAt(mesh_, corner));
  double before = 0;
  for (std::size_t k = 1; k + 2 < around.size(); ++k) {
    before += ShortfallOf(around.front(), around[k], around[k + 1]);
  }

  std::int32_t hint = mesh_.hint(beyond);
  const Vec2 place = BestPlace(around, BornBesideCrowd(row.place, field.At(row.place, hint)));
  const Metric metric = field.At(place, hint);
  for (std::size_t k = 0; k + 1 < corners.size(); ++k) {
    if (Orient2d(place, around[k].position, around[k + 1].position) <= 0) return false;
  }
  if (!IsGain(before, ShortfallAround(around, BornBesideCrowd(place, metric)))) return false;

  PutIn(place, corners, cavity);
  edit_.SetMetric(star_.center(), metric);
  edit_.Hint(star_.center()) = hint;
  return true;
}

/// A new node in place of triangles that have corners.front() in common. The star becomes its own.
void Mender::PutIn(Vec2 place, std::span<const VertexId> corners,
                   std::span<const TriangleId> cavity) {
  const std::int32_t region = mesh_.triangle(cavity.front()).region;
  VisitState visit = mesh_.vertex(corners.front()).visit;
  visit.drift_x = visit.drift_y = 0;
  visit.active = false;
  visit.mended = true;
  const VertexId node = edit_.AddVertex(place);
  std::vector<NewTriangle> triangles;
  for (std::size_t k = 0; k + 1 < corners.size(); ++k) {
    triangles.push_back({{node, corners[k], corners[k + 1]}, region});
  }
  edit_.ReplaceCavity(cavity, triangles);
  edit_.Visit(node) = visit;
  state_.moved.push_back(node);
  star_.Gather(mesh_, node);
}

}  // namespace pliant
