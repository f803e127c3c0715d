#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <cstddef>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "client/cpp/client.h"
#include "tests/client/fake_server.h"
#include "tests/client/model_mesh.h"

namespace pliant::client {

/// A few revisions of a mesh, and the diffs between them: models[r] is revision r.
struct History {
  std::vector<ModelMesh> models{1};

  explicit History(int revision_count, int change_count = 20) {
    ModelChanger changer(/*seed=*/1996);
    for (int r = 0; r < revision_count; ++r) {
      models.push_back(changer.Next(models.back(), change_count));
    }
  }
  [[nodiscard]] MeshDiff Diff(std::size_t to) const { return DiffOf(models[to - 1], models[to]); }
  [[nodiscard]] MeshDiff Snapshot(std::size_t of) const { return DiffOf({}, models[of]); }
};

inline std::unique_ptr<Session> Open(const std::string& address, const ConnectOptions& options) {
  Result<Client> client = Client::Connect(address, options);
  EXPECT_TRUE(client.ok());
  Result<std::unique_ptr<Session>> session = client->OpenSession("s1");
  EXPECT_TRUE(session.ok()) << session.error().message;
  return std::move(session).value();
}

inline std::unique_ptr<Session> Open(
    const FakeServer& server, std::chrono::milliseconds reconnect_max = std::chrono::seconds(60)) {
  return Open(server.address(), {.reconnect_max = reconnect_max});
}

}  // namespace pliant::client
