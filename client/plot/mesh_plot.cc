#include "client/plot/mesh_plot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include "client/plot/axis.h"
#include "core/base/sort_unique.h"

namespace pliant::plot {
namespace {

constexpr double kMargin = 12;
constexpr double kTitleHeight = 26;
constexpr double kCaptionHeight = 24;
constexpr double kAxisLeft = 64;
constexpr double kAxisRight = 24;  // Half a label of the last tick.
constexpr double kAxisBottom = 28;
constexpr double kScaleWidth = 74;

/// From the mesh's coordinates to those of the drawing.
struct View {
  BoundingBox window;
  Vec2 low;   ///< Upper left corner of the panel.
  Vec2 high;  ///< Lower right corner.
  Vec2 scale;

  [[nodiscard]] Vec2 operator()(Vec2 p) const {
    return {low.x + scale.x * (p.x - window.low.x), high.y - scale.y * (p.y - window.low.y)};
  }
  [[nodiscard]] bool Sees(Vec2 low_corner, Vec2 high_corner) const {
    return high_corner.x >= window.low.x && low_corner.x <= window.high.x &&
           high_corner.y >= window.low.y && low_corner.y <= window.high.y;
  }
};

using Edge = std::array<std::int32_t, 2>;

/// The edges of the mesh by the way they are drawn, each in ascending order.
struct EdgeLists {
  std::vector<Edge> inner;
  std::vector<Edge> boundary;                              ///< Without those in `constrained`.
  std::vector<std::pair<std::int32_t, Edge>> constrained;  ///< By tag.
};

class MeshPlotter {
 public:
  MeshPlotter(const MeshData& mesh, const PlotOptions& options) : mesh_(mesh), options_(options) {}
  Drawing Plot();

 private:
  [[nodiscard]] View MakeView() const;
  void FillTriangles();
  void FillRegions();
  void FillValues();
  void DrawEdges();
  void DrawConstrained(const EdgeLists& lists, double width);
  void DrawEllipses();
  void DrawScale();
  void DrawTitles();
  [[nodiscard]] bool Sees(const std::array<std::int32_t, 3>& triangle) const;
  [[nodiscard]] Path TrianglePath(const std::array<std::int32_t, 3>& triangle) const;
  [[nodiscard]] Segments ToSegments(const std::vector<Edge>& edges, const Stroke& stroke) const;
  [[nodiscard]] bool HasScale() const {
    return options_.fill == Fill::kValues &&
           options_.triangle_values.size() == mesh_.triangles.size() && !mesh_.triangles.empty();
  }
  [[nodiscard]] bool HasEllipses() const {
    return options_.ellipses == Ellipses::kShow && options_.metrics.size() == mesh_.points.size();
  }
  [[nodiscard]] Vec2 point(std::int32_t i) const {
    return mesh_.points[static_cast<std::size_t>(i)];
  }

