// PliantLoop, the part that ends an update, and its state between updates.

#include <utility>

#include "core/pliant/loop.h"

namespace pliant {

bool PliantLoop::Mend(Executor& executor) {
  PLIANT_CHECK(state_.queue.empty() && mender_.done());
  // The paper's loop has no such thing.
  if (options_.variant == Variant::kPaper) state_.mending = Mending::kDone;
  switch (state_.mending) {
    case Mending::kNotBegun:
      // Before the first commit everywhere, also where the metric never moved anything.
      if (mender_.Start(state_.epoch, edit_.committed() == Revision::kNone ? 0 : first_epoch_,
                        executor)) {
        state_.mending = Mending::kFirst;
      }
      return true;
    case Mending::kFirst:
      // As a later update would find them: those that the update has worn out get visits again.
      BeginUpdate(SettingsOf(options_));
      for (const VertexId node : mender_.TakeMoved()) {
        // A later update may have deleted what a mending that was cut short had moved.
        if (!mesh_.IsLive(node)) continue;
        star_.Gather(mesh_, node);
        PushRing(star_, 0);
      }
      state_.mending = Mending::kSettling;
      return true;
    case Mending::kSettling:
      // Settling has an epoch of its own, and nobody else has moved since the first mending.
      if (mender_.Start(state_.epoch - 1, state_.epoch, executor)) {
        state_.mending = Mending::kLast;
      }
      return true;
    case Mending::kLast:
      mender_.TakeMoved();
      state_.mending = Mending::kDone;
      return false;
    case Mending::kDone:
      return false;
  }
  PLIANT_CHECK(false, "mending");
}

void PliantLoop::MendNext(const MetricField& field) {
  const Mender::Mended mended = mender_.VisitNext(field);
  state_.counts.moves += mended.moves;
  state_.counts.swaps += mended.swaps;
  state_.counts.insertions += mended.insertions;
  state_.counts.mended += mended.moves + mended.swaps + mended.insertions;
}

PliantLoop::State PliantLoop::Save() const {
  State state = state_;
  state.options = options_;
  state.mender = mender_.state();
  return state;
}

void PliantLoop::SetOptions(const Options& options) {
  options_ = options;
  mender_.Permit(options.permissions);
  mender_.LimitVertices(options.vertices_max);
}

void PliantLoop::Restore(State state) {
  SetOptions(state.options);
  mender_.Restore(std::exchange(state.mender, {}));
  state_ = std::move(state);
  first_epoch_ = state_.epoch;
  left_behind_ = LeftBehind::kNothing;
  drifting_.clear();
  refined_ = false;
}

void PliantLoop::Renumber(std::span<const VertexId> new_ids) {
  state_.queue.Transform([&](VertexId old) { return new_ids[old.index()]; });
  mender_.Renumber(new_ids);
}

}  // namespace pliant
