#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/vec2.h"
#include "core/metric/math_functions.h"

namespace pliant {

/// An expression as a list of operations on a stack of numbers, built from its reverse Polish
/// notation and checked while it is built: an accepted program cannot leave its stack.
///
/// *Invariants*: after Finish() returned true, Evaluate needs at most kDepthMax values and ends
/// with exactly one.
/// *Threads*: Evaluate from as many as you like.
class ExpressionProgram {
 public:
  /// What one step of a program does: first the variables, and the operators that take their
  /// arguments from the stack, for Apply; then what the other functions make.
  enum class Operator : std::uint8_t {
    kX,
    kY,
    kT,
    kAdd,
    kSubtract,
    kMultiply,
    kDivide,
    kPower,
    kLess,
    kLessEqual,
    kGreater,
    kGreaterEqual,
    kEqual,
    kNotEqual,
    kAnd,
    kOr,
    kNegate,
    kNot,
    kConstant,
    kSquare,
    kIntegerPower,
    kCallUnary,
    kCallBinary,
    kCallTernary,
    kCallFold,
    kJumpIfZero,
    kJump,
  };

  /// Most numbers on the stack: bounds the scratch memory of Evaluate.
  static constexpr int kDepthMax = 256;

  // The tape in the order of reverse Polish notation. `condition ? a : b` is: condition, If(), a,
  // Else(), b, EndIf().
  void Push(double constant);
  /// @pre op <= Operator::kNot
  void Apply(Operator op);
  void Call(const MathFunction& function, int argument_count);
  void If();
  void Else();
  void EndIf();

  /// True if what was built leaves exactly one number and never needed more than kDepthMax.
  [[nodiscard]] bool Finish();

  /// @pre Finish() returned true. No allocation; at a few nanoseconds per operation.
  [[nodiscard]] double Evaluate(Vec2 p, double t) const;

 private:
  struct Instruction {
    Operator code;
    std::int32_t operand = 0;  ///< Count of arguments, exponent, or index of the jump's target.
    double constant = 0;
    const MathFunction* function = nullptr;
  };
  struct Branch {
    std::size_t jump;  ///< Index of the instruction whose target is still open.
    int depth;         ///< Of the stack before either branch pushed its value.
    bool in_else;
  };

  void Append(Instruction instruction, int popped);
  void FoldConstants(int argument_count);
  [[nodiscard]] bool CloseBranch(bool in_else);
  [[nodiscard]] static double Run(std::span<const Instruction> code, Vec2 p, double t);

  std::vector<Instruction> code_;
  std::vector<Branch> branches_;
  std::size_t barrier_ = 0;  ///< Instructions from here on are reached only one after the other.
  int depth_ = 0;
  bool valid_ = true;
};

}  // namespace pliant
