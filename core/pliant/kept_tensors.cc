#include "core/pliant/kept_tensors.h"

#include <algorithm>

namespace pliant {

void KeptTensors::Set(VertexId vertex, const Metric& tensor) {
  if (vertex.index() >= rows_.size()) rows_.resize(vertex.index() + 1);
  Row& row = Mutable(vertex);
  row.tensor = tensor;
  row.log = Log(tensor);
  row.live = true;
}

void KeptTensors::Remove(VertexId vertex) { Mutable(vertex).live = false; }

KeptTensors::Row& KeptTensors::Mutable(VertexId vertex) {
  Row& row = rows_[vertex.index()];
  // Of rows that the last commit did not have, nothing comes back.
  if (!row.logged && vertex.index() < committed_size_) {
    log_.emplace_back(vertex, row);
    row.logged = true;
  }
  return row;
}

void KeptTensors::Commit() {
  for (const auto& [vertex, old] : log_) rows_[vertex.index()].logged = false;
  log_.clear();
  committed_size_ = rows_.size();
}

std::vector<std::pair<VertexId, Metric>> KeptTensors::Changed() const {
  std::vector<std::pair<VertexId, Metric>> changed;
  for (const auto& [vertex, old] : log_) {
    if (old.live && !(Has(vertex) && At(vertex) == old.tensor)) {
      changed.emplace_back(vertex, old.tensor);
    }
  }
  std::ranges::sort(changed, {}, [](const auto& entry) { return entry.first; });
  return changed;
}

void KeptTensors::Rollback() {
  for (const auto& [vertex, old] : log_) rows_[vertex.index()] = old;
  log_.clear();
  rows_.resize(committed_size_);
}

}  // namespace pliant
