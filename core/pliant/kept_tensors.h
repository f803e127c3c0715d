#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/base/ids.h"
#include "core/base/large_pages.h"
#include "core/metric/metric.h"

namespace pliant {

/// A tensor of each vertex, with its logarithm, that can go back to the last commit.
///
/// *Invariants*: after Rollback everything is as at the last Commit, to the bit.
/// *Threads*: one caller at a time.
class KeptTensors {
 public:
  /// Makes room for vertices below this number at once.
  void Reserve(std::int32_t slot_count) { rows_.reserve(static_cast<std::size_t>(slot_count)); }
  void Set(VertexId vertex, const Metric& tensor);
  /// A vertex that is gone. @pre Has(vertex)
  void Remove(VertexId vertex);

  [[nodiscard]] bool Has(VertexId vertex) const {
    return vertex.index() < rows_.size() && rows_[vertex.index()].live;
  }
  [[nodiscard]] const Metric& At(VertexId vertex) const { return rows_[vertex.index()].tensor; }
  [[nodiscard]] const LogMetric& LogAt(VertexId vertex) const { return rows_[vertex.index()].log; }

  /// From now on Rollback returns to here. @par Cost O(changed since the last Commit)
  void Commit();
  /// True if nothing has happened since then.
  [[nodiscard]] bool as_committed() const {
    return log_.empty() && rows_.size() == committed_size_;
  }
  /// Tensors of the last Commit at vertices that have another one now, or none; ascending.
  /// @par Cost O(changed since then)
  [[nodiscard]] std::vector<std::pair<VertexId, Metric>> Changed() const;
  void Rollback();

 private:
  struct Row {
    Metric tensor;
    LogMetric log;
    bool live = false;
    bool logged = false;
  };

  /// Writable; the first call since Commit logs what stood there.
  Row& Mutable(VertexId vertex);

  LargeVector<Row> rows_;
  std::vector<std::pair<VertexId, Row>> log_;
  std::size_t committed_size_ = 0;
};

}  // namespace pliant
