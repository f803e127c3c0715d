#include "core/motion/chords.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <set>
#include <utility>

#include "core/mesh/place_map.h"
#include "core/mesh/segment_edges.h"
#include "core/metric/metric.h"

namespace pliant {
namespace {

/// Most segments of one chord: so many edges that are all a little too short are one too many, and
/// what is looked at for each of them stays small.
constexpr std::size_t kSegmentsMax = 16;

/// A segment keeps at least this share of its length on the chord: nothing folds.
constexpr double kShareKept = 0.5;

/// What it costs to move a corner by the whole tolerance, in the units of CostOf: as much as four
/// edges cost that are half as long as they should be. So a stretch that is only just too dense
/// becomes one that is nearly straight, and a curve that is compressed step by step keeps its shape
/// far better than the tolerance says.
constexpr double kCostOfTolerance = 2;

/// What counts as rounding, as a share of the coordinates.
constexpr double kRounding = 1e-12;

/// Edges that a stretch of some metric length asks for.
int EdgesFor(double length) {
  // The least m >= 1 with length < sqrt(m (m + 1)): there one more would fit as well.
  const double m = std::floor((std::sqrt(1 + 4 * length * length) - 1) / 2) + 1;
  return static_cast<int>(std::min(m, 1e8));
}

/// By how much the edges of a stretch miss length 1: 0 if they do not, the same for twice as long
/// and half as long.
double CostOf(double length, int edge_count) {
  const double edge = length / edge_count;
  return edge > 0 ? edge_count * (edge + 1 / edge - 2) : std::numeric_limits<double>::infinity();
}

/// The two segments at a soft corner.
std::array<std::int32_t, 2> SegmentsAt(const Mesh& mesh, VertexId corner) {
  std::array<std::int32_t, 2> segments{-1, -1};
  std::size_t count = 0;
  ForEachEdgeAt(mesh, corner, [&](EdgeId id) {
    if (count < 2) segments[count] = mesh.edge(id).segment;
    ++count;
  });
  return segments;
}

class ChordChooser {
 public:
  ChordChooser(const Mesh& mesh, std::span<const VertexId> corners, double tolerance)
      : mesh_(mesh), tolerance_(tolerance), place_of_(mesh.vertex_slots()) {
    corners_.assign(corners.begin(), corners.end());
    std::ranges::sort(corners_);
    place_of_.Reserve(corners_.size());
    for (std::size_t i = 0; i < corners_.size(); ++i) {
      place_of_.Add(corners_[i], static_cast<std::int32_t>(i));
    }
    done_.assign(corners_.size(), false);
  }

  std::vector<Chord> Run() {
    for (std::size_t i = 0; i < corners_.size(); ++i) {
      if (done_[i]) continue;
      FollowChain(corners_[i]);
      CutChain();
    }
    DropDoubles();
    return std::move(chords_);
  }

 private:
  /// A segment of a chain.
  struct Link {
    std::int32_t segment = 0;
    double straight = 0;  ///< From end to end, in domain units.
    double length = 0;    ///< Of its edges, in metric length.
    int edge_count = 1;   ///< That it asks for by itself.
    bool frozen = false;  ///< In part: it stays.
  };

  /// The best way to cut a chain up to some corner.
  struct Cut {
    double cost = std::numeric_limits<double>::infinity();
    std::size_t from = 0;  ///< Where its last piece begins.
  };

  [[nodiscard]] VertexId OtherEnd(std::int32_t segment, VertexId end) const {
    const SegmentRecord& line = mesh_.segments()[static_cast<std::size_t>(segment)];
    return line.a == end ? line.b : line.a;
  }

  [[nodiscard]] std::int32_t OtherSegment(VertexId corner, std::int32_t segment) const {
    const auto [first, second] = SegmentsAt(mesh_, corner);
    return first == segment ? second : first;
  }

  [[nodiscard]] bool MayGo(VertexId vertex) const {
    return place_of_.At(vertex) != PlaceMap::kNone;
  }

  /// Lists the segments around a corner as far as corners may go, from one end to the other. Where
  /// all corners of a loop may, it begins and ends at the first of them.
  void FollowChain(VertexId corner) {
    VertexId at = corner;
    std::int32_t segment = SegmentsAt(mesh_, corner)[0];
    for (;;) {
      at = OtherEnd(segment, at);
      if (at == corner || !MayGo(at)) break;
      segment = OtherSegment(at, segment);
    }
    if (at == corner) segment = SegmentsAt(mesh_, corner)[0];
    const VertexId first = at;
    ends_.assign(1, first);
    links_.clear();
    for (;;) {
      links_.push_back(LinkOf(segment));
      at = OtherEnd(segment, at);
      ends_.push_back(at);
      if (MayGo(at)) done_[static_cast<std::size_t>(place_of_.At(at))] = true;
      if (at == first || !MayGo(at)) return;
      segment = OtherSegment(at, segment);
    }
  }

  [[nodiscard]] Link LinkOf(std::int32_t segment) const {
    const SegmentRecord& line = mesh_.segments()[static_cast<std::size_t>(segment)];
    Link link{.segment = segment};
    link.straight = Length(mesh_.position(line.b) - mesh_.position(line.a));
    ForEachPiece(mesh_, segment, [&](EdgeId id) {
      const EdgeRecord& edge = mesh_.edge(id);
      const VertexRecord& a = mesh_.vertex(edge.vertices[0]);
      const VertexRecord& b = mesh_.vertex(edge.vertices[1]);
      link.length += std::sqrt(SquaredLength(0.5 * (a.metric + b.metric), b.position - a.position));
      const bool inside_frozen = edge.vertices[1] != line.b && b.frozen;
      link.frozen = link.frozen || edge.frozen || inside_frozen;
    });
    link.edge_count = EdgesFor(link.length);
    return link;
  }

