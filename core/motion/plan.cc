#include "core/motion/plan.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include "core/base/check.h"
#include "core/base/sort_unique.h"
#include "core/mesh/id_bits.h"
#include "core/mesh/place_map.h"
#include "core/mesh/segment_edges.h"
#include "core/mesh/star.h"
#include "core/metric/math_functions.h"

namespace pliant {
namespace {

constexpr double kAngleMax = 1000;
constexpr std::size_t kDegreeMax = 16;
/// A piece of a turn: its chord deviates from the arc by 0.1 % of the radius.
constexpr double kAngleOfPiece = 0.09;
constexpr std::int32_t kPiecesOfPath = 16;
/// A named vertex this far off its segment, as a share of the coordinates, still lies on it: some
/// thousand roundings, and below what Validate lets pass.
constexpr double kOffSegment = 1e-12;

Error MotionError(ErrorCode code, const char* field, std::size_t index, const std::string& what) {
  return {code, "entry " + std::to_string(index) + " of " + field + " " + what, field,
          static_cast<std::int64_t>(index)};
}

/// Who is reached next: a heap by distance, then vertex, then source. Which of two comes first
/// cannot be predicted, so they are compared as whole numbers, without a branch.
class NearestFirst {
 public:
  struct Entry {
    double distance = 0;
    VertexId vertex;
    std::size_t source = 0;
  };

  [[nodiscard]] bool empty() const { return heap_.empty(); }
  void Push(double distance, VertexId vertex, std::size_t source) {
    // Not negative: the bits are in the order of the values.
    heap_.push_back({std::bit_cast<std::uint64_t>(distance),
                     static_cast<std::uint64_t>(vertex.index()) << 32 | source});
    std::push_heap(heap_.begin(), heap_.end(), IsFarther);
  }
  Entry Pop() {
    std::pop_heap(heap_.begin(), heap_.end(), IsFarther);
    const auto [distance, who] = heap_.back();
    heap_.pop_back();
    return {std::bit_cast<double>(distance), VertexId(static_cast<std::int32_t>(who >> 32)),
            static_cast<std::size_t>(who & UINT32_MAX)};
  }

 private:
  struct Key {
    std::uint64_t distance;
    std::uint64_t who;
  };
  static bool IsFarther(const Key& a, const Key& b) {
    return (static_cast<int>(a.distance > b.distance) |
            (static_cast<int>(a.distance == b.distance) & static_cast<int>(a.who > b.who))) != 0;
  }

  std::vector<Key> heap_;
};

Status CheckShape(const PathShape& shape, std::size_t index) {
  const auto bad = [&](ErrorCode code, const std::string& what) {
    return MotionError(code, "motion.tags", index, what);
  };
  bool finite = true;
  if (const auto* translation = std::get_if<Translation>(&shape)) {
    finite = IsFinite(translation->by);
  } else if (const auto* rotation = std::get_if<Rotation>(&shape)) {
    finite = IsFinite(rotation->center) && std::isfinite(rotation->angle_rad);
    if (finite && std::fabs(rotation->angle_rad) > kAngleMax) {
      return bad(ErrorCode::kOutOfRange,
                 "turns by more than 1000 radians; turn in several updates");
    }
  } else if (const auto* map = std::get_if<AffineMap>(&shape)) {
    finite = IsFinite(map->b) && IsFinite(Vec2{map->a11, map->a12}) &&
             IsFinite(Vec2{map->a21, map->a22});
    if (finite && !(map->a11 * map->a22 - map->a12 * map->a21 > 0)) {
      return bad(ErrorCode::kOutOfRange, "has a determinant that is not positive");
    }
  } else {
    const auto& path = std::get<PolynomialPath>(shape).coefficients;
    if (path.empty() || path.size() > kDegreeMax) {
      return bad(ErrorCode::kOutOfRange,
                 "has " + std::to_string(path.size()) + " coefficients; expected 1 to 16");
    }
    for (const Vec2 c : path) finite = finite && IsFinite(c);
  }
  if (!finite) return bad(ErrorCode::kNotFinite, "has a number that is NaN or infinite");
  return {};
}

}  // namespace

Result<MotionPlan> MotionPlan::Make(const Mesh& mesh, MotionRequest request,
                                    const StopSignal* stop) {
  MotionPlan plan(std::move(request), stop);
  if (!(plan.request_.follow_length >= 0) || !std::isfinite(plan.request_.follow_length)) {
    return Error{ErrorCode::kOutOfRange, "motion.follow_length must be a finite number >= 0",
                 "motion.follow_length"};
  }
  PLIANT_RETURN_IF_ERROR(plan.AddNamed(mesh));
  PLIANT_RETURN_IF_ERROR(plan.AddTagged(mesh));
  plan.SetPieceCount();
  plan.ChooseCuts(mesh);
  if (stop != nullptr && stop->asked()) return Stopped();
  return plan;
}

Status MotionPlan::AddNamed(const Mesh& mesh) {
  const std::vector<VertexId>& vertices = request_.vertices;
  const std::vector<Vec2>& positions = request_.positions;
  if (vertices.size() != positions.size()) {
    return Error{ErrorCode::kArrayLength,
                 "there are " + std::to_string(positions.size()) + " positions for " +
                     std::to_string(vertices.size()) + " vertices; send one for each",
                 "motion.positions"};
  }
  PlaceMap seen(mesh.vertex_slots());
  seen.Reserve(vertices.size());
  movers_.reserve(vertices.size());
  StopPoll stopped(stop_);
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    if (stopped()) return Stopped();
    const VertexId id = vertices[i];
    if (!mesh.IsLive(id)) {
      return MotionError(
          ErrorCode::kIndexOutOfRange, "motion.vertices", i,
          "is " + std::to_string(id.value()) + ", which is no vertex of this revision");
    }
    if (!seen.Add(id, 0)) {
      return MotionError(ErrorCode::kDuplicateId, "motion.vertices", i,
                         "names vertex " + std::to_string(id.value()) + " a second time");
    }
    if (!IsFinite(positions[i])) {
      return MotionError(ErrorCode::kNotFinite, "motion.positions", i, "is NaN or infinite");
    }
    const VertexRecord& record = mesh.vertex(id);
    if (record.edge.valid() && !record.fixed) {
      const std::int32_t segment = mesh.edge(record.edge).segment;
      named_.emplace(id.value(), Named{segment, id, positions[i]});
    } else if (!record.edge.valid() || !SameBits(record.position, positions[i])) {
      movers_.push_back({id, record.position, positions[i]});
      names_inside_ = names_inside_ || !record.edge.valid();
    }
  }
  return {};
}

