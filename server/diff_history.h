#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>

#include "core/mesh/mesh_diff.h"

namespace pliant::server {

/// The last diffs of a session, so that a reader who is behind gets what it missed as one diff
/// instead of the whole mesh.
///
/// *Invariants*: the diffs follow each other without a gap; they hold at most `bytes_max` bytes,
/// but for the newest one until Trim.
/// *Threads*: one caller at a time; the diffs themselves never change and may be read by any.
class DiffHistory {
 public:
  explicit DiffHistory(std::size_t bytes_max) : bytes_max_(bytes_max) {}

  /// Takes the diff of a commit; drops the oldest ones beyond the bound, but not this one. One that
  /// does not follow the newest empties the history first.
  void Add(std::shared_ptr<const MeshDiff> diff);
  /// The newest diff loses its privilege: a diff that is larger than the bound goes.
  void Trim();

  /// What takes a mirror of `revision` to the newest revision, merged; null if that is not kept, or
  /// if nothing is. @pre revision is not the newest @par Cost O(diffs log count)
  [[nodiscard]] std::shared_ptr<const MeshDiff> Since(Revision revision) const;

  /// Another bound, from the next Add on.
  void SetBytesMax(std::size_t bytes_max) { bytes_max_ = bytes_max; }

  [[nodiscard]] std::size_t bytes() const { return bytes_; }
  /// All of them, oldest first.
  [[nodiscard]] const std::deque<std::shared_ptr<const MeshDiff>>& diffs() const { return diffs_; }
  [[nodiscard]] std::size_t count() const { return diffs_.size(); }

 private:
  void DropOldest();

  std::size_t bytes_max_;
  std::size_t bytes_ = 0;
  std::deque<std::shared_ptr<const MeshDiff>> diffs_;
};

}  // namespace pliant::server
