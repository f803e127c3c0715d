#include "server/stored_form.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "server/blobs.h"
#include "tests/support/wire_arrays.h"

namespace pliant::server {
namespace {

TEST(StoredForm, BringsBackWhatASessionStartsFrom) {
  v1::CreateSession create = test::UnitSquare("0.25");
  create.mutable_options()->set_seed(7);
  const Result<SessionInput> input = WireCodec().ReadInput(FormOf(create));
  ASSERT_TRUE(input.ok()) << input.error().message;
  EXPECT_EQ(std::get<Domain>(input->engine.start).points.size(), 4u);
  EXPECT_EQ(std::get<SizeMetric>(input->engine.metric.source).size, "0.25");
  EXPECT_EQ(input->engine.options.seed, 7u);
}

TEST(StoredForm, BringsBackUpdates) {
  v1::EditRequest request;
  request.set_update_id(12);
  request.mutable_metric()->add_sources()->mutable_size()->set_size("x");
  const UpdateCommand command = WireCodec().ReadUpdate(FormOf(request));
  EXPECT_EQ(command.update_id, 12);
  EXPECT_EQ(std::get<SizeMetric>(std::get<MetricUpdate>(command.body).source).size, "x");
}

v1::EditRequest Tensors(std::size_t count, double first) {
  v1::EditRequest request;
  request.set_update_id(12);
  v1::VertexMetric& vertices = *request.mutable_metric()->add_sources()->mutable_vertices();
  std::vector<double> numbers(3 * count, 1.0);
  numbers.front() = first;
  *vertices.mutable_tensors() = test::Doubles(numbers, 3);
  return request;
}

// Goal: an update that comes again is known by its fingerprint, however its arrays come.
TEST(StoredForm, KnowsAnUpdateAgain) {
  for (const std::size_t count : {1u, 2'730u, 2'731u, 50'000u}) {
    SCOPED_TRACE(testing::Message() << count << " tensors, of 24 bytes; a block has 65,536");
    const v1::EditRequest request = Tensors(count, 1.0);
    const Fingerprint first = FingerprintOf(request);
    EXPECT_EQ(first.kind, UpdateKind::kMetric);
    EXPECT_NE(first.hash, 0u);
    v1::EditRequest again = request;
    std::int64_t last_blob_id = 17;
    BlobAssembler blobs;
    for (v1::BlobChunk& chunk : TakeLargeArrays(again, last_blob_id)) {
      ASSERT_TRUE(blobs.Add(std::move(chunk)).ok());
    }
    ASSERT_TRUE(blobs.Resolve(again).ok());
    EXPECT_EQ(FingerprintOf(again), first) << "in chunks";
    std::string& bytes = *again.mutable_metric()
                              ->mutable_sources(0)
                              ->mutable_vertices()
                              ->mutable_tensors()
                              ->mutable_data();
    bytes.back() = static_cast<char>(bytes.back() ^ 1);
    EXPECT_NE(FingerprintOf(again), first) << "another number at the end";
    EXPECT_NE(FingerprintOf(Tensors(count, 2.0)), first) << "another one at the begin";
  }
}

TEST(StoredForm, TellsKindsOfUpdatesApart) {
  v1::EditRequest advance;
  advance.mutable_advance();
  v1::EditRequest discard;
  discard.mutable_discard();
  EXPECT_EQ(FingerprintOf(advance).kind, UpdateKind::kAdvance);
  EXPECT_EQ(KindOf(discard), UpdateKind::kDiscard);
  EXPECT_NE(FingerprintOf(advance), FingerprintOf(discard));
  advance.mutable_advance()->set_budget_visits(1);
  v1::EditRequest other = advance;
  other.mutable_advance()->set_budget_visits(2);
  EXPECT_NE(FingerprintOf(advance), FingerprintOf(other));
}

TEST(StoredForm, RefusesOtherBytes) {
  const Bytes bad(9, std::byte{0xff});
  EXPECT_EQ(WireCodec().ReadInput(bad).error().code, ErrorCode::kDataCorrupt);
  const UpdateCommand command = WireCodec().ReadUpdate(bad);
  EXPECT_EQ(std::get<BadUpdate>(command.body).error.code, ErrorCode::kDataCorrupt);
}

}  // namespace
}  // namespace pliant::server
