#pragma once

#include <optional>

#include "core/mesh/change_log.h"
#include "core/mesh/mesh.h"
#include "core/transfer/region_locator.h"
#include "core/transfer/touched_region.h"
#include "core/transfer/transfer_rows.h"

namespace pliant {

/// What a commit needs to carry values from the old mesh to the new one: the touched region of
/// both, a way to find new points in the old, and the transfer rows. To be made before the change
/// log is emptied.
/// *Threads*: one at a time. @par Cost O(k log k) for k touched elements.
class MeshTransfer {
 public:
  /// @param mesh, log  of one MeshEdit, after its first commit; must outlive this.
  MeshTransfer(const Mesh& mesh, const ChangeLog& log)
      : old_(mesh, log), region_(GatherTouchedRegion(old_)) {
    if (region_.before.triangles.empty()) return;
    locator_.emplace(region_);
    rows_ = MakeTransferRows(old_, region_, *locator_);
  }
  MeshTransfer(const MeshTransfer&) = delete;
  MeshTransfer& operator=(const MeshTransfer&) = delete;

  /// True if no triangle changed.
  [[nodiscard]] bool empty() const { return !locator_.has_value(); }
  [[nodiscard]] const OldMesh& old() const { return old_; }
  [[nodiscard]] const TouchedRegion& region() const { return region_; }
  /// @pre !empty()
  [[nodiscard]] const RegionLocator& locator() const { return *locator_; }
  [[nodiscard]] const TransferRows& rows() const { return rows_; }

 private:
  OldMesh old_;
  TouchedRegion region_;
  std::optional<RegionLocator> locator_;
  TransferRows rows_;
};

}  // namespace pliant
