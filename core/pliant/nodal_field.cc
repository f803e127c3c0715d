#include "core/pliant/nodal_field.h"

namespace pliant {

Metric NodalField::At(Vec2 p, std::int32_t& hint) const { return Exp(mesh_->LogAt(p, hint)); }

void NodalField::ProbeLogEach(std::span<LogQuestion> questions) const {
  for (LogQuestion& one : questions) one.answer = mesh_->LogAt(one.place, one.hint);
}

}  // namespace pliant
