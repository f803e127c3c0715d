#include "server/store/packing.h"

#include <gtest/gtest.h>

#include <random>

namespace pliant::server {
namespace {

Bytes RandomBytes(std::size_t size, int values, std::uint64_t seed) {
  std::mt19937_64 rng(seed);
  Bytes bytes(size);
  for (std::byte& byte : bytes)
    byte = static_cast<std::byte>(rng() % static_cast<unsigned>(values));
  return bytes;
}

TEST(Packing, GivesBackWhatItWasGivenAndCompressesWhereItPays) {
  for (const std::size_t size : {0, 1, 255, 256, 100'000}) {
    for (const int values : {2, 256}) {
      SCOPED_TRACE(testing::Message() << size << " bytes of " << values << " values");
      const Bytes bytes = RandomBytes(size, values, /*seed=*/size + 1);
      const Packed packed = Pack(bytes, 7);
      const bool pays = values == 2 && size >= 256;
      EXPECT_EQ(packed.form, pays ? PackForm::kZstd : PackForm::kRaw);
      if (pays) {
        EXPECT_LT(packed.bytes.size(), size * 7 / 8 + 1);
      }
      const Result<Bytes> again = Unpack(packed, 7);
      ASSERT_TRUE(again.ok()) << again.error().message;
      EXPECT_EQ(*again, bytes);
    }
  }
}

// Method: one bit flipped in each byte in turn, and each number beside them changed.
TEST(Packing, NoticesEveryChange) {
  for (const int values : {2, 256}) {
    const Packed good = Pack(RandomBytes(500, values, /*seed=*/3), 7);
    for (std::size_t i = 0; i < good.bytes.size(); ++i) {
      Packed bad = good;
      bad.bytes[i] ^= std::byte{1};
      ASSERT_FALSE(Unpack(bad, 7).ok()) << "byte " << i;
    }
    Packed bad = good;
    bad.size += 1;
    EXPECT_EQ(Unpack(bad, 7).error().code, ErrorCode::kDataCorrupt);
    bad = good;
    bad.form = good.form == PackForm::kRaw ? PackForm::kZstd : PackForm::kRaw;
    EXPECT_EQ(Unpack(bad, 7).error().code, ErrorCode::kDataCorrupt);
    bad = good;
    bad.bytes.pop_back();
    EXPECT_EQ(Unpack(bad, 7).error().code, ErrorCode::kDataCorrupt);
    EXPECT_EQ(Unpack(good, 8).error().code, ErrorCode::kDataCorrupt) << "another row's place";
  }
}

}  // namespace
}  // namespace pliant::server
