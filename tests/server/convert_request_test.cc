#include "server/convert_request.h"

#include <gtest/gtest.h>

#include <string>

#include "pliant/v1/session.pb.h"
#include "server/limits.h"

namespace pliant::server {
namespace {

TEST(ConvertRequest, ReadsPages) {
  EXPECT_EQ(ConvertPageToken("").value(), 0);
  EXPECT_EQ(ConvertPageToken("17").value(), 17);
  for (const char* token : {"x", "1x", "-1", "0", "99999999999999999999"}) {
    EXPECT_EQ(ConvertPageToken(token).error().field, "page_token") << token;
  }
  EXPECT_EQ(ConvertPageSize(0).value(), static_cast<std::size_t>(kPageSizeDefault));
  EXPECT_EQ(ConvertPageSize(kPageSizeMax).value(), static_cast<std::size_t>(kPageSizeMax));
  EXPECT_EQ(ConvertPageSize(kPageSizeMax + 1).error().field, "page_size");
  EXPECT_EQ(ConvertPageSize(-1).error().code, ErrorCode::kOutOfRange);
}

// Goal: no number ends a session's updates for good by a slip; at the bound and one past it.
TEST(ConvertRequest, ChecksNumbersOfUpdates) {
  EXPECT_TRUE(CheckUpdateId(1).ok());
  EXPECT_TRUE(CheckUpdateId(kUpdateIdMax).ok());
  EXPECT_EQ(CheckUpdateId(kUpdateIdMax + 1).error().code, ErrorCode::kOutOfRange);
  EXPECT_EQ(CheckUpdateId(INT64_MAX).error().field, "update_id");
  EXPECT_EQ(CheckUpdateId(0).error().code, ErrorCode::kProtocolOrder);
  EXPECT_EQ(CheckUpdateId(-1).error().code, ErrorCode::kProtocolOrder);
}

TEST(ConvertRequest, ReadsTheNumbering) {
  v1::GetMeshRequest request;
  EXPECT_EQ(NumberingOf(request).value(), v1::NUMBERING_STABLE);
  request.set_numbering(v1::NUMBERING_DENSE);
  EXPECT_EQ(NumberingOf(request).value(), v1::NUMBERING_DENSE);
  request.set_numbering(v1::NUMBERING_UNSPECIFIED);
  EXPECT_EQ(NumberingOf(request).error().field, "numbering");
}

}  // namespace
}  // namespace pliant::server
