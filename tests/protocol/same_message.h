#pragma once

#include <google/protobuf/util/message_differencer.h>
#include <gtest/gtest.h>

#include <string>

namespace pliant::test {

/// To the last bit; a failure begins with `promise`.
inline void ExpectSame(const google::protobuf::Message& a, const google::protobuf::Message& b,
                       const std::string& promise = "not the same") {
  std::string report;
  google::protobuf::util::MessageDifferencer differencer;
  differencer.ReportDifferencesToString(&report);
  EXPECT_TRUE(differencer.Compare(a, b)) << promise << "\n" << report;
}

}  // namespace pliant::test