  const MeshData& mesh_;
  const PlotOptions& options_;
  View view_;
  Drawing drawing_;
};

BoundingBox WindowOf(const std::vector<Vec2>& points) {
  return points.empty() ? BoundingBox{.low = {0, 0}, .high = {1, 1}} : BoxOf(points);
}

/// A box without width or height cannot be mapped onto a panel.
BoundingBox WithArea(BoundingBox box) {
  const double size = std::max(box.high.x - box.low.x, box.high.y - box.low.y);
  const double half = size > 0 ? 0.5 * size : 0.5;
  if (!(box.high.x > box.low.x)) {
    box.low.x -= half;
    box.high.x += half;
  }
  if (!(box.high.y > box.low.y)) {
    box.low.y -= half;
    box.high.y += half;
  }
  return box;
}

EdgeLists ListEdges(const MeshData& mesh) {
  const auto ordered = [](std::int32_t a, std::int32_t b) {
    return a < b ? Edge{a, b} : Edge{b, a};
  };
  EdgeLists lists;
  std::vector<Edge> special;
  for (std::size_t i = 0; i < mesh.edges.size(); ++i) {
    const Edge edge = ordered(mesh.edges[i][0], mesh.edges[i][1]);
    const std::int32_t tag = i < mesh.edge_tags.size() ? mesh.edge_tags[i] : 0;
    lists.constrained.emplace_back(tag, edge);
    special.push_back(edge);
  }
  std::sort(lists.constrained.begin(), lists.constrained.end());
  std::sort(special.begin(), special.end());
  std::vector<Edge> all;
  all.reserve(3 * mesh.triangles.size());
  for (const auto& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) all.push_back(ordered(t[k], t[(k + 1) % 3]));
  }
  std::sort(all.begin(), all.end());
  for (std::size_t i = 0; i < all.size();) {
    std::size_t end = i + 1;
    while (end < all.size() && all[end] == all[i]) ++end;
    if (!std::binary_search(special.begin(), special.end(), all[i])) {
      (end - i == 1 ? lists.boundary : lists.inner).push_back(all[i]);
    }
    i = end;
  }
  return lists;
}

/// The closed loops around the triangles of a tag, with these on the left. Filling the outline
/// leaves no hairlines between triangles and is far smaller than the triangles.
std::vector<std::vector<std::int32_t>> RegionOutline(const MeshData& mesh, std::int32_t tag) {
  std::vector<Edge> sides;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (mesh.triangle_tags[i] != tag) continue;
    const auto& t = mesh.triangles[i];
    for (std::size_t k = 0; k < 3; ++k) sides.push_back({t[k], t[(k + 1) % 3]});
  }
  std::sort(sides.begin(), sides.end());
  std::vector<Edge> outline;
  for (const Edge& side : sides) {
    if (!std::binary_search(sides.begin(), sides.end(), Edge{side[1], side[0]})) {
      outline.push_back(side);
    }
  }
  std::vector<char> is_used(outline.size(), 0);
  std::vector<std::vector<std::int32_t>> loops;
  for (std::size_t first = 0; first < outline.size(); ++first) {
    if (is_used[first]) continue;
    std::vector<std::int32_t> loop;
    for (std::size_t at = first; at < outline.size() && !is_used[at];) {
      is_used[at] = 1;
      loop.push_back(outline[at][0]);
      // The next side starts where this one ends; where loops touch there are several.
      const Edge wanted = {outline[at][1], 0};
      at = static_cast<std::size_t>(std::lower_bound(outline.begin(), outline.end(), wanted) -
                                    outline.begin());
      while (at < outline.size() && is_used[at] && outline[at][0] == wanted[0]) ++at;
      if (at < outline.size() && outline[at][0] != wanted[0]) break;
    }
    loops.push_back(std::move(loop));
  }
  return loops;
}

Drawing MeshPlotter::Plot() {
  view_ = MakeView();
  drawing_.width = view_.high.x + (options_.window.has_value() ? kAxisRight : kMargin) +
                   (HasScale() ? kScaleWidth : 0);
  drawing_.height = view_.high.y + kMargin + (options_.window.has_value() ? kAxisBottom : 0) +
                    (options_.caption.empty() ? 0 : kCaptionHeight);
  // Without a window everything is inside, and bold lines may stand out of the box a little.
  if (options_.window.has_value()) {
    drawing_.items.emplace_back(BeginClip{.low = view_.low, .high = view_.high});
  }
  FillTriangles();
  DrawEdges();
  DrawEllipses();
  if (options_.window.has_value()) {
    drawing_.items.emplace_back(EndClip{});
    Frame frame;
    frame.x = {.low = view_.window.low.x,
               .high = view_.window.high.x,
               .from = view_.low.x,
               .to = view_.high.x};
    frame.y = {.low = view_.window.low.y,
               .high = view_.window.high.y,
               .from = view_.high.y,
               .to = view_.low.y};
    DrawFrame(frame, drawing_);
  }
  if (HasScale()) DrawScale();
  DrawTitles();
  return std::move(drawing_);
}

