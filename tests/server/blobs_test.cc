#include "server/blobs.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "pliant/v1/session.pb.h"
#include "server/limits.h"

namespace pliant::server {
namespace {

// A piece of a blob of `total` bytes.
v1::BlobChunk Chunk(std::int64_t id, std::size_t total, std::size_t offset,
                    const std::string& data) {
  v1::BlobChunk chunk;
  chunk.set_blob_id(id);
  chunk.set_total_bytes(static_cast<std::int64_t>(total));
  chunk.set_offset_bytes(static_cast<std::int64_t>(offset));
  chunk.set_data(data);
  return chunk;
}

ErrorCode CodeOf(const Status& status) {
  return status.ok() ? ErrorCode::kUnavailable : status.error().code;
}

TEST(Blobs, ComeTogetherInTheArraysThatNameThem) {
  BlobAssembler blobs;
  ASSERT_TRUE(blobs.Add(Chunk(1, 5, 0, "abc")).ok());
  ASSERT_TRUE(blobs.Add(Chunk(1, 5, 3, "de")).ok());
  ASSERT_TRUE(blobs.Add(Chunk(4, 2, 0, "xy")).ok());
  EXPECT_EQ(blobs.pending_bytes(), 7U);
  v1::CreateSession create;
  create.mutable_domain()->mutable_points()->set_blob_id(1);
  create.mutable_metric()->add_sources()->mutable_vertices()->mutable_tensors()->set_blob_id(4);
  create.mutable_domain()->mutable_segments()->set_data("inline");
  ASSERT_TRUE(blobs.Resolve(create).ok());
  EXPECT_EQ(create.domain().points().data(), "abcde");
  EXPECT_EQ(create.metric().sources(0).vertices().tensors().data(), "xy");
  EXPECT_EQ(create.domain().segments().data(), "inline");
  EXPECT_EQ(blobs.pending_bytes(), 0U);
}

TEST(Blobs, RefuseGapsMixturesRepetitionsAndOverruns) {
  {
    BlobAssembler blobs;
    EXPECT_EQ(CodeOf(blobs.Add(Chunk(1, 5, 1, "abc"))), ErrorCode::kProtocolOrder) << "gap";
  }
  {
    BlobAssembler blobs;
    ASSERT_TRUE(blobs.Add(Chunk(1, 5, 0, "abc")).ok());
    EXPECT_EQ(CodeOf(blobs.Add(Chunk(2, 5, 0, "abc"))), ErrorCode::kProtocolOrder) << "mixed";
  }
  {
    BlobAssembler blobs;
    ASSERT_TRUE(blobs.Add(Chunk(2, 3, 0, "abc")).ok());
    EXPECT_EQ(CodeOf(blobs.Add(Chunk(2, 3, 0, "abc"))), ErrorCode::kProtocolOrder) << "repeated";
  }
  {
    BlobAssembler blobs;
    EXPECT_EQ(CodeOf(blobs.Add(Chunk(1, 2, 0, "abc"))), ErrorCode::kProtocolOrder) << "overrun";
  }
}

TEST(Blobs, RefuseABlobThatIsUnknownIncompleteOrUsedTwiceAndNameTheArray) {
  BlobAssembler blobs;
  ASSERT_TRUE(blobs.Add(Chunk(1, 3, 0, "abc")).ok());
  ASSERT_TRUE(blobs.Add(Chunk(2, 5, 0, "abc")).ok());
  v1::CreateSession create;
  create.mutable_domain()->mutable_points()->set_blob_id(1);
  create.mutable_domain()->mutable_segments()->set_blob_id(1);
  Status status = blobs.Resolve(create);
  ASSERT_EQ(CodeOf(status), ErrorCode::kProtocolOrder);
  EXPECT_EQ(status.error().field, "domain.segments");
  create.Clear();
  create.mutable_metric()->add_sources()->mutable_vertices()->mutable_tensors()->set_blob_id(2);
  status = blobs.Resolve(create);
  ASSERT_EQ(CodeOf(status), ErrorCode::kProtocolOrder);
  EXPECT_EQ(status.error().field, "metric.sources[0].vertices.tensors");
}

TEST(Blobs, TakeAChunkAtTheBoundAndNotOneByteMore) {
  BlobAssembler blobs;
  EXPECT_TRUE(blobs.Add(Chunk(1, kChunkBytesMax, 0, std::string(kChunkBytesMax, 'a'))).ok());
  EXPECT_EQ(
      CodeOf(blobs.Add(Chunk(2, kChunkBytesMax + 1, 0, std::string(kChunkBytesMax + 1, 'a')))),
      ErrorCode::kTooLarge);
  EXPECT_EQ(CodeOf(blobs.Add(Chunk(2, 1, 0, ""))), ErrorCode::kTooLarge) << "empty";
}

TEST(Blobs, TakeAsManyWaitingBlobsAsAllowedAndNotOneMore) {
  BlobAssembler blobs;
  for (std::size_t i = 1; i <= kBlobsPendingMax; ++i) {
    ASSERT_TRUE(blobs.Add(Chunk(static_cast<std::int64_t>(i), 1, 0, "a")).ok());
  }
  EXPECT_EQ(CodeOf(blobs.Add(Chunk(1000, 1, 0, "a"))), ErrorCode::kTooLarge);
}

TEST(Blobs, RefuseAnUploadBeyondTheBoundWhenItIsAnnounced) {
  BlobAssembler blobs;
  EXPECT_TRUE(blobs.Add(Chunk(1, kUploadBytesMax, 0, "a")).ok()) << "at the bound";
  BlobAssembler other;
  EXPECT_EQ(CodeOf(other.Add(Chunk(1, kUploadBytesMax + 1, 0, "a"))), ErrorCode::kTooLarge);
  BlobAssembler negative;
  v1::BlobChunk chunk = Chunk(1, 1, 0, "a");
  chunk.set_total_bytes(-1);
  EXPECT_EQ(CodeOf(negative.Add(chunk)), ErrorCode::kTooLarge);
}

// Goal: what one end takes apart the other puts together, at and around every size where the form
// changes.
TEST(Blobs, SurviveBeingTakenApartAndPutTogether) {
  for (const std::size_t size :
       {std::size_t{0}, std::size_t{1}, kInlineBytesMax, kInlineBytesMax + 1, kChunkBytesMax,
        kChunkBytesMax + 1, 3 * kChunkBytesMax}) {
    SCOPED_TRACE(size);
    std::string bytes(size, '\0');
    for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<char>(i * 31 % 251);
    v1::MeshSnapshot snapshot;
    snapshot.mutable_vertex_positions()->set_data(bytes);
    snapshot.mutable_vertex_ids()->set_data(bytes);
    std::int64_t last_blob_id = 0;
    const std::vector<v1::BlobChunk> chunks = TakeLargeArrays(snapshot, last_blob_id);
    EXPECT_EQ(last_blob_id, size > kInlineBytesMax ? 2 : 0);
    EXPECT_LT(snapshot.ByteSizeLong(), 2 * kInlineBytesMax + 100);
    BlobAssembler blobs;
    for (const v1::BlobChunk& chunk : chunks) {
      EXPECT_LE(chunk.ByteSizeLong(), static_cast<std::size_t>(kMessageBytesMax));
      ASSERT_TRUE(blobs.Add(chunk).ok());
    }
    ASSERT_TRUE(blobs.Resolve(snapshot).ok());
    EXPECT_EQ(snapshot.vertex_positions().data(), bytes);
    EXPECT_EQ(snapshot.vertex_ids().data(), bytes);
    EXPECT_EQ(blobs.pending_bytes(), 0U);
  }
}

}  // namespace
}  // namespace pliant::server
