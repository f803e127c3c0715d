#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <vector>

#include "client/cpp/mesh_replica.h"
#include "client/cpp/types.h"
#include "core/base/result.h"
#include "core/mesh/mesh_diff.h"

namespace pliant::client {

/// How much of a mesh is followed.
enum class Follow {
  kMesh,
  kVertices,  ///< Neither triangles nor edges: points that move, come and go.
};

/// How a session is followed.
struct SubscribeOptions {
  Parts parts = Parts::kMesh;
  Follow follow = Follow::kMesh;
  /// Only triangles of these regions, their corners, and constrained edges between such corners;
  /// Subscription::absent_region_tags tells which are not there. Empty: all.
  std::vector<std::int32_t> region_tags = {};
  /// How long to try to take up a lost connection. 0: not at all.
  std::chrono::milliseconds reconnect_max{60'000};
};

/// A verified copy of the mesh of a session that anybody edits, or of the part that is wanted. Who
/// reads more slowly than the session commits gets what was missed as one diff, or the whole mesh.
///
/// *Invariants*: replica() holds the mesh of replica().revision(), bit for bit.
/// *Threads*: one at a time, but for Cancel.
class Subscription {
 public:
  ~Subscription();
  Subscription(const Subscription&) = delete;
  Subscription& operator=(const Subscription&) = delete;

  [[nodiscard]] const MeshReplica& replica() const;

  /// Those of SubscribeOptions::region_tags that no triangle had at the last change: not there yet,
  /// any more, or at all.
  [[nodiscard]] const std::vector<std::int32_t>& absent_region_tags() const;

  /// Waits for the next change, applies it to the replica and returns it; a base_revision of 0
  /// means that it is the whole mesh. A lost connection is taken up again, with pauses that grow
  /// and are spread at random. Errors: kSessionNotFound when the session has been deleted;
  /// kUnavailable when the connection does not come back; kCancelled after Cancel;
  /// kReplicaMismatch, after which the next call gets the whole mesh.
  [[nodiscard]] Result<MeshDiff> Next();

  /// Lets Next fail now, and ends the subscription. From any thread.
  void Cancel();

 private:
  friend class Client;
  class Impl;
  explicit Subscription(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace pliant::client
