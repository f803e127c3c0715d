#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <utility>
#include <vector>

#include "core/base/ids.h"
#include "core/base/result.h"
#include "core/base/stop_signal.h"
#include "core/geometry/vec2.h"
#include "core/mesh/mesh.h"
#include "core/mesh/place_map.h"
#include "core/metric/metric.h"
#include "core/motion/motion.h"

namespace pliant {

/// A vertex that moves by itself.
struct Mover {
  static constexpr std::int32_t kStraight = -1;

  VertexId vertex;
  Vec2 from;
  Vec2 to;                         ///< Where it goes if it goes straight.
  std::int32_t shape = kStraight;  ///< Index into MotionRequest::tags, else.
  bool given = true;               ///< Must arrive; others ride along and may be removed.
};

/// A vertex inside a segment that moves, or along which it moves itself.
struct Rider {
  VertexId vertex;
  std::int32_t segment = 0;
  double t = 0;        ///< Its parameter at first; it goes straight to t_end.
  double t_end = 0;    ///< Equal to `t` if the vertex was not named.
  bool given = false;  ///< It was named: must arrive, exactly at `to`.
  Vec2 to;
};

/// Who moves, and where everyone is at any time of the motion.
///
/// *Invariants*: no vertex is both mover and rider or one of them twice. At(0) is where the vertex
/// was, At(1) of a straight mover has the bits that were asked for.
/// *Threads*: one caller at a time (positions are cached per time).
class MotionPlan {
 public:
  /// Checks a request against the mesh and lists what moves.
  /// Errors, with `field` among "motion.vertices", "motion.positions", "motion.tags" and
  /// "motion.follow_length": kArrayLength, kIndexOutOfRange (no live vertex, or no edge has the
  /// tag), kDuplicateId, kNotFinite, kOutOfRange; index = position in the given list.
  /// @param stop  asked while the plan is made and carried out, null: nobody; then kCancelled here,
  ///              and what FindRiders and AddFollowers leave may be incomplete: ask it afterwards.
  ///              Outlives the plan.
  /// @par Cost O(what moves + constrained edges)
  [[nodiscard]] static Result<MotionPlan> Make(const Mesh& mesh, MotionRequest request,
                                               const StopSignal* stop = nullptr);

  /// Vertices at which segments are to be cut before riders are looked for: those that are named
  /// and leave the line of their segment, by more than the rounding of their coordinates.
  [[nodiscard]] const std::vector<VertexId>& cuts() const { return cuts_; }

  /// Lists who rides along. @pre the cuts are made
  void FindRiders(const Mesh& mesh);

  /// Adds the interior vertices within follow_length of the movers. @pre FindRiders
  /// @par Cost O(k log k) for k vertices
  void AddFollowers(const Mesh& mesh);

  [[nodiscard]] const std::vector<Mover>& movers() const { return movers_; }
  [[nodiscard]] const std::vector<Rider>& riders() const { return riders_; }
  /// Segments with an end that moves, ascending.
  [[nodiscard]] const std::vector<std::int32_t>& moved_segments() const { return segments_; }

  /// True if what moves by this shape has other lengths or angles at time s than at first, by more
  /// than rounding.
  [[nodiscard]] bool Distorts(std::int32_t shape, double s) const;

  /// Where a mover is at time s.
  [[nodiscard]] Vec2 At(const Mover& mover, double s) const;
  /// The parameter of a rider at time s.
  [[nodiscard]] static double ParameterAt(const Rider& rider, double s) {
    return s == 1 ? rider.t_end : rider.t + s * (rider.t_end - rider.t);
  }

  /// Pieces of equal time within which every path is straight, up to 0.1 % of its radius.
  [[nodiscard]] std::int32_t piece_count() const { return piece_count_; }

  /// True if vertices in the interior are named.
  [[nodiscard]] bool names_inside() const { return names_inside_; }
  [[nodiscard]] const MotionRequest& request() const { return request_; }
  [[nodiscard]] const StopSignal* stop() const { return stop_; }

  /// The tensor that a mover carries along: turned and stretched as its surroundings are at time s.
  [[nodiscard]] Metric Carried(const Mover& mover, const Metric& metric, double s) const;

 private:
  /// p goes to center + (p - center) mapped by a, + shift.
  struct Map {
    Vec2 center;
    Vec2 column_x{1, 0};
    Vec2 column_y{0, 1};
    Vec2 shift;
  };

  /// The maps of all tags at one time: sines and cosines cost more than all the rest. Two times
  /// are kept, because the paths of a piece are asked for by their two ends, in turn.
  struct MapsAt {
    double time = -1;
    std::vector<Map> maps;
  };

  /// A vertex inside a segment that the request names.
  struct Named {
    std::int32_t segment = 0;
    VertexId vertex;
    Vec2 to;
  };

  MotionPlan(MotionRequest request, const StopSignal* stop)
      : request_(std::move(request)), stop_(stop) {}
  Status AddNamed(const Mesh& mesh);
  Status AddTagged(const Mesh& mesh);
  void SetPieceCount();
  void ChooseCuts(const Mesh& mesh);
  [[nodiscard]] bool StaysStraight(const Mesh& mesh, std::int32_t segment) const;
  [[nodiscard]] Vec2 EndOf(const Mesh& mesh, VertexId vertex) const;
  [[nodiscard]] const Map& MapAt(std::int32_t shape, double s) const;
  [[nodiscard]] static Map MapOf(const PathShape& shape, double s);

  MotionRequest request_;
  const StopSignal* stop_;
  std::vector<Mover> movers_;
  std::vector<Rider> riders_;
  PlaceMap mover_of_;                              ///< In movers_.
  std::unordered_map<std::int32_t, Named> named_;  ///< By vertex slot.
  std::vector<VertexId> cuts_;
  std::vector<std::int32_t> segments_;
  std::int32_t piece_count_ = 1;
  bool names_inside_ = false;
  mutable std::array<MapsAt, 2> cached_;  ///< The last two times asked for, the last one first.
};

}  // namespace pliant
