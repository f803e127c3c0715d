#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/ids.h"
#include "core/geometry/bounding_box.h"
#include "core/geometry/vec2.h"
#include "core/mesh/mesh.h"
#include "core/pliant/options.h"

namespace pliant {

/// Why the metric is not met at a place. The first rule that holds of a triangle names its kind.
enum class TroubleKind {
  /// The geometry is smaller than the wanted size, or a given corner is sharper than a triangle can
  /// be: two given vertices, or vertices of different segments, are nearer than kTroubleLengthMin;
  /// or two constrained edges meet at a given vertex of the triangle.
  kGeometry,
  /// Insertions were refused, and an edge is longer than kTroubleLengthMax.
  kVertexLimit,
  /// Directions cross: at the ends of an edge both metrics have an aspect ratio of 2 or more, and
  /// their axes differ by 30 degrees or more.
  kCrossed,
  /// The direction turns along an edge by less, but by more than the aspect ratio allows: the angle
  /// times the smaller aspect ratio is 1 or more, so that the edge strays from the front that it
  /// shall follow by an eighth of the front's thickness and more.
  kCurvature,
  /// The wanted size differs at the ends of an edge by a factor of 2 or more: a smooth metric
  /// changes by less than 1.5 over an edge of length 1.
  kSizeJump,
  /// Constraints keep the loop from doing better: the triangle, a side or a corner of it is frozen,
  /// or a restriction forbids what would help. Comes before all others.
  kFrozen,
  /// None of these: the loop was stopped, or is stuck.
  kUnsettled,
};

/// True of kinds that limits on the metric can cure: GradationOptions::gradation and rotation.
[[nodiscard]] constexpr bool LimitsHelp(TroubleKind kind) {
  return kind == TroubleKind::kCrossed || kind == TroubleKind::kCurvature ||
         kind == TroubleKind::kSizeJump;
}

/// A triangle is bad if its Q (Quality::q_mean) is below this, or an edge of it has an eq. 4 length
/// outside [kTroubleLengthMin, kTroubleLengthMax]. Where a metric can be met the loop keeps well
/// away from all three (min Q 0.6, lengths 0.6 to 1.6); where it was cooled, edges of up to about 2
/// are left on purpose.
inline constexpr double kTroubleQuality = 0.4;
inline constexpr double kTroubleLengthMin = 0.5;
inline constexpr double kTroubleLengthMax = 2.5;

/// At most this many troubles are told apart in one report; the smallest beyond are put together,
/// by kind.
inline constexpr std::size_t kTroublesMax = 32;

/// A place where the metric is not met: bad triangles that lie within an edge of each other.
struct Trouble {
  TroubleKind kind = TroubleKind::kUnsettled;  ///< Of most of its triangles that have a kind.
  std::int64_t vertex_count = 0;               ///< Corners of bad triangles.
  std::int64_t place_count = 1;                ///< Above 1 where several were put together.
  Vec2 center = {};                            ///< Of the worst triangle, by Q; domain units.
  BoundingBox box = {};                        ///< Around the bad triangles; domain units.
  double q_min = 0;
  double length_min = 0;  ///< By eq. 4, over the edges of the bad triangles.
  double length_max = 0;
};

/// What FindTroubles judges by, beyond the mesh.
struct TroubleContext {
  bool insertions_refused = false;
  Permissions permissions = {};
};

/// Where troubles may be, taken down before a commit, so that who waits for that waits for no more.
struct TroubleSearch {
  bool everywhere = false;        ///< The mesh was never committed.
  std::vector<VertexId> changed;  ///< Else: since the last commit; some may be dead.
  TroubleContext context;
};

/// The places among `triangles` (ascending, live) where the metric at the mesh's vertices is not
/// met, by falling vertex count. The same for the same mesh, whatever the order of work.
/// @par Cost O(triangles), and O(b log b) for b bad ones
[[nodiscard]] std::vector<Trouble> FindTroubles(const Mesh& mesh,
                                                std::span<const TriangleId> triangles,
                                                const TroubleContext& context);

/// The live triangles, ascending: all of them, or those at some vertices, of which some may be
/// dead.
[[nodiscard]] std::vector<TriangleId> LiveTrianglesOf(const Mesh& mesh);
[[nodiscard]] std::vector<TriangleId> TrianglesAt(const Mesh& mesh,
                                                  std::span<const VertexId> vertices);

}  // namespace pliant
