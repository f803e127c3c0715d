#include "server/diff_history.h"

#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include "core/mesh/merge_diffs.h"

namespace pliant::server {
namespace {

/// Halves are merged first: every row is then copied once for each doubling, not once for each
/// diff.
MeshDiff Merge(std::span<const std::shared_ptr<const MeshDiff>> diffs) {
  if (diffs.size() == 1) return *diffs[0];
  const std::size_t half = diffs.size() / 2;
  return MergeDiffs(Merge(diffs.first(half)), Merge(diffs.subspan(half)));
}

}  // namespace

void DiffHistory::Add(std::shared_ptr<const MeshDiff> diff) {
  if (!diffs_.empty() && diffs_.back()->revision != diff->base_revision) {
    diffs_.clear();
    bytes_ = 0;
  }
  bytes_ += BytesOf(*diff);
  diffs_.push_back(std::move(diff));
  while (diffs_.size() > 1 && bytes_ > bytes_max_) DropOldest();
}

void DiffHistory::Trim() {
  while (bytes_ > bytes_max_) DropOldest();
}

void DiffHistory::DropOldest() {
  bytes_ -= BytesOf(*diffs_.front());
  diffs_.pop_front();
}

std::shared_ptr<const MeshDiff> DiffHistory::Since(Revision revision) const {
  const auto first = std::lower_bound(
      diffs_.begin(), diffs_.end(), revision,
      [](const auto& diff, Revision wanted) { return diff->base_revision < wanted; });
  if (first == diffs_.end() || (*first)->base_revision != revision) return nullptr;
  if (first + 1 == diffs_.end()) return *first;
  const std::vector<std::shared_ptr<const MeshDiff>> diffs(first, diffs_.end());
  return std::make_shared<const MeshDiff>(Merge(diffs));
}

}  // namespace pliant::server
