#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "core/base/ids.h"
#include "core/base/result.h"
#include "core/base/stop_signal.h"
#include "core/delaunay/metric_flip.h"
#include "core/geometry/vec2.h"
#include "core/mesh/mesh_edit.h"
#include "core/mesh/place_map.h"
#include "core/mesh/star.h"
#include "core/motion/motion.h"
#include "core/motion/plan.h"

namespace pliant {

/// Carries a motion out on the mesh, in sub-steps after each of which every triangle is positive.
///
/// A sub-step that would turn a triangle over, or flatten it, is a leap: the vertices that stand
/// still where it leads are dropped, and the cavity that this leaves is triangulated at the new
/// positions. If that fails where next to nobody can be dropped, or at the end of a motion that
/// names vertices in the interior, the cavity grows by whatever it overlaps. Where a leap fails,
/// the sub-step is taken back and tried with half its length. Once it is short against the wanted
/// edge length, what blocks it is removed: free vertices in the interior first, then vertices
/// inside segments; then edges are swapped; at last a cavity of any kind is triangulated anew.
/// Triangles that have become poor are swapped after each sub-step.
///
/// *Invariants*: between sub-steps the mesh is valid, apart from metrics of moved vertices, which
/// are still those of where they were.
/// *Threads*: one caller at a time.
class Advance {
 public:
  /// Called after each sub-step with its time; for tests.
  using Observer = std::function<void(double)>;

  /// @param plan  complete: cuts made, riders and followers found. Must outlive this object.
  Advance(MeshEdit& edit, const MotionPlan& plan, Observer observer = nullptr);

  /// Goes on until time `limit`, or as far as possible, or until the plan's stop signal is asked
  /// and says yes: then the mesh is somewhere in between and good for nothing but being undone.
  /// @return the time reached.
  /// @par Cost O(m) per sub-step for m vertices that move against a neighbour
  double RunTo(double limit);

  /// The counts of the motion; fraction and edges are the caller's.
  [[nodiscard]] const MotionReport& report() const { return report_; }

  /// Live vertices whose surroundings are not what they were, ascending.
  struct Disturbance {
    std::vector<VertexId> all;
    std::vector<VertexId> strained;  ///< MeshChange::Outcome::drifting.
  };
  [[nodiscard]] Disturbance Disturbed();

  /// Why the last positions allow no mesh at all: a vertex (index) named in the interior would be
  /// outside of the domain, on a constrained edge, or where another one (other_index) is. Nothing
  /// if that was not tried, or is not so.
  [[nodiscard]] const std::optional<Error>& Misplaced() const { return misplaced_; }

  /// Two constrained edges at triangles that could not be kept; none if it ran to its end.
  [[nodiscard]] std::pair<EdgeId, EdgeId> Blockers() const { return blockers_; }

 private:
  /// A triangle that a sub-step would spoil.
  struct Spoiled {
    TriangleId triangle;
    double step = 0;  ///< Longest metric length that a corner of it was to go.
    bool flipped = false;
  };
  enum class When { kBefore, kNow };

  [[nodiscard]] bool IsFree(VertexId vertex) const;
  [[nodiscard]] std::int32_t GroupOf(VertexId vertex) const;
  [[nodiscard]] Vec2 PositionAt(VertexId vertex, double s) const;
  void FindFront();
  void JoinFront(VertexId vertex);
  void GatherNear();
  void Place(std::size_t place, double s);
  void PlaceNear(double s);
  void PlaceRest(double s);
  void PlaceRider(const Rider& rider, double s);
  void TakeBack();
  [[nodiscard]] bool IsNear(std::size_t place) const { return near_stamp_[place] == stamp_; }
  [[nodiscard]] bool flips() const;
  void CheckFront();
  /// Looks for triangles of the others that rounding has turned over.
  void CheckRest();
  void SortSpoiled();
  template <class Visit>
  void ForEachTriangleAt(VertexId vertex, Visit visit);
  /// All triangles that have a corner in the front, some of them more than once.
  template <class Visit>
  void ForEachTriangleOfFront(Visit visit);
  [[nodiscard]] bool IsInFront(VertexId vertex) const {
    const std::int32_t place = place_of_.At(vertex);
    return place != PlaceMap::kNone && in_front_[static_cast<std::size_t>(place)];
  }
  void CheckTriangle(TriangleId id);
  [[nodiscard]] double Height(const TriangleRecord& triangle, When when) const;
  [[nodiscard]] Vec2 PositionBefore(VertexId vertex) const;
  /// Makes room where the last try failed. @return true if something was changed.
  bool MakeRoom(double s);
  bool RemoveOne(TriangleId id);
  bool Remove(VertexId vertex);
  bool SwapOne(TriangleId id, double s);
  [[nodiscard]] bool StaysPositive(VertexId a, VertexId b, VertexId c, double s) const;
  void Accept(double s);
  void SwapPoor();
  /// Goes to time s by triangulating anew what lies in the way. @return false, and nothing
  /// changed, if that does not work
  bool Leap(double s);
  /// True if few corners of the spoiled triangles may be removed.
  [[nodiscard]] bool MostAreGiven() const;
  /// Those in the interior that had to move far have triangles that reach across others, though
  /// they be positive.
  void AddStarsOfGiven(std::vector<TriangleId>& cavity);
  /// True if a vertex that has nowhere to go is at a spoiled triangle. @pre misplaced_
  [[nodiscard]] bool MisplacedBlocks() const;
  /// True if the error is about a vertex that is named, and in the interior.
  [[nodiscard]] bool IsOfNamed(const Error& error) const;
  bool Retriangulate(double s);
  /// @return false, and fill_error_ says why, if that does not work
  bool Fill(const std::vector<TriangleId>& cavity, double s);
  void NoteBlockers();

