#include "core/base/result.h"

namespace pliant {

std::string_view ErrorCodeName(ErrorCode code) {
  switch (code) {
#define PLIANT_CASE(constant, name) \
  case ErrorCode::constant:         \
    return name
    PLIANT_CASE(kArrayLength, "ARRAY_LENGTH");
    PLIANT_CASE(kArrayType, "ARRAY_TYPE");
    PLIANT_CASE(kIndexOutOfRange, "INDEX_OUT_OF_RANGE");
    PLIANT_CASE(kDuplicateId, "DUPLICATE_ID");
    PLIANT_CASE(kNotFinite, "NOT_FINITE");
    PLIANT_CASE(kOutOfRange, "OUT_OF_RANGE");
    PLIANT_CASE(kEmpty, "EMPTY");
    PLIANT_CASE(kTooLarge, "TOO_LARGE");
    PLIANT_CASE(kDuplicatePoint, "DUPLICATE_POINT");
    PLIANT_CASE(kZeroLengthSegment, "ZERO_LENGTH_SEGMENT");
    PLIANT_CASE(kDuplicateSegment, "DUPLICATE_SEGMENT");
    PLIANT_CASE(kCrossingSegments, "CROSSING_SEGMENTS");
    PLIANT_CASE(kPointOnSegment, "POINT_ON_SEGMENT");
    PLIANT_CASE(kOpenLoop, "OPEN_LOOP");
    PLIANT_CASE(kSegmentOutsideDomain, "SEGMENT_OUTSIDE_DOMAIN");
    PLIANT_CASE(kPointOutsideDomain, "POINT_OUTSIDE_DOMAIN");
    PLIANT_CASE(kSeedOutsideDomain, "SEED_OUTSIDE_DOMAIN");
    PLIANT_CASE(kConflictingRegions, "CONFLICTING_REGIONS");
    PLIANT_CASE(kNothingInside, "NOTHING_INSIDE");
    PLIANT_CASE(kTriangleDegenerate, "TRIANGLE_DEGENERATE");
    PLIANT_CASE(kTriangleOrientation, "TRIANGLE_ORIENTATION");
    PLIANT_CASE(kNonManifoldEdge, "NON_MANIFOLD_EDGE");
    PLIANT_CASE(kNotConforming, "NOT_CONFORMING");
    PLIANT_CASE(kEdgeNotInMesh, "EDGE_NOT_IN_MESH");
    PLIANT_CASE(kNotPositiveDefinite, "NOT_POSITIVE_DEFINITE");
    PLIANT_CASE(kExpressionSyntax, "EXPRESSION_SYNTAX");
    PLIANT_CASE(kExpressionValue, "EXPRESSION_VALUE");
    PLIANT_CASE(kFileNotFound, "FILE_NOT_FOUND");
    PLIANT_CASE(kFileUnreadable, "FILE_UNREADABLE");
    PLIANT_CASE(kFileSyntax, "FILE_SYNTAX");
    PLIANT_CASE(kFileUnsupported, "FILE_UNSUPPORTED");
    PLIANT_CASE(kFileUnwritable, "FILE_UNWRITABLE");
    PLIANT_CASE(kDataCorrupt, "DATA_CORRUPT");
    PLIANT_CASE(kDataVersion, "DATA_VERSION");
    PLIANT_CASE(kSessionNotFound, "SESSION_NOT_FOUND");
    PLIANT_CASE(kSessionExists, "SESSION_EXISTS");
    PLIANT_CASE(kSessionBusy, "SESSION_BUSY");
    PLIANT_CASE(kRevisionNotFound, "REVISION_NOT_FOUND");
    PLIANT_CASE(kRevisionMismatch, "REVISION_MISMATCH");
    PLIANT_CASE(kProtocolOrder, "PROTOCOL_ORDER");
    PLIANT_CASE(kUpdateRejected, "UPDATE_REJECTED");
    PLIANT_CASE(kFrozen, "FROZEN");
    PLIANT_CASE(kJobNotFound, "JOB_NOT_FOUND");
    PLIANT_CASE(kJobExists, "JOB_EXISTS");
    PLIANT_CASE(kJobNotDone, "JOB_NOT_DONE");
    PLIANT_CASE(kResourceExhausted, "RESOURCE_EXHAUSTED");
    PLIANT_CASE(kCancelled, "CANCELLED");
    PLIANT_CASE(kDeadlineExceeded, "DEADLINE_EXCEEDED");
    PLIANT_CASE(kUnavailable, "UNAVAILABLE");
    PLIANT_CASE(kUnimplemented, "UNIMPLEMENTED");
    PLIANT_CASE(kReplicaMismatch, "REPLICA_MISMATCH");
    PLIANT_CASE(kInternal, "INTERNAL");
#undef PLIANT_CASE
  }
  return "INTERNAL";
}

}  // namespace pliant
