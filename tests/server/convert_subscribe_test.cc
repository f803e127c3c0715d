#include "server/convert_subscribe.h"

#include <gtest/gtest.h>

namespace pliant::server {
namespace {

TEST(ConvertSubscribe, TakesARevisionAndRefusesWhatItCannotDo) {
  v1::SubscribeRequest request;
  request.set_session_id("s");
  EXPECT_EQ(*ConvertSubscribe(request), Revision::kNone);
  request.set_mirror_revision(7);
  request.set_mirror_mode(v1::MIRROR_MODE_FULL);
  EXPECT_EQ(*ConvertSubscribe(request), Revision(7));

  request.set_mirror_mode(v1::MIRROR_MODE_POSITIONS);
  EXPECT_EQ(ConvertSubscribe(request).error().code, ErrorCode::kUnimplemented);
  request.set_mirror_mode(v1::MIRROR_MODE_UNSPECIFIED);
  EXPECT_EQ(ConvertSubscribe(request).error().code, ErrorCode::kOutOfRange);
  request.clear_mirror_mode();
  request.add_region_tags(3);
  EXPECT_EQ(ConvertSubscribe(request).error().field, "region_tags");
  request.clear_region_tags();
  request.set_mirror_revision(-1);
  EXPECT_EQ(ConvertSubscribe(request).error().field, "mirror_revision");
  request.set_mirror_revision(1);
  request.set_session_id("");
  EXPECT_FALSE(ConvertSubscribe(request).ok());
}

}  // namespace
}  // namespace pliant::server
