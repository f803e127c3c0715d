#pragma once

#include <cstdint>
#include <vector>

#include "core/base/ids.h"
#include "core/base/result.h"
#include "pliant/v1/session.pb.h"
#include "server/convert.h"

/// What a subscriber asks for, checked as in server/convert.h.
namespace pliant::server {

struct SubscribeSpec {
  Revision mirror_revision = Revision::kNone;
  Mirror mirror = Mirror::kFull;
  std::vector<std::int32_t> region_tags = {};  ///< Ascending; empty: all.
  v1::Numbering numbering = v1::NUMBERING_STABLE;
  WantedParts parts = {};

  /// Wants less than the whole mesh.
  [[nodiscard]] bool partial() const {
    return mirror == Mirror::kPositions || (mirror == Mirror::kFull && !region_tags.empty());
  }
};

/// Errors: kOutOfRange, kTooLarge, kUnimplemented.
[[nodiscard]] Result<SubscribeSpec> ConvertSubscribe(const v1::SubscribeRequest& request);

}  // namespace pliant::server
