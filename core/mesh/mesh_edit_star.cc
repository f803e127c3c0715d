// MeshEdit, the part that takes a vertex out of the interior: the most frequent cavity by far.

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "core/mesh/mesh_edit.h"

namespace pliant {
namespace {}  // namespace

void MeshEdit::ReplaceStar(const Star& star, std::span<const NewTriangle> ears) {
  PLIANT_CHECK(star.closed() && ears.size() + 2 == star.triangles().size(), "vertex",
               star.center());
  GatherRim(star);
  const std::span<const TriangleId> slots = star.triangles().first(ears.size());
  FreeTriangle(star.triangles()[ears.size() + 1]);
  FreeTriangle(star.triangles()[ears.size()]);
  for (std::size_t k = 0; k < ears.size(); ++k) {
    const auto tip = std::ranges::find(rim_, ears[k].vertices[1], &RimSide::from);
    PLIANT_CHECK(tip != rim_.end(), "vertex", star.center(), "ear", k);
    const auto before = tip == rim_.begin() ? rim_.end() - 1 : tip - 1;
    const auto after = tip + 1 == rim_.end() ? rim_.begin() : tip + 1;
    TriangleRecord& record = TouchTriangle(slots[k]);
    record.vertices = ears[k].vertices;
    record.region = ears[k].region;
    record.neighbors = {};
    record.constrained = 0;
    LinkToRim(slots[k], 0, *tip);
    LinkToRim(slots[k], 2, *before);
    if (k + 1 == ears.size()) {
      LinkToRim(slots[k], 1, *after);
    } else {
      *before = {before->from, slots[k], 1, false};
      rim_.erase(tip);
    }
  }
  for (const TriangleId id : slots) {
    PointVerticesAt(id);
    if (mesh_.triangle(id).constrained != 0) PointEdgesAt(id);
  }
  CheckAfter(slots);
}

void MeshEdit::GatherRim(const Star& star) {
  rim_.clear();
  for (std::size_t k = 0; k < star.triangles().size(); ++k) {
    const TriangleId id = star.triangles()[k];
    const TriangleRecord& record = mesh_.triangle(id);
    const int side = mesh_.CornerOf(id, star.center());
    const TriangleId beyond = record.neighbors[static_cast<std::size_t>(side)];
    rim_.push_back({star.ring()[k], beyond, beyond.valid() ? mesh_.SideTowards(beyond, id) : 0,
                    record.IsConstrained(side)});
  }
}

void MeshEdit::LinkToRim(TriangleId id, int side, const RimSide& rim) {
  TriangleRecord& record = TouchTriangle(id);
  record.neighbors[static_cast<std::size_t>(side)] = rim.beyond;
  if (rim.constrained) {
    record.constrained = static_cast<std::uint8_t>(record.constrained | (1U << side));
  }
  if (rim.beyond.valid()) {
    TouchTriangle(rim.beyond).neighbors[static_cast<std::size_t>(rim.side)] = id;
  }
}

}  // namespace pliant
