#include "core/pliant/frozen.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <span>
#include <string>
#include <utility>

#include "core/base/sort_unique.h"

namespace pliant {
namespace {

/// Refuses names that name nothing, and those that come twice.
template <class Name, class Exists, class Number>
Status CheckNames(std::span<const Name> names, const std::string& field, Exists exists,
                  Number number) {
  std::vector<std::pair<Name, std::size_t>> sorted;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (!exists(names[i])) {
      return Error{ErrorCode::kIndexOutOfRange,
                   field + "[" + std::to_string(i) + "] is " + std::to_string(number(names[i])) +
                       ", which names nothing in this revision",
                   field, static_cast<std::int64_t>(i)};
    }
    sorted.emplace_back(names[i], i);
  }
  std::sort(sorted.begin(), sorted.end());
  for (std::size_t i = 1; i < sorted.size(); ++i) {
    if (sorted[i].first != sorted[i - 1].first) continue;
    return Error{ErrorCode::kDuplicateId,
                 field + "[" + std::to_string(sorted[i].second) + "] names " +
                     std::to_string(number(sorted[i].first)) + " a second time",
                 field, static_cast<std::int64_t>(sorted[i].second),
                 static_cast<std::int64_t>(sorted[i - 1].second)};
  }
  return {};
}

Status CheckConstraints(const Mesh& mesh, const Constraints& constraints) {
  const auto value = [](auto id) { return id.value(); };
  PLIANT_RETURN_IF_ERROR(CheckNames(
      std::span(constraints.vertices), "constraints.frozen_vertices",
      [&](VertexId id) { return mesh.IsLive(id); }, value));
  PLIANT_RETURN_IF_ERROR(CheckNames(
      std::span(constraints.edges), "constraints.frozen_edges",
      [&](EdgeId id) { return id.valid() && id.value() < mesh.edge_slots() && mesh.edge(id).live; },
      value));
  if (constraints.regions.empty()) return {};
  std::vector<std::int32_t> tags;
  for (const TriangleRecord& triangle : mesh.triangle_records()) {
    if (triangle.live) tags.push_back(triangle.region);
  }
  SortUnique(tags);
  return CheckNames(
      std::span(constraints.regions), "constraints.frozen_regions",
      [&](std::int32_t tag) { return std::binary_search(tags.begin(), tags.end(), tag); },
      [](std::int32_t tag) { return tag; });
}

void AddRegions(const Mesh& mesh, std::span<const std::int32_t> regions, FrozenElements& frozen) {
  for (std::int32_t t = 0; t < mesh.triangle_slots(); ++t) {
    const TriangleRecord& triangle = mesh.triangle(TriangleId(t));
    if (!triangle.live || std::ranges::find(regions, triangle.region) == regions.end()) continue;
    frozen.triangles.emplace_back(t);
    const auto& corners = triangle.vertices;
    frozen.vertices.insert(frozen.vertices.end(), corners.begin(), corners.end());
    for (int side = 0; side < 3; ++side) {
      if (!triangle.IsConstrained(side)) continue;
      frozen.edges.push_back(
          mesh.FindEdge(corners[static_cast<std::size_t>(NextCorner(side))],
                        corners[static_cast<std::size_t>(PreviousCorner(side))]));
    }
  }
}

template <class IdType>
std::vector<IdType> Without(const std::vector<IdType>& from, const std::vector<IdType>& others) {
  std::vector<IdType> rest;
  std::ranges::set_difference(from, others, std::back_inserter(rest));
  return rest;
}

template <class IdType>
std::vector<IdType> Mark(MeshEdit& edit, const std::vector<IdType>& now,
                         const std::vector<IdType>& wanted) {
  for (const IdType id : Without(wanted, now)) edit.SetHold(id, MeshEdit::Hold::kFrozen);
  std::vector<IdType> thawed = Without(now, wanted);
  for (const IdType id : thawed) edit.SetHold(id, MeshEdit::Hold::kFree);
  return thawed;
}

/// @param elements  "vertices", "edges" or "triangles", as the error's field names them
Error Changed(const std::string& what, const std::string& elements, std::int32_t slot) {
  return {ErrorCode::kFrozen,
          what + " " + std::to_string(slot) +
              " is frozen and would be changed: lift that constraint first, or ask for something "
              "that leaves it alone",
          elements, slot};
}

}  // namespace

Result<FrozenElements> WhatFreezes(const Mesh& mesh, const Constraints& constraints) {
  PLIANT_RETURN_IF_ERROR(CheckConstraints(mesh, constraints));
  FrozenElements frozen{constraints.vertices, constraints.edges, {}};
  if (!constraints.regions.empty()) AddRegions(mesh, constraints.regions, frozen);
  SortUnique(frozen.edges);
  for (const EdgeId id : frozen.edges) {
    const auto& ends = mesh.edge(id).vertices;
    frozen.vertices.insert(frozen.vertices.end(), ends.begin(), ends.end());
  }
  SortUnique(frozen.vertices);
  return frozen;
}

FrozenElements FrozenOf(const Mesh& mesh) {
  FrozenElements frozen;
  const auto collect = [](const auto& records, std::int32_t slots, auto& ids) {
    for (std::int32_t i = 0; i < slots; ++i) {
      const auto& record = records[static_cast<std::size_t>(i)];
      if (record.live && record.frozen) ids.emplace_back(i);
    }
  };
  collect(mesh.vertex_records(), mesh.vertex_slots(), frozen.vertices);
  collect(mesh.edge_records(), mesh.edge_slots(), frozen.edges);
  collect(mesh.triangle_records(), mesh.triangle_slots(), frozen.triangles);
  return frozen;
}

std::vector<VertexId> ChangeFrozen(MeshEdit& edit, const FrozenElements& now,
                                   const FrozenElements& wanted) {
  const Mesh& mesh = edit.mesh();
  std::vector<VertexId> freed = Mark(edit, now.vertices, wanted.vertices);
  for (const EdgeId id : Mark(edit, now.edges, wanted.edges)) {
    const auto& ends = mesh.edge(id).vertices;
    freed.insert(freed.end(), ends.begin(), ends.end());
  }
  for (const TriangleId id : Mark(edit, now.triangles, wanted.triangles)) {
    const auto& corners = mesh.triangle(id).vertices;
    freed.insert(freed.end(), corners.begin(), corners.end());
  }
  SortUnique(freed);
  return freed;
}

Status CheckFrozenKept(const Mesh& mesh, const ChangeLog& log) {
  for (const auto& [id, old] : log.vertices) {
    if (!old.live || !old.frozen) continue;
    const VertexRecord& now = mesh.vertex(id);
    if (!now.live || !SameBits(now.position, old.position))
      return Changed("vertex", "vertices", id.value());
  }
  for (const auto& [id, old] : log.edges) {
    if (!old.live || !old.frozen) continue;
    const EdgeRecord& now = mesh.edge(id);
    if (!now.live || now.vertices != old.vertices) return Changed("edge", "edges", id.value());
  }
  for (const auto& [id, old] : log.triangles) {
    if (!old.live || !old.frozen) continue;
    const TriangleRecord& now = mesh.triangle(id);
    if (!now.live || now.vertices != old.vertices || now.region != old.region) {
      return Changed("triangle", "triangles", id.value());
    }
  }
  return {};
}

}  // namespace pliant
