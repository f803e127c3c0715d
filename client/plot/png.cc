#include "client/plot/png.h"

#include <cairo.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "client/plot/indexed_png.h"

namespace pliant::plot {
namespace {

constexpr double kPixelsMax = 32767;

struct Destroy {
  void operator()(cairo_surface_t* surface) const { cairo_surface_destroy(surface); }
  void operator()(cairo_t* cairo) const { cairo_destroy(cairo); }
};

/// True if the path is nothing but triangles, which touch but do not overlap.
bool IsTriangles(const Path& path) {
  for (std::size_t i = 0; i < path.verbs.size(); ++i) {
    if (path.verbs[i] != "MLLZ"[i % 4]) return false;
  }
  return path.verbs.size() % 4 == 0;
}

class CairoPainter {
 public:
  CairoPainter(cairo_t* cairo, double scale) : cairo_(cairo), scale_(scale) {}
  void operator()(const Shape& shape);
  void operator()(const Segments& segments);
  void operator()(const Text& text);
  void operator()(const BeginClip& clip);
  void operator()(const EndClip&) { cairo_restore(cairo_); }

 private:
  void Paint(const Shape& shape);
  void SetColor(Color c) { cairo_set_source_rgba(cairo_, c.r, c.g, c.b, c.a); }
  void SetStroke(const Stroke& stroke);
  void AddPath(const Path& path);
  [[nodiscard]] std::vector<std::array<Vec2, 2>> Distinct(
      const std::vector<std::array<Vec2, 2>>& lines) const;

