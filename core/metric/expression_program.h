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

  struct Instruction {
    Operator code;
    std::int32_t operand = 0;  ///< Count of arguments, exponent, or index of the jump's target.
    double constant = 0;
    const MathFunction* function = nullptr;
  };

  /// What was built, in the order of reverse Polish notation.
  [[nodiscard]] std::span<const Instruction> code() const { return code_; }

  /// How many numbers Compute needs. @pre the operator combines numbers: no variable, constant,
  /// jump or fold
  [[nodiscard]] static constexpr std::size_t ArgumentCount(Operator code) {
    switch (code) {
      case Operator::kNegate:
      case Operator::kNot:
      case Operator::kSquare:
      case Operator::kIntegerPower:
      case Operator::kCallUnary:
        return 1;
      case Operator::kCallTernary:
        return 3;
      default:
        return 2;
    }
  }

  /// The number that an instruction makes of numbers, a fold of two. @pre as for ArgumentCount
  [[nodiscard]] static double Compute(const Instruction& i, double a, double b, double c) {
    switch (i.code) {
      // clang-format off
      case Operator::kAdd: return a + b;
      case Operator::kSubtract: return a - b;
      case Operator::kMultiply: return a * b;
      case Operator::kDivide: return a / b;
      case Operator::kPower: return Power(a, b);
      case Operator::kLess: return a < b ? 1 : 0;
      case Operator::kLessEqual: return a <= b ? 1 : 0;
      case Operator::kGreater: return a > b ? 1 : 0;
      case Operator::kGreaterEqual: return a >= b ? 1 : 0;
      case Operator::kEqual: return a == b ? 1 : 0;
      case Operator::kNotEqual: return a != b ? 1 : 0;
      case Operator::kAnd: return a != 0 && b != 0 ? 1 : 0;
      case Operator::kOr: return a != 0 || b != 0 ? 1 : 0;
      case Operator::kNegate: return -a;
      case Operator::kNot: return a == 0 ? 1 : 0;
      case Operator::kSquare: return a * a;
      case Operator::kIntegerPower: return IntegerPower(a, i.operand);
      case Operator::kCallUnary: return i.function->unary(a);
      case Operator::kCallBinary: return i.function->binary(a, b);
      case Operator::kCallTernary: return i.function->ternary(a, b, c);
      case Operator::kCallFold: return i.function->fold(a, b);
      // clang-format on
      default:
        return 0;
    }
  }

 private:
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
