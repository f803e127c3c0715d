#include "core/pliant/ask.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "core/base/check.h"
#include "core/geometry/vec2.h"

namespace pliant {
namespace {

/// Enough for what is the same for all questions of a formula to be paid once, and for walks in a
/// background mesh to wait for the memory together; few enough to stay in the nearest cache.
constexpr std::size_t kQuestionsAtOnce = 16;

}  // namespace

void AskAt(MeshEdit& edit, const MetricField& field, std::span<const VertexId> vertices,
           std::span<Metric> metrics) {
  PLIANT_CHECK(vertices.size() == metrics.size());
  const Mesh& mesh = edit.mesh();
  std::array<Vec2, kQuestionsAtOnce> points;
  std::array<std::int32_t, kQuestionsAtOnce> hints;
  std::int32_t last_hint = MetricField::kNoHint;
  for (std::size_t begin = 0; begin < vertices.size(); begin += kQuestionsAtOnce) {
    const auto block = vertices.subspan(begin, std::min(kQuestionsAtOnce, vertices.size() - begin));
    for (std::size_t i = 0; i < block.size(); ++i) {
      points[i] = mesh.position(block[i]);
      hints[i] = mesh.hint(block[i]);
    }
    if (hints.front() == MetricField::kNoHint) hints.front() = last_hint;
    field.AtEach(std::span(points).first(block.size()), std::span(hints).first(block.size()),
                 metrics.subspan(begin, block.size()));
    for (std::size_t i = 0; i < block.size(); ++i) edit.Hint(block[i]) = hints[i];
    last_hint = hints[block.size() - 1];
  }
}

}  // namespace pliant
