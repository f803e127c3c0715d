#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/mesh/mesh.h"
#include "core/transfer/field.h"
#include "core/transfer/transfer.h"

namespace pliant {

/// Values of one field at some elements, as a client sends them.
struct FieldValues {
  std::string name;  ///< 1 to 64 characters of [a-z0-9_].
  FieldLocation location = FieldLocation::kVertex;
  std::size_t column_count = 1;  ///< 1, 2 or 3.
  /// Slots of the last commit, ascending; nothing for all live elements in ascending order.
  std::optional<std::vector<std::int32_t>> ids = {};
  std::vector<double> values = {};  ///< Row after row.
};

/// Sets, changes or drops fields.
struct FieldUpdate {
  std::vector<FieldValues> values = {};
  /// How the fields named in `values` follow the mesh from now on; absent: as before, linear at
  /// first.
  std::optional<TransferKind> transfer = {};
  std::vector<std::string> dropped_names = {};
};

/// The solution fields of a session, as they were at the last commit, and what is staged for the
/// next one. At a commit the staged values are written first, because they belong to the elements
/// of the last one; then all fields are carried over to the new mesh.
///
/// *Invariants*: fields stand in ascending order of name. *Threads*: one at a time.
class FieldSet {
 public:
  /// Most fields of a session: bounds memory and the work of a commit.
  static constexpr std::size_t kFieldsMax = 64;

  /// Checks an update against the mesh of the last commit and keeps it for the next one.
  /// Errors, index = position in the given array: kOutOfRange (name, column_count), kArrayLength,
  /// kIndexOutOfRange (no live element), kDuplicateId (ids do not ascend), kNotFinite, kEmpty (some
  /// values of a field that is not there yet, or of another location or column count), kTooLarge
  /// (kFieldsMax). Nothing is staged then. @par Cost O(values sent)
  Status Stage(const Mesh& mesh, const FieldUpdate& update);
  /// True if something is staged.
  [[nodiscard]] bool staged() const { return !staged_.empty(); }
  /// Goes to the fields of another revision; what is staged is forgotten.
  void Restore(std::span<const Field> fields) {
    fields_.assign(fields.begin(), fields.end());
    staged_.clear();
  }
  /// Forgets what is staged.
  void Discard() { staged_.clear(); }

  /// Writes what is staged and carries the fields over.
  /// @par Cost  O(values staged + touched elements) a field
  FieldChanges Commit(const MeshTransfer& transfer);

  [[nodiscard]] std::span<const Field> fields() const { return fields_; }
  /// All values at some elements of the last commit, ascending: what a snapshot holds.
  /// @par Cost O(elements) a field
  [[nodiscard]] std::vector<FieldChange> At(std::span<const VertexId> vertices,
                                            std::span<const TriangleId> triangles) const;
  /// Null if there is none of that name.
  [[nodiscard]] const Field* Find(const std::string& name) const;
  /// True if a commit has nothing to do.
  [[nodiscard]] bool idle() const { return fields_.empty() && staged_.empty(); }
  /// True if a field, also a staged one, is conservative.
  [[nodiscard]] bool conserves() const;

 private:
  /// Slots of a field that a commit wrote, in any order, some twice.
  struct Written {
    std::string name;
    std::vector<std::int32_t> slots;
  };

  void Write(const Mesh& mesh, const FieldUpdate& update, std::vector<Written>& written);
  void Carry(const MeshTransfer& transfer, std::vector<Written>& written);
  Written& WrittenOf(const std::string& name, std::vector<Written>& written) const;

  std::vector<Field> fields_;
  std::vector<FieldUpdate> staged_;
};

}  // namespace pliant
