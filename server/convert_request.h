#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "core/base/result.h"
#include "pliant/v1/mesh.pb.h"

/// Fields that several requests have; rules as in convert.h.
namespace pliant::server {

/// The number that a page begins at; 0 for an empty token. Error: kOutOfRange.
[[nodiscard]] Result<std::int64_t> ConvertPageToken(const std::string& token);

/// Error: kOutOfRange.
[[nodiscard]] Result<std::size_t> ConvertPageSize(std::int32_t page_size);

/// @param numbering  NUMBERING_STABLE where the request has none. Error: kOutOfRange.
[[nodiscard]] Result<v1::Numbering> ConvertNumbering(v1::Numbering numbering);

/// The numbering of a GetMesh or FetchResult.
template <class Request>
[[nodiscard]] Result<v1::Numbering> NumberingOf(const Request& request) {
  return ConvertNumbering(request.has_numbering() ? request.numbering() : v1::NUMBERING_STABLE);
}

}  // namespace pliant::server
