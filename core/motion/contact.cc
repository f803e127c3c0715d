#include "core/motion/contact.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/base/stop_signal.h"
#include "core/geometry/box_tree.h"
#include "core/geometry/vec2.h"
#include "core/mesh/place_map.h"

namespace pliant {
namespace {

/// By how much of the products it is made of a determinant may miss 0 and still count as contact:
/// some tens of roundings.
constexpr double kTouch = 1e-13;

/// Who stops before a contact ends this share of the way before it: there must be room for
/// triangles in between. Then he looks again, so often at most.
constexpr double kShyOfContact = 1e-3;
constexpr int kShortenMax = 20;

/// A point on a straight line: where it is at 0 and how far it goes until 1.
struct Line {
  Vec2 from;
  Vec2 by;

  [[nodiscard]] Vec2 At(double t) const { return from + t * by; }
};

/// c0 + c1 t + c2 t^2.
struct Quadratic {
  double c0 = 0;
  double c1 = 0;
  double c2 = 0;
};

/// The times in (0, 1] at which a quadratic is zero; at most two.
struct Roots {
  std::array<double, 2> at{};
  std::size_t count = 0;

  void Add(double t) {
    if (t > 0 && t <= 1) at[count++] = t;
  }
};

Roots RootsOf(const Quadratic& q) {
  Roots roots;
  if (q.c2 == 0) {
    if (q.c1 != 0) roots.Add(-q.c0 / q.c1);
    return roots;
  }
  const double discriminant = q.c1 * q.c1 - 4 * q.c2 * q.c0;
  if (discriminant < 0) {
    // A touch without a crossing, missed by rounding, counts at its vertex.
    if (-discriminant <= kTouch * q.c1 * q.c1) roots.Add(-q.c1 / (2 * q.c2));
    return roots;
  }
  const double root = std::sqrt(discriminant);
  const double half = -0.5 * (q.c1 + (q.c1 >= 0 ? root : -root));
  roots.Add(half / q.c2);
  if (half != 0) roots.Add(q.c0 / half);
  return roots;
}

Quadratic CrossOf(const Line& u, const Line& v) {
  return {Cross(u.from, v.from), Cross(u.from, v.by) + Cross(u.by, v.from), Cross(u.by, v.by)};
}
Quadratic DotOf(const Line& u, const Line& v) {
  return {Dot(u.from, v.from), Dot(u.from, v.by) + Dot(u.by, v.from), Dot(u.by, v.by)};
}
Line Between(const Line& a, const Line& b) { return {b.from - a.from, b.by - a.by}; }

/// True if p lies on the segment ab, ends included, up to rounding. `size` bounds the coordinates
/// that went into the points.
bool Touches(Vec2 a, Vec2 b, Vec2 p, double size) {
  const Vec2 along = b - a;
  const Vec2 to_p = p - a;
  const double length = Length(along);
  // Too far by `slack` counts as touching.
  const double slack = kTouch * size;
  if (std::fabs(Cross(along, to_p)) > slack * (length + slack)) return false;
  const double at = Dot(along, to_p);
  return at >= -slack * (length + slack) && at <= length * length + slack * (length + slack);
}

/// The first time in (0, 1] at which p lies on ab; infinity if it does not.
double FirstTouch(const Line& a, const Line& b, const Line& p) {
  const Line along = Between(a, b);
  const Line to_p = Between(a, p);
  double size = 0;
  for (const Line* line : {&a, &b, &p}) {
    size = std::max({size, std::fabs(line->from.x), std::fabs(line->from.y),
                     std::fabs(line->from.x + line->by.x), std::fabs(line->from.y + line->by.y)});
  }
  double first = std::numeric_limits<double>::infinity();
  // On the line of the segment; or, where p stays on that line, at one of its ends.
  for (const Quadratic& q :
       {CrossOf(along, to_p), DotOf(along, to_p), DotOf(along, Between(b, p))}) {
    const Roots roots = RootsOf(q);
    for (std::size_t i = 0; i < roots.count; ++i) {
      const double t = roots.at[i];
      if (t < first && Touches(a.At(t), b.At(t), p.At(t), size)) first = t;
    }
  }
  if (first > 1 && Touches(a.At(1), b.At(1), p.At(1), size)) first = 1;
  return first;
}

class ContactFinder {
 public:
  ContactFinder(const Mesh& mesh, const MotionPlan& plan)
      : mesh_(mesh), plan_(plan), stopped_(plan.stop()), mover_of_(mesh.vertex_slots()) {
    mover_of_.Reserve(plan.movers().size());
    for (std::size_t i = 0; i < plan.movers().size() && !stopped_(); ++i) {
      mover_of_.Add(plan.movers()[i].vertex, static_cast<std::int32_t>(i));
    }
  }

  std::optional<Contact> Run() {
    const double piece = 1.0 / plan_.piece_count();
    for (std::int32_t k = 0; k < plan_.piece_count() && !stopped_(); ++k) {
      begin_ = k * piece;
      end_ = k + 1 == plan_.piece_count() ? 1 : (k + 1) * piece;
      if (RunPiece()) {
        return Contact{begin_ + first_ * (end_ - begin_), EdgeAt(first_pair_[0], touch_),
                       EdgeAt(first_pair_[1], touch_)};
      }
    }
    return std::nullopt;
  }

