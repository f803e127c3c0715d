#pragma once

#include <memory>

#include "core/pliant/loop.h"
#include "tests/support/cases.h"
#include "tests/support/mesh_testing.h"

namespace pliant::testing {

/// The mesh that the loop alone makes of a case: with vertices inside its walls, and open to edits.
[[nodiscard]] inline std::unique_ptr<EditedMesh> LoopMesh(Case from) {
  std::unique_ptr<EditedMesh> made = DomainMesh(from.domain);
  const Options options{.variant = Variant::kCooled};
  PliantLoop loop(made->edit, options);
  loop.BeginUpdate(SettingsOf(options));
  for (const VertexId id : testing::LiveVertices(made->mesh)) {
    std::int32_t hint = MetricField::kNoHint;
    made->edit.SetMetric(id, from.field->At(made->mesh.position(id), hint));
    loop.Wake(id);
  }
  (void)loop.Run(*from.field, {});
  return made;
}

}  // namespace pliant::testing
