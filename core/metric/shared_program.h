#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <tuple>
#include <vector>

#include "core/geometry/vec2.h"
#include "core/metric/expression_program.h"

namespace pliant {

/// Expressions that are asked for together, as one list of operations in which what they have in
/// common is computed once: the entries of a tensor mostly repeat each other.
///
/// *Invariants*: results have the bits of ExpressionProgram::Evaluate, because the same operations
/// are done on the same numbers.
/// *Threads*: immutable.
class SharedProgram {
 public:
  static constexpr std::size_t kResultsMax = 3;
  /// Most different values, which bounds the scratch memory of Evaluate.
  static constexpr std::size_t kValuesMax = 512;
  /// Points of one block: enough to pay for finding out what a step does, few enough that what is
  /// computed for a usual formula stays in the fastest cache.
  static constexpr std::size_t kBlockLength = 16;
  /// A number for each point of a block.
  using Block = std::array<double, kBlockLength>;

  /// Nothing if there are more different values; or where what is computed depends on the point: a
  /// program with a condition does only one of its branches.
  /// @param programs  finished, at most kResultsMax.
  [[nodiscard]] static std::optional<SharedProgram> Make(
      std::span<const ExpressionProgram* const> programs);

  /// One number for each program, in order, and 0 for those that there are not. No allocation.
  [[nodiscard]] std::array<double, kResultsMax> Evaluate(Vec2 p, double t) const;

  /// The same at several points at once: entry i of a block belongs to point i, those beyond the
  /// last point mean nothing. @pre 1 <= points.size() <= kBlockLength
  [[nodiscard]] std::array<Block, kResultsMax> EvaluateBlock(std::span<const Vec2> points,
                                                             double t) const;

  /// True if something is computed once instead of several times. If not, one stack for each
  /// program gives a single point's answer faster.
  [[nodiscard]] bool shares() const { return shares_; }

  /// Operations of one evaluation.
  [[nodiscard]] std::size_t size() const { return steps_.size(); }

 private:
  using Instruction = ExpressionProgram::Instruction;
  using Operator = ExpressionProgram::Operator;

  /// Computes one value from others, named by their places.
  struct Step {
    Instruction instruction;
    std::array<std::int32_t, 3> arguments = {};
  };
  using Key = std::tuple<Operator, std::int32_t, const MathFunction*, std::array<std::int32_t, 3>>;
  class Builder;

  SharedProgram() = default;

  // Values: x, y and t, then the constants, then what the steps compute, in order.
  std::vector<double> constants_;
  std::vector<Step> steps_;
  std::array<std::int32_t, kResultsMax> results_ = {};
  std::size_t result_count_ = 0;
  bool shares_ = false;
};

}  // namespace pliant
