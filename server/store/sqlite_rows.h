#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/result.h"
#include "server/store/packing.h"
#include "server/store/sqlite_connection.h"
#include "server/store/store.h"

/// How documents lie in the tables: the statements of SqliteStore. All of them throw
/// SQLite::Exception where SQLite fails, and belong into a transaction.
namespace pliant::server {

/// Which part of a document a row belongs to. Numbers are part of the format.
enum class RowPart : std::int32_t { kSnapshot = 0, kRecord = 1 };

/// Bytes cut into rows that are not too long for the database, each packed.
using PackedPieces = std::vector<Packed>;

/// Where a row stands.
struct RowPlace {
  RowPart part = RowPart::kRecord;
  std::int64_t number = 0;
};

/// @param name  of the document: rows of others do not pass for its own.
[[nodiscard]] PackedPieces PackPieces(std::span<const std::byte> bytes, const StoreKey& name,
                                      RowPlace place);

/// A document's row in the table.
struct DocumentRow {
  std::int64_t id = 0;
  StoredHead head = {};
  Packed packed_head = {};
};

/// Absent if there is no such document.
std::optional<DocumentRow> FindDocument(SqliteConnection& connection, const StoreKey& key);
/// The row, if the epoch may write. Errors: kSessionNotFound, kSessionBusy.
Result<DocumentRow> OwnedDocument(SqliteConnection& connection, const StoreKey& key, Epoch epoch);
/// All of a kind, by age; the heads packed.
std::vector<DocumentRow> AllDocuments(SqliteConnection& connection, DocumentKind kind);

/// Writes what changed in a row, head included. A new row has the id 0.
void PutDocument(SqliteConnection& connection, const DocumentRow& row);
[[nodiscard]] Packed PackHead(const Bytes& head, const StoreKey& key);
/// Error: kDataCorrupt.
[[nodiscard]] Result<Bytes> UnpackHead(const DocumentRow& row);

void PutPiece(SqliteConnection& connection, std::int64_t document, RowPlace place,
              const PackedPieces& pieces, std::size_t piece);
/// Rows of a part with numbers in [from, to].
void DropRows(SqliteConnection& connection, std::int64_t document, RowPart part, std::int64_t from,
              std::int64_t to);
/// The bytes with this number. Error: kDataCorrupt.
Result<Bytes> ReadPieces(SqliteConnection& connection, const DocumentRow& row, RowPlace place);

/// Everything of a document. Error: kDataCorrupt, which names it.
Result<StoredDocument> ReadDocument(SqliteConnection& connection, const DocumentRow& row);

/// As stored, in bytes.
[[nodiscard]] std::size_t SizeOf(const PackedPieces& pieces);

}  // namespace pliant::server
