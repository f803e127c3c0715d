#pragma once

#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <string>
#include <vector>

#include "pliant/v1/array.pb.h"
#include "pliant/v1/session.pb.h"

/// Arrays of the wire for tests, made by hand: independent of the server's own conversion.
namespace pliant::test {

template <class Number>
v1::Array MakeArray(v1::DType type, const std::vector<Number>& numbers, std::int64_t columns) {
  v1::Array array;
  array.set_dtype(type);
  array.add_shape(static_cast<std::int64_t>(numbers.size()) / columns);
  if (columns > 1) array.add_shape(columns);
  array.set_data(numbers.data(), numbers.size() * sizeof(Number));
  return array;
}

inline v1::Array Doubles(const std::vector<double>& numbers, std::int64_t columns) {
  return MakeArray(v1::DTYPE_FLOAT64, numbers, columns);
}

inline v1::Array Ints(const std::vector<std::int32_t>& numbers, std::int64_t columns = 1) {
  return MakeArray(v1::DTYPE_INT32, numbers, columns);
}

template <class Number>
std::vector<Number> NumbersOf(const v1::Array& array) {
  std::vector<Number> numbers(array.data().size() / sizeof(Number));
  if (!numbers.empty()) std::memcpy(numbers.data(), array.data().data(), array.data().size());
  return numbers;
}

/// The unit square as a domain, its sides tagged 1 to 4, with an isotropic size.
inline v1::CreateSession UnitSquare(const std::string& size = "0.2") {
  v1::CreateSession create;
  v1::Domain& domain = *create.mutable_domain();
  *domain.mutable_points() = Doubles({0, 0, 1, 0, 1, 1, 0, 1}, 2);
  *domain.mutable_segments() = Ints({0, 1, 1, 2, 2, 3, 3, 0}, 2);
  *domain.mutable_segment_tags() = Ints({1, 2, 3, 4});
  create.mutable_metric()->add_sources()->mutable_size()->set_size(size);
  return create;
}

/// The unit square as a mesh of two triangles, with tensors at its vertices.
inline v1::CreateSession TwoTriangles() {
  v1::CreateSession create;
  v1::MeshInput& mesh = *create.mutable_mesh();
  *mesh.mutable_points() = Doubles({0, 0, 1, 0, 1, 1, 0, 1}, 2);
  *mesh.mutable_triangles() = Ints({0, 1, 2, 0, 2, 3}, 3);
  *mesh.mutable_triangle_tags() = Ints({7, 8});
  *mesh.mutable_edges() = Ints({0, 1, 0, 2}, 2);  // A side and the border of the regions.
  *mesh.mutable_edge_tags() = Ints({5, 6});
  *create.mutable_metric()->add_sources()->mutable_vertices()->mutable_tensors() =
      Doubles({25, 0, 25, 25, 0, 25, 25, 0, 25, 25, 0, 25}, 3);
  return create;
}

}  // namespace pliant::test
