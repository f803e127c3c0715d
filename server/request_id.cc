#include "server/request_id.h"

#include <atomic>
#include <cstdint>

#include "server/limits.h"

namespace pliant::server {

std::string RequestIdOf(const grpc::CallbackServerContext& call) {
  const auto& metadata = call.client_metadata();
  const auto sent = metadata.find("x-request-id");
  if (sent != metadata.end() && !sent->second.empty()) {
    return std::string(sent->second.data(), sent->second.size()).substr(0, kRequestIdLengthMax);
  }
  static std::atomic<std::int64_t> last = 0;
  return std::string("r-").append(std::to_string(++last));
}

}  // namespace pliant::server
