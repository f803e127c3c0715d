#include "client/plot/mesh_plot.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/client/plot/support.h"

namespace pliant::plot {
namespace {

std::vector<const Segments*> SegmentsOf(const Drawing& drawing) {
  std::vector<const Segments*> all;
  for (const Item& item : drawing.items) {
    if (const Segments* segments = std::get_if<Segments>(&item)) all.push_back(segments);
  }
  return all;
}

const Shape* StrokedShape(const Drawing& drawing) {
  for (const Item& item : drawing.items) {
    const Shape* shape = std::get_if<Shape>(&item);
    if (shape != nullptr && !shape->fill.has_value()) return shape;
  }
  return nullptr;
}

double Width(const MeshData& mesh) {
  double low = INFINITY;
  double high = -INFINITY;
  for (const Vec2 p : mesh.points) {
    low = std::min(low, p.x);
    high = std::max(high, p.x);
  }
  return high - low;
}

/// Of a path of closed polygons; negative if they run clockwise.
double SignedArea(const Path& path) {
  double area = 0;
  std::size_t next = 0;
  std::size_t first = 0;
  for (const char verb : path.verbs) {
    if (verb == 'Z') {
      area += 0.5 * Cross(path.points[next - 1], path.points[first]);
      continue;
    }
    if (verb == 'M') {
      first = next;
    } else {
      area += 0.5 * Cross(path.points[next - 1], path.points[next]);
    }
    ++next;
  }
  return area;
}

/// The unit square as two triangles.
MeshData Square() {
  MeshData mesh;
  mesh.points = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

TEST(MeshPlot, DrawsEachEdgeOnceAndTheBoundaryBold) {
  const Drawing plain = PlotMesh(Square());
  const auto lists = SegmentsOf(plain);
  ASSERT_EQ(lists.size(), 2U);
  EXPECT_EQ(lists[0]->lines.size(), 1U);
  EXPECT_EQ(lists[1]->lines.size(), 4U);
  EXPECT_GT(lists[1]->stroke.width, lists[0]->stroke.width);
  // y points up in the mesh and down in the drawing.
  const auto& diagonal = lists[0]->lines[0];
  EXPECT_GT(diagonal[1].x, diagonal[0].x);
  EXPECT_LT(diagonal[1].y, diagonal[0].y);
}

TEST(MeshPlot, ColorsConstrainedEdgesByTag) {
  MeshData mesh = Square();
  mesh.edges = {{0, 2}, {1, 0}, {2, 1}};
  mesh.edge_tags = {5, 6, 6};
  const Drawing drawing = PlotMesh(mesh);
  const auto lists = SegmentsOf(drawing);
  ASSERT_EQ(lists.size(), 4U);
  EXPECT_EQ(lists[0]->lines.size(), 0U);
  EXPECT_EQ(lists[1]->lines.size(), 2U);
  EXPECT_EQ(lists[2]->lines.size(), 1U);
  EXPECT_EQ(lists[2]->stroke.color, CategoryColor(0));
  EXPECT_EQ(lists[3]->lines.size(), 2U);
  EXPECT_EQ(lists[3]->stroke.color, CategoryColor(1));
}

// Goal: the ellipse around a vertex is where the distance to it is 1/2.
// Method: its curve points, mapped back, have metric length 1/2; and its half-axes are half the
// radii of a metric with known axes.
TEST(MeshPlot, EllipsesHaveTheRadiusOneHalf) {
  const double c = std::sqrt(3.0) / 2;
  const double s = 0.5;
  const double a = 1 / (0.4 * 0.4);
  const double b = 1 / (0.1 * 0.1);
  const Metric metric = {a * c * c + b * s * s, (a - b) * c * s, a * s * s + b * c * c};
  MeshData mesh = Square();
  PlotOptions options{.width = 300, .height = 300};
  options.ellipses = Ellipses::kShow;
  options.metrics.assign(4, metric);
  const Drawing drawing = PlotMesh(mesh, options);
  const Shape* ellipses = StrokedShape(drawing);
  ASSERT_NE(ellipses, nullptr);
  ASSERT_EQ(ellipses->path.points.size(), 4U * 13);
  const auto& points = ellipses->path.points;
  const Vec2 center = 0.5 * (points[0] + points[6]);
  double longest = 0;
  double shortest = INFINITY;
  for (std::size_t curve = 0; curve < 4; ++curve) {
    const Vec2* p = points.data() + 3 * curve;
    for (int i = 0; i <= 200; ++i) {
      const double t = i / 200.0;
      const double r = 1 - t;
      const Vec2 on =
          r * r * r * p[0] + 3 * r * r * t * p[1] + 3 * r * t * t * p[2] + t * t * t * p[3];
      const Vec2 e = {(on.x - center.x) / 300, -(on.y - center.y) / 300};
      EXPECT_NEAR(std::sqrt(SquaredLength(metric, e)), 0.5, 2e-4);
      longest = std::max(longest, Length(e));
      shortest = std::min(shortest, Length(e));
    }
  }
  EXPECT_NEAR(longest, 0.2, 1e-4);
  EXPECT_NEAR(shortest, 0.05, 1e-4);
}

TEST(MeshPlot, WindowShowsOnlyWhatIsInside) {
  const MeshData mesh = io::GridMesh(20, /*seed=*/1);
  PlotOptions options{.width = 400, .height = 200};
  options.window = BoundingBox{{4, 2}, {6, 3}};
  options.fit = WindowFit::kStretch;
  const Drawing drawing = PlotMesh(mesh, options);
  const auto lists = SegmentsOf(drawing);
  EXPECT_GT(lists[0]->lines.size(), 10U);
  EXPECT_LT(lists[0]->lines.size(), 100U);
  // Stretched: the window is 2 by 1 and the panel too, plus the margins for axes.
  EXPECT_NEAR(drawing.width, 400 + 88, 1);
  EXPECT_EQ(CountElements(drawing).substr(0, 14), "clipPath 1 g 1");
}

TEST(MeshPlot, EqualScalesKeepTheShape) {
  MeshData mesh = Square();
  for (Vec2& p : mesh.points) p.x *= 4;
  const auto extent = [](const Drawing& drawing) {
    const auto& diagonal = SegmentsOf(drawing)[0]->lines[0];
    return diagonal[1] - diagonal[0];
  };
  const Vec2 equal = extent(PlotMesh(mesh, {.width = 400, .height = 400}));
  EXPECT_NEAR(equal.x, 400, 1e-9);
  EXPECT_NEAR(equal.y, -100, 1e-9);
  const Vec2 stretched =
      extent(PlotMesh(mesh, {.width = 400, .height = 300, .fit = WindowFit::kStretch}));
  EXPECT_NEAR(stretched.x, 400, 1e-9);
  EXPECT_NEAR(stretched.y, -300, 1e-9);
}

TEST(MeshPlot, FillsByRegionOrQuality) {
  const MeshData mesh = io::GridMesh(4, /*seed=*/1);
  const auto filled_count = [](const Drawing& drawing) {
    std::size_t count = 0;
    for (const Item& item : drawing.items) {
      const Shape* shape = std::get_if<Shape>(&item);
      if (shape != nullptr && shape->fill.has_value()) {
        count += static_cast<std::size_t>(
            std::count(shape->path.verbs.begin(), shape->path.verbs.end(), 'Z'));
      }
    }
    return count;
  };
  // Each of the two regions is one outline.
  EXPECT_EQ(filled_count(PlotMesh(mesh)), 2U);
  EXPECT_EQ(filled_count(PlotMesh(mesh, {.fill = Fill::kNone})), 0U);
  PlotOptions by_quality{.fill = Fill::kValues};
  by_quality.triangle_values = TriangleQualities(mesh, {});
  // And 64 steps of the scale beside it.
  EXPECT_EQ(filled_count(PlotMesh(mesh, by_quality)), 32U + 64U);
}

// Goal: the outline of a region has the area of its triangles, also around holes and where loops
// touch at a point.
// Method: a 5 by 5 board of squares whose tags are drawn at random; the shoelace formula.
TEST(MeshPlot, RegionOutlinesHaveTheAreaOfTheirTriangles) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    MeshData mesh = io::GridMesh(5, seed);
    Rng rng(seed);
    for (std::int32_t& tag : mesh.triangle_tags) tag = static_cast<std::int32_t>(rng.Below(3));
    std::array<double, 3> expected{};
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      const auto& t = mesh.triangles[i];
      const auto point = [&mesh, &t](std::size_t k) {
        return mesh.points[static_cast<std::size_t>(t[k])];
      };
      expected[static_cast<std::size_t>(mesh.triangle_tags[i])] +=
          0.5 * Cross(point(1) - point(0), point(2) - point(0));
    }
    const Drawing drawing = PlotMesh(mesh, {.width = 100, .height = 100});
    const double scale = (drawing.width - 24) / Width(mesh);
    for (std::size_t r = 0; r < 3; ++r) {
      EXPECT_NEAR(SignedArea(std::get<Shape>(drawing.items[r]).path) / (scale * scale),
                  -expected[r], 1e-9);
    }
  }
}

