#pragma once

#include <cstdint>

#include "core/mesh/mesh_diff.h"
#include "core/pliant/quality.h"
#include "pliant/v1/edit.pb.h"
#include "pliant/v1/mesh.pb.h"
#include "pliant/v1/quality.pb.h"
#include "pliant/v1/session.pb.h"
#include "server/convert.h"
#include "server/session_messages.h"

/// From the core to the wire. Arrays are put into the messages whole; server/blobs.h splits them.
/// No state: any thread.
namespace pliant::server {

/// What goes beside the mesh into a diff or snapshot.
struct ReplyContext {
  std::int64_t applied_update_id = 0;
  WantedParts parts = {};
  v1::Numbering numbering = v1::NUMBERING_STABLE;  ///< Snapshots only.
};

[[nodiscard]] v1::MeshDiff ToMeshDiff(const MeshDiff& diff, const ReplyContext& context);

/// @param snapshot  a diff from nothing (SnapshotOf).
[[nodiscard]] v1::MeshSnapshot ToMeshSnapshot(const MeshDiff& snapshot,
                                              const ReplyContext& context);

[[nodiscard]] v1::MeshCounts ToMeshCounts(const MeshSummary& summary);

/// Everything but the revision and the count of active vertices, which the session knows.
[[nodiscard]] v1::QualityReport ToQualityReport(const Quality& quality);

/// What a session says, as its editor gets it.
[[nodiscard]] v1::EditResponse ToEditResponse(const SessionEvent& event, const WantedParts& parts);

/// The same for a subscriber. @pre a diff, a snapshot, a bookmark or a closing event
/// @param numbering  of a snapshot
[[nodiscard]] v1::SubscribeResponse ToSubscribeResponse(
    const SessionEvent& event, const WantedParts& parts,
    v1::Numbering numbering = v1::NUMBERING_STABLE);

[[nodiscard]] v1::Session ToSession(const SessionInfo& info);

}  // namespace pliant::server
