#include "core/pliant/saved_options.h"

#include <cstdint>

#include "core/pliant/check_options.h"

namespace pliant {

void WriteOptions(const Options& options, ByteWriter& writer) {
  writer.Put(static_cast<std::uint8_t>(options.variant));
  writer.Put(static_cast<std::uint8_t>(options.smoothing));
  const Permissions& may = options.permissions;
  writer.Put(static_cast<std::uint8_t>((may.insert ? 1 : 0) | (may.swap ? 2 : 0) |
                                       (may.move ? 4 : 0) | (may.surface ? 8 : 0)));
  writer.Put(options.seed);
  writer.Put(options.step);
  writer.Put(options.speed_threshold);
  writer.Put(options.age_cooling);
  writer.Put(options.age_max);
  writer.Put(options.hops_max);
  writer.Put(options.metric_tolerance);
  writer.Put(options.vertices_max);
  writer.Put(options.visits_per_vertex_max);
  writer.Put(options.boundary_tolerance);
}

Options ReadOptions(ByteReader& reader) {
  Options options;
  const auto variant = reader.Take<std::uint8_t>();
  const auto smoothing = reader.Take<std::uint8_t>();
  const auto may = reader.Take<std::uint8_t>();
  if (variant > static_cast<std::uint8_t>(Variant::kPaper) ||
      smoothing > static_cast<std::uint8_t>(Smoothing::kBubble) || may > 15) {
    reader.Fail();
  }
  options.variant = static_cast<Variant>(variant);
  options.smoothing = static_cast<Smoothing>(smoothing);
  options.permissions = {(may & 1) != 0, (may & 2) != 0, (may & 4) != 0, (may & 8) != 0};
  options.seed = reader.Take<std::uint64_t>();
  options.step = reader.Take<double>();
  options.speed_threshold = reader.Take<double>();
  options.age_cooling = reader.Take<std::int32_t>();
  options.age_max = reader.Take<std::int32_t>();
  options.hops_max = reader.Take<std::int32_t>();
  options.metric_tolerance = reader.Take<double>();
  options.vertices_max = reader.Take<std::int32_t>();
  options.visits_per_vertex_max = reader.Take<std::int32_t>();
  options.boundary_tolerance = reader.Take<double>();
  if (!CheckOptions(options).ok()) reader.Fail();
  return options;
}

}  // namespace pliant
