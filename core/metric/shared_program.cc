#include "core/metric/shared_program.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "core/base/check.h"

namespace pliant {
namespace {

constexpr std::int32_t kVariableCount = 3;

using Block = SharedProgram::Block;
using Instruction = ExpressionProgram::Instruction;
using Operator = ExpressionProgram::Operator;

struct BlockArguments {
  const Block& a;
  const Block& b;
  const Block& c;
};

/// One operation on all numbers of a block. Those that CPUs have for several numbers at a time are
/// written out, so that they become such code; Compute says what each of them is.
void ComputeBlock(const Instruction& i, const BlockArguments& from, Block& to) {
  const Block& a = from.a;
  const Block& b = from.b;
  const Block& c = from.c;
  const auto each = [&](auto&& operation) {
    for (std::size_t k = 0; k < to.size(); ++k) to[k] = operation(a[k], b[k], c[k]);
  };
  switch (i.code) {
    // clang-format off
    case Operator::kAdd: each([](double l, double r, double) { return l + r; }); break;
    case Operator::kSubtract: each([](double l, double r, double) { return l - r; }); break;
    case Operator::kMultiply: each([](double l, double r, double) { return l * r; }); break;
    case Operator::kDivide: each([](double l, double r, double) { return l / r; }); break;
    case Operator::kNegate: each([](double x, double, double) { return -x; }); break;
    case Operator::kSquare: each([](double x, double, double) { return x * x; }); break;
    case Operator::kCallUnary:
      each([&](double x, double, double) { return i.function->unary(x); }); break;
    case Operator::kCallFold:
      each([&](double x, double y, double) { return i.function->fold(x, y); }); break;
    // clang-format on
    default:
      each([&](double x, double y, double z) { return ExpressionProgram::Compute(i, x, y, z); });
      break;
  }
}

}  // namespace

/// Goes through programs and gives every different value a number: variables from 0 on, then steps;
/// constants get negative ones, because it is not known before the end how many there are.
class SharedProgram::Builder {
 public:
  /// @return false if the program cannot be shared
  bool Add(const ExpressionProgram& program) {
    stack_.clear();
    for (const Instruction& instruction : program.code()) {
      switch (instruction.code) {
        case Operator::kX:
        case Operator::kY:
        case Operator::kT:
          stack_.push_back(static_cast<std::int32_t>(instruction.code));
          break;
        case Operator::kConstant:
          stack_.push_back(Constant(instruction.constant));
          break;
        case Operator::kJump:
        case Operator::kJumpIfZero:
          return false;
        case Operator::kCallFold:
          Fold(instruction);
          break;
        default:
          Combine(instruction, ExpressionProgram::ArgumentCount(instruction.code));
          break;
      }
    }
    PLIANT_CHECK(stack_.size() == 1);
    results_.push_back(stack_[0]);
    return kVariableCount + constants_.size() + steps_.size() <= kValuesMax;
  }

  SharedProgram Build() && {
    const auto constant_count = static_cast<std::int32_t>(constants_.size());
    const auto place = [&](std::int32_t value) {
      if (value < 0) return kVariableCount - 1 - value;
      return value < kVariableCount ? value : value + constant_count;
    };
    for (Step& step : steps_) std::ranges::transform(step.arguments, step.arguments.begin(), place);
    SharedProgram program;
    program.shares_ = steps_.size() < operation_count_;
    std::ranges::transform(results_, program.results_.begin(), place);
    program.result_count_ = results_.size();
    program.constants_ = std::move(constants_);
    program.steps_ = std::move(steps_);
    return program;
  }

 private:
  std::int32_t Constant(double value) {
    // By bits: 0 and -0 differ, and a NaN is itself.
    const auto [entry, is_new] = constant_numbers_.try_emplace(
        std::bit_cast<std::uint64_t>(value), -1 - static_cast<std::int32_t>(constants_.size()));
    if (is_new) constants_.push_back(value);
    return entry->second;
  }

