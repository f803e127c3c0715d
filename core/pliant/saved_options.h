#pragma once

#include "core/base/bytes.h"
#include "core/pliant/options.h"

namespace pliant {

/// Options as bytes, for snapshots and revision records.
void WriteOptions(const Options& options, ByteWriter& writer);

/// Fails the reader unless CheckOptions accepts what it finds.
[[nodiscard]] Options ReadOptions(ByteReader& reader);

}  // namespace pliant
