#include "core/base/check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace pliant {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

TEST(Check, PassesSilently) { EXPECT_NO_THROW(PLIANT_CHECK(1 + 1 == 2, "unused", 0)); }

TEST(Check, NamesTheConditionThePlaceAndTheValues) {
  const int count = -3;
  EXPECT_THAT([&] { PLIANT_CHECK(count >= 0, "count", count, "vertex", 7); },
              ThrowsMessage<InvariantViolation>(AllOf(HasSubstr("count >= 0"),
                                                      HasSubstr("tests/core/base/check_test.cc:"),
                                                      HasSubstr("count=-3 vertex=7"))));
}

TEST(Check, NamesFilesFromTheRootSoThatMessagesDoNotDependOnTheMachine) {
  EXPECT_THAT([] { PLIANT_CHECK(false); },
              ThrowsMessage<InvariantViolation>(HasSubstr(" at tests/core/base/check_test.cc:")));
}

TEST(Check, EvaluatesTheConditionOnce) {
  int evaluations = 0;
  PLIANT_CHECK(++evaluations == 1);
  EXPECT_EQ(evaluations, 1);
}

TEST(Check, DebugCheckIsActiveOnlyWithoutNdebug) {
#ifdef NDEBUG
  EXPECT_NO_THROW(PLIANT_DCHECK(false));
#else
  EXPECT_THROW(PLIANT_DCHECK(false), InvariantViolation);
#endif
}

}  // namespace
}  // namespace pliant
