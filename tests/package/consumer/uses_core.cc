#include <pliant/core/pliant/remesher.h>

#include <iostream>

// A mesh of the unit square by a metric by expression: the core with all it links to.
int main() {
  pliant::Domain square;
  square.points = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  square.segments = {{0, 1, 1}, {1, 2, 2}, {2, 3, 3}, {3, 0, 4}};
  pliant::MetricSpec metric;
  metric.source = pliant::SizeMetric{"0.1 + 0.1*x"};
  auto remesher = pliant::Remesher::Create(square, metric, {});
  if (!remesher.ok() || !(*remesher)->Step({}).ok()) return 1;
  const auto summary = (*remesher)->Commit().summary;
  std::cout << summary.vertex_count << " vertices\n";
  return summary.vertex_count > 50 && summary.vertex_count < 200 ? 0 : 1;
}
