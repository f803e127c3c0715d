#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/base/bytes.h"
#include "core/transfer/field.h"

namespace pliant {

/// The fields of one revision, which nobody changes any more; null for none.
using SharedFields = std::shared_ptr<const std::vector<Field>>;

/// A copy to keep. @par Cost O(values)
[[nodiscard]] SharedFields KeepFields(std::span<const Field> fields);

/// What they take in memory.
[[nodiscard]] std::size_t BytesOf(const SharedFields& fields);

void WriteFields(const SharedFields& fields, ByteWriter& writer);

/// What WriteFields wrote, for a mesh with so many slots. The reader fails where it cannot be.
[[nodiscard]] SharedFields ReadFields(ByteReader& reader, std::int32_t vertex_slots,
                                      std::int32_t triangle_slots);

}  // namespace pliant
