#include "server/access.h"

#include <cstddef>
#include <cstdint>
#include <fstream>
#include <sstream>
#include <utility>

#include "pliant/v1/errors.pb.h"

namespace pliant::server {
namespace {

constexpr std::size_t kTokenLengthMin = 16;

// Compares in a time that does not tell how much of a guess was right.
bool SameToken(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  unsigned difference = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    difference |= static_cast<unsigned>(static_cast<unsigned char>(a[i])) ^
                  static_cast<unsigned>(static_cast<unsigned char>(b[i]));
  }
  return difference == 0;
}

Error SyntaxError(std::string message, std::int64_t line) {
  return {ErrorCode::kFileSyntax, "the file of tokens: " + std::move(message), "tokens", line};
}

}  // namespace

Result<Access> Access::FromFile(const std::string& path) {
  std::ifstream file(path);
  if (!file) {
    return Error{ErrorCode::kFileNotFound, "cannot open the file of tokens " + path, "tokens"};
  }
  std::ostringstream text;
  text << file.rdbuf();
  return FromText(text.str());
}

Result<Access> Access::FromText(const std::string& text) {
  Access access;
  std::istringstream lines(text);
  std::string line;
  for (std::int64_t number = 0; std::getline(lines, line); ++number) {
    std::istringstream words(line);
    Grant grant;
    std::string rest;
    if (!(words >> grant.token) || grant.token.starts_with('#')) continue;
    if (!(words >> grant.tenant) || words >> rest) {
      return SyntaxError("expected a token and a tenant on each line", number);
    }
    if (grant.token.size() < kTokenLengthMin) {
      return SyntaxError(
          "a token must have at least " + std::to_string(kTokenLengthMin) + " characters", number);
    }
    access.grants_.push_back(std::move(grant));
  }
  if (access.grants_.empty()) return SyntaxError("it has no tokens, so nobody could call", -1);
  return access;
}

std::optional<std::string> Access::TenantOf(const grpc::CallbackServerContext& call) const {
  const auto& metadata = call.client_metadata();
  const auto found = metadata.find("authorization");
  return TenantOf(found == metadata.end()
                      ? std::string_view()
                      : std::string_view(found->second.data(), found->second.size()));
}

std::optional<std::string> Access::TenantOf(std::string_view authorization) const {
  if (grants_.empty()) return std::string();
  constexpr std::string_view kScheme = "Bearer ";
  if (!authorization.starts_with(kScheme)) return std::nullopt;
  authorization.remove_prefix(kScheme.size());
  for (const Grant& grant : grants_) {
    if (SameToken(grant.token, authorization)) return grant.tenant;
  }
  return std::nullopt;
}

grpc::Status Access::Refusal() {
  v1::ErrorDetail detail;
  detail.set_reason("UNAUTHENTICATED");
  detail.set_field("authorization");
  detail.set_index(-1);
  detail.set_other_index(-1);
  detail.set_message(
      "this server wants a token that it knows: send the metadata `authorization: Bearer TOKEN`");
  detail.set_code(grpc::StatusCode::UNAUTHENTICATED);
  v1::ErrorStatus status;
  status.set_code(detail.code());
  status.set_message(detail.message());
  status.add_details()->set_type_url("type.googleapis.com/pliant.v1.ErrorDetail");
  status.mutable_details(0)->set_value(detail.SerializeAsString());
  return {grpc::StatusCode::UNAUTHENTICATED, detail.message(), status.SerializeAsString()};
}

}  // namespace pliant::server
