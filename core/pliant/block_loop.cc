#include "core/pliant/block_loop.h"

#include <algorithm>
#include <utility>

#include "core/base/check.h"
#include "core/pliant/plane_partition.h"

namespace pliant {
namespace {

/// Rounds with borders of their own. What waits after the last is a few nodes in ten thousand.
constexpr double kLowShares[] = {0.5, 0.4, 0.6};
constexpr int kSharingRoundsMax = std::size(kLowShares);

/// A round with fewer active nodes than this share of a block for each block is not worth it.
constexpr std::int64_t kWorthwhileShare = 16;

/// Every so many vertices one is looked at for where to cut.
constexpr std::int32_t kSampleStep = 32;

/// More parts than this do not help: a tree of cuts is deep enough, and threads are busy.
constexpr std::int32_t kBlocksMax = 1024;

/// Slots of a block for new elements: a level inserts one vertex in five hundred. A block that has
/// used them up, where the metric cannot be met, rests. Less than MeshEdit::Refine leaves room for.
SlotCounts RoomOf(const BlockRule& rule) {
  const std::int32_t vertices = std::max(8, rule.nodes_per_block / 48);
  return {vertices, 2 * vertices, std::max(8, rule.nodes_per_block / 64)};
}

std::int32_t BlockCount(const Mesh& mesh, const BlockRule& rule) {
  return std::clamp(mesh.vertex_count() / rule.nodes_per_block, 2, kBlocksMax);
}

/// The points of some of the vertices: the same for the same mesh.
std::vector<Vec2> SampleOf(const Mesh& mesh, std::int32_t step) {
  std::vector<Vec2> points;
  points.reserve(static_cast<std::size_t>(mesh.vertex_slots() / step + 1));
  for (std::int32_t v = 0; v < mesh.vertex_slots(); v += step) {
    if (mesh.vertex(VertexId(v)).live) points.push_back(mesh.position(VertexId(v)));
  }
  return points;
}

}  // namespace

/// One block: what works on it.
struct BlockLoop::Block {
  Block(Mesh& mesh, Territory& territory, const Options& options)
      : edit(mesh, territory), loop(edit, options) {}

