#include "core/metric/expression_program.h"

#include <gtest/gtest.h>

namespace pliant {
namespace {

using Operator = ExpressionProgram::Operator;

TEST(ExpressionProgram, EvaluatesReversePolishNotation) {
  ExpressionProgram program;  // (x - 2) * y / t
  program.Apply(Operator::kX);
  program.Push(2);
  program.Apply(Operator::kSubtract);
  program.Apply(Operator::kY);
  program.Apply(Operator::kMultiply);
  program.Apply(Operator::kT);
  program.Apply(Operator::kDivide);
  ASSERT_TRUE(program.Finish());
  EXPECT_EQ(program.Evaluate({5, 7}, 3), 7);
}

TEST(ExpressionProgram, TakesOneBranchOfAConditional) {
  ExpressionProgram program;  // 1 + (x ? y : t ^ 2)
  program.Push(1);
  program.Apply(Operator::kX);
  program.If();
  program.Apply(Operator::kY);
  program.Else();
  program.Apply(Operator::kT);
  program.Push(2);
  program.Apply(Operator::kPower);
  program.EndIf();
  program.Apply(Operator::kAdd);
  ASSERT_TRUE(program.Finish());
  EXPECT_EQ(program.Evaluate({1, 10}, 3), 11);
  EXPECT_EQ(program.Evaluate({0, 10}, 3), 10);
}

// Goal: folding must not reach over a place where a jump lands.
TEST(ExpressionProgram, DoesNotFoldAcrossBranches) {
  ExpressionProgram program;  // 10 - (x ? 2 : 3), then ^ 2 of each.
  program.Push(10);
  program.Apply(Operator::kX);
  program.If();
  program.Push(2);
  program.Else();
  program.Push(3);
  program.EndIf();
  program.Apply(Operator::kSubtract);
  program.Push(2);
  program.Apply(Operator::kPower);
  ASSERT_TRUE(program.Finish());
  EXPECT_EQ(program.Evaluate({1, 0}, 0), 64);
  EXPECT_EQ(program.Evaluate({0, 0}, 0), 49);

  ExpressionProgram exponent;  // 2 ^ (x ? 2 : 3)
  exponent.Push(2);
  exponent.Apply(Operator::kX);
  exponent.If();
  exponent.Push(2);
  exponent.Else();
  exponent.Push(3);
  exponent.EndIf();
  exponent.Apply(Operator::kPower);
  ASSERT_TRUE(exponent.Finish());
  EXPECT_EQ(exponent.Evaluate({1, 0}, 0), 4);
  EXPECT_EQ(exponent.Evaluate({0, 0}, 0), 8);
}

TEST(ExpressionProgram, FoldsConstantsToTheValueThatRunningGives) {
  ExpressionProgram folded;
  folded.Push(0.1);
  folded.Push(0.3);
  folded.Apply(Operator::kDivide);
  folded.Push(-3);
  folded.Apply(Operator::kPower);
  folded.Call(*FindMathFunction("sin"), 1);
  ASSERT_TRUE(folded.Finish());
  ExpressionProgram running;
  running.Apply(Operator::kX);
  running.Apply(Operator::kY);
  running.Apply(Operator::kDivide);
  running.Apply(Operator::kT);
  running.Apply(Operator::kPower);
  running.Call(*FindMathFunction("sin"), 1);
  ASSERT_TRUE(running.Finish());
  EXPECT_EQ(folded.Evaluate({}, 0), running.Evaluate({0.1, 0.3}, -3));
}

TEST(ExpressionProgram, FoldsAnyNumberOfArgumentsOfMinAndMax) {
  for (int count = 1; count <= 5; ++count) {
    ExpressionProgram program;
    program.Apply(Operator::kX);
    for (int i = 1; i < count; ++i) program.Push(10 * i);
    program.Call(*FindMathFunction("max"), count);
    ASSERT_TRUE(program.Finish());
    EXPECT_EQ(program.Evaluate({5, 0}, 0), count == 1 ? 5 : 10 * (count - 1));
    EXPECT_EQ(program.Evaluate({500, 0}, 0), 500);
  }
}

// Goal: nothing that would leave its stack is accepted, however it was put together.
TEST(ExpressionProgram, RefusesCodeThatLosesItsStack) {
  const auto refuses = [](auto build) {
    ExpressionProgram program;
    build(program);
    return !program.Finish();
  };
  EXPECT_TRUE(refuses([](auto&) {}));
  EXPECT_TRUE(refuses([](auto& p) { p.Apply(Operator::kAdd); }));
  EXPECT_TRUE(refuses([](auto& p) {
    p.Push(1);
    p.Apply(Operator::kAdd);
  }));
  EXPECT_TRUE(refuses([](auto& p) {  // Goes below its start, then comes back to one.
    p.Apply(Operator::kNegate);
    p.Push(1);
  }));
  EXPECT_TRUE(refuses([](auto& p) {
    p.Push(1);
    p.Push(2);
  }));
  EXPECT_TRUE(refuses([](auto& p) {  // No else.
    p.Push(1);
    p.If();
    p.Push(2);
  }));
  EXPECT_TRUE(refuses([](auto& p) {  // A branch that takes a number from below it.
    p.Push(1);
    p.Push(1);
    p.If();
    p.Push(2);
    p.Apply(Operator::kAdd);
    p.Push(3);
    p.Else();
    p.Push(3);
    p.EndIf();
  }));
  EXPECT_TRUE(refuses([](auto& p) {  // Branches of different depth.
    p.Push(1);
    p.If();
    p.Push(2);
    p.Push(2);
    p.Else();
    p.Push(3);
    p.EndIf();
  }));
  EXPECT_TRUE(refuses([](auto& p) { p.Else(); }));
  EXPECT_TRUE(refuses([](auto& p) {
    p.Push(1);
    p.EndIf();
  }));
  EXPECT_TRUE(refuses([](auto& p) {
    p.Push(1);
    p.Call(*FindMathFunction("atan2"), 1);
  }));
  EXPECT_TRUE(refuses([](auto& p) {
    p.Push(1);
    p.Call(*FindMathFunction("max"), 0);
  }));
}

TEST(ExpressionProgram, BoundsItsDepth) {
  const auto of_depth = [](int depth) {
    ExpressionProgram program;
    for (int i = 0; i < depth; ++i) program.Apply(Operator::kX);
    for (int i = 1; i < depth; ++i) program.Apply(Operator::kAdd);
    return program;
  };
  ExpressionProgram deepest = of_depth(ExpressionProgram::kDepthMax);
  ASSERT_TRUE(deepest.Finish());
  EXPECT_EQ(deepest.Evaluate({1, 0}, 0), ExpressionProgram::kDepthMax);
  EXPECT_FALSE(of_depth(ExpressionProgram::kDepthMax + 1).Finish());
}

}  // namespace
}  // namespace pliant
