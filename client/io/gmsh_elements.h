#pragma once

#include <cstdint>

namespace pliant::io {

/// The numbers that Gmsh's files give the types of elements.
inline constexpr std::int64_t kGmshLine = 1;
inline constexpr std::int64_t kGmshTriangle = 2;
inline constexpr std::int64_t kGmshPoint = 15;

}  // namespace pliant::io