  /// The value of an operation on numbered values.
  std::int32_t Value(const Instruction& instruction, const std::array<std::int32_t, 3>& arguments) {
    ++operation_count_;
    const Key key = {instruction.code, instruction.operand, instruction.function, arguments};
    const auto number = kVariableCount + static_cast<std::int32_t>(steps_.size());
    const auto [entry, is_new] = step_numbers_.try_emplace(key, number);
    if (is_new) steps_.push_back({instruction, arguments});
    return entry->second;
  }

  /// Replaces the upper `count` values of the stack by what the operation makes of them.
  void Combine(const Instruction& instruction, std::size_t count) {
    std::array<std::int32_t, 3> arguments = {};
    std::copy(stack_.end() - static_cast<std::ptrdiff_t>(count), stack_.end(), arguments.begin());
    stack_.resize(stack_.size() - count);
    stack_.push_back(Value(instruction, arguments));
  }

  /// One step for each argument after the first, from left to right.
  void Fold(const Instruction& instruction) {
    const auto count = static_cast<std::size_t>(instruction.operand);
    Instruction pair = instruction;
    pair.operand = 2;
    const std::size_t first = stack_.size() - count;
    std::int32_t folded = stack_[first];
    for (std::size_t i = first + 1; i < stack_.size(); ++i) {
      folded = Value(pair, {folded, stack_[i], 0});
    }
    stack_.resize(first);
    stack_.push_back(folded);
  }

  std::vector<std::int32_t> stack_;
  std::vector<double> constants_;
  std::vector<Step> steps_;
  std::vector<std::int32_t> results_;
  std::size_t operation_count_ = 0;
  std::map<std::uint64_t, std::int32_t> constant_numbers_;
  std::map<Key, std::int32_t> step_numbers_;
};

std::optional<SharedProgram> SharedProgram::Make(
    std::span<const ExpressionProgram* const> programs) {
  PLIANT_CHECK(programs.size() <= kResultsMax);
  Builder builder;
  for (const ExpressionProgram* program : programs) {
    if (!builder.Add(*program)) return std::nullopt;
  }
  return std::move(builder).Build();
}

std::array<double, SharedProgram::kResultsMax> SharedProgram::Evaluate(Vec2 p, double t) const {
  std::array<double, kValuesMax> values;
  values[0] = p.x;
  values[1] = p.y;
  values[2] = t;
  double* next = std::ranges::copy(constants_, values.begin() + kVariableCount).out;
  const auto value = [&](std::int32_t place) { return values[static_cast<std::size_t>(place)]; };
  for (const Step& step : steps_) {
    const auto& [a, b, c] = step.arguments;
    *next++ = ExpressionProgram::Compute(step.instruction, value(a), value(b), value(c));
  }
  std::array<double, kResultsMax> results = {};
  for (std::size_t i = 0; i < result_count_; ++i) results[i] = value(results_[i]);
  return results;
}

std::array<SharedProgram::Block, SharedProgram::kResultsMax> SharedProgram::EvaluateBlock(
    std::span<const Vec2> points, double t) const {
  std::array<Block, kValuesMax> values;
  // A block that is not full repeats its last point: every number that is computed with is defined.
  for (std::size_t i = 0; i < kBlockLength; ++i) {
    const Vec2 p = points[std::min(i, points.size() - 1)];
    values[0][i] = p.x;
    values[1][i] = p.y;
    values[2][i] = t;
  }
  std::size_t next = kVariableCount;
  for (const double constant : constants_) values[next++].fill(constant);
  const auto value = [&](std::int32_t place) -> const Block& {
    return values[static_cast<std::size_t>(place)];
  };
  for (const Step& step : steps_) {
    const auto& [a, b, c] = step.arguments;
    ComputeBlock(step.instruction, {value(a), value(b), value(c)}, values[next++]);
  }
  std::array<Block, kResultsMax> results = {};
  for (std::size_t i = 0; i < result_count_; ++i) results[i] = value(results_[i]);
  return results;
}

}  // namespace pliant