  double FreeTimeBefore(double time) {
    const double piece = 1.0 / plan_.piece_count();
    end_ = (1 - kShyOfContact) * time;
    begin_ = piece * std::floor(end_ / piece);
    for (int i = 0; i < kShortenMax && end_ > begin_ && !stopped_(); ++i) {
      if (!RunPiece()) return end_;
      end_ = begin_ + (1 - kShyOfContact) * first_ * (end_ - begin_);
    }
    return begin_;
  }

 private:
  [[nodiscard]] const SegmentRecord& SegmentOf(std::int32_t segment) const {
    return mesh_.segments()[static_cast<std::size_t>(segment)];
  }

  [[nodiscard]] Line LineOf(VertexId vertex) const {
    const std::int32_t mover = mover_of_.At(vertex);
    if (mover == PlaceMap::kNone) return {mesh_.position(vertex), {}};
    const Mover& m = plan_.movers()[static_cast<std::size_t>(mover)];
    const Vec2 from = plan_.At(m, begin_);
    return {from, plan_.At(m, end_) - from};
  }

  /// Finds the first contact within a piece.
  bool RunPiece() {
    const std::size_t count = mesh_.segments().size();
    std::vector<BoundingBox> boxes(count);
    std::vector<BoundingBox> line_boxes;
    std::vector<std::int32_t> lines;
    for (std::size_t s = 0; s < count; ++s) {
      if (stopped_()) return false;
      if (!mesh_.segments()[s].is_line()) continue;
      boxes[s] = SweptBox(static_cast<std::int32_t>(s));
      line_boxes.push_back(boxes[s]);
      lines.push_back(static_cast<std::int32_t>(s));
    }
    const BoxTree tree(line_boxes);
    first_ = std::numeric_limits<double>::infinity();
    for (const std::int32_t segment : plan_.moved_segments()) {
      if (stopped_()) return false;
      tree.ForEachMeeting(boxes[static_cast<std::size_t>(segment)], [&](std::int32_t place) {
        const std::int32_t other = lines[static_cast<std::size_t>(place)];
        const bool both =
            std::binary_search(plan_.moved_segments().begin(), plan_.moved_segments().end(), other);
        if (other != segment && (!both || segment < other)) TestPair(segment, other);
        return true;
      });
    }
    return first_ <= 1;
  }

  [[nodiscard]] BoundingBox SweptBox(std::int32_t segment) const {
    const Line a = LineOf(SegmentOf(segment).a);
    const Line b = LineOf(SegmentOf(segment).b);
    return BoxOf(std::array{a.from, a.At(1), b.from, b.At(1)});
  }

  /// Two segments that do not cross first meet where an end of one lies on the other.
  void TestPair(std::int32_t one, std::int32_t two) {
    const SegmentRecord& s = SegmentOf(one);
    const SegmentRecord& t = SegmentOf(two);
    TestPoint(one, two, t.a);
    TestPoint(one, two, t.b);
    TestPoint(two, one, s.a);
    TestPoint(two, one, s.b);
  }

  void TestPoint(std::int32_t segment, std::int32_t other, VertexId point) {
    const SegmentRecord& s = SegmentOf(segment);
    if (point == s.a || point == s.b) return;
    const Line p = LineOf(point);
    const double time = FirstTouch(LineOf(s.a), LineOf(s.b), p);
    if (time < first_) {
      first_ = time;
      first_pair_ = {segment, other};
      touch_ = p.At(time);
    }
  }

  /// The edge of a segment that is nearest to a point of it at the time of contact.
  [[nodiscard]] EdgeId EdgeAt(std::int32_t segment, Vec2 point) const {
    const SegmentRecord& s = SegmentOf(segment);
    const Vec2 a = LineOf(s.a).At(first_);
    const Vec2 along = LineOf(s.b).At(first_) - a;
    const double length = Dot(along, along);
    const double t = length > 0 ? Dot(point - a, along) / length : 0;
    EdgeId best;
    VertexId at = s.a;
    while (at != s.b) {
      EdgeId next;
      for (EdgeId id = mesh_.vertex(at).edge; id.valid();) {
        const EdgeRecord& edge = mesh_.edge(id);
        if (edge.segment == segment && edge.vertices[0] == at) next = id;
        id = edge.next[edge.vertices[0] == at ? 0 : 1];
      }
      PLIANT_CHECK(next.valid(), "segment", segment);
      best = next;
      if (mesh_.edge(next).parameters[1] >= t) break;
      at = mesh_.edge(next).vertices[1];
    }
    return best;
  }

  const Mesh& mesh_;
  const MotionPlan& plan_;
  StopPoll stopped_;
  PlaceMap mover_of_;
  double begin_ = 0;
  double end_ = 1;
  double first_ = 0;
  std::array<std::int32_t, 2> first_pair_{};
  Vec2 touch_;
};

}  // namespace

std::optional<Contact> FindContact(const Mesh& mesh, const MotionPlan& plan) {
  return ContactFinder(mesh, plan).Run();
}

double FreeTimeBefore(const Contact& contact, const Mesh& mesh, const MotionPlan& plan) {
  return ContactFinder(mesh, plan).FreeTimeBefore(contact.time);
}

}  // namespace pliant
