#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <set>
#include <vector>

#include "core/base/ids.h"
#include "core/base/result.h"
#include "core/metric/metric_spec.h"
#include "core/pliant/revision_delta.h"

namespace pliant::server {

/// What takes a session back over one commit.
struct UndoStep {
  RevisionDelta delta;
  std::shared_ptr<const MetricSpec> spec;  ///< What the engine follows at `delta.revision`.
  std::int64_t active_count = 0;           ///< Vertices that were active there.
};

/// The way back from a session's current revision to earlier ones: a chain of deltas, each from a
/// revision to an older one, bounded by bytes. Saved revisions stay in reach: beyond the bound the
/// deltas between them are merged, so that each costs a mesh at most, and only what lies before the
/// oldest of them is let go.
///
/// *Invariants*: the chain has no gap and begins at the newest revision; every saved revision is
/// the newest or one that the chain leads to.
/// *Threads*: one caller at a time.
class UndoHistory {
 public:
  struct Bounds {
    std::size_t bytes_max = 0;
    std::size_t saved_max = 0;
  };
  explicit UndoHistory(Bounds bounds) : bounds_(bounds) {}

  /// Another bound, from the next Add on.
  void SetBytesMax(std::size_t bytes_max) { bounds_.bytes_max = bytes_max; }

  /// A commit: `undo` leads from its revision to the one before.
  void Add(UndoStep undo);
  /// Lets go of every revision that is not saved, as if the bound were zero.
  void KeepSavedOnly();
  /// There is no way back any more. Saved revisions are lost.
  void Clear();

  /// The oldest revision that can be returned to. @param newest  where the session is
  [[nodiscard]] Revision Oldest(Revision newest) const;

  /// What leads from the newest revision to an older one. Error: kRevisionNotFound, with the oldest
  /// that is kept. @par Cost O(deltas)
  [[nodiscard]] Result<UndoStep> WayTo(Revision revision, Revision newest) const;

  /// Keeps a revision within reach. Errors: kRevisionNotFound, kResourceExhausted.
  [[nodiscard]] Status Save(Revision revision, Revision newest);
  /// Lets go of saved revisions, of all or, on error, of none. Error: kRevisionNotFound with the
  /// index of the first that is not saved.
  [[nodiscard]] Status Release(const std::vector<std::int64_t>& revisions);

  [[nodiscard]] std::vector<std::int64_t> saved() const;
  [[nodiscard]] std::size_t bytes() const { return bytes_; }

  /// Oldest first; each leads to a smaller number.
  [[nodiscard]] const std::deque<UndoStep>& steps() const { return steps_; }
  /// Takes over steps and saved revisions that were written before. False if they cannot be: the
  /// chain has a gap, or a saved revision is out of reach.
  [[nodiscard]] bool Restore(std::deque<UndoStep> steps, const std::vector<std::int64_t>& saved,
                             Revision newest);

 private:
  [[nodiscard]] bool Reaches(Revision revision, Revision newest) const;
  void Shrink();
  bool MergeOnePair();

  Bounds bounds_;
  std::deque<UndoStep> steps_;  // Oldest first; each leads to a smaller number.
  std::size_t bytes_ = 0;
  std::set<Revision> saved_;
};

}  // namespace pliant::server
