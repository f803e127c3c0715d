#include "core/metric/expression_program.h"

#include <array>
#include <cmath>

#include "core/base/check.h"

namespace pliant {

void ExpressionProgram::Push(double constant) {
  Append({.code = Operator::kConstant, .constant = constant}, 0);
}

void ExpressionProgram::Apply(Operator op) {
  PLIANT_CHECK(op <= Operator::kNot);
  const bool is_variable = op <= Operator::kT;
  const bool is_unary = op == Operator::kNegate || op == Operator::kNot;

  // A constant exponent chooses its method once: Power would find the same one at every call.
  const bool follows_constant = code_.size() > barrier_ && code_.back().code == Operator::kConstant;
  if (op == Operator::kPower && follows_constant && depth_ >= 2) {
    const double exponent = code_.back().constant;
    if (exponent == std::floor(exponent) && std::abs(exponent) <= 64) {
      code_.pop_back();
      --depth_;
      const auto operand = static_cast<std::int32_t>(exponent);
      Append(
          {.code = operand == 2 ? Operator::kSquare : Operator::kIntegerPower, .operand = operand},
          1);
      return;
    }
  }
  Append({.code = op}, is_variable ? 0 : is_unary ? 1 : 2);
}

void ExpressionProgram::Call(const MathFunction& function, int argument_count) {
  Operator code = Operator::kCallFold;
  int expected = argument_count;
  if (function.unary != nullptr) {
    code = Operator::kCallUnary;
    expected = 1;
  } else if (function.binary != nullptr) {
    code = Operator::kCallBinary;
    expected = 2;
  } else if (function.ternary != nullptr) {
    code = Operator::kCallTernary;
    expected = 3;
  }
  if (argument_count != expected || argument_count < 1) valid_ = false;
  Append({.code = code, .operand = argument_count, .function = &function}, argument_count);
}

void ExpressionProgram::If() {
  Append({.code = Operator::kJumpIfZero}, 1);
  --depth_;
  branches_.push_back({.jump = code_.size() - 1, .depth = depth_, .in_else = false});
  barrier_ = code_.size();
}

void ExpressionProgram::Else() {
  if (!CloseBranch(false)) return;
  Branch& branch = branches_.back();
  // The jump over the else branch stands before the place where the condition's jump lands.
  code_.push_back({.code = Operator::kJump});
  code_[branch.jump].operand = static_cast<std::int32_t>(code_.size());
  branch.jump = code_.size() - 1;
  branch.in_else = true;
  depth_ = branch.depth;
  barrier_ = code_.size();
}

void ExpressionProgram::EndIf() {
  if (!CloseBranch(true)) return;
  code_[branches_.back().jump].operand = static_cast<std::int32_t>(code_.size());
  branches_.pop_back();
  barrier_ = code_.size();
}

bool ExpressionProgram::Finish() {
  if (depth_ != 1 || !branches_.empty()) valid_ = false;
  return valid_;
}

/// Adds an instruction that takes `popped` numbers and leaves one (If() takes that one back).
void ExpressionProgram::Append(Instruction instruction, int popped) {
  // Inside a branch, the numbers below it are not its own to take.
  const int floor = branches_.empty() ? 0 : branches_.back().depth;
  if (depth_ - popped < floor) valid_ = false;
  depth_ += 1 - popped;
  if (depth_ > kDepthMax) valid_ = false;
  code_.push_back(instruction);
  if (valid_ && popped > 0 && instruction.code != Operator::kJumpIfZero) FoldConstants(popped);
}

/// Replaces the last instruction by its value if its arguments are the constants before it. The
/// value is computed by the same code as ever, so that folding cannot change a result.
void ExpressionProgram::FoldConstants(int argument_count) {
  const auto length = static_cast<std::size_t>(argument_count) + 1;
  if (code_.size() < barrier_ + length) return;
  const std::span<const Instruction> tail = std::span(code_).last(length);
  for (const Instruction& argument : tail.first(length - 1)) {
    if (argument.code != Operator::kConstant) return;
  }
  const double value = Run(tail, {}, 0);
  code_.resize(code_.size() - length);
  code_.push_back({.code = Operator::kConstant, .constant = value});
}

/// Checks that the branch just ended left exactly one number.
bool ExpressionProgram::CloseBranch(bool in_else) {
  const bool closes = !branches_.empty() && branches_.back().in_else == in_else &&
                      depth_ == branches_.back().depth + 1;
  if (!closes) valid_ = false;
  return closes;
}

double ExpressionProgram::Evaluate(Vec2 p, double t) const {
  PLIANT_DCHECK(valid_);
  return Run(code_, p, t);
}

double ExpressionProgram::Run(std::span<const Instruction> code, Vec2 p, double t) {
  // `top` is the number on top; the others lie below it in memory. One slot more than the depth,
  // because the first push spills a `top` that means nothing.
  std::array<double, kDepthMax + 1> stack;
  double* below = stack.data();
  double top = 0;
  const Instruction* const begin = code.data();
  const Instruction* const end = begin + code.size();
  for (const Instruction* i = begin; i != end; ++i) {
    switch (i->code) {
      // clang-format off
      case Operator::kConstant: *below++ = top; top = i->constant; break;
      case Operator::kX: *below++ = top; top = p.x; break;
      case Operator::kY: *below++ = top; top = p.y; break;
      case Operator::kT: *below++ = top; top = t; break;
      // What most formulas mostly do, without asking twice what it is.
      case Operator::kAdd: top = *--below + top; break;
      case Operator::kSubtract: top = *--below - top; break;
      case Operator::kMultiply: top = *--below * top; break;
      case Operator::kDivide: top = *--below / top; break;
      case Operator::kSquare: top = top * top; break;
      case Operator::kNegate: top = -top; break;
      case Operator::kCallUnary: top = i->function->unary(top); break;
      // clang-format on
      case Operator::kCallFold: {
        const std::int32_t rest = i->operand - 1;
        below -= rest;
        if (rest == 0) break;
        double folded = below[0];
        for (std::int32_t k = 1; k < rest; ++k) folded = i->function->fold(folded, below[k]);
        top = i->function->fold(folded, top);
        break;
      }
      case Operator::kJumpIfZero: {
        const double condition = top;
        top = *--below;
        if (condition == 0) i = begin + i->operand - 1;
        break;
      }
      case Operator::kJump:
        i = begin + i->operand - 1;
        break;
      default: {
        const std::size_t count = ArgumentCount(i->code);
        below -= count - 1;
        top = count == 1   ? Compute(*i, top, 0, 0)
              : count == 2 ? Compute(*i, below[0], top, 0)
                           : Compute(*i, below[0], below[1], top);
        break;
      }
    }
  }
  return top;
}

}  // namespace pliant