Status MotionPlan::AddTagged(const Mesh& mesh) {
  std::unordered_map<std::int32_t, std::int32_t> shape_of;
  for (std::size_t i = 0; i < request_.tags.size(); ++i) {
    PLIANT_RETURN_IF_ERROR(CheckShape(request_.tags[i].shape, i));
    for (const std::int32_t tag : request_.tags[i].tags) {
      if (!shape_of.emplace(tag, static_cast<std::int32_t>(i)).second) {
        return MotionError(ErrorCode::kDuplicateId, "motion.tags", i,
                           "names tag " + std::to_string(tag) + " a second time");
      }
    }
  }
  if (shape_of.empty()) return {};
  std::unordered_set<std::int32_t> found;
  std::vector<std::pair<VertexId, std::int32_t>> points;
  for (std::int32_t e = 0; e < mesh.edge_slots(); ++e) {
    const EdgeRecord& edge = mesh.edge(EdgeId(e));
    if (!edge.live) continue;
    const auto shape = shape_of.find(edge.tag);
    if (shape == shape_of.end()) continue;
    found.insert(edge.tag);
    for (const VertexId end : edge.vertices) {
      if (mesh.vertex(end).fixed) points.emplace_back(end, shape->second);
    }
  }
  for (std::size_t i = 0; i < request_.tags.size(); ++i) {
    for (const std::int32_t tag : request_.tags[i].tags) {
      if (!found.contains(tag)) {
        return MotionError(ErrorCode::kIndexOutOfRange, "motion.tags", i,
                           "names tag " + std::to_string(tag) + ", which no edge has");
      }
    }
  }
  IdBits<VertexId> known(mesh.vertex_slots());
  for (const Mover& mover : movers_) known.Add(mover.vertex);
  // By vertex, then by the place of the motion in the list: the first one wins.
  std::sort(points.begin(), points.end());
  for (const auto& [vertex, shape] : points) {
    if (known.Has(vertex)) continue;
    known.Add(vertex);
    const Vec2 p = mesh.position(vertex);
    movers_.push_back({vertex, p, p, shape});
  }
  return {};
}

void MotionPlan::SetPieceCount() {
  for (const TagMotion& motion : request_.tags) {
    std::int32_t count = 1;
    if (const auto* rotation = std::get_if<Rotation>(&motion.shape)) {
      count = static_cast<std::int32_t>(std::fabs(rotation->angle_rad) / kAngleOfPiece) + 1;
    } else if (const auto* path = std::get_if<PolynomialPath>(&motion.shape)) {
      if (path->coefficients.size() > 1) count = kPiecesOfPath;
    }
    piece_count_ = std::max(piece_count_, count);
  }
}

