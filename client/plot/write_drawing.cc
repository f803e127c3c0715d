#include "client/plot/write_drawing.h"

#include "client/io/file.h"
#include "client/plot/png.h"
#include "client/plot/svg.h"

namespace pliant::plot {

Status WriteDrawing(const std::string& path, const Drawing& drawing, double dots_per_inch) {
  const std::string extension = io::Extension(path);
  if (extension == ".svg") return io::WriteFileAtomically(path, FormatSvg(drawing));
  if (extension == ".png") {
    PLIANT_ASSIGN_OR_RETURN(const std::string bytes, FormatPng(drawing, dots_per_inch / 96));
    return io::WriteFileAtomically(path, bytes);
  }
  return Error{
      .code = ErrorCode::kFileUnsupported,
      .message = path + ": pictures are written as .svg or .png, not as '" + extension + "'",
      .field = path};
}

}  // namespace pliant::plot