  /// Finds the cheapest way to cut the chain into pieces, and notes the chords among them.
  void CutChain() {
    cuts_.assign(ends_.size(), Cut{});
    cuts_[0].cost = 0;
    for (std::size_t to = 1; to < ends_.size(); ++to) {
      const Link& last = links_[to - 1];
      cuts_[to] = {cuts_[to - 1].cost + CostOf(last.length, last.edge_count), to - 1};
      for (std::size_t from = to - 1; from-- > 0 && to - from <= kSegmentsMax;) {
        if (last.frozen || links_[from].frozen) break;
        const std::optional<double> cost = CostOfChord(from, to);
        if (cost && cuts_[from].cost + *cost < cuts_[to].cost) {
          cuts_[to] = {cuts_[from].cost + *cost, from};
        }
      }
    }
    for (std::size_t to = ends_.size() - 1; to > 0; to = cuts_[to].from) {
      if (to - cuts_[to].from > 1) chords_.push_back(ChordOf(cuts_[to].from, to));
    }
  }

  /// Where a point is on the chord, and how far off.
  struct Foot {
    double t = 0;
    double distance = 0;
  };
  [[nodiscard]] Foot FootOf(std::size_t corner, std::size_t from, std::size_t to) const {
    const Vec2 a = mesh_.position(ends_[from]);
    const Vec2 along = mesh_.position(ends_[to]) - a;
    const Vec2 arm = mesh_.position(ends_[corner]) - a;
    return {Dot(arm, along) / Dot(along, along), std::fabs(Cross(along, arm)) / Length(along)};
  }

  /// Nothing if the chord does not come into question.
  [[nodiscard]] std::optional<double> CostOfChord(std::size_t from, std::size_t to) const {
    const Vec2 a = mesh_.position(ends_[from]);
    const double chord = Length(mesh_.position(ends_[to]) - a);
    if (!(chord > 0)) return std::nullopt;
    const double slack = kRounding * (chord + Length(a));
    double length = 0;
    double straight = 0;
    double farthest = 0;
    double last = 0;
    for (std::size_t i = from; i < to; ++i) {
      const Foot foot = i + 1 == to ? Foot{1, 0} : FootOf(i + 1, from, to);
      if (!((foot.t - last) * chord >= kShareKept * links_[i].straight)) return std::nullopt;
      if (!(foot.distance <= tolerance_ + slack)) return std::nullopt;
      last = foot.t;
      farthest = std::max(farthest, foot.distance);
      length += links_[i].length;
      straight += links_[i].straight;
    }
    length *= chord / straight;
    const int edge_count = EdgesFor(length);
    if (edge_count >= static_cast<int>(to - from)) return std::nullopt;
    const double moved = farthest / (tolerance_ + slack);
    return CostOf(length, edge_count) + kCostOfTolerance * moved * moved;
  }

  [[nodiscard]] Chord ChordOf(std::size_t from, std::size_t to) const {
    Chord chord;
    for (std::size_t i = from; i <= to; ++i) {
      chord.corners.push_back(ends_[i]);
      const bool inside = i > from && i < to;
      chord.parameters.push_back(inside ? FootOf(i, from, to).t : (i == from ? 0 : 1));
      if (i < to) chord.segments.push_back(links_[i].segment);
    }
    return chord;
  }

  /// Two segments with the same two ends would be one on the other.
  void DropDoubles() {
    std::set<std::pair<VertexId, VertexId>> known;
    std::erase_if(chords_, [&](const Chord& chord) {
      const VertexId a = chord.corners.front();
      const VertexId b = chord.corners.back();
      bool joined = a == b || !known.emplace(std::min(a, b), std::max(a, b)).second;
      ForEachEdgeAt(mesh_, a, [&](EdgeId id) {
        joined = joined || OtherEnd(mesh_.edge(id).segment, a) == b;
      });
      return joined;
    });
  }

  const Mesh& mesh_;
  const double tolerance_;
  std::vector<VertexId> corners_;  // Ascending.
  PlaceMap place_of_;              // In corners_.
  std::vector<bool> done_;
  std::vector<Chord> chords_;
  // Of the chain at hand: link i runs from end i to end i + 1.
  std::vector<VertexId> ends_;
  std::vector<Link> links_;
  std::vector<Cut> cuts_;
};

}  // namespace

Vec2 Chord::PositionOf(const Mesh& mesh, std::size_t corner) const {
  const Vec2 a = mesh.position(corners.front());
  const Vec2 b = mesh.position(corners.back());
  return a + parameters[corner] * (b - a);
}

bool IsSoftCorner(const Mesh& mesh, VertexId vertex) {
  const VertexRecord& record = mesh.vertex(vertex);
  if (!record.live || !record.fixed || record.frozen || record.pinched) return false;
  int count = 0;
  bool soft = true;
  std::int32_t tag = 0;
  std::int32_t segment = -1;
  ForEachEdgeAt(mesh, vertex, [&](EdgeId id) {
    const EdgeRecord& edge = mesh.edge(id);
    soft = soft && !edge.frozen && (count == 0 || (edge.tag == tag && edge.segment != segment));
    tag = edge.tag;
    segment = edge.segment;
    ++count;
  });
  return soft && count == 2;
}

std::vector<Chord> ChooseChords(const Mesh& mesh, std::span<const VertexId> corners,
                                double tolerance) {
  return ChordChooser(mesh, corners, tolerance).Run();
}

}  // namespace pliant
