#include "server/convert_subscribe.h"

#include <gtest/gtest.h>

#include "server/limits.h"

namespace pliant::server {
namespace {

v1::SubscribeRequest Request() {
  v1::SubscribeRequest request;
  request.set_session_id("s");
  return request;
}

TEST(ConvertSubscribe, TakesEverythingThatCanBeAskedFor) {
  EXPECT_EQ(ConvertSubscribe(Request())->mirror_revision, Revision::kNone);
  EXPECT_FALSE(ConvertSubscribe(Request())->partial());
  v1::SubscribeRequest request = Request();
  request.set_mirror_revision(7);
  request.set_mirror_mode(v1::MIRROR_MODE_FULL);
  request.set_numbering(v1::NUMBERING_DENSE);
  request.add_parts(v1::MESH_PART_TRANSFER);
  const SubscribeSpec whole = *ConvertSubscribe(request);
  EXPECT_EQ(whole.mirror_revision, Revision(7));
  EXPECT_EQ(whole.numbering, v1::NUMBERING_DENSE);
  EXPECT_TRUE(whole.parts.transfer);
  EXPECT_FALSE(whole.partial());

  request = Request();
  request.add_region_tags(3);
  request.add_region_tags(-2);
  const SubscribeSpec regions = *ConvertSubscribe(request);
  EXPECT_EQ(regions.region_tags, (std::vector{-2, 3}));
  EXPECT_TRUE(regions.partial());
  request.set_mirror_mode(v1::MIRROR_MODE_NONE);
  EXPECT_FALSE(ConvertSubscribe(request)->partial()) << "there is nothing to filter";
  request = Request();
  request.set_mirror_mode(v1::MIRROR_MODE_POSITIONS);
  EXPECT_EQ(ConvertSubscribe(request)->mirror, Mirror::kPositions);
  EXPECT_TRUE(ConvertSubscribe(request)->partial());
}

TEST(ConvertSubscribe, NamesWhatIsWrong) {
  const auto field_of = [](const v1::SubscribeRequest& request) {
    const Result<SubscribeSpec> spec = ConvertSubscribe(request);
    return spec.ok() ? "" : spec.error().field;
  };
  v1::SubscribeRequest request = Request();
  request.set_mirror_mode(v1::MIRROR_MODE_UNSPECIFIED);
  EXPECT_EQ(field_of(request), "mirror_mode");
  request = Request();
  request.set_numbering(v1::NUMBERING_UNSPECIFIED);
  EXPECT_EQ(field_of(request), "numbering");
  request = Request();
  request.set_mirror_revision(-1);
  EXPECT_EQ(field_of(request), "mirror_revision");
  request = Request();
  request.add_parts(v1::MESH_PART_TRANSFER);
  request.add_region_tags(3);
  EXPECT_EQ(field_of(request), "parts");
  request = Request();
  for (int i = 0; i < kRegionTagsMax; ++i) request.add_region_tags(i);
  EXPECT_EQ(field_of(request), "");
  request.add_region_tags(0);
  EXPECT_EQ(field_of(request), "region_tags");
  EXPECT_EQ(ConvertSubscribe(request).error().code, ErrorCode::kTooLarge);
  EXPECT_FALSE(ConvertSubscribe(v1::SubscribeRequest()).ok());
}

}  // namespace
}  // namespace pliant::server
