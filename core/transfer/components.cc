#include "core/transfer/components.h"

#include <limits>
#include <numeric>

namespace pliant {

OverlapComponents::OverlapComponents(const TouchedRegion& region)
    : region_(region),
      before_count_(region.before.triangles.size()),
      after_count_(region.after.triangles.size()),
      parents_(before_count_ + after_count_ + region.after.vertex_ids.size()),
      met_(before_count_, false) {
  std::iota(parents_.begin(), parents_.end(), std::size_t{0});
}

void OverlapComponents::AddOverlaps(std::int32_t after, const OverlapFinder& found) {
  const std::size_t node = before_count_ + static_cast<std::size_t>(after);
  for (const Overlap& overlap : found.overlaps()) {
    const auto before = static_cast<std::size_t>(overlap.before);
    met_[before] = true;
    Join(node, before);
  }
  if (found.overlaps().empty()) Join(node, static_cast<std::size_t>(found.nearest()));
}

void OverlapComponents::LinkCorners() {
  for (std::size_t t = 0; t < after_count_; ++t) {
    for (const std::int32_t corner : region_.after.triangles[t]) {
      Join(before_count_ + t, before_count_ + after_count_ + static_cast<std::size_t>(corner));
    }
  }
}

void OverlapComponents::LinkVertices(std::int32_t a, std::int32_t b) {
  const std::size_t first = before_count_ + after_count_;
  Join(first + static_cast<std::size_t>(a), first + static_cast<std::size_t>(b));
}

void OverlapComponents::Finish(const RegionLocator& locator) {
  JoinOrphans(locator);
  constexpr auto kNone = std::numeric_limits<std::size_t>::max();
  std::vector<std::size_t> label_of_root(parents_.size(), kNone);
  labels_.resize(parents_.size());
  count_ = 0;
  for (std::size_t node = 0; node < parents_.size(); ++node) {
    std::size_t& label = label_of_root[Root(node)];
    if (label == kNone) label = count_++;
    labels_[node] = label;
  }
}

void OverlapComponents::JoinOrphans(const RegionLocator& locator) {
  for (std::size_t t = 0; t < before_count_; ++t) {
    if (met_[t]) continue;
    for (const std::int32_t neighbor : locator.neighbors(static_cast<std::int32_t>(t))) {
      if (neighbor >= 0) Join(t, static_cast<std::size_t>(neighbor));
    }
  }
  std::vector<bool> has_new(parents_.size(), false);
  for (std::size_t t = 0; t < after_count_; ++t) has_new[Root(before_count_ + t)] = true;
  for (std::size_t t = 0; t < before_count_; ++t) {
    if (has_new[Root(t)] || after_count_ == 0) continue;
    const Vec2 center = CenterOf(CornersOf(region_.before, static_cast<std::int32_t>(t)));
    std::size_t nearest = 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t n = 0; n < after_count_; ++n) {
      const Vec2 way = CenterOf(CornersOf(region_.after, static_cast<std::int32_t>(n))) - center;
      if (Dot(way, way) >= least) continue;
      least = Dot(way, way);
      nearest = n;
    }
    Join(t, before_count_ + nearest);
    has_new[Root(t)] = true;
  }
}

/// Halves the way to the root as it goes.
std::size_t OverlapComponents::Root(std::size_t node) {
  while (parents_[node] != node) {
    parents_[node] = parents_[parents_[node]];
    node = parents_[node];
  }
  return node;
}

/// The lower root wins, which keeps the way independent of the order of joins.
void OverlapComponents::Join(std::size_t a, std::size_t b) {
  a = Root(a);
  b = Root(b);
  if (a < b) parents_[b] = a;
  if (b < a) parents_[a] = b;
}

}  // namespace pliant
