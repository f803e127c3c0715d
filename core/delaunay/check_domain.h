#pragma once

#include <cstdint>
#include <string>

#include "core/base/result.h"
#include "core/base/stop_signal.h"
#include "core/geometry/domain.h"

namespace pliant {

/// What can be said about a domain by looking at its arrays: everything up to kDuplicateSegment.
///
/// @return the first error in the order of ErrorCode, at the lowest index.
/// @param stop  not owned; null: nobody; else asked, and nothing is checked for sure if it says
/// yes.
/// @par Cost  O(n log n).
[[nodiscard]] Status CheckArrays(const Domain& domain, const StopSignal* stop = nullptr);

/// Why a segment cannot be part of a triangulation: the lowest one that it crosses or overlaps, or
/// else the lowest point inside it. The lower of two segments is the error's index.
///
/// @pre CheckArrays(domain).ok()
/// @par Cost  O(n)
[[nodiscard]] Status CheckSegment(const Domain& domain, std::int32_t segment);

/// Looks through all segments for the lowest one that crosses or overlaps another, and then for
/// the lowest point inside a segment.
///
/// Meant for points on one line; elsewhere O(n log n) for segments of about equal length, O(n^2) at
/// worst.
/// @pre CheckArrays(domain).ok()
[[nodiscard]] Status CheckSegments(const Domain& domain);

/// "(0.1, 2)": the shortest digits that give the same doubles back.
[[nodiscard]] std::string Text(Vec2 p);
/// "point 3 at (0.1, 2)"
[[nodiscard]] std::string PointText(const Domain& domain, std::int32_t point);
/// "segment 7 from (0, 0) to (0.1, 2)"
[[nodiscard]] std::string SegmentText(const Domain& domain, std::int32_t segment);

}  // namespace pliant
