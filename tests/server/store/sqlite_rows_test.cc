#include "server/store/sqlite_rows.h"

#include <gtest/gtest.h>

#include "tests/support/temporary_folder.h"

namespace pliant::server {
namespace {

const StoreKey kRowKey{DocumentKind::kSession, "tenant", "name"};

class SqliteRowsTest : public testing::Test {
 protected:
  SqliteRowsTest()
      : connection_(
            SqliteConnection::Open(folder_.path() + "/db", SqliteConnection::Mode::kWrite, "")
                .value()) {}

  DocumentRow NewRow(const StoreKey& key) {
    DocumentRow row;
    row.head.key = key;
    row.head.epoch = Epoch::kFirst;
    row.packed_head = PackHead(Bytes(3, std::byte{7}), key);
    PutDocument(*connection_, row);
    return *FindDocument(*connection_, key);
  }

  const test::TemporaryFolder folder_;
  std::unique_ptr<SqliteConnection> connection_;
};

TEST_F(SqliteRowsTest, KeepsDocumentsApartAndInOrder) {
  for (const char* name : {"b", "a", "c"}) NewRow({DocumentKind::kSession, "t", name});
  NewRow({DocumentKind::kJob, "t", "a"});
  NewRow({DocumentKind::kSession, "u", "a"});
  std::string names;
  for (const DocumentRow& row : AllDocuments(*connection_, DocumentKind::kSession)) {
    names += row.head.key.tenant + row.head.key.name + " ";
    EXPECT_EQ(*UnpackHead(row), Bytes(3, std::byte{7}));
  }
  EXPECT_EQ(names, "tb ta tc ua ");
  EXPECT_FALSE(FindDocument(*connection_, {DocumentKind::kJob, "t", "b"}).has_value());
}

TEST_F(SqliteRowsTest, OnlyTheNewestEpochOwnsADocument) {
  DocumentRow row = NewRow(kRowKey);
  EXPECT_TRUE(OwnedDocument(*connection_, kRowKey, Epoch::kFirst).ok());
  row.head.epoch = Epoch(2);
  PutDocument(*connection_, row);
  EXPECT_EQ(OwnedDocument(*connection_, kRowKey, Epoch::kFirst).error().code,
            ErrorCode::kSessionBusy);
  EXPECT_TRUE(OwnedDocument(*connection_, kRowKey, Epoch(2)).ok());
}

// Method: 2.5 MiB that do not compress make three rows; one is lost, one stands in another's place.
TEST_F(SqliteRowsTest, PutsLongBytesTogetherAgainAndMissesNone) {
  const DocumentRow row = NewRow(kRowKey);
  Bytes bytes(5 << 19);
  std::uint64_t x = 1;
  for (std::byte& byte : bytes) {
    x = x * 6364136223846793005u + 1442695040888963407u;
    byte = static_cast<std::byte>(x >> 56);
  }
  const RowPlace place{RowPart::kSnapshot, 4};
  const PackedPieces pieces = PackPieces(bytes, kRowKey, place);
  ASSERT_EQ(pieces.size(), 3u);
  EXPECT_GE(SizeOf(pieces), bytes.size());
  for (std::size_t i = 0; i < 3; ++i) PutPiece(*connection_, row.id, place, pieces, i);
  EXPECT_EQ(*ReadPieces(*connection_, row, place), bytes);

  connection_->database().exec("DELETE FROM rows WHERE piece = 1");
  EXPECT_EQ(ReadPieces(*connection_, row, place).error().code, ErrorCode::kDataCorrupt);
  connection_->database().exec("DELETE FROM rows WHERE piece = 2");
  EXPECT_FALSE(ReadPieces(*connection_, row, place).ok());
  PutPiece(*connection_, row.id, {RowPart::kSnapshot, 5}, pieces, 0);
  EXPECT_FALSE(ReadPieces(*connection_, row, {RowPart::kSnapshot, 5}).ok());
  DropRows(*connection_, row.id, RowPart::kSnapshot, 0, 9);
  EXPECT_FALSE(ReadPieces(*connection_, row, place).ok()) << "nothing is left of it";
}

}  // namespace
}  // namespace pliant::server
