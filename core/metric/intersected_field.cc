#include "core/metric/intersected_field.h"

#include <utility>

#include "core/base/check.h"
#include "core/metric/saved_field.h"

namespace pliant {

IntersectedField::IntersectedField(std::vector<std::shared_ptr<MetricField>> parts,
                                   const SizeBounds& bounds, std::size_t hinted)
    : parts_(std::move(parts)), hints_(parts_.size()), bounds_(bounds), hinted_(hinted) {
  PLIANT_CHECK(hinted_ < parts_.size());
  for (std::atomic<std::int32_t>& hint : hints_) hint = kNoHint;
}

/// `ask` answers for one part; nothing as soon as one has no answer.
template <class Ask>
std::optional<Metric> IntersectedField::Meet(Ask ask, std::int32_t& hint) const {
  const auto answer = [&](std::size_t i) {
    if (i == hinted_) return ask(*parts_[i], hint);
    std::int32_t near = hints_[i].load(std::memory_order_relaxed);
    const std::optional<Metric> metric = ask(*parts_[i], near);
    hints_[i].store(near, std::memory_order_relaxed);
    return metric;
  };
  std::optional<Metric> finest = answer(0);
  for (std::size_t i = 1; finest && i < parts_.size(); ++i) {
    const std::optional<Metric> metric = answer(i);
    if (!metric) return std::nullopt;
    finest = Intersect(*finest, *metric);
  }
  return finest ? std::optional(Bound(*finest, bounds_)) : std::nullopt;
}

Metric IntersectedField::At(Vec2 p, std::int32_t& hint) const {
  return *Meet(
      [p](const MetricField& part, std::int32_t& near) { return std::optional(part.At(p, near)); },
      hint);
}

std::optional<Metric> IntersectedField::Probe(Vec2 p, std::int32_t& hint) const {
  return Meet([p](const MetricField& part, std::int32_t& near) { return part.Probe(p, near); },
              hint);
}

Status IntersectedField::status() const {
  for (const std::shared_ptr<MetricField>& part : parts_) {
    if (Status status = part->status(); !status.ok()) return status;
  }
  return {};
}

Status IntersectedField::Save(ByteWriter& writer) const {
  PutFieldKind(SavedFieldKind::kIntersected, writer);
  PutBounds(bounds_, writer);
  writer.Put(static_cast<std::uint32_t>(parts_.size()));
  for (const std::shared_ptr<MetricField>& part : parts_) {
    PLIANT_RETURN_IF_ERROR(part->Save(writer));
  }
  return {};
}

std::size_t IntersectedField::bytes() const {
  std::size_t bytes = sizeof(*this);
  for (const std::shared_ptr<MetricField>& part : parts_) bytes += part->bytes();
  return bytes;
}

}  // namespace pliant
