#include "server/convert_subscribe.h"

#include "server/convert.h"

namespace pliant::server {

Result<Revision> ConvertSubscribe(const v1::SubscribeRequest& request) {
  PLIANT_RETURN_IF_ERROR(CheckSessionId(request.session_id()));
  if (request.mirror_revision() < 0) {
    return Error{ErrorCode::kOutOfRange, "mirror_revision is negative; 0 means no mirror",
                 "mirror_revision"};
  }
  if (request.has_mirror_mode() && request.mirror_mode() != v1::MIRROR_MODE_FULL) {
    const bool is_known = request.mirror_mode() == v1::MIRROR_MODE_NONE ||
                          request.mirror_mode() == v1::MIRROR_MODE_POSITIONS;
    return Error{is_known ? ErrorCode::kUnimplemented : ErrorCode::kOutOfRange,
                 is_known ? "subscribers get whole diffs; leave mirror_mode out"
                          : "mirror_mode is no known mode",
                 "mirror_mode"};
  }
  if (request.region_tags_size() > 0) {
    return Error{ErrorCode::kUnimplemented,
                 "a filter by region is not implemented by this server; leave region_tags out",
                 "region_tags"};
  }
  return Revision(request.mirror_revision());
}

}  // namespace pliant::server
