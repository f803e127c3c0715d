#pragma once

#include <cstdint>
#include <map>
#include <memory>

#include "tests/protocol/promises.h"
#include "tests/simulation/world.h"
#include "tests/support/mirror.h"

namespace pliant::simulation {

/// An editor written from proto/README.md alone, which sends up to five commands ahead of their
/// answers and repeats what has none. It edits the first session; others may take that over while
/// its connection is lost, and use the numbers that it has used.
class ImitatedEditor {
 public:
  explicit ImitatedEditor(World& world) : world_(world) {}

  void Act();
  void Receive();
  void Cancel();
  /// Its connection is gone.
  void Lose();
  /// Sends a last command. @return false as long as something has no answer
  bool Finish();

  [[nodiscard]] bool is_connected() const { return link_ != nullptr; }
  [[nodiscard]] const test::Mirror& mirror() const { return mirror_; }
  /// What it has seen, for the checkers of tests/protocol.
  [[nodiscard]] const test::Transcript& transcript() const { return transcript_; }
  [[nodiscard]] std::int64_t merged_count() const { return merged_count_; }
  [[nodiscard]] std::int64_t snapshot_count() const { return snapshot_count_; }
  [[nodiscard]] std::int64_t unfinished_count() const { return unfinished_count_; }
  [[nodiscard]] std::int64_t busy_count() const { return busy_count_; }

 private:
  void Connect();
  void Send(v1::EditRequest request);
  [[nodiscard]] v1::EditRequest RandomUpdate();
  void Take(const v1::EditResponse& response);

  World& world_;
  std::shared_ptr<EditLink> link_;
  bool is_open_ = false;
  test::Mirror mirror_;
  test::Transcript transcript_;
  std::int64_t last_update_id_ = 0;
  bool is_last_sent_ = false;
  std::map<std::int64_t, v1::EditRequest> unanswered_;
  std::int64_t merged_count_ = 0;
  std::int64_t snapshot_count_ = 0;
  std::int64_t unfinished_count_ = 0;
  std::int64_t busy_count_ = 0;
};

}  // namespace pliant::simulation
