// How a session serves calls such as GetMesh and GetQuality; see session.h.
#include <string>
#include <utility>

#include "server/session.h"

namespace pliant::server {

void Session::HandleCall(const SessionCall& call) {
  if (const Status there = Need(); !there.ok()) {
    call(there.error());
    return;
  }
  if (!engine_) {
    call(Error{ErrorCode::kSessionNotFound, "session " + session_id_ + " does not exist", {}});
    return;
  }
  const CommittedState state{engine_->engine(),
                             revision_,
                             applied_update_id_,
                             active_count_,
                             engine_->staged_count(),
                             summary_.value_or(MeshSummary{}),
                             this};
  if (revision_ == Revision::kNone) {
    call(Error{ErrorCode::kRevisionNotFound,
               "session " + session_id_ + " has no revision yet: advance it first", "revision"});
    return;
  }
  call(&state);
}

void Session::GoOn(SessionCallRest rest) { call_rest_ = std::move(rest); }

// Works on the call until it is answered (true) or the slice ends (false).
bool Session::ContinueCall(Clock::Time slice_end) {
  {
    const std::lock_guard lock(mutex_);
    last_used_ = environment_.clock->Now();
  }
  if (!call_rest_({}, slice_end)) return false;
  call_rest_ = nullptr;
  return true;
}

// What a call has begun to look at will be gone, or is not to be trusted.
void Session::EndCall(const Error& error) {
  if (const SessionCallRest rest = std::exchange(call_rest_, nullptr)) rest(error, {});
}

}  // namespace pliant::server
