#include "server/convert_request.h"

#include <charconv>

#include "server/limits.h"

namespace pliant::server {

Status CheckUpdateId(std::int64_t update_id) {
  if (update_id > 0 && update_id <= kUpdateIdMax) return {};
  const std::string is = "update_id is " + std::to_string(update_id);
  if (update_id > 0) {
    return RangeError(is + "; allowed are numbers up to " + std::to_string(kUpdateIdMax) +
                          ", so that there are some left: take the session's last_update_id + 1",
                      "update_id");
  }
  return Error{ErrorCode::kProtocolOrder,
               is + "; updates, advances and rollbacks are numbered from 1, each greater than "
                    "every earlier one, so that a repeated one is applied once",
               "update_id"};
}

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
