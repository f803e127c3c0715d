#include "core/metric/metric_functions.h"

#include <cmath>
#include <string>
#include <utility>
#include <variant>

#include "core/metric/intersected_field.h"
#include "core/metric/saved_field.h"
#include "core/metric/saved_spec.h"

namespace pliant {
namespace {

MetricSpec SpecOf(const PlainMetric& part, double time, const SizeBounds& bounds) {
  MetricSpec spec{.time = time, .bounds = bounds};
  std::visit([&](const auto& source) { spec.source = source; }, part);
  return spec;
}

Status CheckCounts(const FunctionsSpec& spec) {
  const std::size_t count = spec.parts.size();
  if (count == 0 || count > FunctionsSpec::kPartsMax) {
    return Error{.code = count == 0 ? ErrorCode::kEmpty : ErrorCode::kTooLarge,
                 .message = std::to_string(count) + " metrics beside tensors; expected 1 to " +
                            std::to_string(FunctionsSpec::kPartsMax),
                 .field = "metric.sources"};
  }
  if (spec.before_count <= count) return {};
  return Error{.code = ErrorCode::kOutOfRange,
               .message = std::to_string(spec.before_count) +
                          " metrics before the tensors; there "
                          "are " +
                          std::to_string(count),
               .field = "metric.sources"};
}

}  // namespace

MetricFunctions::MetricFunctions(FunctionsSpec spec, const SizeBounds& bounds,
                                 const BoundingBox& box)
    : spec_(std::move(spec)), bounds_(bounds), box_(box), hints_(spec_.parts.size()) {
  for (std::atomic<std::int32_t>& hint : hints_) hint = MetricField::kNoHint;
}

Result<std::shared_ptr<const MetricFunctions>> MetricFunctions::Make(FunctionsSpec spec,
                                                                     const SizeBounds& bounds,
                                                                     const BoundingBox& box,
                                                                     const StopSignal* stop) {
  PLIANT_RETURN_IF_ERROR(CheckCounts(spec));
  const std::shared_ptr<MetricFunctions> functions(
      new MetricFunctions(std::move(spec), bounds, box));
  const FunctionsSpec& kept = functions->spec_;
  for (std::size_t i = 0; i < kept.parts.size(); ++i) {
    auto made = MakeMetricField(SpecOf(kept.parts[i], kept.time, bounds), box, stop);
    if (!made.ok()) {
      Error error = made.error();
      const std::size_t source = i < kept.before_count ? i : i + 1;
      error.message = "metric.sources[" + std::to_string(source) + "]: " + std::move(error.message);
      return error;
    }
    functions->parts_.push_back(std::move(*made));
  }
  return std::shared_ptr<const MetricFunctions>(functions);
}

bool MetricFunctions::AreSame(const MetricFunctions* a, const MetricFunctions* b) {
  if (a == b) return true;
  return a != nullptr && b != nullptr && a->IsMadeFrom(b->spec_, b->bounds_) &&
         a->box_.low == b->box_.low && a->box_.high == b->box_.high;
}

void MetricFunctions::MeetEach(std::span<const Vec2> points, std::span<Metric> tensors) const {
  if (points.empty()) return;
  std::vector<Metric> finest;
  std::vector<Metric> answers(points.size());
  std::vector<std::int32_t> hints(points.size());
  const auto meet = [&](std::span<const Metric> metrics) {
    if (finest.empty()) {
      finest.assign(metrics.begin(), metrics.end());
      return;
    }
    for (std::size_t i = 0; i < finest.size(); ++i) finest[i] = Intersect(finest[i], metrics[i]);
  };
  for (std::size_t part = 0; part <= parts_.size(); ++part) {
    if (part == spec_.before_count) meet(tensors);
    if (part == parts_.size()) break;
    hints.assign(hints.size(), MetricField::kNoHint);
    hints.front() = hints_[part].load(std::memory_order_relaxed);
    parts_[part]->AtEach(points, hints, answers);
    hints_[part].store(hints.back(), std::memory_order_relaxed);
    meet(answers);
  }
  for (std::size_t i = 0; i < finest.size(); ++i) tensors[i] = Bound(finest[i], bounds_);
}

std::shared_ptr<MetricField> MetricFunctions::Over(std::shared_ptr<MetricField> tensors) const {
  std::vector<std::shared_ptr<MetricField>> all = parts_;
  all.insert(all.begin() + static_cast<std::ptrdiff_t>(spec_.before_count), std::move(tensors));
  return std::make_shared<IntersectedField>(std::move(all), bounds_, spec_.before_count);
}

Status MetricFunctions::status() const {
  for (const std::shared_ptr<MetricField>& part : parts_) {
    if (Status status = part->status(); !status.ok()) return status;
  }
  return {};
}

std::size_t MetricFunctions::bytes() const {
  std::size_t bytes = sizeof(*this);
  for (const std::shared_ptr<MetricField>& part : parts_) bytes += part->bytes();
  for (const PlainMetric& part : spec_.parts) {
    const auto* background = std::get_if<BackgroundMetric>(&part);
    if (background == nullptr) continue;
    bytes += background->mesh.points.size() * (sizeof(Vec2) + sizeof(Metric)) +
             background->mesh.triangles.size() * sizeof(background->mesh.triangles[0]);
  }
  return bytes;
}

void MetricFunctions::Save(ByteWriter& writer) const {
  const MetricSpec spec{
      .source = IntersectedMetric{spec_.parts}, .time = spec_.time, .bounds = bounds_};
  PutSpec(&spec, writer);
  writer.Put(static_cast<std::uint32_t>(spec_.before_count));
  for (const double number : {box_.low.x, box_.low.y, box_.high.x, box_.high.y}) writer.Put(number);
}

std::shared_ptr<const MetricFunctions> MetricFunctions::Read(ByteReader& reader) {
  std::optional<MetricSpec> spec = TakeSpec(reader);
  const auto before_count = reader.Take<std::uint32_t>();
  BoundingBox box{};
  bool is_finite = true;
  for (double* number : {&box.low.x, &box.low.y, &box.high.x, &box.high.y}) {
    *number = reader.Take<double>();
    is_finite = is_finite && std::isfinite(*number);
  }
  auto* intersected = spec ? std::get_if<IntersectedMetric>(&spec->source) : nullptr;
  if (reader.ok() && is_finite && intersected != nullptr) {
    auto made = Make(
        {.parts = std::move(intersected->parts), .before_count = before_count, .time = spec->time},
        spec->bounds, box);
    if (made.ok()) return *std::move(made);
  }
  reader.Fail();
  return nullptr;
}

}  // namespace pliant