View MeshPlotter::MakeView() const {
  View view;
  const bool has_window = options_.window.has_value();
  view.window = WithArea(has_window ? *options_.window : WindowOf(mesh_.points));
  const Vec2 extent = view.window.high - view.window.low;
  view.scale = {options_.width / extent.x, options_.height / extent.y};
  if (options_.fit == WindowFit::kEqual) {
    const double scale = std::min(view.scale.x, view.scale.y);
    view.scale = {scale, scale};
  }
  view.low = {has_window ? kAxisLeft : kMargin,
              kMargin + (options_.title.empty() ? 0 : kTitleHeight)};
  view.high = view.low + Vec2{view.scale.x * extent.x, view.scale.y * extent.y};
  return view;
}

bool MeshPlotter::Sees(const std::array<std::int32_t, 3>& triangle) const {
  const Vec2 a = point(triangle[0]);
  const Vec2 b = point(triangle[1]);
  const Vec2 c = point(triangle[2]);
  return view_.Sees({std::min({a.x, b.x, c.x}), std::min({a.y, b.y, c.y})},
                    {std::max({a.x, b.x, c.x}), std::max({a.y, b.y, c.y})});
}

Path MeshPlotter::TrianglePath(const std::array<std::int32_t, 3>& triangle) const {
  Path path;
  path.MoveTo(view_(point(triangle[0])));
  path.LineTo(view_(point(triangle[1])));
  path.LineTo(view_(point(triangle[2])));
  path.Close();
  return path;
}

void MeshPlotter::FillTriangles() {
  if (HasScale()) return FillValues();
  if (options_.fill == Fill::kRegions) FillRegions();
}

void MeshPlotter::FillRegions() {
  std::vector<std::int32_t> tags = mesh_.triangle_tags;
  SortUnique(tags);
  if (tags.size() < 2 || mesh_.triangle_tags.size() != mesh_.triangles.size()) return;
  for (std::size_t r = 0; r < tags.size(); ++r) {
    Shape shape{.path = {},
                .fill = Lighter(CategoryColor(static_cast<std::int64_t>(r)), 0.8),
                .stroke = {}};
    for (const std::vector<std::int32_t>& loop : RegionOutline(mesh_, tags[r])) {
      shape.path.MoveTo(view_(point(loop.front())));
      for (std::size_t k = 1; k < loop.size(); ++k) shape.path.LineTo(view_(point(loop[k])));
      shape.path.Close();
    }
    drawing_.items.emplace_back(std::move(shape));
  }
}

void MeshPlotter::FillValues() {
  // Triangles of nearly the same value share a path, which keeps the picture small.
  constexpr std::size_t kStepCount = 64;
  std::vector<Shape> shapes(kStepCount);
  for (std::size_t step = 0; step < kStepCount; ++step) {
    const Color color = ScaleColor((static_cast<double>(step) + 0.5) / kStepCount);
    shapes[step].fill = color;
    shapes[step].stroke = Stroke{.color = color, .width = 0.4};
  }
  for (std::size_t i = 0; i < mesh_.triangles.size(); ++i) {
    if (!Sees(mesh_.triangles[i])) continue;
    const double value = std::clamp(options_.triangle_values[i], 0.0, 1.0);
    const auto step = std::min(static_cast<std::size_t>(value * kStepCount), kStepCount - 1);
    const Path path = TrianglePath(mesh_.triangles[i]);
    Path& all = shapes[step].path;
    all.verbs += path.verbs;
    all.points.insert(all.points.end(), path.points.begin(), path.points.end());
  }
  for (Shape& shape : shapes) {
    if (!shape.path.verbs.empty()) drawing_.items.emplace_back(std::move(shape));
  }
}