  MeshEdit& edit_;
  const Mesh& mesh_;
  const MotionPlan& plan_;
  const Observer observer_;
  StopPoll stopped_;
  MetricFlipper flipper_;
  MotionReport report_;
  double time_ = 0;  ///< Of the last accepted sub-step.

  std::vector<VertexId> moving_;  ///< Movers, then riders, in the plan's order.
  std::vector<Vec2> before_;      ///< Their positions before the last try.
  PlaceMap place_of_;             ///< In moving_.
  std::vector<VertexId> front_;   ///< Those with a neighbour that does not move alike.
  std::vector<bool> in_front_;    ///< By place.
  /// Places of the front and its neighbours: those that a try moves. The rest follows when it is
  /// accepted, and counts as near from then on until the next try.
  std::vector<std::size_t> near_;
  std::vector<std::uint32_t> near_stamp_;  ///< By place: equal to stamp_ if in near_.
  std::uint32_t stamp_ = 0;
  std::vector<Spoiled> spoiled_;
  std::vector<VertexId> poor_;             ///< Front vertices with a triangle of low quality.
  std::vector<std::uint32_t> poor_stamp_;  ///< By place: equal to stamp_ if in poor_.
  std::vector<VertexId> torn_;             ///< They have other triangles now.
  std::pair<EdgeId, EdgeId> blockers_;
  Error fill_error_;
  std::optional<Error> misplaced_;
  Star star_;
};

template <class Visit>
void Advance::ForEachTriangleAt(VertexId vertex, Visit visit) {
  if (mesh_.vertex(vertex).pinched) {
    for (const TriangleId fan : FansOf(mesh_, vertex)) {
      star_.Gather(mesh_, vertex, fan);
      for (const TriangleId id : star_.triangles()) visit(id);
    }
    return;
  }
  const TriangleId start = mesh_.FanStart(vertex, mesh_.vertex(vertex).triangle);
  TriangleId id = start;
  do {
    visit(id);
    const int corner = mesh_.CornerOf(id, vertex);
    id = mesh_.triangle(id).neighbors[static_cast<std::size_t>(NextCorner(corner))];
  } while (id.valid() && id != start);
}

template <class Visit>
void Advance::ForEachTriangleOfFront(Visit visit) {
  // Of a front that is most of the mesh, to read all triangles in order takes a third of the time.
  constexpr std::size_t kScanShare = 6;
  if (kScanShare * front_.size() <= static_cast<std::size_t>(mesh_.triangle_slots())) {
    for (const VertexId vertex : front_) {
      if (stopped_()) return;
      if (mesh_.IsLive(vertex)) ForEachTriangleAt(vertex, visit);
    }
    return;
  }
  for (std::int32_t t = 0; t < mesh_.triangle_slots() && !stopped_(); ++t) {
    const TriangleRecord& triangle = mesh_.triangle(TriangleId(t));
    if (!triangle.live) continue;
    const auto& v = triangle.vertices;
    if (IsInFront(v[0]) || IsInFront(v[1]) || IsInFront(v[2])) visit(TriangleId(t));
  }
}

}  // namespace pliant
