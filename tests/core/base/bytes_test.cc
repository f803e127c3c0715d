#include "core/base/bytes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include "core/base/rng.h"

namespace pliant {
namespace {

constexpr Seal kSeal{.kind = 0x54534554, .version = 3};

Bytes SomeBytes(std::size_t count, std::uint64_t seed) {
  Rng rng(seed);
  Bytes bytes(count);
  for (std::byte& byte : bytes) byte = static_cast<std::byte>(rng.Below(256));
  return bytes;
}

TEST(Bytes, AreLittleEndianWithoutPadding) {
  ByteWriter writer;
  writer.Put(std::uint8_t{0x01});
  writer.Put(std::uint32_t{0x05040302});
  writer.PutText("AB");
  const Bytes bytes = std::move(writer).Take();
  const std::vector<int> expected{1, 2, 3, 4, 5, 2, 0, 0, 0, 0, 0, 0, 0, 'A', 'B'};
  ASSERT_EQ(bytes.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(static_cast<int>(bytes[i]), expected[i]) << "byte " << i;
  }
}

TEST(Bytes, BringEveryNumberBackBitForBit) {
  const std::vector<double> numbers{0, -0.0, 1.5, std::numeric_limits<double>::denorm_min(),
                                    -std::numeric_limits<double>::infinity()};
  ByteWriter writer;
  writer.PutColumn(numbers);
  writer.Put(std::int64_t{-7});
  writer.PutColumn(std::vector<std::int32_t>{});
  writer.Put(0.25F);
  const Bytes bytes = std::move(writer).Take();
  ByteReader reader(bytes);
  const std::vector<double> back = reader.TakeColumn<double>();
  EXPECT_EQ(back, numbers);
  EXPECT_TRUE(std::signbit(back[1]));
  EXPECT_EQ(reader.Take<std::int64_t>(), -7);
  EXPECT_TRUE(reader.TakeColumn<std::int32_t>().empty());
  EXPECT_FALSE(reader.AtEnd());
  EXPECT_EQ(reader.Take<float>(), 0.25F);
  EXPECT_TRUE(reader.AtEnd());
}

TEST(ByteReader, NeverReadsPastTheEndAndFailsForGood) {
  ByteWriter writer;
  writer.Put(std::uint64_t{1000});
  writer.Put(std::uint8_t{5});
  const Bytes bytes = std::move(writer).Take();
  ByteReader reader(bytes);
  EXPECT_TRUE(reader.TakeColumn<double>().empty()) << "a column of 1000 numbers in one byte";
  EXPECT_FALSE(reader.ok());
  EXPECT_EQ(reader.Take<std::uint8_t>(), 0) << "after a failure nothing is read";
  EXPECT_FALSE(reader.AtEnd());
}

// Goal: damage shows. Method: every bit of short inputs, every cut, and lengths that differ by
// zeros only.
TEST(Checksum, ShowsEveryFlippedBitAndEveryCut) {
  for (const std::size_t size : {1, 7, 8, 31, 32, 33, 100}) {
    Bytes bytes = SomeBytes(size, size);
    const std::uint64_t sum = Checksum(bytes);
    for (std::size_t bit = 0; bit < 8 * size; ++bit) {
      bytes[bit / 8] ^= std::byte{1} << (bit % 8);
      EXPECT_NE(Checksum(bytes), sum) << "bit " << bit << " of " << size << " bytes";
      bytes[bit / 8] ^= std::byte{1} << (bit % 8);
    }
    for (std::size_t cut = 0; cut < size; ++cut) {
      EXPECT_NE(Checksum(std::span(bytes).first(cut)), sum);
    }
  }
  std::set<std::uint64_t> sums;
  for (std::size_t size = 0; size < 200; ++size) sums.insert(Checksum(Bytes(size)));
  EXPECT_EQ(sums.size(), 200U) << "zeros of different lengths";
}

TEST(Seal, GivesBackWhatItHolds) {
  for (const std::size_t size : {0, 1, 1000}) {
    const Bytes payload = SomeBytes(size, 9);
    const Bytes sealed = SealBytes(kSeal, payload);
    const auto opened = OpenSeal(sealed, kSeal, "thing");
    ASSERT_TRUE(opened.ok());
    EXPECT_TRUE(std::equal(opened->begin(), opened->end(), payload.begin(), payload.end()));
  }
}

TEST(Seal, SaysWhatIsWrong) {
  const Bytes sealed = SealBytes(kSeal, SomeBytes(50, 4));
  const auto code_of = [](std::span<const std::byte> bytes, const Seal& seal) {
    const auto opened = OpenSeal(bytes, seal, "thing");
    return opened.ok() ? std::string("ok") : std::string(ErrorCodeName(opened.error().code));
  };
  EXPECT_EQ(code_of(sealed, {.kind = 1, .version = 3}), "DATA_CORRUPT");
  EXPECT_EQ(code_of(sealed, {.kind = kSeal.kind, .version = 2}), "DATA_VERSION");
  EXPECT_EQ(code_of(sealed, {.kind = kSeal.kind, .version = 4}), "ok") << "older formats are read";
  for (std::size_t size = 0; size < sealed.size(); ++size) {
    EXPECT_EQ(code_of(std::span(sealed).first(size), kSeal), "DATA_CORRUPT") << size << " bytes";
  }
  for (std::size_t i = 8; i < sealed.size(); ++i) {
    Bytes damaged = sealed;
    damaged[i] ^= std::byte{0x10};
    EXPECT_EQ(code_of(damaged, kSeal), "DATA_CORRUPT") << "byte " << i;
  }
}

}  // namespace
}  // namespace pliant
