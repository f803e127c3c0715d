#pragma once

#include <cstdint>
#include <memory>

#include "core/base/bytes.h"
#include "core/metric/gradation.h"
#include "core/metric/metric.h"
#include "core/metric/metric_field.h"

namespace pliant {

/// How the bytes of a field begin. Part of the format: add, never renumber.
enum class SavedFieldKind : std::uint8_t {
  kTensorExpression = 1,
  kSizeExpression = 2,
  kBackground = 3,
  kIntersected = 4,
};

/// What MetricField::Save of the fields of this library begins with.
void PutFieldKind(SavedFieldKind kind, ByteWriter& writer);

void PutBounds(const SizeBounds& bounds, ByteWriter& writer);
[[nodiscard]] SizeBounds TakeBounds(ByteReader& reader);

void PutGradation(const GradationOptions& gradation, ByteWriter& writer);
[[nodiscard]] GradationOptions TakeGradation(ByteReader& reader);

/// The field that MetricField::Save wrote: it answers every question with the same bits.
///
/// @return the field; null, and the reader fails, where the bytes cannot be one.
/// @par Cost O(bytes)
[[nodiscard]] std::shared_ptr<MetricField> ReadField(ByteReader& reader);

}  // namespace pliant
