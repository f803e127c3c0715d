#pragma once

#include <vector>

#include "core/base/ids.h"
#include "core/base/result.h"
#include "core/base/stop_signal.h"
#include "core/mesh/mesh_edit.h"
#include "core/pliant/options.h"

namespace pliant {

/// A change of the mesh that is not the loop's, such as a boundary that moves. Remesher carries it
/// out between two runs of the loop; who makes one lies in the layers above.
class MeshChange {
 public:
  /// What Remesher does afterwards.
  struct Outcome {
    /// Live vertices whose surroundings have changed: they wake. None twice.
    std::vector<VertexId> disturbed;
    /// Live vertices that lie elsewhere now: the metric is asked for there. None twice.
    std::vector<VertexId> moved;
    /// New vertices, which have no metric yet. None twice.
    std::vector<VertexId> created;
    /// Live vertices that brought their tensors along: the metric follows them. None twice and
    /// none of `moved`.
    std::vector<VertexId> carriers;
    /// Live vertices that go by the density around them, not by their extents alone
    /// (PliantLoop::Drift): those whose triangles were only stretched, which may happen again and
    /// again, and those inside segments that stand too close together. None twice.
    std::vector<VertexId> drifting;
    /// True if these went along with a front of the metric, and not with a body.
    bool follows_front = false;
  };

  virtual ~MeshChange() = default;

  /// True if the mesh will cover another domain, of which conservative fields know nothing yet.
  [[nodiscard]] virtual bool replaces_domain() const { return false; }

  /// What the session permits its loop; a change that it need not be asked for keeps to it too.
  virtual void Permit(const Permissions& /*permissions*/) {}

  /// Somebody who may want Apply to end before it is done, with the error of Stopped(): from the
  /// next Apply on. Null: nobody. Not owned.
  void ListenTo(const StopSignal* stop) { stop_ = stop; }

  /// Changes the mesh. On an error the caller undoes what was done; it may also undo what went
  /// well, to see whether it would, and ask again.
  virtual Result<Outcome> Apply(MeshEdit& edit) = 0;

 protected:
  [[nodiscard]] const StopSignal* stop() const { return stop_; }
  [[nodiscard]] bool stop_asked() const { return stop_ != nullptr && stop_->asked(); }

 private:
  const StopSignal* stop_ = nullptr;
};

}  // namespace pliant
