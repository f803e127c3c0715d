#include "tests/bench/workload_step.h"

#include <utility>

#include "core/mesh/export_mesh.h"

namespace pliant::bench {
namespace {

/// Bytes of a diff's arrays: ids of 4 bytes, positions of 16, triangles of three ids and edges of
/// two with a tag.
double BytesOf(const MeshDiff& diff) {
  return static_cast<double>(20 * diff.vertex_ids.size() + 4 * diff.removed_vertices.size() +
                             16 * diff.triangle_ids.size() + 4 * diff.removed_triangles.size() +
                             16 * diff.edge_ids.size() + 4 * diff.removed_edges.size());
}

}  // namespace

Result<Update> RunOne(Remesher& remesher, const std::function<Status()>& stage) {
  Update update;
  Status status;
  update.stage = TimeOf([&] { status = stage(); });
  PLIANT_RETURN_IF_ERROR(status);
  Result<Progress> progress = Progress{};
  update.loop = TimeOf([&] { progress = remesher.Step({}); });
  PLIANT_RETURN_IF_ERROR(progress);
  update.progress = *progress;
  update.commit = TimeOf([&] { update.diff = remesher.Commit(); });
  return update;
}

nlohmann::json JsonOf(const std::vector<Update>& updates) {
  std::vector<Duration> stage;
  std::vector<Duration> loop;
  std::vector<Duration> commit;
  std::vector<Duration> total;
  std::vector<double> changed;
  std::vector<double> visits;
  for (const Update& update : updates) {
    stage.push_back(update.stage);
    loop.push_back(update.loop);
    commit.push_back(update.commit);
    total.push_back(update.total());
    changed.push_back(
        static_cast<double>(update.diff.vertex_ids.size() + update.diff.removed_vertices.size()));
    visits.push_back(static_cast<double>(update.progress.counts.visits));
  }
  return {{"updates", updates.size()},
          {"total", bench::JsonOf(total)},
          {"stage_cpu_s", bench::JsonOf(stage)["cpu_s"]},
          {"loop_cpu_s", bench::JsonOf(loop)["cpu_s"]},
          {"commit_cpu_s", bench::JsonOf(commit)["cpu_s"]},
          {"changed_nodes", Median(changed)},
          {"visits", Median(visits)}};
}

std::vector<Metric> TensorsAt(const Mesh& mesh, const MetricField& field) {
  std::vector<Metric> tensors;
  std::int32_t hint = MetricField::kNoHint;
  for (const Vec2 p : ExportMesh(mesh).data.points) tensors.push_back(field.At(p, hint));
  return tensors;
}

void Untouched::Before(const Mesh& mesh, const std::function<bool(const VertexRecord&)>& inside) {
  live_.assign(static_cast<std::size_t>(mesh.vertex_slots()), false);
  outside_ = live_;
  live_count_ = 0;
  outside_count_ = 0;
  for (std::int32_t v = 0; v < mesh.vertex_slots(); ++v) {
    if (!mesh.vertex(VertexId(v)).live) continue;
    ++live_count_;
    live_[static_cast<std::size_t>(v)] = true;
    outside_[static_cast<std::size_t>(v)] = !inside(mesh.vertex(VertexId(v)));
    outside_count_ += outside_[static_cast<std::size_t>(v)] ? 1 : 0;
  }
}

void Untouched::After(const MeshDiff& diff, const MeshDiff& snapshot) {
  double touched = 0;
  double touched_outside = 0;
  for (const auto* ids : {&diff.vertex_ids, &diff.removed_vertices}) {
    for (const VertexId id : *ids) {
      // Who is new, perhaps in the slot of one long gone, has nothing that could be kept.
      if (id.index() >= live_.size() || !live_[id.index()]) continue;
      ++touched;
      touched_outside += outside_[id.index()] ? 1 : 0;
    }
  }
  ++steps_;
  kept_ += 1 - touched / live_count_;
  kept_outside_ += outside_count_ > 0 ? 1 - touched_outside / outside_count_ : 1;
  bytes_ += BytesOf(diff) / BytesOf(snapshot);
}

nlohmann::json Untouched::Json() const {
  return {{"untouched", kept_ / steps_},
          {"untouched_outside_zone", kept_outside_ / steps_},
          {"diff_bytes_share", bytes_ / steps_}};
}

}  // namespace pliant::bench
