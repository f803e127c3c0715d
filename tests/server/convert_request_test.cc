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
