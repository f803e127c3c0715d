// What a session uses of its tenant's share; see session.h and tenant_account.h.
#include "server/session.h"

namespace pliant::server {

SessionUsage Session::Usage() const {
  if (!engine_) return {};
  const std::int64_t vertices = engine_->engine().vertex_count();
  return {.vertices = vertices,
          .bytes = vertices * kBytesPerVertex +
                   static_cast<std::int64_t>(history_.bytes() + undo_.bytes())};
}

void Session::ReportUsage() {
  const SessionUsage now = Usage();
  if (environment_.account != nullptr) environment_.account->Change(reported_, now);
  reported_ = now;
  const std::lock_guard lock(mutex_);
  info_.memory_bytes = now.bytes;
}

Status Session::CheckRoom(const SessionUsage& wanted) const {
  if (environment_.account == nullptr) return {};
  return environment_.account->CheckRoom(reported_, wanted);
}

Status Session::CheckCompute() const {
  if (environment_.account == nullptr) return {};
  return environment_.account->CheckCompute(environment_.clock->Now());
}

void Session::Charge(std::chrono::nanoseconds time) const {
  if (environment_.account == nullptr) return;
  environment_.account->Charge(time, environment_.clock->Now());
}

}  // namespace pliant::server
