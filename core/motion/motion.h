#pragma once

#include <cstdint>
#include <variant>
#include <vector>

#include "core/base/ids.h"
#include "core/geometry/vec2.h"

namespace pliant {

/// By a vector, in domain units.
struct Translation {
  Vec2 by;
};

/// About a point, counter-clockwise; on its way everything follows circles.
struct Rotation {
  Vec2 center;
  double angle_rad = 0;  ///< May exceed a full turn; at most 1000 in size.
};

/// x' = a x + b, entry by entry on a straight line from the identity. Positive determinant.
struct AffineMap {
  double a11 = 1;
  double a12 = 0;
  double a21 = 0;
  double a22 = 1;
  Vec2 b;
};

/// Displacement sum_k coefficients[k-1] s^k for s from 0 to 1.
struct PolynomialPath {
  std::vector<Vec2> coefficients;  ///< 1 to 16.
};

using PathShape = std::variant<Translation, Rotation, AffineMap, PolynomialPath>;

/// A motion of the given points of all segments with certain tags.
struct TagMotion {
  std::vector<std::int32_t> tags;
  PathShape shape;
};

/// What to do with a motion that cannot be completed because boundaries would cross.
enum class ImpossibleMotion {
  kRefuse,  ///< Error kCrossingSegments; the mesh stays as it was.
  kStop,    ///< Go as far as possible; MotionReport says how far.
};

/// What moves, all of it at the same time, for s from 0 to 1.
///
/// Vertices named by id go straight to their positions, and have exactly these at the end. If some
/// that the loop put on a segment leave its line, those become given points: the boundary has
/// corners there from then on. Those in the interior may be sent anywhere inside the domain as it
/// is at the end, past others and across holes; boundaries, constrained edges and their vertices
/// must not meet on their way. As long as a segment stays straight, up to rounding, its vertices
/// stay what they are; like named vertices in the interior they arrive, and afterwards the loop may
/// smooth or delete them. Vertices that are not named ride along with their segment. A point of
/// several moved tags follows the first of them in the list; one that is
/// also named by id goes where its id says.
struct MotionRequest {
  std::vector<VertexId> vertices;  ///< None twice.
  std::vector<Vec2> positions;     ///< One for each.
  std::vector<TagMotion> tags;     ///< No tag twice.
  ImpossibleMotion on_impossible = ImpossibleMotion::kRefuse;
  /// Interior vertices within this many wanted edge lengths of what moves ride along with it, and
  /// so does their metric. Saves remeshing a boundary layer. >= 0.
  double follow_length = 0;
};

/// How a motion went.
struct MotionReport {
  double fraction = 1;                   ///< Of the motion that was done, 0 to 1.
  std::int64_t moved_count = 0;          ///< Vertices that moved, those that rode along too.
  std::int64_t sub_step_count = 0;       ///< Accepted; after each of them the mesh was valid.
  std::int64_t rejected_count = 0;       ///< Tried and taken back.
  std::int64_t removed_count = 0;        ///< Vertices that stood in the way.
  std::int64_t swap_count = 0;           ///< Edges swapped on the way.
  std::int64_t retriangulate_count = 0;  ///< Cavities that were triangulated anew.
  /// With fraction < 1: constrained edges that would meet; none if something else stopped it.
  EdgeId first_edge;
  EdgeId second_edge;
};

}  // namespace pliant
