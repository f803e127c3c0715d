#include "client/plot/svg.h"

#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <string_view>

namespace pliant::plot {
namespace {

class SvgWriter {
 public:
  void Write(const Drawing& drawing);
  void operator()(const Shape& shape);
  void operator()(const Segments& segments);
  void operator()(const Text& text);
  void operator()(const BeginClip& clip);
  void operator()(const EndClip&) { out_ += "</g>\n"; }
  [[nodiscard]] std::string Take() && { return std::move(out_); }

 private:
  void Put(double value);
  void Put(Vec2 p) {
    Put(p.x);
    out_ += ' ';
    Put(p.y);
  }
  void PutPath(const Path& path);
  void PutColor(const char* attribute, Color color);
  void PutStroke(const Stroke& stroke);
  void PutEscaped(std::string_view text);

  std::string out_;
  int clip_count_ = 0;
};

void SvgWriter::Write(const Drawing& drawing) {
  out_ += "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"";
  Put(drawing.width);
  out_ += "\" height=\"";
  Put(drawing.height);
  out_ += "\" viewBox=\"0 0 ";
  Put({drawing.width, drawing.height});
  out_ +=
      "\" font-family=\"DejaVu Sans, Helvetica, Arial, sans-serif\" stroke-linecap=\"round\" "
      "stroke-linejoin=\"round\">\n<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n";
  for (const Item& item : drawing.items) std::visit(*this, item);
  out_ += "</svg>\n";
}

void SvgWriter::operator()(const Shape& shape) {
  out_ += "<path";
  if (shape.fill.has_value()) {
    PutColor("fill", *shape.fill);
  } else {
    out_ += " fill=\"none\"";
  }
  if (shape.stroke.has_value()) PutStroke(*shape.stroke);
  out_ += " d=\"";
  PutPath(shape.path);
  out_ += "\"/>\n";
}

void SvgWriter::operator()(const Segments& segments) {
  if (segments.lines.empty()) return;
  out_ += "<path fill=\"none\"";
  PutStroke(segments.stroke);
  out_ += " d=\"";
  for (const auto& line : segments.lines) {
    out_ += 'M';
    Put(line[0]);
    out_ += 'L';
    Put(line[1]);
  }
  out_ += "\"/>\n";
}

void SvgWriter::operator()(const Text& text) {
  out_ += "<text x=\"";
  Put(text.at.x);
  out_ += "\" y=\"";
  Put(text.at.y);
  out_ += "\" font-size=\"";
  Put(text.size);
  out_ += '"';
  if (text.weight == Weight::kBold) out_ += " font-weight=\"bold\"";
  if (text.anchor == Anchor::kMiddle) out_ += " text-anchor=\"middle\"";
  if (text.anchor == Anchor::kEnd) out_ += " text-anchor=\"end\"";
  PutColor("fill", text.color);
  if (text.rotation_degrees != 0) {
    out_ += " transform=\"rotate(";
    Put(-text.rotation_degrees);
    out_ += ' ';
    Put(text.at);
    out_ += ")\"";
  }
  out_ += '>';
  PutEscaped(text.text);
  out_ += "</text>\n";
}

void SvgWriter::operator()(const BeginClip& clip) {
  const std::string name = "clip" + std::to_string(clip_count_++);
  out_ += "<clipPath id=\"" + name + "\"><rect x=\"";
  Put(clip.low.x);
  out_ += "\" y=\"";
  Put(clip.low.y);
  out_ += "\" width=\"";
  Put(clip.high.x - clip.low.x);
  out_ += "\" height=\"";
  Put(clip.high.y - clip.low.y);
  out_ += "\"/></clipPath><g clip-path=\"url(#" + name + ")\">\n";
}

void SvgWriter::Put(double value) {
  std::array<char, 340> buffer;
  const double rounded = std::isfinite(value) ? std::round(value * 1000) / 1000 : 0;
  // Adding 0 turns -0 into 0.
  const auto result = std::to_chars(buffer.data(), buffer.data() + buffer.size(), rounded + 0.0,
                                    std::chars_format::fixed);
  out_.append(buffer.data(), static_cast<std::size_t>(result.ptr - buffer.data()));
}

void SvgWriter::PutPath(const Path& path) {
  std::size_t next = 0;
  for (const char verb : path.verbs) {
    out_ += verb;
    const std::size_t count = verb == 'C' ? 3 : (verb == 'Z' ? 0 : 1);
    for (std::size_t k = 0; k < count; ++k) {
      if (k > 0) out_ += ' ';
      Put(path.points[next++]);
    }
  }
}

void SvgWriter::PutColor(const char* attribute, Color color) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  out_ += ' ';
  out_ += attribute;
  out_ += "=\"#";
  for (const double part : {color.r, color.g, color.b}) {
    const auto byte = static_cast<std::size_t>(std::lround(part * 255));
    out_ += kDigits[byte / 16 % 16];
    out_ += kDigits[byte % 16];
  }
  out_ += '"';
  if (color.a == 1) return;
  out_ += ' ';
  out_ += attribute;
  out_ += "-opacity=\"";
  Put(color.a);
  out_ += '"';
}

void SvgWriter::PutStroke(const Stroke& stroke) {
  PutColor("stroke", stroke.color);
  out_ += " stroke-width=\"";
  Put(stroke.width);
  out_ += '"';
}

void SvgWriter::PutEscaped(std::string_view text) {
  for (const char c : text) {
    if (c == '&') {
      out_ += "&amp;";
    } else if (c == '<') {
      out_ += "&lt;";
    } else if (c == '>') {
      out_ += "&gt;";
    } else {
      // Control characters are not allowed in XML.
      out_ += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
    }
  }
}

}  // namespace

std::string FormatSvg(const Drawing& drawing) {
  SvgWriter writer;
  writer.Write(drawing);
  return std::move(writer).Take();
}

}  // namespace pliant::plot
