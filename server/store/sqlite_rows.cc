#include "server/store/sqlite_rows.h"

#include <algorithm>
#include <string>
#include <utility>

namespace pliant::server {
namespace {

// A row of it fits well into one write of the log, and other documents get their turn between two.
constexpr std::size_t kPieceBytesMax = std::size_t{1} << 20;

// Says where a row stands in a way that does not change when the database is copied.
std::uint64_t PlaceOf(const StoreKey& key, RowPlace place, std::size_t piece) {
  ByteWriter writer;
  writer.Put(static_cast<std::int32_t>(key.kind));
  writer.PutText(key.tenant);
  writer.PutText(key.name);
  writer.Put(static_cast<std::int32_t>(place.part));
  writer.Put(place.number);
  writer.Put(static_cast<std::uint64_t>(piece));
  return Checksum(std::move(writer).Take());
}

// Heads stand where no record does.
constexpr RowPlace kHeadPlace{RowPart::kRecord, -1};

Error Damaged(const StoreKey& key, const std::string& what) {
  return {ErrorCode::kDataCorrupt,
          "the stored " + std::string(key.kind == DocumentKind::kJob ? "job " : "session ") +
              key.name + " is damaged: " + what +
              "; the others are not; restore it from a backup or delete it",
          key.name};
}

Packed TakePacked(SQLite::Statement& row, int first) {
  Packed packed;
  packed.form = static_cast<PackForm>(row.getColumn(first).getInt());
  packed.size = static_cast<std::size_t>(row.getColumn(first + 1).getInt64());
  packed.checksum = static_cast<std::uint64_t>(row.getColumn(first + 2).getInt64());
  const SQLite::Column blob = row.getColumn(first + 3);
  const auto* bytes = static_cast<const std::byte*>(blob.getBlob());
  packed.bytes.assign(bytes, bytes + blob.getBytes());
  return packed;
}

void BindPacked(SQLite::Statement& statement, int first, const Packed& packed) {
  statement.bind(first, static_cast<std::int32_t>(packed.form));
  statement.bind(first + 1, static_cast<std::int64_t>(packed.size));
  statement.bind(first + 2, static_cast<std::int64_t>(packed.checksum));
  // A blob of no bytes still needs a place, or it is NULL.
  static constexpr std::byte kNothing{};
  statement.bindNoCopy(first + 3, packed.bytes.empty() ? &kNothing : packed.bytes.data(),
                       static_cast<int>(packed.bytes.size()));
}

DocumentRow TakeRow(SQLite::Statement& row) {
  DocumentRow document;
  document.id = row.getColumn(0).getInt64();
  document.head.key = {DocumentKind(row.getColumn(1).getInt()), row.getColumn(2).getString(),
                       row.getColumn(3).getString()};
  document.head.epoch = Epoch(row.getColumn(4).getInt64());
  document.head.last_number = row.getColumn(5).getInt64();
  document.head.snapshot_number = row.getColumn(6).getInt64();
  document.head.snapshot_size = static_cast<std::size_t>(row.getColumn(7).getInt64());
  document.head.journal_size = static_cast<std::size_t>(row.getColumn(8).getInt64());
  document.packed_head = TakePacked(row, 9);
  return document;
}

}  // namespace

PackedPieces PackPieces(std::span<const std::byte> bytes, const StoreKey& name, RowPlace place) {
  PackedPieces pieces;
  do {
    const auto piece = bytes.first(std::min(bytes.size(), kPieceBytesMax));
    pieces.push_back(Pack(piece, PlaceOf(name, place, pieces.size())));
    bytes = bytes.subspan(piece.size());
  } while (!bytes.empty());
  return pieces;
}

std::optional<DocumentRow> FindDocument(SqliteConnection& connection, const StoreKey& key) {
  SQLite::Statement& find =
      connection.Use("SELECT * FROM documents WHERE kind = ? AND tenant = ? AND name = ?");
  find.bind(1, static_cast<std::int32_t>(key.kind));
  find.bindNoCopy(2, key.tenant);
  find.bindNoCopy(3, key.name);
  if (!find.executeStep()) return std::nullopt;
  return TakeRow(find);
}

Result<DocumentRow> OwnedDocument(SqliteConnection& connection, const StoreKey& key, Epoch epoch) {
  std::optional<DocumentRow> row = FindDocument(connection, key);
  if (!row) {
    return Error{ErrorCode::kSessionNotFound, "nothing is stored of " + key.name, "session_id"};
  }
  if (row->head.epoch != epoch) {
    return Error{ErrorCode::kSessionBusy,
                 "another server has claimed " + key.name + ", so this one no longer writes to it",
                 "session_id"};
  }
  return *std::move(row);
}

std::vector<DocumentRow> AllDocuments(SqliteConnection& connection, DocumentKind kind) {
  SQLite::Statement& all = connection.Use("SELECT * FROM documents WHERE kind = ? ORDER BY id");
  all.bind(1, static_cast<std::int32_t>(kind));
  std::vector<DocumentRow> rows;
  while (all.executeStep()) rows.push_back(TakeRow(all));
  return rows;
}

void PutDocument(SqliteConnection& connection, const DocumentRow& row) {
  SQLite::Statement& put = connection.Use(
      "INSERT INTO documents VALUES(NULLIF(?1, 0), ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?) "
      "ON CONFLICT(id) DO UPDATE SET epoch = excluded.epoch, last_number = excluded.last_number, "
      "snapshot_number = excluded.snapshot_number, snapshot_size = excluded.snapshot_size, "
      "journal_size = excluded.journal_size, form = excluded.form, size = excluded.size, "
      "checksum = excluded.checksum, head = excluded.head");
  put.bind(1, row.id);
  put.bind(2, static_cast<std::int32_t>(row.head.key.kind));
  put.bindNoCopy(3, row.head.key.tenant);
  put.bindNoCopy(4, row.head.key.name);
  put.bind(5, static_cast<std::int64_t>(row.head.epoch));
  put.bind(6, row.head.last_number);
  put.bind(7, row.head.snapshot_number);
  put.bind(8, static_cast<std::int64_t>(row.head.snapshot_size));
  put.bind(9, static_cast<std::int64_t>(row.head.journal_size));
  BindPacked(put, 10, row.packed_head);
  put.exec();
}

Packed PackHead(const Bytes& head, const StoreKey& key) {
  return Pack(head, PlaceOf(key, kHeadPlace, 0));
}

Result<Bytes> UnpackHead(const DocumentRow& row) {
  Result<Bytes> head = Unpack(row.packed_head, PlaceOf(row.head.key, kHeadPlace, 0));
  if (!head.ok()) return Damaged(row.head.key, head.error().message);
  return head;
}

void PutPiece(SqliteConnection& connection, std::int64_t document, RowPlace place,
              const PackedPieces& pieces, std::size_t piece) {
  SQLite::Statement& put =
      connection.Use("INSERT OR REPLACE INTO rows VALUES(?, ?, ?, ?, ?, ?, ?, ?, ?)");
  put.bind(1, document);
  put.bind(2, static_cast<std::int32_t>(place.part));
  put.bind(3, place.number);
  put.bind(4, static_cast<std::int64_t>(piece));
  put.bind(5, static_cast<std::int64_t>(pieces.size()));
  BindPacked(put, 6, pieces[piece]);
  put.exec();
}

void DropRows(SqliteConnection& connection, std::int64_t document, RowPart part, std::int64_t from,
              std::int64_t to) {
  SQLite::Statement& drop =
      connection.Use("DELETE FROM rows WHERE document = ? AND part = ? AND number BETWEEN ? AND ?");
  drop.bind(1, document);
  drop.bind(2, static_cast<std::int32_t>(part));
  drop.bind(3, from);
  drop.bind(4, to);
  drop.exec();
}

Result<Bytes> ReadPieces(SqliteConnection& connection, const DocumentRow& row, RowPlace place) {
  SQLite::Statement& read = connection.Use(
      "SELECT piece_count, form, size, checksum, bytes FROM rows "
      "WHERE document = ? AND part = ? AND number = ? ORDER BY piece");
  read.bind(1, row.id);
  read.bind(2, static_cast<std::int32_t>(place.part));
  read.bind(3, place.number);
  const std::string name =
      (place.part == RowPart::kSnapshot ? "snapshot " : "record ") + std::to_string(place.number);
  Bytes bytes;
  std::int64_t count = 0;
  std::int64_t expected = 1;
  while (read.executeStep()) {
    expected = read.getColumn(0).getInt64();
    const auto piece = static_cast<std::size_t>(count++);
    Result<Bytes> part = Unpack(TakePacked(read, 1), PlaceOf(row.head.key, place, piece));
    if (!part.ok()) return Damaged(row.head.key, "in " + name + ", " + part.error().message);
    if (bytes.empty()) {
      bytes = *std::move(part);
    } else {
      bytes.insert(bytes.end(), part->begin(), part->end());
    }
  }
  if (count != expected) return Damaged(row.head.key, name + " is not there as a whole");
  return bytes;
}

Result<StoredDocument> ReadDocument(SqliteConnection& connection, const DocumentRow& row) {
  StoredDocument document;
  document.head = row.head;
  PLIANT_ASSIGN_OR_RETURN(document.head.head, UnpackHead(row));
  PLIANT_ASSIGN_OR_RETURN(
      document.snapshot,
      ReadPieces(connection, row, {RowPart::kSnapshot, row.head.snapshot_number}));
  for (std::int64_t i = row.head.snapshot_number + 1; i <= row.head.last_number; ++i) {
    PLIANT_ASSIGN_OR_RETURN(Bytes record, ReadPieces(connection, row, {RowPart::kRecord, i}));
    document.records.push_back(std::move(record));
  }
  return document;
}

std::size_t SizeOf(const PackedPieces& pieces) {
  std::size_t size = 0;
  for (const Packed& piece : pieces) size += piece.bytes.size();
  return size;
}

}  // namespace pliant::server
