#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "pliant/v1/edit.pb.h"
#include "tests/support/pieces.h"
#include "tests/support/wire_arrays.h"

/// What hostile bytes are made from: requests that are right.
namespace pliant::test {

/// One edit request of every kind.
inline std::vector<std::string> EditCorpus() {
  std::vector<std::string> corpus;
  const auto add = [&](auto&& fill) {
    v1::EditRequest request;
    request.set_update_id(7);
    fill(request);
    corpus.push_back(request.SerializeAsString());
  };
  add([](auto& r) { r.mutable_metric()->add_sources()->mutable_size()->set_size("0.1 + x"); });
  add([](auto& r) {
    v1::ExpressionMetric& e = *r.mutable_metric()->add_sources()->mutable_expression();
    e.set_m11("1");
    e.set_m12("0");
    e.set_m22("2");
    r.mutable_metric()->mutable_limits()->set_gradation(1.5);
  });
  add([](auto& r) {
    v1::VertexMetric& v = *r.mutable_metric()->add_sources()->mutable_vertices();
    v.set_revision(3);
    *v.mutable_vertex_ids() = Ints({1, 2});
    *v.mutable_tensors() = Doubles({1, 0, 1, 2, 0, 2}, 3);
  });
  add([](auto& r) { *r.mutable_metric() = TwoTriangles().metric(); });
  add([](auto& r) {
    v1::SolutionMetric& s = *r.mutable_metric()->add_sources()->mutable_solution();
    s.mutable_field()->set_location(v1::FIELD_LOCATION_VERTEX);
    *s.mutable_field()->mutable_values() = Doubles({1, 2, 3}, 1);
    s.set_complexity(100);
  });
  add([](auto& r) {
    v1::BoundaryUpdate& b = *r.mutable_boundary();
    *b.mutable_vertices()->mutable_vertex_ids() = Ints({4});
    *b.mutable_vertices()->mutable_positions() = Doubles({0.5, 0.25}, 2);
    b.add_tags()->mutable_rotation()->set_angle_rad(1);
    b.mutable_tags(0)->add_tags(3);
    b.add_tags()->mutable_path()->add_x(1);
  });
  add([](auto& r) {
    *r.mutable_nodes()->mutable_vertices()->mutable_positions() = Doubles({0, 0, 1, 1}, 2);
  });
  add([](auto& r) {
    v1::FieldValues& f = *r.mutable_fields()->add_values();
    f.set_name("u");
    f.set_location(v1::FIELD_LOCATION_TRIANGLE);
    *f.mutable_values() = Doubles({1, 2, 3, 4}, 2);
    r.mutable_fields()->set_transfer(v1::TRANSFER_BOUNDED);
  });
  add([](auto& r) {
    v1::ConstraintUpdate& c = *r.mutable_constraints();
    *c.mutable_frozen_vertices() = Ints({1, 2, 3});
    *c.mutable_frozen_edges() = Ints({0});
    c.add_frozen_regions(2);
    c.add_restrictions(v1::RESTRICTION_NO_SWAP);
    c.set_revision(1);
  });
  add([](auto& r) { r.mutable_options()->set_hops_max(4); });
  add([](auto& r) { r.mutable_rollback()->set_to_revision(2); });
  add([](auto& r) { r.mutable_advance()->set_budget_ms(20); });
  add([](auto& r) { r.mutable_discard(); });
  return corpus;
}

/// A session's life: each kind of update, as the session of SessionTrial takes it.
inline std::vector<Piece> SessionCorpus() {
  std::vector<Piece> pieces;
  const auto add = [&](auto&& fill) {
    v1::EditRequest request;
    fill(request);
    pieces.push_back({.choice = 0, .bytes = request.SerializeAsString()});
  };
  const auto advance = [&] { add([](auto& r) { r.mutable_advance(); }); };
  const auto size = [&](const std::string& formula) {
    add([&](auto& r) { r.mutable_metric()->add_sources()->mutable_size()->set_size(formula); });
    advance();
  };
  advance();
  size("10");  // Only the corners are left, so that their count is known.
  add([](auto& r) {
    v1::FieldValues& f = *r.mutable_fields()->add_values();
    f.set_name("u");
    f.set_location(v1::FIELD_LOCATION_VERTEX);
    *f.mutable_values() = Doubles({1, 2, 3, 4}, 1);
    r.mutable_fields()->set_revision(2);
  });
  size("0.1 + 0.1*x");
  add([](auto& r) {
    v1::VertexMetric& v = *r.mutable_metric()->add_sources()->mutable_vertices();
    v.set_revision(3);
    *v.mutable_vertex_ids() = Ints({0, 1, 2});
    *v.mutable_tensors() = Doubles({100, 0, 100, 50, 5, 60, 25, 0, 25}, 3);
  });
  advance();
  add([](auto& r) {
    v1::BoundaryUpdate& b = *r.mutable_boundary();
    *b.mutable_vertices()->mutable_vertex_ids() = Ints({2});
    *b.mutable_vertices()->mutable_positions() = Doubles({1.1, 1.05}, 2);
    b.mutable_vertices()->set_revision(4);
  });
  advance();
  add([](auto& r) {
    *r.mutable_constraints()->mutable_frozen_vertices() = Ints({1, 3});
    r.mutable_constraints()->add_restrictions(v1::RESTRICTION_NO_SWAP);
    r.mutable_constraints()->set_revision(5);
  });
  size("0.15");
  add([](auto& r) { r.mutable_rollback()->set_to_revision(2); });
  add([](auto& r) { r.mutable_options()->set_hops_max(3); });
  add([](auto& r) { r.mutable_discard(); });
  add([](auto& r) { r.mutable_advance()->set_budget_visits(5); });
  return pieces;
}

}  // namespace pliant::test
