#pragma once

#include <cairo.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "client/io/file.h"
#include "client/plot/svg.h"
#include "tests/client/io/support.h"

namespace pliant::plot {

/// A decoded picture: grey values 0 to 255, row by row.
struct Picture {
  int width = 0;
  int height = 0;
  std::vector<double> grey;

  [[nodiscard]] double at(double x, double y) const {
    return grey[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                static_cast<std::size_t>(x)];
  }
  [[nodiscard]] double Darkest() const {
    double darkest = 255;
    for (const double value : grey) darkest = std::min(darkest, value);
    return darkest;
  }
};

inline Picture Decode(const std::string& path) {
  cairo_surface_t* surface = cairo_image_surface_create_from_png(path.c_str());
  EXPECT_EQ(cairo_surface_status(surface), CAIRO_STATUS_SUCCESS) << path;
  Picture picture{.width = cairo_image_surface_get_width(surface),
                  .height = cairo_image_surface_get_height(surface),
                  .grey = {}};
  const unsigned char* data = cairo_image_surface_get_data(surface);
  const int stride = cairo_image_surface_get_stride(surface);
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      const unsigned char* pixel = data + y * stride + 4 * x;
      picture.grey.push_back((pixel[0] + pixel[1] + pixel[2]) / 3.0);
    }
  }
  cairo_surface_destroy(surface);
  return picture;
}

/// How often each element occurs in the SVG of a drawing, as Python's XML parser sees it:
/// "clipPath 1 g 1 path 4 rect 2 svg 1 text 3"; fails the test if it is not well-formed.
inline std::string CountElements(const Drawing& drawing) {
  const io::TemporaryFolder folder;
  const std::string path = folder.File("a.svg");
  EXPECT_TRUE(io::WriteFileAtomically(path, FormatSvg(drawing)).ok());
  return io::Shell(std::string(PLIANT_PYTHON) +
                   " -c \"import collections, xml.etree.ElementTree as e; "
                   "c = collections.Counter(x.tag.split('}')[1] for x in e.parse('" +
                   path +
                   "').iter()); print(*[v for k in sorted(c) for v in (k, c[k])], end='')\"");
}

}  // namespace pliant::plot
