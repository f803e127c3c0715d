#include "server/log.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

namespace pliant::server {
namespace {

TEST(Log, WritesFieldsAsText) {
  EXPECT_EQ(FormatLogLine(LogFormat::kText, "commit", {{"session", "s1"}, {"what", "a b"}}),
            R"(commit session=s1 what="a b")");
}

// Goal: nothing that a client sends can break a line of JSON or forge a field.
TEST(Log, WritesFieldsAsJsonWhateverTheyHold) {
  const std::string hostile = "x\",\"level\":\"forged\n\xff\t\\";
  const std::string line =
      FormatLogLine(LogFormat::kJson, "commit", {{"session", hostile}, {"revision", "4"}});
  const nlohmann::json parsed = nlohmann::json::parse("{" + line + "}");
  EXPECT_EQ(parsed.size(), 3U);
  EXPECT_EQ(parsed["event"], "commit");
  EXPECT_EQ(parsed["revision"], "4");
  EXPECT_EQ(line.find('\n'), std::string::npos);
  EXPECT_EQ(FormatLogLine(LogFormat::kText, "e", {{"a", "x\ny"}}).find('\n'), std::string::npos);
}

}  // namespace
}  // namespace pliant::server
