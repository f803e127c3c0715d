#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

#include "core/base/check.h"

namespace pliant {

/// The precise cause of a refusal. One name for one cause, on the wire (as `reason`), in C++, in
/// Python and in logs; server/error_status.cc maps each to a gRPC status. Add, never rename.
enum class ErrorCode {
  // Arrays.
  kArrayLength,      ///< An array does not have the length that another one implies.
  kArrayType,        ///< An array holds another type of number than documented.
  kIndexOutOfRange,  ///< An index names no element.
  kDuplicateId,      ///< An id is named twice in one request.
  kNotFinite,        ///< A coordinate, size or tensor entry is NaN or infinite.
  kOutOfRange,       ///< A number lies outside the documented range.
  kEmpty,            ///< Something that must have an element has none.
  kTooLarge,         ///< Beyond a stated limit.
  // Domains (core/geometry/domain.h).
  kDuplicatePoint,        ///< Two points have the same coordinates.
  kZeroLengthSegment,     ///< A segment joins a point to itself.
  kDuplicateSegment,      ///< Two segments join the same two points.
  kCrossingSegments,      ///< Two segments cross or overlap.
  kPointOnSegment,        ///< A point lies in the interior of a segment that it does not end.
  kOpenLoop,              ///< The boundary does not close: outside reaches inside.
  kSegmentOutsideDomain,  ///< A segment has the domain on neither side.
  kPointOutsideDomain,    ///< A point lies outside the domain and on no segment.
  kSeedOutsideDomain,     ///< A hole or region seed lies outside the domain or on a segment.
  kConflictingRegions,    ///< Two region seeds with different tags lie in one region.
  kNothingInside,         ///< The domain has no interior.
  // Meshes that come in.
  kTriangleDegenerate,   ///< A triangle has zero area or a repeated vertex.
  kTriangleOrientation,  ///< A triangle is clockwise where others are counter-clockwise.
  kNonManifoldEdge,      ///< More than two triangles, or two equally oriented ones, at an edge.
  kNotConforming,        ///< Triangles overlap or a vertex hangs on an edge.
  kEdgeNotInMesh,        ///< A constrained edge is no edge of the triangles.
  // Metrics.
  kNotPositiveDefinite,  ///< A tensor is not symmetric positive definite.
  kExpressionSyntax,     ///< An expression cannot be parsed.
  kExpressionValue,      ///< An expression has no usable value at a point of the domain.
  // Files.
  kFileNotFound,
  kFileUnreadable,
  kFileSyntax,
  kFileUnsupported,
  kFileUnwritable,
  // Stored states.
  kDataCorrupt,  ///< Stored bytes are not those that were written.
  kDataVersion,  ///< Stored bytes were written by a newer program.
  // Sessions.
  kSessionNotFound,
  kSessionExists,
  kSessionBusy,
  kRevisionNotFound,
  kRevisionMismatch,
  kProtocolOrder,   ///< A message came where the protocol does not allow it.
  kUpdateRejected,  ///< An update that this advance was to commit was refused.
  kFrozen,          ///< A constraint keeps what the request would change.
  // Jobs.
  kJobNotFound,  ///< None of that id, or expired.
  kJobExists,    ///< The wished id is taken.
  kJobNotDone,   ///< It has no mesh (yet).
  // Any call.
  kResourceExhausted,
  kCancelled,
  kDeadlineExceeded,
  kUnavailable,
  kUnimplemented,
  kReplicaMismatch,  ///< A replica's counts or hash differ from the server's.
  kInternal,
};

/// The code's name as it stands on the wire, e.g. "CROSSING_SEGMENTS".
[[nodiscard]] std::string_view ErrorCodeName(ErrorCode code);

/// Why something that the world can do wrong was refused.
struct Error {
  ErrorCode code = ErrorCode::kInternal;
  /// What was wrong, where, what was expected and what to do; a full sentence for a person.
  std::string message;
  /// The offending input in the caller's words, e.g. "domain.segments"; may be empty.
  std::string field = {};
  /// The first offending index in the caller's own numbering; -1 if it has none.
  std::int64_t index = -1;
  /// The second one where two clash (two segments that cross); -1 otherwise.
  std::int64_t other_index = -1;
  /// When trying again makes sense, in ms from now; 0 if that is not known.
  std::int64_t retry_after_ms = 0;
};

/// A T, or the reason why there is none. T must not be Error.
template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}      // NOLINT: implicit
  Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}  // NOLINT: implicit

  [[nodiscard]] bool ok() const { return state_.index() == 0; }
  explicit operator bool() const { return ok(); }

  /// @pre ok()
  T& value() & {
    CheckOk();
    return std::get<0>(state_);
  }
  const T& value() const& {
    CheckOk();
    return std::get<0>(state_);
  }
  T&& value() && {
    CheckOk();
    return std::get<0>(std::move(state_));
  }
  T& operator*() & { return value(); }
  const T& operator*() const& { return value(); }
  T&& operator*() && { return std::move(*this).value(); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }

  /// @pre !ok()
  [[nodiscard]] const Error& error() const {
    PLIANT_CHECK(!ok());
    return std::get<1>(state_);
  }

 private:
  void CheckOk() const { PLIANT_CHECK(ok(), "error", std::get<1>(state_).message); }

  std::variant<T, Error> state_;
};

/// Success, or the reason why not.
class [[nodiscard]] Status {
 public:
  Status() = default;
  Status(Error error) : error_(std::move(error)) {}  // NOLINT: implicit, like Result

  [[nodiscard]] bool ok() const { return !error_.has_value(); }
  explicit operator bool() const { return ok(); }
  /// @pre !ok()
  [[nodiscard]] const Error& error() const {
    PLIANT_CHECK(!ok());
    return *error_;
  }

 private:
  std::optional<Error> error_;
};

}  // namespace pliant

/// Returns the error of `expression` (a Status or Result) from the enclosing function, if any.
#define PLIANT_RETURN_IF_ERROR(expression)                        \
  do {                                                            \
    if (auto pliant_status = (expression); !pliant_status.ok()) { \
      return pliant_status.error();                               \
    }                                                             \
  } while (false)

/// Declares `declaration` and sets it to the value of `expression`, a Result; returns its error
/// from the enclosing function otherwise.
#define PLIANT_ASSIGN_OR_RETURN(declaration, expression) \
  PLIANT_ASSIGN_OR_RETURN_IMPL(PLIANT_CONCAT(pliant_result_, __LINE__), declaration, expression)
#define PLIANT_ASSIGN_OR_RETURN_IMPL(result, declaration, expression) \
  auto result = (expression);                                         \
  if (!result.ok()) return result.error();                            \
  declaration = std::move(result).value()
#define PLIANT_CONCAT(a, b) PLIANT_CONCAT_IMPL(a, b)
#define PLIANT_CONCAT_IMPL(a, b) a##b
