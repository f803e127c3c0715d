#include "core/pliant/retriangulate.h"

#include <cstddef>

#include "core/geometry/predicates.h"
#include "core/geometry/vec2.h"

namespace pliant {
namespace {

/// Cutting takes the square of the corners at least; a vertex of more neighbours than this stays.
constexpr std::size_t kCornersMax = 250;

/// What is left of the polygon, with the shape of the ear at each corner: a cut changes two of
/// them.
class EarCutter {
 public:
  EarCutter(const Mesh& mesh, std::span<const VertexId> polygon, const Metric& metric)
      : metric_(metric) {
    left_.reserve(polygon.size());
    for (const VertexId vertex : polygon) left_.push_back({vertex, mesh.position(vertex), 0});
    for (std::size_t i = 0; i < left_.size(); ++i) left_[i].shape = Shape(i);
  }

  /// Index of the best ear's tip; nothing if there is no ear.
  [[nodiscard]] std::optional<std::size_t> BestEar() const {
    std::optional<std::size_t> best;
    double best_shape = -1;
    for (std::size_t i = 0; i < left_.size(); ++i) {
      if (left_[i].shape > best_shape && IsEar(i)) {
        best = i;
        best_shape = left_[i].shape;
      }
    }
    return best;
  }

  [[nodiscard]] std::array<VertexId, 3> Ear(std::size_t tip) const {
    return {left_[Before(tip)].vertex, left_[tip].vertex, left_[After(tip)].vertex};
  }
  void Cut(std::size_t tip) {
    left_.erase(left_.begin() + static_cast<std::ptrdiff_t>(tip));
    const std::size_t after = tip == left_.size() ? 0 : tip;
    const std::size_t before = Before(after);
    left_[before].shape = Shape(before);
    left_[after].shape = Shape(after);
  }
  [[nodiscard]] std::size_t size() const { return left_.size(); }

 private:
  struct Corner {
    VertexId vertex;
    Vec2 position;
    double shape;
  };

  [[nodiscard]] std::size_t Before(std::size_t i) const {
    return i == 0 ? left_.size() - 1 : i - 1;
  }
  [[nodiscard]] std::size_t After(std::size_t i) const { return i + 1 == left_.size() ? 0 : i + 1; }

  [[nodiscard]] bool IsEar(std::size_t tip) const {
    const Corner& a = left_[Before(tip)];
    const Corner& b = left_[tip];
    const Corner& c = left_[After(tip)];
    if (Orient2d(a.position, b.position, c.position) <= 0) return false;
    for (const Corner& other : left_) {
      if (other.vertex == a.vertex || other.vertex == b.vertex || other.vertex == c.vertex) {
        continue;
      }
      const Vec2 p = other.position;
      if (Orient2d(a.position, b.position, p) >= 0 && Orient2d(b.position, c.position, p) >= 0 &&
          Orient2d(c.position, a.position, p) >= 0) {
        return false;
      }
    }
    return true;
  }

  /// Area over squared sides, up to a constant factor: the quality of the triangle in the metric.
  [[nodiscard]] double Shape(std::size_t tip) const {
    const Vec2 ab = left_[tip].position - left_[Before(tip)].position;
    const Vec2 bc = left_[After(tip)].position - left_[tip].position;
    return Cross(ab, bc) / (SquaredLength(metric_, ab) + SquaredLength(metric_, bc) +
                            SquaredLength(metric_, ab + bc));
  }

  const Metric& metric_;
  std::vector<Corner> left_;
};

}  // namespace

std::optional<std::vector<NewTriangle>> CutEars(const Mesh& mesh, std::span<const VertexId> polygon,
                                                const Metric& metric, std::int32_t region) {
  if (polygon.size() > kCornersMax) return std::nullopt;
  EarCutter cutter(mesh, polygon, metric);
  std::vector<NewTriangle> triangles;
  triangles.reserve(polygon.size());
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
