#pragma once

#include <cstdint>
#include <span>

#include "core/base/ids.h"
#include "core/mesh/slots.h"

namespace pliant {

/// What one of several writers of a mesh may touch while the others are at work: the vertices that
/// it owns, and slots that nobody else takes.
///
/// Vertices are shared out among writers; a triangle or edge belongs to a writer if all its corners
/// do. A writer obeys three rules. It writes only to what it owns; of a triangle with a foreign
/// corner it writes the entry for a neighbour across a side that it owns, and of an edge with a
/// foreign end the entry for the next edge at its own end. It changes position and metric only of a
/// vertex whose neighbours it all owns. And of foreign vertices it reads only position and metric,
/// only of those next to its own. Then nobody reads what another writes: a foreign vertex next to
/// one's own has a neighbour that its owner does not own. And nothing of this changes meanwhile,
/// because triangles with corners of several owners are not replaced.
///
/// *Threads*: one writer, on one thread at a time.
class Territory {
 public:
  using Owner = std::uint16_t;

  Territory() = default;
  /// @param owners  of every vertex slot; not owned. Others read it meanwhile, but not the entries
  ///                of slots that only this writer takes.
  Territory(std::span<Owner> owners, Owner self) : owners_(owners), self_(self) {}

  [[nodiscard]] bool Owns(VertexId vertex) const { return owners_[vertex.index()] == self_; }
  /// Takes over a vertex just made.
  void Settle(VertexId vertex) { owners_[vertex.index()] = self_; }

  /// True if there are slots for one insertion: a vertex, two triangles, an edge.
  [[nodiscard]] bool HasRoom() const {
    return slots.vertices.free_count() >= 1 && slots.triangles.free_count() >= 2 &&
           slots.edges.free_count() >= 1;
  }

  /// Slots of this writer alone.
  struct Slots {
    SlotAllocator vertices;
    SlotAllocator triangles;
    SlotAllocator edges;
  };
  Slots slots;

 private:
  std::span<Owner> owners_;
  Owner self_ = 0;
};

}  // namespace pliant
