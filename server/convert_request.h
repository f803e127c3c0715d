#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>

#include "core/base/result.h"
#include "pliant/v1/mesh.pb.h"

/// Fields that several requests have, and how those are refused; rules as in convert.h.
namespace pliant::server {

/// The field has a value that the protocol does not know or allow.
[[nodiscard]] inline Error RangeError(std::string message, std::string field) {
  return {ErrorCode::kOutOfRange, std::move(message), std::move(field)};
}

/// The protocol knows it, this server does not.
[[nodiscard]] inline Error NotYet(const std::string& what, std::string field) {
  return {ErrorCode::kUnimplemented,
          what + " is not implemented by this server; GetServerInfo lists what is",
          std::move(field)};
}

/// From 1 to kUpdateIdMax. Errors: kProtocolOrder, kOutOfRange.
[[nodiscard]] Status CheckUpdateId(std::int64_t update_id);

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