Segments MeshPlotter::ToSegments(const std::vector<Edge>& edges, const Stroke& stroke) const {
  Segments segments{.lines = {}, .stroke = stroke};
  segments.lines.reserve(edges.size());
  for (const Edge& edge : edges) {
    const Vec2 a = point(edge[0]);
    const Vec2 b = point(edge[1]);
    if (!view_.Sees({std::min(a.x, b.x), std::min(a.y, b.y)},
                    {std::max(a.x, b.x), std::max(a.y, b.y)})) {
      continue;
    }
    segments.lines.push_back({view_(a), view_(b)});
  }
  return segments;
}

void MeshPlotter::DrawEdges() {
  const EdgeLists lists = ListEdges(mesh_);
  Segments inner = ToSegments(lists.inner, {});
  // Hairlines that get thinner as the mesh gets finer keep dense parts readable. The median is
  // taken, because a few long edges say nothing about the fine parts.
  std::vector<double> lengths;
  lengths.reserve(inner.lines.size());
  for (const auto& line : inner.lines) lengths.push_back(Length(line[1] - line[0]));
  double typical = 20;
  if (!lengths.empty()) {
    const auto middle = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2);
    std::nth_element(lengths.begin(), middle, lengths.end());
    typical = *middle;
  }
  const double width = std::clamp(0.045 * typical, 0.12, 0.8);
  // Where ellipses go over it, the mesh steps back.
  const Color color = HasEllipses() ? Color{0.6, 0.62, 0.66, 1} : Color{0.2, 0.22, 0.26, 1};
  inner.stroke = {.color = color, .width = width};
  drawing_.items.emplace_back(std::move(inner));
  const double bold = std::clamp(3.5 * width, 0.9, 1.8);
  drawing_.items.emplace_back(ToSegments(lists.boundary, {.color = kInk, .width = bold}));
  DrawConstrained(lists, bold);
}

void MeshPlotter::DrawConstrained(const EdgeLists& lists, double width) {
  if (lists.constrained.empty()) return;
  const bool one_tag = lists.constrained.front().first == lists.constrained.back().first;
  std::int64_t rank = 0;
  for (std::size_t i = 0; i < lists.constrained.size(); ++rank) {
    const std::int32_t tag = lists.constrained[i].first;
    std::vector<Edge> edges;
    for (; i < lists.constrained.size() && lists.constrained[i].first == tag; ++i) {
      edges.push_back(lists.constrained[i].second);
    }
    const Color color = one_tag ? kInk : CategoryColor(rank);
    drawing_.items.emplace_back(ToSegments(edges, {.color = color, .width = width}));
  }
}

void MeshPlotter::DrawEllipses() {
  if (!HasEllipses()) return;
  Shape shape{
      .path = {}, .fill = {}, .stroke = Stroke{.color = {0.80, 0.16, 0.22, 0.9}, .width = 0.7}};
  for (std::size_t i = 0; i < mesh_.points.size(); ++i) {
    const Metric& m = options_.metrics[i];
    const double determinant = Determinant(m);
    if (!(m.m11 > 0 && determinant > 0)) continue;
    // With M = L L', the points p + 1/2 inv(L') c of unit vectors c have distance 1/2 from p. The
    // columns of inv(L') are (1/l11, 0) and (-l21/l11, 1) / l22.
    const double l11 = std::sqrt(m.m11);
    const double l22 = std::sqrt(determinant) / l11;
    const Vec2 u = {0.5 / l11, 0};
    const Vec2 v = {-0.5 * m.m12 / (m.m11 * l22), 0.5 / l22};
    const Vec2 reach = {std::abs(u.x) + std::abs(v.x), std::abs(v.y)};
    const Vec2 p = mesh_.points[i];
    if (!view_.Sees(p - reach, p + reach)) continue;
    const auto scaled = [this](Vec2 e) { return Vec2{view_.scale.x * e.x, -view_.scale.y * e.y}; };
    shape.path.Ellipse(view_(p), scaled(u), scaled(v));
  }
  // Ellipses at the boundary reach beyond it, into titles.
  drawing_.items.emplace_back(BeginClip{.low = view_.low, .high = view_.high});
  drawing_.items.emplace_back(std::move(shape));
  drawing_.items.emplace_back(EndClip{});
}

