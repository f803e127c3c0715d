#pragma once

#include <grpcpp/grpcpp.h>

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"

namespace pliant::server {

/// Who may call, and whose sessions a call may see.
///
/// Without tokens everybody may, as the tenant "". With tokens every call carries the metadata
/// `authorization: Bearer TOKEN`, and sees the sessions of that token's tenant and no others.
///
/// *Threads*: any; it does not change.
class Access {
 public:
  /// Everybody.
  Access() = default;

  /// From a file with a token and a tenant on each line, separated by blanks; several tokens may
  /// belong to one tenant. Lines that begin with # are comments. Errors: kFileNotFound,
  /// kFileSyntax (index = line, from 0).
  static Result<Access> FromFile(const std::string& path);
  /// The same from the file's text.
  static Result<Access> FromText(const std::string& text);

  /// The tenant of a call; nothing if it has no token that is known.
  [[nodiscard]] std::optional<std::string> TenantOf(const grpc::CallbackServerContext& call) const;
  /// The same from the value of `authorization`; empty: there is none.
  [[nodiscard]] std::optional<std::string> TenantOf(std::string_view authorization) const;
  /// How a call without tenant ends: UNAUTHENTICATED.
  [[nodiscard]] static grpc::Status Refusal();

 private:
  struct Grant {
    std::string token;
    std::string tenant;
  };
  std::vector<Grant> grants_;
};

}  // namespace pliant::server
