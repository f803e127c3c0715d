// PliantLoop, the part that thins a lattice out in bulk where a metric has become much coarser: the
// reverse of halving its edges.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/mesh/place_map.h"
#include "core/pliant/extent.h"
#include "core/pliant/loop.h"

namespace pliant {
namespace {

/// Nodes whose spokes are all shorter than this may go: of a lattice that is twice as fine as it
/// should be they have length 0.5.
constexpr double kShortLength = 0.7;

/// Nodes that one call takes away at most: some milliseconds. The loop deletes the others.
constexpr std::size_t kThinnedMax = std::size_t{1} << 14;

/// A size that grows by more than 2^kThinningRounds is left to the loop in the end.
constexpr int kThinningRounds = 6;

}  // namespace

/// Which of some nodes stay: where the mesh is a lattice, every other one along its lines, which is
/// a lattice again.
class PliantLoop::Thinning {
 public:
  Thinning(const Mesh& mesh, std::span<const VertexId> crowded)
      : mesh_(mesh), nodes_(crowded), place_of_(mesh.vertex_slots()) {
    place_of_.Reserve(nodes_.size());
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      place_of_.Add(nodes_[i], static_cast<std::int32_t>(i));
    }
    fates_.assign(nodes_.size(), Fate::kOpen);
  }

  /// @return those that go, none of which has none that stays for a neighbour
  std::vector<VertexId> Run() {
    for (const VertexId node : nodes_) {
      Keep(node);
      while (next_ < kept_.size()) Spread(kept_[next_++]);
    }
    return std::move(gone_);
  }

 private:
  enum class Fate : std::uint8_t { kOpen, kStays, kGoes };

  /// @return false, and nothing, if the node is none of these or its fate is known
  bool Decide(VertexId node, Fate fate) {
    const std::int32_t place = place_of_.At(node);
    if (place == PlaceMap::kNone) return false;
    Fate& known = fates_[static_cast<std::size_t>(place)];
    if (known != Fate::kOpen) return false;
    known = fate;
    return true;
  }

  void Keep(VertexId node) {
    if (Decide(node, Fate::kStays)) kept_.push_back(node);
  }

  /// Lets the neighbours of a kept node go, and keeps who lies straight behind them.
  void Spread(VertexId node) {
    star_.Gather(mesh_, node);
    for (const VertexId neighbor : star_.ring()) {
      if (!Decide(neighbor, Fate::kGoes)) continue;
      gone_.push_back(neighbor);
      between_.push_back(neighbor);
    }
    for (const VertexId neighbor : between_) {
      star_.Gather(mesh_, neighbor);
      const std::span<const VertexId> ring = star_.ring();
      if (!star_.closed() || ring.size() % 2 != 0) continue;
      const auto at = static_cast<std::size_t>(std::ranges::find(ring, node) - ring.begin());
      Keep(ring[(at + ring.size() / 2) % ring.size()]);
    }
    between_.clear();
  }

  const Mesh& mesh_;
  std::span<const VertexId> nodes_;
  PlaceMap place_of_;  // In nodes_.
  std::vector<Fate> fates_;
  std::vector<VertexId> kept_;
  std::size_t next_ = 0;  // In kept_.
  std::vector<VertexId> gone_;
  std::vector<VertexId> between_;
  Star star_;
};

void PliantLoop::ThinOut(std::vector<VertexId> nodes) {
  if (options_.variant == Variant::kPaper || !(options_.permissions == Permissions{})) return;
  std::size_t left = kThinnedMax;
  for (int round = 0; round < kThinningRounds; ++round) {
    std::erase_if(nodes, [&](VertexId node) { return !IsCrowded(node); });
    if (nodes.empty()) return;
    for (const VertexId node : Thinning(mesh_, nodes).Run()) {
      if (left == 0) return;
      star_.Gather(mesh_, node);
      if (TryDelete(NodeExtent(mesh_, star_), Heat())) --left;
    }
  }
}

bool PliantLoop::IsCrowded(VertexId node) {
  const VertexRecord& record = mesh_.vertex(node);
  if (!record.live || record.edge.valid() || Stays(node)) return false;
  star_.Gather(mesh_, node);
  return std::ranges::all_of(star_.ring(), [&](VertexId other) {
    const VertexRecord& far = mesh_.vertex(other);
    const double squared = SquaredEdgeLength(record, far);
    return squared < kShortLength * kShortLength;
  });
}

}  // namespace pliant