  MeshEdit edit;
  PliantLoop loop;
  StopReason reason = StopReason::kConverged;
};

BlockLoop::BlockLoop(MeshEdit& edit, PliantLoop& loop, const Options& options,
                     const BlockRule& rule)
    : edit_(edit), loop_(loop), options_(options), rule_(rule) {}

BlockLoop::~BlockLoop() = default;

bool BlockLoop::Suits(const Mesh& mesh, const Options& options, const BlockRule& rule) {
  const std::int64_t room =
      std::int64_t{BlockCount(mesh, rule) + kSharingRoundsMax - 1} * RoomOf(rule).vertices;
  return mesh.vertex_count() >= rule.nodes_min && options.variant != Variant::kPaper &&
         mesh.vertex_count() + room <= options.vertices_max;
}

StopReason BlockLoop::Run(const MetricField& field, const Budget& budget, Executor& executor) {
  Budget left = budget;
  while (in_round_ || WantsRound()) {
    if (!in_round_) BeginRound(executor);
    const StopReason reason = RunRound(field, left, executor);
    if (reason != StopReason::kConverged) return reason;
    EndRound();
  }
  Leave();
  return loop_.Run(field, left);
}

bool BlockLoop::WantsRound() const {
  const std::int64_t worthwhile =
      std::int64_t{BlockCount(edit_.mesh(), rule_)} * rule_.nodes_per_block / kWorthwhileShare;
  return round_ < kSharingRoundsMax && loop_.active_count() >= worthwhile &&
         Suits(edit_.mesh(), options_, rule_);
}

void BlockLoop::BeginRound(Executor& executor) {
  // One part more every round, so that other borders are sure even in a strip.
  const std::int32_t part_count = BlockCount(edit_.mesh(), rule_) + round_;
  territories_.resize(static_cast<std::size_t>(part_count));
  edit_.LendSlots(territories_, RoomOf(rule_));
  ShareOut(executor, part_count);
  blocks_.clear();
  for (Territory& territory : territories_) {
    blocks_.push_back(std::make_unique<Block>(edit_.mesh_to_share(), territory, options_));
    blocks_.back()->loop.Join(loop_);
  }
  Distribute(executor);
  in_round_ = true;
}

void BlockLoop::ShareOut(Executor& executor, std::int32_t part_count) {
  const Mesh& mesh = edit_.mesh();
  const std::int32_t step = std::clamp(rule_.nodes_per_block / 8, 1, kSampleStep);
  const PlanePartition partition(SampleOf(mesh, step), part_count, kLowShares[round_]);
  owners_.resize(static_cast<std::size_t>(mesh.vertex_slots()));
  Chunks(mesh.vertex_slots()).ForEach(executor, [&](std::int32_t v) {
    owners_[static_cast<std::size_t>(v)] =
        static_cast<Territory::Owner>(partition.PartOf(mesh.position(VertexId(v))));
  });
  for (std::size_t i = 0; i < territories_.size(); ++i) {
    auto slots = std::move(territories_[i].slots);
    territories_[i] = Territory(owners_, static_cast<Territory::Owner>(i));
    territories_[i].slots = std::move(slots);
  }
}

void BlockLoop::Distribute(Executor& executor) {
  const Mesh& mesh = edit_.mesh();
  const std::vector<VertexId> nodes = loop_.HandOver();
  const Chunks chunks(std::ssize(nodes));
  // First how many of each chunk go to each block, then where in the sorted list they begin.
  const std::size_t block_count = blocks_.size();
  std::vector<std::size_t> places(static_cast<std::size_t>(chunks.count()) * block_count);
  const auto for_nodes_of = [&](std::int32_t chunk, auto&& function) {
    std::size_t* const row = &places[static_cast<std::size_t>(chunk) * block_count];
    for (std::int64_t i = chunks.begin(chunk); i < chunks.end(chunk); ++i) {
      const VertexId node = nodes[static_cast<std::size_t>(i)];
      // The slot of a node that died in the queue may become another block's.
      if (!mesh.IsLive(node) || !mesh.vertex(node).visit.active) continue;
      function(node, row[owners_[node.index()]]);
    }
  };
  executor.Run(chunks.count(), [&](std::int32_t chunk) {
    for_nodes_of(chunk, [](VertexId, std::size_t& count) { ++count; });
  });
  std::vector<std::size_t> begins;
  std::size_t sum = 0;
  for (std::size_t block = 0; block < block_count; ++block) {
    begins.push_back(sum);
    for (std::size_t i = block; i < places.size(); i += block_count) {
      sum += std::exchange(places[i], sum);
    }
  }
  begins.push_back(sum);
  std::vector<VertexId> sorted(nodes.size());
  executor.Run(chunks.count(), [&](std::int32_t chunk) {
    for_nodes_of(chunk, [&](VertexId node, std::size_t& place) { sorted[place++] = node; });
  });
  for (std::size_t block = 0; block < block_count; ++block) {
    blocks_[block]->loop.TakeOver(
        std::span(sorted).subspan(begins[block], begins[block + 1] - begins[block]));
  }
}

StopReason BlockLoop::RunRound(const MetricField& field, Budget& budget, Executor& executor) {
  while (active_count() > 0) {
    if (budget.visits_max <= 0) return StopReason::kVisitBudget;
    const StopReason reason = RunSlice(field, budget, executor);
    if (reason == StopReason::kCancelled) return reason;
  }
  return StopReason::kConverged;
}

StopReason BlockLoop::RunSlice(const MetricField& field, Budget& budget, Executor& executor) {
  std::vector<Block*> busy;
  for (const auto& block : blocks_) {
    if (block->loop.active_count() > 0) busy.push_back(block.get());
  }
  const std::int64_t share = budget.visits_max / std::ssize(busy);
  const std::int64_t rest = budget.visits_max % std::ssize(busy);
  if (share == 0) busy.resize(static_cast<std::size_t>(rest));
  InlineExecutor alone;
  // Checks of every operation look further than a block may.
  Executor& runs_blocks = kValidateEvery ? alone : executor;
  runs_blocks.Run(static_cast<std::int32_t>(busy.size()), [&](std::int32_t i) {
    Block& block = *busy[static_cast<std::size_t>(i)];
    block.reason = block.loop.Run(field, {share + (i < rest ? 1 : 0), budget.stop});
  });
  bool cancelled = false;
  for (Block* block : busy) {
    budget.visits_max -= block->loop.counts().visits;
    loop_.Add(block->loop.counts());
    block->loop.ResetCounts();
    cancelled = cancelled || block->reason == StopReason::kCancelled;
  }
  edit_.CountLent(territories_);
  return cancelled ? StopReason::kCancelled : StopReason::kConverged;
}

void BlockLoop::EndRound() {
  for (const auto& block : blocks_) loop_.TakeOver(block->loop.HandOver());
  blocks_.clear();
  edit_.ReturnSlots(territories_);
  in_round_ = false;
  ++round_;
}

void BlockLoop::Leave() {
  if (in_round_) EndRound();
}

std::int64_t BlockLoop::active_count() const {
  std::int64_t count = 0;
  for (const auto& block : blocks_) count += block->loop.active_count();
  return count;
}

}  // namespace pliant
