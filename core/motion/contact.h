#pragma once

#include <optional>

#include "core/base/ids.h"
#include "core/mesh/mesh.h"
#include "core/motion/plan.h"

namespace pliant {

/// The first moment at which two constrained edges of a motion meet.
struct Contact {
  double time = 1;  ///< In (0, 1].
  EdgeId first;
  EdgeId second;
};

/// Looks ahead: follows every segment along the plan, on straight lines within its pieces, and
/// finds when a point first touches a segment that it is no end of.
///
/// Times are those of floating point: a contact that misses by less than about 1e-12 of the
/// segments' size may be found or not. Decides whether a motion is refused before anything is
/// touched; that no triangle turns over is decided by exact predicates when it is carried out.
/// @return nothing if nothing meets, or the plan's stop signal was asked and said yes.
/// @par Cost O((m + n) log n) per piece for m moved of n segments, when few come near each other
[[nodiscard]] std::optional<Contact> FindContact(const Mesh& mesh, const MotionPlan& plan);

/// Where a motion can stop before its first contact: a time shortly before that at which nothing
/// has met. The straight line of a piece meets something at another time than the curve that it
/// stands for; positions at the answer are on the curve, and reached on straight lines without a
/// contact.
/// @return at least 0. @par Cost as FindContact, in one piece
[[nodiscard]] double FreeTimeBefore(const Contact& contact, const Mesh& mesh,
                                    const MotionPlan& plan);

}  // namespace pliant
