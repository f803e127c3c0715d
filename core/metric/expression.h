#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "core/geometry/vec2.h"
#include "core/metric/expression_program.h"

namespace pliant {

/// A formula in x, y and t, e.g. "0.01 + 0.1*abs(y - sin(pi*x))". Syntax and functions:
/// core/metric/README.md.
///
/// *Invariants*: pure; the same numbers give the same bits on every CPU and with every compiler,
/// because no function of the C library takes part.
/// *Threads*: Evaluate from as many as you like.
class Expression {
 public:
  /// Most characters; bounds the time of parsing and of every evaluation.
  static constexpr std::size_t kLengthMax = 4096;
  /// Most parentheses open at once.
  static constexpr int kNestingMax = 64;

  /// Parses `text`, which may come from anyone. Errors: kExpressionSyntax with `index` = offset in
  /// characters of the offending token; kTooLarge for one beyond the limits above.
  /// @par Cost  about 0.1 ms for a typical formula, a few ms for the longest one.
  [[nodiscard]] static Result<Expression> Parse(std::string_view text);

  /// The value at p and time t; may be NaN or infinite, e.g. sqrt(-1) or 1/0.
  [[nodiscard]] double Evaluate(Vec2 p, double t) const { return program_.Evaluate(p, t); }

  [[nodiscard]] const ExpressionProgram& program() const { return program_; }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  Expression(std::string text, ExpressionProgram program)
      : text_(std::move(text)), program_(std::move(program)) {}

  std::string text_;
  ExpressionProgram program_;
};

}  // namespace pliant
