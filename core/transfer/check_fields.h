#pragma once

#include <span>

#include "core/base/result.h"
#include "core/mesh/mesh.h"
#include "core/transfer/field.h"
#include "core/transfer/field_set.h"

namespace pliant {

/// What is wrong with an update of these fields on the mesh of the last commit; see
/// FieldSet::Stage. @par Cost O(values sent)
[[nodiscard]] Status CheckFieldUpdate(const Mesh& mesh, std::span<const Field> fields,
                                      const FieldUpdate& update);

/// The elements that were live at the last commit, ascending.
[[nodiscard]] std::vector<std::int32_t> CommittedSlots(const Mesh& mesh, FieldLocation location);

}  // namespace pliant
