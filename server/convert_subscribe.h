#pragma once

#include "core/base/ids.h"
#include "core/base/result.h"
#include "pliant/v1/session.pb.h"

/// What a subscriber asks for, checked as in server/convert.h.
namespace pliant::server {

/// The revision of the subscriber's mirror. Errors: kOutOfRange, kUnimplemented.
[[nodiscard]] Result<Revision> ConvertSubscribe(const v1::SubscribeRequest& request);

}  // namespace pliant::server
