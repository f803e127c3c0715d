#pragma once

#include <cstddef>
#include <functional>
#include <span>

#include "core/base/bytes.h"
#include "core/base/result.h"
#include "server/jobs/job.h"

namespace pliant::server {

/// How what jobs are made from and end with is written: the bytes of a submission and of an
/// outcome. WireJobCodec (server/convert_job.h) is the one of the server.
struct JobCodec {
  std::function<Result<JobInput>(std::span<const std::byte>)> read_input;
  std::function<Bytes(const JobResult&)> write_result;
  std::function<Bytes(const Error&)> write_error;
};

}  // namespace pliant::server
