#include "client/plot/png.h"

#include <gtest/gtest.h>

#include <chrono>

#include "client/plot/chart.h"
#include "client/plot/mesh_plot.h"
#include "client/plot/write_drawing.h"
#include "tests/client/plot/support.h"

namespace pliant::plot {
namespace {

TEST(Png, HasTheRightSizeAndIsNotBlank) {
  const io::TemporaryFolder folder;
  Drawing drawing{.width = 50.5, .height = 20, .items = {}};
  Shape shape{.path = {}, .fill = kInk, .stroke = {}};
  shape.path.Rectangle({10, 5}, {20, 15});
  drawing.items = {BeginClip{{0, 0}, {15, 20}}, shape, EndClip{}};
  ASSERT_TRUE(WriteDrawing(folder.File("a.png"), drawing).ok());
  const Picture picture = Decode(folder.File("a.png"));
  EXPECT_EQ(picture.width, 101);
  EXPECT_EQ(picture.height, 40);
  EXPECT_LT(picture.at(25, 20), 50);   // Inside the rectangle and the clip.
  EXPECT_EQ(picture.at(35, 20), 255);  // Inside the rectangle, outside the clip.
  EXPECT_EQ(picture.at(5, 5), 255);
}

TEST(Png, RefusesSizesThatCannotBeDrawn) {
  EXPECT_EQ(FormatPng({}).error().code, ErrorCode::kOutOfRange);
  EXPECT_EQ(FormatPng({.width = 20000, .height = 1, .items = {}}).error().code,
            ErrorCode::kOutOfRange);
}

// Goal: PNG and SVG show the same picture.
// Method: librsvg draws the SVG; the pictures may differ in the shades along edges only.
TEST(Png, LooksLikeTheSvg) {
  const io::TemporaryFolder folder;
  const MeshData mesh = io::GridMesh(8, /*seed=*/2);
  PlotOptions options{.width = 300, .height = 300, .title = "A mesh", .caption = "a < b"};
  options.window = BoundingBox{{0.5, 0.5}, {6, 2}};
  options.metrics.assign(mesh.points.size(), Metric{3, 1, 8});
  options.ellipses = Ellipses::kShow;
  const std::vector<std::int64_t> counts = {1, 5, 9, 3};
  const Drawing drawing = Beside(
      {PlotMesh(mesh, options), PlotQuality({.angle_counts = counts, .length_counts = counts})});
  ASSERT_TRUE(WriteDrawing(folder.File("a.png"), drawing).ok());
  ASSERT_TRUE(WriteDrawing(folder.File("a.svg"), drawing).ok());
  io::Shell(std::string(PLIANT_RSVG) + " -z 2 " + folder.File("a.svg") + " -o " +
            folder.File("b.png"));
  const Picture ours = Decode(folder.File("a.png"));
  const Picture theirs = Decode(folder.File("b.png"));
  EXPECT_LT(ours.Darkest(), 60);
  ASSERT_NEAR(ours.width, theirs.width, 1);
  ASSERT_NEAR(ours.height, theirs.height, 1);
  double difference = 0;
  double ink = 0;
  const int width = std::min(ours.width, theirs.width);
  const int height = std::min(ours.height, theirs.height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      difference += std::abs(ours.at(x, y) - theirs.at(x, y));
      ink += 255 - ours.at(x, y);
    }
  }
  EXPECT_LT(difference, 0.08 * ink);
}

// Goal: a mesh far finer than the picture is drawn in seconds and looks grey, not white.
TEST(Png, DrawsLargeMeshesQuickly) {
  const io::TemporaryFolder folder;
  const MeshData mesh = io::GridMesh(400, /*seed=*/2);
  const auto start = std::chrono::steady_clock::now();
  ASSERT_TRUE(WriteDrawing(folder.File("a.png"), PlotMesh(mesh)).ok());
  const std::chrono::duration<double> time = std::chrono::steady_clock::now() - start;
  EXPECT_LT(time.count(), 20) << "about 2 s when alone on a machine of 2020";
  const Picture picture = Decode(folder.File("a.png"));
  double sum = 0;
  for (int i = -50; i < 50; ++i) {
    for (int j = -50; j < 50; ++j) sum += picture.at(picture.width / 2 + i, picture.height / 2 + j);
  }
  EXPECT_LT(sum / 10000, 220);
}

}  // namespace
}  // namespace pliant::plot
