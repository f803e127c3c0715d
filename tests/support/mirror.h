#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "pliant/v1/mesh.pb.h"
#include "tests/support/wire_arrays.h"

/// A client's mirror, written from proto/README.md alone: shares no code with server or client.
namespace pliant::test {

class Mirror {
 public:
  std::int64_t revision = 0;
  std::map<std::int32_t, std::array<double, 2>> vertices;
  std::map<std::int32_t, std::array<std::int32_t, 4>> triangles;  // Three vertices and the tag.
  std::map<std::int32_t, std::array<std::int32_t, 3>> edges;      // Two vertices and the tag.

  /// Applies a diff; what is wrong with it, or nothing.
  std::string Apply(const v1::MeshDiff& diff) {
    if (diff.base_revision() != revision) return "the diff has another base";
    std::string wrong;
    Remove(diff.removed_vertices(), vertices, wrong);
    Remove(diff.removed_triangles(), triangles, wrong);
    Remove(diff.removed_edges(), edges, wrong);
    Write(diff, wrong);
    revision = diff.revision();
    if (wrong.empty()) wrong = Check(diff.counts(), diff.state_hash());
    return wrong;
  }

  /// Takes a snapshot in place of everything.
  std::string Take(const v1::MeshSnapshot& snapshot) {
    vertices.clear();
    triangles.clear();
    edges.clear();
    std::string wrong;
    Write(snapshot, wrong);
    revision = snapshot.revision();
    if (wrong.empty()) wrong = Check(snapshot.counts(), snapshot.state_hash());
    return wrong;
  }

  [[nodiscard]] std::uint64_t Hash() const {
    std::uint64_t sum = 0;
    for (const auto& [slot, p] : vertices) {
      sum += Element(1, slot,
                     {std::bit_cast<std::uint64_t>(p[0]), std::bit_cast<std::uint64_t>(p[1])});
    }
    for (const auto& [slot, t] : triangles) {
      sum += Element(2, slot, {Word(t[0]), Word(t[1]), Word(t[2]), Word(t[3])});
    }
    for (const auto& [slot, e] : edges) {
      sum += Element(3, slot, {Word(e[0]), Word(e[1]), Word(e[2])});
    }
    return sum;
  }

  friend bool operator==(const Mirror& a, const Mirror& b) {
    return a.revision == b.revision && a.vertices == b.vertices && a.triangles == b.triangles &&
           a.edges == b.edges;
  }

 private:
  static std::uint64_t Word(std::int32_t value) { return static_cast<std::uint32_t>(value); }
  static std::uint64_t Mix(std::uint64_t x) {
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9;
    x = (x ^ (x >> 27)) * 0x94d049bb133111eb;
    return x ^ (x >> 31);
  }
  static std::uint64_t Element(std::uint64_t kind, std::int32_t slot,
                               const std::vector<std::uint64_t>& words) {
    std::uint64_t state = Mix((kind << 32) + Word(slot));
    for (const std::uint64_t word : words) state = Mix(state + 0x9e3779b97f4a7c15 + word);
    return state;
  }

  template <class Elements>
  static void Remove(const v1::Array& slots, Elements& elements, std::string& wrong) {
    std::int32_t last = -1;
    for (const std::int32_t slot : NumbersOf<std::int32_t>(slots)) {
      if (slot <= last) wrong = "removed slots are not ascending";
      if (elements.erase(slot) == 0) wrong = "a removed slot was not live";
      last = slot;
    }
  }

  static void CheckAscending(const std::vector<std::int32_t>& ids, std::string& wrong) {
    for (std::size_t i = 1; i < ids.size(); ++i) {
      if (ids[i] <= ids[i - 1]) wrong = "slots are not ascending";
    }
  }

  // A diff or a snapshot: their columns have the same names.
  template <class Message>
  void Write(const Message& message, std::string& wrong) {
    const auto vertex_ids = NumbersOf<std::int32_t>(message.vertex_ids());
    const auto positions = NumbersOf<double>(message.vertex_positions());
    CheckAscending(vertex_ids, wrong);
    for (std::size_t i = 0; i < vertex_ids.size(); ++i) {
      vertices[vertex_ids[i]] = {positions.at(2 * i), positions.at(2 * i + 1)};
    }
    const auto triangle_ids = NumbersOf<std::int32_t>(message.triangle_ids());
    const auto corners = NumbersOf<std::int32_t>(message.triangle_vertices());
    const auto regions = NumbersOf<std::int32_t>(message.triangle_tags());
    CheckAscending(triangle_ids, wrong);
    for (std::size_t i = 0; i < triangle_ids.size(); ++i) {
      const std::array<std::int32_t, 4> triangle = {corners.at(3 * i), corners.at(3 * i + 1),
                                                    corners.at(3 * i + 2), regions.at(i)};
      if (triangle[0] > triangle[1] || triangle[0] > triangle[2]) {
        wrong = "a triangle does not begin with its smallest slot";
      }
      triangles[triangle_ids[i]] = triangle;
    }
    const auto edge_ids = NumbersOf<std::int32_t>(message.edge_ids());
    const auto ends = NumbersOf<std::int32_t>(message.edge_vertices());
    const auto tags = NumbersOf<std::int32_t>(message.edge_tags());
    CheckAscending(edge_ids, wrong);
    for (std::size_t i = 0; i < edge_ids.size(); ++i) {
      edges[edge_ids[i]] = {ends.at(2 * i), ends.at(2 * i + 1), tags.at(i)};
    }
  }

  [[nodiscard]] std::string Check(const v1::MeshCounts& counts, std::uint64_t state_hash) const {
    if (counts.vertex_count() != static_cast<std::int64_t>(vertices.size()) ||
        counts.triangle_count() != static_cast<std::int64_t>(triangles.size()) ||
        counts.edge_count() != static_cast<std::int64_t>(edges.size())) {
      return "the counts differ";
    }
    return Hash() == state_hash ? "" : "the hash differs";
  }
};

}  // namespace pliant::test
