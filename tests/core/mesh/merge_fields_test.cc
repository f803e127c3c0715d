#include "core/mesh/merge_fields.h"

#include <gtest/gtest.h>

#include <map>
#include <optional>
#include <set>

#include "core/base/rng.h"

namespace pliant {
namespace {

/// A replica of fields at vertices: values by name and slot.
using Model = std::map<std::string, std::map<std::int32_t, double>>;

void Apply(const MeshDiff& diff, Model& model) {
  for (const std::string& name : diff.fields.dropped_names) model.erase(name);
  for (const VertexId id : diff.removed_vertices) {
    for (auto& [name, values] : model) values.erase(id.value());
  }
  for (const FieldChange& field : diff.fields.changed) {
    for (std::size_t i = 0; i < field.rows.slots.size(); ++i) {
      model[field.name][field.rows.slots[i]] = field.rows.values[i];
    }
  }
}

/// A diff that removes some vertices and changes, makes or drops fields of `model`.
MeshDiff RandomDiff(const Model& model, Rng& rng) {
  MeshDiff diff;
  std::set<std::int32_t> removed;
  for (std::int32_t slot = 0; slot < 12; ++slot) {
    if (rng.Below(4) == 0) removed.insert(slot);
  }
  for (const std::int32_t slot : removed) diff.removed_vertices.emplace_back(slot);
  for (const char* name : {"a", "b", "c"}) {
    if (model.contains(name) && rng.Below(4) == 0) {
      diff.fields.dropped_names.emplace_back(name);
      continue;
    }
    if (rng.Below(3) == 0) continue;
    FieldChange change{.name = name, .rows = {}};
    for (std::int32_t slot = 0; slot < 12; ++slot) {
      if (removed.contains(slot) || rng.Below(2) == 0) continue;
      change.rows.slots.push_back(slot);
      change.rows.values.push_back(rng.Unit());
    }
    if (!change.rows.slots.empty()) diff.fields.changed.push_back(std::move(change));
  }
  return diff;
}

// Goal: one merged diff does to a replica what the two do one after the other.
TEST(MergeFields, DoesWhatTheTwoDoOneAfterTheOther) {
  Rng rng(8);
  for (int trial = 0; trial < 2000; ++trial) {
    Model base;
    Apply(RandomDiff({}, rng), base);
    const MeshDiff first = RandomDiff(base, rng);
    Model expected = base;
    Apply(first, expected);
    const MeshDiff second = RandomDiff(expected, rng);
    Apply(second, expected);
    MeshDiff merged;
    for (const MeshDiff* diff : {&first, &second}) {
      merged.removed_vertices.insert(merged.removed_vertices.end(), diff->removed_vertices.begin(),
                                     diff->removed_vertices.end());
    }
    merged.fields = MergeFields(first, second);
    Model model = base;
    // As a replica does: what is removed in between is written again where it came back.
    Apply(merged, model);
    for (auto* either : {&model, &expected}) {
      std::erase_if(*either, [](const auto& entry) { return entry.second.empty(); });
    }
    ASSERT_EQ(model, expected) << "trial " << trial;
    for (const FieldChange& field : merged.fields.changed) {
      ASSERT_TRUE(std::ranges::is_sorted(field.rows.slots));
    }
  }
}

TEST(MergeFields, TakesTheLaterShape) {
  MeshDiff first;
  first.fields.changed = {{.name = "a", .column_count = 1, .rows = {{1, 2}, {3, 4}}}};
  MeshDiff second;
  second.fields.changed = {{.name = "a", .column_count = 2, .rows = {{2}, {5, 6}}}};
  EXPECT_EQ(MergeFields(first, second), second.fields);
}

}  // namespace
}  // namespace pliant