  cairo_t* cairo_;
  double scale_;
};

void CairoPainter::operator()(const Shape& shape) {
  // Filling many separate triangles at once takes far longer than a few at a time. That is the same
  // picture only if no part shines through another one.
  constexpr std::size_t kManyVerbs = 2000;
  const bool is_opaque = (!shape.fill.has_value() || shape.fill->a == 1) &&
                         (!shape.stroke.has_value() || shape.stroke->color.a == 1);
  if (shape.path.verbs.size() < kManyVerbs || !is_opaque || !IsTriangles(shape.path)) {
    return Paint(shape);
  }
  constexpr std::size_t kTrianglesPerPart = 64;
  const std::size_t triangle_count = shape.path.points.size() / 3;
  for (std::size_t begin = 0; begin < triangle_count; begin += kTrianglesPerPart) {
    const std::size_t count = std::min(kTrianglesPerPart, triangle_count - begin);
    Shape part{.path = {}, .fill = shape.fill, .stroke = shape.stroke};
    part.path.verbs = shape.path.verbs.substr(0, 4 * count);
    const auto first = shape.path.points.begin() + static_cast<std::ptrdiff_t>(3 * begin);
    part.path.points.assign(first, first + static_cast<std::ptrdiff_t>(3 * count));
    Paint(part);
  }
}

void CairoPainter::Paint(const Shape& shape) {
  AddPath(shape.path);
  if (shape.fill.has_value()) {
    SetColor(*shape.fill);
    cairo_fill_preserve(cairo_);
  }
  if (shape.stroke.has_value()) {
    SetStroke(*shape.stroke);
    cairo_stroke_preserve(cairo_);
  }
  cairo_new_path(cairo_);
}

void CairoPainter::operator()(const Segments& segments) {
  SetStroke(segments.stroke);
  // Stroking many crossing lines at once takes far longer than a few at a time.
  constexpr std::size_t kLinesPerStroke = 64;
  std::size_t pending = 0;
  for (const auto& line : Distinct(segments.lines)) {
    cairo_move_to(cairo_, line[0].x, line[0].y);
    cairo_line_to(cairo_, line[1].x, line[1].y);
    if (++pending == kLinesPerStroke) {
      cairo_stroke(cairo_);
      pending = 0;
    }
  }
  cairo_stroke(cairo_);
}

std::vector<std::array<Vec2, 2>> CairoPainter::Distinct(
    const std::vector<std::array<Vec2, 2>>& lines) const {
  // Below this, drawing all is quick, and no line moves by even a quarter pixel.
  constexpr std::size_t kManyLines = 50000;
  if (lines.size() < kManyLines) return lines;
  const double step = 0.25 / scale_;
  const auto snap = [step](Vec2 p) {
    return Vec2{step * std::round(p.x / step), step * std::round(p.y / step)};
  };
  const auto before = [](Vec2 a, Vec2 b) { return a.x != b.x ? a.x < b.x : a.y < b.y; };
  std::vector<std::array<Vec2, 2>> distinct;
  distinct.reserve(lines.size());
  for (const auto& line : lines) {
    Vec2 a = snap(line[0]);
    Vec2 b = snap(line[1]);
    if (a == b) continue;
    if (before(b, a)) std::swap(a, b);
    distinct.push_back({a, b});
  }
  std::sort(distinct.begin(), distinct.end(), [before](const auto& x, const auto& y) {
    return x[0] == y[0] ? before(x[1], y[1]) : before(x[0], y[0]);
  });
  distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
  return distinct;
}

void CairoPainter::operator()(const Text& text) {
  cairo_save(cairo_);
  cairo_select_font_face(
      cairo_, "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL,
      text.weight == Weight::kBold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
  cairo_set_font_size(cairo_, text.size);
  cairo_text_extents_t extents;
  cairo_text_extents(cairo_, text.text.c_str(), &extents);
  const double share = text.anchor == Anchor::kStart ? 0 : text.anchor == Anchor::kMiddle ? 0.5 : 1;
  cairo_translate(cairo_, text.at.x, text.at.y);
  cairo_rotate(cairo_, -text.rotation_degrees * std::numbers::pi / 180);
  cairo_move_to(cairo_, -share * extents.x_advance, 0);
  SetColor(text.color);
  cairo_show_text(cairo_, text.text.c_str());
  cairo_new_path(cairo_);
  cairo_restore(cairo_);
}

void CairoPainter::operator()(const BeginClip& clip) {
  cairo_save(cairo_);
  cairo_rectangle(cairo_, clip.low.x, clip.low.y, clip.high.x - clip.low.x,
                  clip.high.y - clip.low.y);
  cairo_clip(cairo_);
}

void CairoPainter::SetStroke(const Stroke& stroke) {
  SetColor(stroke.color);
  cairo_set_line_width(cairo_, stroke.width);
}

void CairoPainter::AddPath(const Path& path) {
  const Vec2* p = path.points.data();
  for (const char verb : path.verbs) {
    if (verb == 'M') {
      cairo_move_to(cairo_, p->x, p->y);
    } else if (verb == 'L') {
      cairo_line_to(cairo_, p->x, p->y);
    } else if (verb == 'C') {
      cairo_curve_to(cairo_, p[0].x, p[0].y, p[1].x, p[1].y, p[2].x, p[2].y);
      p += 2;
    } else {
      cairo_close_path(cairo_);
      continue;
    }
    ++p;
  }
}

cairo_status_t AppendBytes(void* bytes, const unsigned char* data, unsigned int size) {
  static_cast<std::string*>(bytes)->append(reinterpret_cast<const char*>(data), size);
  return CAIRO_STATUS_SUCCESS;
}

Error CairoError(cairo_status_t status) {
  return {.code = ErrorCode::kResourceExhausted,
          .message = std::string("cannot draw the picture: ") + cairo_status_to_string(status)};
}

}  // namespace

Result<std::string> FormatPng(const Drawing& drawing, double scale) {
  const double width = std::ceil(drawing.width * scale);
  const double height = std::ceil(drawing.height * scale);
  if (!(width >= 1 && height >= 1 && width <= kPixelsMax && height <= kPixelsMax)) {
    return Error{.code = ErrorCode::kOutOfRange,
                 .message = "a picture of " + std::to_string(width) + " by " +
                            std::to_string(height) + " pixels cannot be drawn; 1 to 32767 can"};
  }
  const std::unique_ptr<cairo_surface_t, Destroy> surface(cairo_image_surface_create(
      CAIRO_FORMAT_RGB24, static_cast<int>(width), static_cast<int>(height)));
  if (const cairo_status_t status = cairo_surface_status(surface.get())) return CairoError(status);
  const std::unique_ptr<cairo_t, Destroy> cairo(cairo_create(surface.get()));
  cairo_set_source_rgb(cairo.get(), 1, 1, 1);
  cairo_paint(cairo.get());
  cairo_scale(cairo.get(), scale, scale);
  cairo_set_line_cap(cairo.get(), CAIRO_LINE_CAP_ROUND);
  cairo_set_line_join(cairo.get(), CAIRO_LINE_JOIN_ROUND);
  CairoPainter painter(cairo.get(), scale);
  for (const Item& item : drawing.items) std::visit(painter, item);
  if (const cairo_status_t status = cairo_status(cairo.get())) return CairoError(status);
  cairo_surface_flush(surface.get());
  const int row_bytes = cairo_image_surface_get_stride(surface.get());
  const int rows = cairo_image_surface_get_height(surface.get());
  const Pixels pixels{
      .bytes = {cairo_image_surface_get_data(surface.get()),
                static_cast<std::size_t>(row_bytes) * static_cast<std::size_t>(rows)},
      .row_bytes = row_bytes,
      .width = cairo_image_surface_get_width(surface.get()),
      .height = rows};
  if (std::optional<std::string> indexed = FormatIndexedPng(pixels)) return std::move(*indexed);
  std::string bytes;
  if (const auto status = cairo_surface_write_to_png_stream(surface.get(), AppendBytes, &bytes)) {
    return CairoError(status);
  }
  return bytes;
}

}  // namespace pliant::plot
