#include "core/pliant/visit_audit.h"

#include <algorithm>
#include <cstddef>

#include "core/base/sentence.h"
#include "core/base/sort_unique.h"
#include "core/mesh/star.h"

namespace pliant {
namespace {

constexpr std::size_t kAgeCount = 256;

}  // namespace

int SignOfPotentialChange(const std::vector<std::int64_t>& changes) {
  std::int64_t largest = 0;
  for (const std::int64_t change : changes) largest = std::max(largest, std::max(change, -change));
  // Horner's rule from the heaviest weight. All that follows weighs less than `largest` of the
  // present weight, because 1/3 + 1/9 + ... = 1/2: a sum beyond it keeps its sign.
  std::int64_t sum = 0;
  for (const std::int64_t change : changes) {
    sum = 3 * sum + change;
    if (sum > largest) return 1;
    if (sum < -largest) return -1;
  }
  return sum > 0 ? 1 : sum < 0 ? -1 : 0;
}

void VisitAudit::Sync(const Mesh& mesh) {
  known_.assign(static_cast<std::size_t>(mesh.vertex_slots()), {});
  for (std::int32_t v = 0; v < mesh.vertex_slots(); ++v) {
    known_[static_cast<std::size_t>(v)] = NowOf(mesh, VertexId(v));
  }
}

VisitAudit::Known VisitAudit::NowOf(const Mesh& mesh, VertexId node) const {
  const VertexRecord& record = mesh.vertex(node);
  return {record.live, record.visit.epoch, record.visit.age};
}

void VisitAudit::AddRing(const Mesh& mesh, VertexId node) {
  Star star;
  for (const TriangleId fan : FansOf(mesh, node)) {
    star.Gather(mesh, node, fan);
    surroundings_.insert(surroundings_.end(), star.ring().begin(), star.ring().end());
  }
}

void VisitAudit::AddSurroundings(const Mesh& mesh, VertexId node) {
  surroundings_.push_back(node);
  const std::size_t begin = surroundings_.size();
  AddRing(mesh, node);
  const std::size_t end = surroundings_.size();
  for (std::size_t k = begin; k < end; ++k) AddRing(mesh, surroundings_[k]);
}

void VisitAudit::Begin(const Mesh& mesh, VertexId node, std::uint32_t epoch) {
  node_ = node;
  epoch_ = epoch;
  // A node that waits since an earlier update is reached by its visit, at age 0.
  const Known& known = known_[node.index()];
  age_before_ = known.epoch == epoch ? known.age : std::uint8_t{0};
  surroundings_.clear();
  AddSurroundings(mesh, node);
}

std::string VisitAudit::End(const Mesh& mesh) {
  ++visit_count_;
  known_.resize(static_cast<std::size_t>(mesh.vertex_slots()));
  if (mesh.IsLive(node_)) AddSurroundings(mesh, node_);
  SortUnique(surroundings_);

  std::vector<std::int64_t> changes(kAgeCount, 0);
  int born_count = 0;
  for (const VertexId vertex : surroundings_) {
    const Known now = NowOf(mesh, vertex);
    Known& before = known_[vertex.index()];
    const bool is_node = vertex == node_;
    const bool was_reached = before.live && (is_node || before.epoch == epoch_);
    const std::uint8_t old_age = is_node ? age_before_ : before.age;
    if (before.live && was_reached) {
      --changes[old_age];
      if (now.live && now.age < old_age) return Sentence("node ", vertex, " has grown younger");
      if (now.live && is_node && now.age == old_age) {
        return Sentence("node ", vertex, " was visited and is as old as before");
      }
      if (now.live) ++changes[now.age];
    }
    if (!before.live && now.live) {
      ++born_count;
      ++changes[now.age];
      if (now.epoch != epoch_) return Sentence("node ", vertex, " is of another update");
      if (now.age <= age_before_) {
        return Sentence("node ", vertex, " is new and has age ", int{now.age},
                        ", which must be above ", int{age_before_}, ", that of node ", node_);
      }
    }
    before = now;
  }
  if (born_count > 1) return Sentence("the visit of node ", node_, " made ", born_count, " nodes");
  if (SignOfPotentialChange(changes) >= 0) {
    return Sentence("the potential did not fall in the visit of node ", node_);
  }
  return {};
}

}  // namespace pliant
