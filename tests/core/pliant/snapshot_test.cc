#include "core/pliant/snapshot.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <utility>

#include "core/base/rng.h"
#include "core/mesh/validate.h"
#include "core/pliant/remesher.h"
#include "tests/support/session_script.h"

namespace pliant {
namespace {

using ::testing::AnyOf;
using testing::SessionScript;

Bytes SavedAfter(std::uint64_t seed, int revisions) {
  const SessionScript script(seed);
  const auto session = script.Start();
  for (int n = 1; n <= revisions; ++n) (void)script.Run(*session, n);
  return *session->Save();
}

TEST(Snapshot, HoldsTheOptionsAndTheRevision) {
  const SessionScript script(7);
  const auto session = script.Start();
  for (int n = 1; n <= 3; ++n) (void)script.Run(*session, n);
  const auto loaded = *Remesher::Load(*session->Save());
  EXPECT_EQ(loaded->options(), session->options());
  EXPECT_EQ(loaded->revision(), Revision(3));
  EXPECT_TRUE(Validate(loaded->mesh()).empty());
  EXPECT_FALSE(loaded->TakeUndo().has_value());
}

TEST(Snapshot, IsOfACommitAndOfNothingElse) {
  const SessionScript script(1);
  const auto session = script.Start();
  ASSERT_FALSE(session->Save().ok());
  EXPECT_EQ(session->Save().error().code, ErrorCode::kRevisionNotFound);
  (void)script.Run(*session, 1);
  const Bytes state = *session->Save();
  ASSERT_TRUE(session->SetMetric({.source = SizeMetric{"0.07"}}).ok());
  ASSERT_FALSE(session->Save().ok());
  EXPECT_EQ(session->Save().error().code, ErrorCode::kProtocolOrder);
  session->Rollback();
  EXPECT_EQ(*session->Save(), state);
}

TEST(Snapshot, RefusesDamagedBytes) {
  const Bytes bytes = SavedAfter(2, 3);
  Rng rng(6);
  for (int i = 0; i < 300; ++i) {
    Bytes damaged = bytes;
    if (i % 3 == 0) {
      damaged.resize(rng.Below(bytes.size()));
    } else {
      damaged[rng.Below(bytes.size())] ^= std::byte{1} << rng.Below(8);
    }
    const auto loaded = Remesher::Load(damaged);
    ASSERT_FALSE(loaded.ok()) << i;
    EXPECT_THAT(loaded.error().code, AnyOf(ErrorCode::kDataCorrupt, ErrorCode::kDataVersion));
  }
}

// Goal: bytes with the right checksum and wrong contents are refused, or make a session that can be
//       looked at without leaving its memory (the sanitizers watch).
TEST(Snapshot, WrongContentsWithTheRightChecksumDoNoHarm) {
  const Bytes bytes = SavedAfter(4, 3);
  constexpr std::size_t kHeader = 24;
  constexpr Seal kSeal{.kind = 0x53534c50, .version = 2};
  Rng rng(7);
  int loaded_count = 0;
  for (int i = 0; i < 2000; ++i) {
    Bytes payload(bytes.begin() + kHeader, bytes.end());
    const std::size_t at = rng.Below(payload.size());
    payload[at] = static_cast<std::byte>(rng.Below(256));
    const auto loaded = Remesher::Load(SealBytes(kSeal, payload));
    if (!loaded.ok()) {
      EXPECT_EQ(loaded.error().code, ErrorCode::kDataCorrupt);
      continue;
    }
    ++loaded_count;
    (void)Validate((*loaded)->mesh());
  }
  EXPECT_GT(loaded_count, 0) << "the test needs some that are read";
  EXPECT_LT(loaded_count, 2000) << "and some that are not";
}

}  // namespace
}  // namespace pliant