void MeshPlotter::DrawScale() {
  const double left = drawing_.width - kScaleWidth + 4;
  const double height = std::min(200.0, view_.high.y - view_.low.y - 20);
  const double top = view_.low.y + 18;
  constexpr int kStepCount = 64;
  for (int i = 0; i < kStepCount; ++i) {
    Shape step{.path = {}, .fill = ScaleColor(1 - (i + 0.5) / kStepCount), .stroke = {}};
    const double y = top + height * i / kStepCount;
    // Each step reaches under the next one, so that no gap shows.
    const double end = std::min(y + 2 * height / kStepCount, top + height);
    step.path.Rectangle({left, y}, {left + 12, end});
    drawing_.items.emplace_back(std::move(step));
  }
  for (const double value : {0.0, 0.5, 1.0}) {
    drawing_.items.emplace_back(
        Text{.at = {left + 17, top + height * (1 - value) + 4}, .text = Label(value), .size = 11});
  }
  drawing_.items.emplace_back(
      Text{.at = {left, top - 8}, .text = options_.values_label, .size = 11});
}

void MeshPlotter::DrawTitles() {
  const double middle = 0.5 * (view_.low.x + view_.high.x);
  if (!options_.title.empty()) {
    drawing_.items.emplace_back(Text{.at = {middle, kMargin + 10},
                                     .text = options_.title,
                                     .size = 14,
                                     .anchor = Anchor::kMiddle,
                                     .weight = Weight::kBold});
  }
  if (!options_.caption.empty()) {
    // A letter is about 0.55 of its size wide; a narrow panel gets smaller ones.
    const double room = 2 * std::min(middle, drawing_.width - middle);
    const double fitting = room / (0.55 * static_cast<double>(options_.caption.size()));
    drawing_.items.emplace_back(Text{.at = {middle, drawing_.height - kMargin},
                                     .text = options_.caption,
                                     .size = std::min(12.0, fitting),
                                     .anchor = Anchor::kMiddle,
                                     .color = kFaintInk});
  }
}

}  // namespace

Drawing PlotMesh(const MeshData& mesh, const PlotOptions& options) {
  return MeshPlotter(mesh, options).Plot();
}

std::vector<double> TriangleQualities(const MeshData& mesh, std::span<const Metric> metrics) {
  constexpr double kThird = 1.0 / 3;
  const bool has_metrics = metrics.size() == mesh.points.size();
  std::vector<double> qualities;
  qualities.reserve(mesh.triangles.size());
  for (const auto& triangle : mesh.triangles) {
    std::array<Vec2, 3> p;
    Metric mean;
    if (has_metrics) mean = {0, 0, 0};
    for (std::size_t k = 0; k < 3; ++k) {
      const auto i = static_cast<std::size_t>(triangle[k]);
      p[k] = mesh.points[i];
      if (has_metrics) mean = mean + kThird * metrics[i];
    }
    const double area = NormalizedArea(p[0], mean, p[1], mean, p[2], mean);
    const double squares = SquaredLength(mean, p[1] - p[0]) + SquaredLength(mean, p[2] - p[1]) +
                           SquaredLength(mean, p[0] - p[2]);
    const double quality = 4 * std::sqrt(3.0) * area / squares;
    qualities.push_back(quality > 0 ? quality : 0);
  }
  return qualities;
}

std::string MeshCaption(const MeshData& mesh, std::span<const double> qualities) {
  std::string caption = WithThousands(std::to_string(mesh.points.size())) + " nodes, " +
                        WithThousands(std::to_string(mesh.triangles.size())) + " triangles";
  if (qualities.empty()) return caption;
  double sum = 0;
  for (const double quality : qualities) sum += quality;
  const double mean = sum / static_cast<double>(qualities.size());
  return caption + ", mean quality " + Label(std::round(1000 * mean) / 1000);
}

}  // namespace pliant::plot
