#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <ostream>

namespace pliant {

/// A 32-bit slot number that cannot be mixed up with a slot of another kind.
///
/// Ids are slots in the arrays of a session: 0-based, dense, stable while the element lives, and
/// used again (lowest first) by a later revision after it died. -1 means "none".
template <class Tag>
class Id {
 public:
  constexpr Id() = default;
  constexpr explicit Id(std::int32_t value) : value_(value) {}
  static constexpr Id FromIndex(std::size_t index) { return Id(static_cast<std::int32_t>(index)); }

  [[nodiscard]] constexpr std::int32_t value() const { return value_; }
  /// The slot as an array index. @pre valid()
  [[nodiscard]] constexpr std::size_t index() const { return static_cast<std::size_t>(value_); }
  [[nodiscard]] constexpr bool valid() const { return value_ >= 0; }

  friend constexpr auto operator<=>(Id, Id) = default;
  friend std::ostream& operator<<(std::ostream& out, Id id) { return out << id.value_; }

 private:
  std::int32_t value_ = -1;
};

using VertexId = Id<struct VertexTag>;
using TriangleId = Id<struct TriangleTag>;
/// A constrained edge: a piece of the boundary or of an internal constraint. Edges of the mesh
/// that may be swapped away have no id.
using EdgeId = Id<struct EdgeTag>;

/// The number of a committed state of a session: 1 for the first mesh, then one more per commit.
enum class Revision : std::int64_t { kNone = 0 };

}  // namespace pliant

template <class Tag>
struct std::hash<pliant::Id<Tag>> {
  std::size_t operator()(pliant::Id<Tag> id) const noexcept {
    return std::hash<std::int32_t>()(id.value());
  }
};