void MotionPlan::ChooseCuts(const Mesh& mesh) {
  StopPoll stopped(stop_);
  mover_of_ = PlaceMap(mesh.vertex_slots());
  mover_of_.Reserve(movers_.size());
  for (std::size_t i = 0; i < movers_.size() && !stopped(); ++i) {
    mover_of_.Add(movers_[i].vertex, static_cast<std::int32_t>(i));
  }
  std::unordered_map<std::int32_t, bool> straight;
  // In the order of the request, not of the map.
  for (const VertexId vertex : request_.vertices) {
    if (stopped()) return;
    const auto named = named_.find(vertex.value());
    if (named == named_.end()) continue;
    const auto [known, is_new] = straight.emplace(named->second.segment, false);
    if (is_new) known->second = StaysStraight(mesh, named->second.segment);
    if (known->second) continue;
    cuts_.push_back(vertex);
    mover_of_.Add(vertex, static_cast<std::int32_t>(movers_.size()));
    movers_.push_back({vertex, mesh.position(vertex), named->second.to});
    named_.erase(named);
  }
}

bool MotionPlan::StaysStraight(const Mesh& mesh, std::int32_t segment) const {
  const SegmentRecord& line = mesh.segments()[static_cast<std::size_t>(segment)];
  const Vec2 a = EndOf(mesh, line.a);
  const Vec2 along = EndOf(mesh, line.b) - a;
  const double slack = kOffSegment * (Length(along) + Length(a));
  double last = 0;
  bool straight = Dot(along, along) > 0;
  ForEachInside(mesh, segment, [&](VertexId vertex, double t) {
    const auto named = named_.find(vertex.value());
    if (named != named_.end()) {
      t = Dot(named->second.to - a, along) / Dot(along, along);
      straight = straight && Length(named->second.to - (a + t * along)) <= slack;
    }
    straight = straight && last < t && t < 1;
    last = t;
  });
  return straight;
}

Vec2 MotionPlan::EndOf(const Mesh& mesh, VertexId vertex) const {
  const std::int32_t mover = mover_of_.At(vertex);
  return mover == PlaceMap::kNone ? mesh.position(vertex)
                                  : At(movers_[static_cast<std::size_t>(mover)], 1);
}

void MotionPlan::FindRiders(const Mesh& mesh) {
  for (const Mover& mover : movers_) {
    ForEachEdgeAt(mesh, mover.vertex,
                  [&](EdgeId id) { segments_.push_back(mesh.edge(id).segment); });
  }
  for (const auto& [slot, named] : named_) {
    if (!SameBits(mesh.position(named.vertex), named.to)) segments_.push_back(named.segment);
  }
  SortUnique(segments_);
  for (const std::int32_t segment : segments_) {
    const SegmentRecord& line = mesh.segments()[static_cast<std::size_t>(segment)];
    const Vec2 a = EndOf(mesh, line.a);
    const Vec2 along = EndOf(mesh, line.b) - a;
    ForEachInside(mesh, segment, [&](VertexId vertex, double t) {
      Rider rider{.vertex = vertex, .segment = segment, .t = t, .t_end = t, .to = {}};
      const auto named = named_.find(vertex.value());
      if (named != named_.end()) {
        rider.given = true;
        rider.to = named->second.to;
        rider.t_end = Dot(rider.to - a, along) / Dot(along, along);
      }
      riders_.push_back(rider);
    });
  }
}

void MotionPlan::AddFollowers(const Mesh& mesh) {
  if (request_.follow_length == 0) return;
  // Dijkstra over the edges: every follower moves like the mover that is nearest to it.
  struct Reached {
    double distance = std::numeric_limits<double>::infinity();
    bool done = false;
  };
  NearestFirst queue;
  std::vector<Reached> reached;
  PlaceMap place_of(mesh.vertex_slots());
  const auto place = [&](VertexId vertex) {
    if (place_of.Add(vertex, static_cast<std::int32_t>(reached.size()))) reached.emplace_back();
    return static_cast<std::size_t>(place_of.At(vertex));
  };
  const auto reach = [&](double distance, VertexId vertex, std::size_t source) {
    Reached& known = reached[place(vertex)];
    if (known.done || known.distance <= distance) return;
    known.distance = distance;
    queue.Push(distance, vertex, source);
  };
  for (std::size_t i = 0; i < movers_.size(); ++i) {
    const VertexId vertex = movers_[i].vertex;
    reach(0, vertex, i);
    if (!mesh.vertex(vertex).edge.valid()) {
      reached[static_cast<std::size_t>(place_of.At(vertex))].done = true;  // Leads nobody.
    }
  }
  for (const Rider& rider : riders_) {
    const SegmentRecord& segment = mesh.segments()[static_cast<std::size_t>(rider.segment)];
    const std::int32_t a = mover_of_.At(segment.a);
    // A segment of which one end stays leads nobody: it stretches.
    if (a != PlaceMap::kNone && mover_of_.At(segment.b) != PlaceMap::kNone) {
      reach(0, rider.vertex, static_cast<std::size_t>(a));
    }
  }
  Star star;
  StopPoll stopped(stop_);
  while (!queue.empty() && !stopped()) {
    const NearestFirst::Entry nearest = queue.Pop();
    const VertexId vertex = nearest.vertex;
    Reached& here = reached[static_cast<std::size_t>(place_of.At(vertex))];
    if (here.done) continue;
    here.done = true;
    const VertexRecord& record = mesh.vertex(vertex);
    if (nearest.distance > 0) {
      // What lies behind another wall does not belong to the layer.
      if (record.edge.valid() || record.fixed || record.frozen) continue;
      const Mover& leader = movers_[nearest.source];
      movers_.push_back({vertex, record.position, record.position + (leader.to - leader.from),
                         leader.shape, false});
    }
    const auto look_around = [&](TriangleId fan) {
      star.Gather(mesh, vertex, fan);
      for (const VertexId neighbor : star.ring()) {
        // Half of them are; a distance costs more than a look at the table.
        if (reached[place(neighbor)].done) continue;
        const double next =
            nearest.distance + Distance(record.position, record.metric, mesh.position(neighbor),
                                        mesh.metric(neighbor));
        if (next <= request_.follow_length) reach(next, neighbor, nearest.source);
      }
    };
    if (!record.pinched) {
      look_around(record.triangle);
      continue;
    }
    for (const TriangleId fan : FansOf(mesh, vertex)) look_around(fan);
  }
}

