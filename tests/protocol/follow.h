#pragma once

#include <gtest/gtest.h>

#include <string>
#include <utility>

#include "pliant/v1/edit.pb.h"
#include "tests/protocol/promises.h"
#include "tests/support/in_process_server.h"
#include "tests/support/mirror.h"

namespace pliant::test {

/// The mesh of a session as GetMesh returns it.
inline Mirror Fetch(InProcessServer& server, const std::string& id) {
  v1::GetMeshRequest request;
  request.set_session_id(id);
  v1::MeshSnapshot snapshot;
  const grpc::Status status = server.GetMesh(request, &snapshot);
  EXPECT_TRUE(status.ok()) << status.error_message();
  Mirror mirror;
  EXPECT_EQ(mirror.Take(snapshot), "") << kComplete;
  return mirror;
}

/// What of an answer is the same whenever and wherever it is given.
inline v1::EditResponse WithoutTimes(v1::EditResponse answer) {
  if (answer.has_advanced()) {
    answer.mutable_advanced()->clear_compute_us();
    answer.mutable_advanced()->clear_elapsed_us();
    answer.mutable_advanced()->clear_durable_revision();
  }
  return answer;
}

}  // namespace pliant::test
