#include "client/io/medit_sections.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <string>

namespace pliant::io {
namespace {

template <class T>
std::string Raw(T value) {
  std::string bytes(sizeof(T), '\0');
  std::memcpy(bytes.data(), &value, sizeof(T));
  return bytes;
}
std::string Raw32(std::int32_t value) { return Raw(value); }

// Goal: the layout of each binary version is the published one.
// Method: files put together by hand from its description, with one vertex 1.5, -2 of tag 3.
TEST(MeditSections, ReadsEveryBinaryVersion) {
  for (std::int32_t version = 1; version <= 4; ++version) {
    SCOPED_TRACE(version);
    const auto position = [version](std::size_t at) {
      return version < 3 ? Raw32(static_cast<std::int32_t>(at))
                         : Raw(static_cast<std::int64_t>(at));
    };
    const auto integer = [version](std::int32_t value) {
      return version < 4 ? Raw32(value) : Raw(std::int64_t{value});
    };
    const auto real = [version](double value) {
      return version == 1 ? Raw(static_cast<float>(value)) : Raw(value);
    };
    const std::size_t word = version < 3 ? 4 : 8;
    std::string bytes = Raw32(1) + Raw32(version);
    bytes += Raw32(3) + position(bytes.size() + 4 + word + 4) + Raw32(2);
    const std::string body = integer(1) + real(1.5) + real(-2) + integer(3);
    bytes += Raw32(4) + position(bytes.size() + 4 + word + body.size()) + body;
    bytes += Raw32(54) + position(0);

    MeditSections sections(bytes);
    ASSERT_EQ(sections.Next(), "Vertices");
    EXPECT_EQ(sections.dimension(), 2);
    EXPECT_EQ(sections.Count(3), 1U);
    EXPECT_EQ(sections.reader().Real(), 1.5);
    EXPECT_EQ(sections.reader().Real(), -2);
    EXPECT_EQ(sections.reader().Tag(), 3);
    EXPECT_EQ(sections.Next(), "");
    EXPECT_TRUE(sections.reader().ok());
  }
}

TEST(MeditSections, RefusesSectionsThatPointBack) {
  const std::string bytes = Raw32(1) + Raw32(2) + Raw32(3) + Raw32(8) + Raw32(2);
  MeditSections sections(bytes);
  EXPECT_EQ(sections.Next(), "");
  ASSERT_FALSE(sections.reader().ok());
  EXPECT_EQ(sections.reader().status().error().code, ErrorCode::kFileSyntax);
}

TEST(MeditSections, RefusesUnknownBinaryVersions) {
  const std::string bytes = Raw32(1) + Raw32(5);
  MeditSections sections(bytes);
  EXPECT_EQ(sections.Next(), "");
  EXPECT_EQ(sections.reader().status().error().code, ErrorCode::kFileUnsupported);
}

TEST(MeditSections, SkipsTitlesInQuotes) {
  MeditSections sections("MeshVersionFormatted 2 Title \"with Vertices in it\" Edges 0 End Edges");
  EXPECT_EQ(sections.Next(), "Title");
  EXPECT_EQ(sections.Next(), "Edges");
  EXPECT_EQ(sections.Next(), "");
  EXPECT_TRUE(sections.reader().ok());
}

}  // namespace
}  // namespace pliant::io
