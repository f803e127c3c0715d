#include "server/stored_form.h"

#include <gtest/gtest.h>

#include "tests/support/wire_arrays.h"

namespace pliant::server {
namespace {

TEST(StoredForm, BringsBackWhatASessionStartsFrom) {
  v1::CreateSession create = test::UnitSquare("0.25");
  create.mutable_options()->set_seed(7);
  const Result<EngineInput> input = WireCodec().ReadInput(FormOf(create));
  ASSERT_TRUE(input.ok()) << input.error().message;
  EXPECT_EQ(std::get<Domain>(input->start).points.size(), 4u);
  EXPECT_EQ(std::get<SizeMetric>(input->metric.source).size, "0.25");
  EXPECT_EQ(input->options.seed, 7u);
}

TEST(StoredForm, BringsBackUpdates) {
  v1::EditRequest request;
  request.set_update_id(12);
  request.mutable_metric()->add_sources()->mutable_size()->set_size("x");
  const UpdateCommand command = WireCodec().ReadUpdate(FormOf(request));
  EXPECT_EQ(command.update_id, 12);
  EXPECT_EQ(std::get<SizeMetric>(std::get<MetricUpdate>(command.body).source).size, "x");
}

TEST(StoredForm, RefusesOtherBytes) {
  const Bytes bad(9, std::byte{0xff});
  EXPECT_EQ(WireCodec().ReadInput(bad).error().code, ErrorCode::kDataCorrupt);
  const UpdateCommand command = WireCodec().ReadUpdate(bad);
  EXPECT_EQ(std::get<BadUpdate>(command.body).error.code, ErrorCode::kDataCorrupt);
}

}  // namespace
}  // namespace pliant::server