MotionPlan::Map MotionPlan::MapOf(const PathShape& shape, double s) {
  Map map;
  if (const auto* translation = std::get_if<Translation>(&shape)) {
    map.shift = s * translation->by;
  } else if (const auto* rotation = std::get_if<Rotation>(&shape)) {
    static const auto* sine = FindMathFunction("sin");
    static const auto* cosine = FindMathFunction("cos");
    const double angle = s * rotation->angle_rad;
    map.center = rotation->center;
    map.column_x = {cosine->unary(angle), sine->unary(angle)};
    map.column_y = {-map.column_x.y, map.column_x.x};
  } else if (const auto* affine = std::get_if<AffineMap>(&shape)) {
    map.column_x = {1 + s * (affine->a11 - 1), s * affine->a21};
    map.column_y = {s * affine->a12, 1 + s * (affine->a22 - 1)};
    map.shift = s * affine->b;
  } else {
    const auto& path = std::get<PolynomialPath>(shape).coefficients;
    for (std::size_t k = path.size(); k-- > 0;) map.shift = s * (map.shift + path[k]);
  }
  return map;
}

const MotionPlan::Map& MotionPlan::MapAt(std::int32_t shape, double s) const {
  if (s != cached_[0].time) std::swap(cached_[0], cached_[1]);
  MapsAt& last = cached_[0];
  if (s != last.time) {
    last.maps.clear();
    for (const TagMotion& motion : request_.tags) last.maps.push_back(MapOf(motion.shape, s));
    last.time = s;
  }
  return last.maps[static_cast<std::size_t>(shape)];
}

bool MotionPlan::Distorts(std::int32_t shape, double s) const {
  constexpr double kRounding = 1e-12;
  const Map& map = MapAt(shape, s);
  return std::abs(Dot(map.column_x, map.column_x) - 1) > kRounding ||
         std::abs(Dot(map.column_y, map.column_y) - 1) > kRounding ||
         std::abs(Dot(map.column_x, map.column_y)) > kRounding;
}

Metric MotionPlan::Carried(const Mover& mover, const Metric& metric, double s) const {
  if (mover.shape == Mover::kStraight) return metric;
  const Map& map = MapAt(mover.shape, s);
  // An edge e becomes F e, and keeps its length in F^-T M F^-1.
  const double determinant = Cross(map.column_x, map.column_y);
  if (!(determinant > 0)) return metric;
  const Vec2 x = (1 / determinant) * Vec2{map.column_y.y, -map.column_x.y};
  const Vec2 y = (1 / determinant) * Vec2{-map.column_y.x, map.column_x.x};
  const Metric carried{SquaredLength(metric, x), InnerProduct(metric, x, y),
                       SquaredLength(metric, y)};
  return IsPositiveDefinite(carried) ? carried : metric;
}

Vec2 MotionPlan::At(const Mover& mover, double s) const {
  if (s == 0) return mover.from;
  if (mover.shape == Mover::kStraight) {
    return s == 1 ? mover.to : mover.from + s * (mover.to - mover.from);
  }
  const Map& map = MapAt(mover.shape, s);
  if (map.column_x == Vec2{1, 0} && map.column_y == Vec2{0, 1}) return mover.from + map.shift;
  const Vec2 arm = mover.from - map.center;
  return map.center + arm.x * map.column_x + arm.y * map.column_y + map.shift;
}

}  // namespace pliant
