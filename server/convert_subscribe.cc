#include "server/convert_subscribe.h"

#include <algorithm>
#include <string>

#include "server/convert_request.h"
#include "server/limits.h"

namespace pliant::server {
namespace {

Result<Mirror> ConvertMirror(v1::MirrorMode mode) {
  switch (mode) {
    case v1::MIRROR_MODE_FULL:
      return Mirror::kFull;
    case v1::MIRROR_MODE_NONE:
      return Mirror::kNone;
    case v1::MIRROR_MODE_POSITIONS:
      return Mirror::kPositions;
    default:
      return RangeError("mirror_mode is no known mode", "mirror_mode");
  }
}

}  // namespace

Result<SubscribeSpec> ConvertSubscribe(const v1::SubscribeRequest& request) {
  PLIANT_RETURN_IF_ERROR(CheckSessionId(request.session_id()));
  if (request.mirror_revision() < 0) {
    return RangeError("mirror_revision is negative; 0 means no mirror", "mirror_revision");
  }
  SubscribeSpec spec{.mirror_revision = Revision(request.mirror_revision())};
  if (request.has_mirror_mode()) {
    PLIANT_ASSIGN_OR_RETURN(spec.mirror, ConvertMirror(request.mirror_mode()));
  }
  if (request.has_numbering()) {
    spec.numbering = request.numbering();
    if (spec.numbering != v1::NUMBERING_STABLE && spec.numbering != v1::NUMBERING_DENSE) {
      return RangeError("numbering is no known numbering", "numbering");
    }
  }
  if (request.region_tags_size() > kRegionTagsMax) {
    return Error{ErrorCode::kTooLarge,
                 std::to_string(request.region_tags_size()) + " region tags; at most " +
                     std::to_string(kRegionTagsMax) + " can be named",
                 "region_tags"};
  }
  spec.region_tags.assign(request.region_tags().begin(), request.region_tags().end());
  std::sort(spec.region_tags.begin(), spec.region_tags.end());
  spec.region_tags.erase(std::unique(spec.region_tags.begin(), spec.region_tags.end()),
                         spec.region_tags.end());
  PLIANT_ASSIGN_OR_RETURN(spec.parts, ConvertParts(request.parts()));
  if (spec.parts.transfer && !spec.region_tags.empty()) {
    return RangeError(
        "transfer rows name vertices of all regions; leave MESH_PART_TRANSFER or region_tags out",
        "parts");
  }
  return spec;
}

}  // namespace pliant::server
