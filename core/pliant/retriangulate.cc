#include "core/pliant/retriangulate.h"

#include <cstddef>

#include "core/geometry/predicates.h"
#include "core/geometry/vec2.h"

namespace pliant {
namespace {

/// Cutting takes the square of the corners at least; a vertex of more neighbours than this stays.
constexpr std::size_t kCornersMax = 250;

class EarCutter {
 public:
  EarCutter(const Mesh& mesh, std::span<const VertexId> polygon, const Metric& metric)
      : mesh_(mesh), metric_(metric), left_(polygon.begin(), polygon.end()) {}

  /// Index of the best ear's tip; nothing if there is no ear.
  [[nodiscard]] std::optional<std::size_t> BestEar() const {
    std::optional<std::size_t> best;
    double best_shape = -1;
    for (std::size_t i = 0; i < left_.size(); ++i) {
      const double shape = Shape(i);
      if (shape > best_shape && IsEar(i)) {
        best = i;
        best_shape = shape;
      }
    }
    return best;
  }

  [[nodiscard]] std::array<VertexId, 3> Ear(std::size_t tip) const {
    return {At(tip + left_.size() - 1), At(tip), At(tip + 1)};
  }
  void Cut(std::size_t tip) { left_.erase(left_.begin() + static_cast<std::ptrdiff_t>(tip)); }
  [[nodiscard]] std::size_t size() const { return left_.size(); }

 private:
  [[nodiscard]] VertexId At(std::size_t i) const { return left_[i % left_.size()]; }

  [[nodiscard]] bool IsEar(std::size_t tip) const {
    const auto [a, b, c] = Ear(tip);
    const Vec2 pa = mesh_.position(a);
    const Vec2 pb = mesh_.position(b);
    const Vec2 pc = mesh_.position(c);
    if (Orient2d(pa, pb, pc) <= 0) return false;
    for (const VertexId other : left_) {
      if (other == a || other == b || other == c) continue;
      const Vec2 p = mesh_.position(other);
      if (Orient2d(pa, pb, p) >= 0 && Orient2d(pb, pc, p) >= 0 && Orient2d(pc, pa, p) >= 0) {
        return false;
      }
    }
    return true;
  }

  /// Area over squared sides, up to a constant factor: the quality of the triangle in the metric.
  [[nodiscard]] double Shape(std::size_t tip) const {
    const auto [a, b, c] = Ear(tip);
    const Vec2 ab = mesh_.position(b) - mesh_.position(a);
    const Vec2 bc = mesh_.position(c) - mesh_.position(b);
    return Cross(ab, bc) / (SquaredLength(metric_, ab) + SquaredLength(metric_, bc) +
                            SquaredLength(metric_, ab + bc));
  }

  const Mesh& mesh_;
  const Metric& metric_;
  std::vector<VertexId> left_;
};

}  // namespace

std::optional<std::vector<NewTriangle>> CutEars(const Mesh& mesh, std::span<const VertexId> polygon,
                                                const Metric& metric, std::int32_t region) {
  if (polygon.size() > kCornersMax) return std::nullopt;
  EarCutter cutter(mesh, polygon, metric);
  std::vector<NewTriangle> triangles;
  while (cutter.size() >= 3) {
    const std::optional<std::size_t> tip = cutter.BestEar();
    if (!tip) return std::nullopt;
    triangles.push_back({cutter.Ear(*tip), region});
    if (cutter.size() == 3) break;
    cutter.Cut(*tip);
  }
  return triangles;
}

}  // namespace pliant
