#include "client/plot/write_drawing.h"

#include <gtest/gtest.h>

#include "tests/client/plot/support.h"

namespace pliant::plot {
namespace {

TEST(WriteDrawing, TakesTheFormatFromTheExtension) {
  const io::TemporaryFolder folder;
  const Drawing drawing{.width = 4, .height = 3, .items = {}};
  ASSERT_TRUE(WriteDrawing(folder.File("a.PNG"), drawing).ok());
  ASSERT_TRUE(WriteDrawing(folder.File("a.svg"), drawing).ok());
  EXPECT_EQ(io::ReadFile(folder.File("a.PNG")).value().substr(1, 3), "PNG");
  EXPECT_EQ(io::ReadFile(folder.File("a.svg")).value().substr(0, 4), "<svg");
}

TEST(WriteDrawing, NamesTheCauseOfAFailure) {
  const io::TemporaryFolder folder;
  const Drawing drawing{.width = 4, .height = 3, .items = {}};
  EXPECT_EQ(WriteDrawing(folder.File("a.pdf"), drawing).error().code, ErrorCode::kFileUnsupported);
  EXPECT_EQ(WriteDrawing(folder.File("none/a.svg"), drawing).error().code,
            ErrorCode::kFileUnwritable);
  EXPECT_EQ(WriteDrawing(folder.File("a.png"), {}).error().code, ErrorCode::kOutOfRange);
}

}  // namespace
}  // namespace pliant::plot