TEST(MeshPlot, NothingAndOnePointHaveAPictureToo) {
  EXPECT_GT(PlotMesh({}).width, 0);
  MeshData point;
  point.points = {{5, 5}};
  EXPECT_EQ(CountElements(PlotMesh(point)).substr(0, 4), "rect");
}

TEST(MeshPlot, QualityIsOneForTheWantedTriangle) {
  MeshData mesh;
  mesh.points = {{0, 0}, {1, 0}, {0.5, std::sqrt(3.0) / 2}, {0.5, -1}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 1}};
  EXPECT_NEAR(TriangleQualities(mesh, {})[0], 1, 1e-15);
  EXPECT_EQ(TriangleQualities(mesh, {})[1], 0);
  // Stretched by 10 along x, it is what the metric wants that is stretched so too.
  for (Vec2& p : mesh.points) p.x *= 10;
  const std::vector<Metric> metrics(4, Metric{0.01, 0, 1});
  EXPECT_NEAR(TriangleQualities(mesh, metrics)[0], 1, 1e-14);
  EXPECT_LT(TriangleQualities(mesh, {})[0], 0.4);
}

TEST(MeshPlot, CaptionCountsInThousands) {
  MeshData mesh;
  mesh.points.resize(1234567);
  mesh.triangles.resize(925);
  EXPECT_EQ(MeshCaption(mesh, {}), "1,234,567 nodes, 925 triangles");
  const std::vector<double> qualities = {0.9, 0.9514};
  EXPECT_EQ(MeshCaption(mesh, qualities), "1,234,567 nodes, 925 triangles, mean quality 0.926");
}

}  // namespace
}  // namespace pliant::plot
