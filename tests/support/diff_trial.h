#pragma once

#include <algorithm>
#include <string>
#include <string_view>

#include "client/cpp/convert.h"
#include "client/cpp/mesh_replica.h"
#include "pliant/v1/session.pb.h"
#include "proto/columns.h"
#include "tests/support/pieces.h"

namespace pliant::test {

/// What contradicts the invariants of a replica, or nothing.
inline std::string WrongWith(const client::MeshReplica& replica) {
  MeshSummary found;
  const auto all_live = [&](const auto& ids) {
    return std::ranges::all_of(ids, [&](VertexId id) { return replica.IsLive(id); });
  };
  for (std::size_t i = 0; i < replica.positions().size(); ++i) {
    const VertexId id = VertexId::FromIndex(i);
    if (!replica.IsLive(id)) continue;
    ++found.vertex_count;
    found.state_hash += VertexHash(id, replica.positions()[i]);
  }
  for (std::size_t i = 0; i < replica.triangles().size(); ++i) {
    const TriangleId id = TriangleId::FromIndex(i);
    if (!replica.IsLive(id)) continue;
    const auto& corners = replica.triangles()[i];
    if (!all_live(corners)) return "a triangle has a corner that is free";
    ++found.triangle_count;
    found.state_hash += TriangleHash(id, corners, replica.triangle_regions()[i]);
  }
  for (std::size_t i = 0; i < replica.edges().size(); ++i) {
    const EdgeId id = EdgeId::FromIndex(i);
    if (!replica.IsLive(id)) continue;
    const auto& ends = replica.edges()[i];
    if (!all_live(ends)) return "an edge has an end that is free";
    ++found.edge_count;
    found.state_hash += EdgeHash(id, ends, replica.edge_tags()[i]);
  }
  return found == replica.summary() ? "" : "the summary is not that of the arrays";
}

/// Pieces are messages of a subscription; a client follows them as it would a server. What is wrong
/// with its replica, or nothing.
inline std::string TryDiffs(std::string_view bytes) {
  wire::ColumnReader reader(/*blob_bytes_max=*/1 << 20);
  client::MeshReplica replica;
  for (const Piece& piece : Cut(bytes)) {
    v1::SubscribeResponse response;
    if (!response.ParseFromString(piece.bytes)) continue;
    if (response.has_chunk()) static_cast<void>(reader.Add(response.chunk()));
    if (!response.has_diff() && !response.has_snapshot()) continue;
    const Result<MeshDiff> diff = response.has_diff()
                                      ? client::FromWire(response.diff(), reader)
                                      : client::FromWire(response.snapshot(), reader);
    if (!diff.ok()) {
      if (diff.error().message.empty()) return "a refusal says nothing";
      continue;
    }
    const Revision before = replica.revision();
    const Status status = response.has_diff() ? replica.Apply(*diff) : replica.Reset(*diff);
    if (!status.ok() && replica.revision() != before) return "a refused diff changed the replica";
    if (const std::string wrong = WrongWith(replica); !wrong.empty()) return wrong;
    static_cast<void>(replica.Compact());
  }
  return "";
}

}  // namespace pliant::test
