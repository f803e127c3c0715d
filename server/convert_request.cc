#include "server/convert_request.h"

#include <charconv>

#include "server/limits.h"

namespace pliant::server {

Result<std::int64_t> ConvertPageToken(const std::string& token) {
  std::int64_t after = 0;
  if (token.empty()) return after;
  const auto [end, error] = std::from_chars(token.data(), token.data() + token.size(), after);
  if (error == std::errc() && end == token.data() + token.size() && after > 0) return after;
  return Error{ErrorCode::kOutOfRange, "page_token is not one that this server gave out",
               "page_token"};
}

Result<std::size_t> ConvertPageSize(std::int32_t page_size) {
  if (page_size == 0) return std::size_t{kPageSizeDefault};
  if (page_size > 0 && page_size <= kPageSizeMax) return static_cast<std::size_t>(page_size);
  return Error{ErrorCode::kOutOfRange,
               "page_size is " + std::to_string(page_size) + "; allowed are 1 to " +
                   std::to_string(kPageSizeMax) + ", or 0 for " + std::to_string(kPageSizeDefault),
               "page_size"};
}

Result<v1::Numbering> ConvertNumbering(v1::Numbering numbering) {
  if (numbering == v1::NUMBERING_STABLE || numbering == v1::NUMBERING_DENSE) return numbering;
  return Error{ErrorCode::kOutOfRange, "numbering is no known numbering", "numbering"};
}

}  // namespace pliant::server
