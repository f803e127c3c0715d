#include "server/store/sqlite_store.h"

#include <filesystem>
#include <future>
#include <optional>
#include <utility>

#include "core/base/check.h"
#include "server/limits.h"
#include "server/store/sqlite_connection.h"
#include "server/store/sqlite_rows.h"

namespace pliant::server {
namespace {

// Log pages after which the writer moves them into the database: when it has nothing else to do,
// and, far later, in any case.
constexpr int kIdlePages = 1'000;
constexpr int kPagesMax = 16'000;

std::size_t SizeOf(const StoreBatch& batch) {
  std::size_t size = batch.head.size();
  for (const Bytes& record : batch.records) size += record.size();
  return size;
}

Status CheckNext(const DocumentRow& row, std::int64_t first) {
  if (first == row.head.last_number + 1) return {};
  return Error{ErrorCode::kInternal,
               "record " + std::to_string(first) + " of " + row.head.key.name +
                   " does not follow record " + std::to_string(row.head.last_number),
               {}};
}

// The same write that Append does, packed by the caller's thread.
struct PackedBatch {
  std::int64_t first = 0;
  std::vector<PackedPieces> records;
  Packed head;
};

Status AppendNow(SqliteConnection& connection, const StoreKey& key, Epoch epoch,
                 const PackedBatch& batch) {
  PLIANT_ASSIGN_OR_RETURN(DocumentRow row, OwnedDocument(connection, key, epoch));
  PLIANT_RETURN_IF_ERROR(CheckNext(row, batch.first));
  for (const PackedPieces& record : batch.records) {
    const RowPlace place{RowPart::kRecord, ++row.head.last_number};
    for (std::size_t i = 0; i < record.size(); ++i) PutPiece(connection, row.id, place, record, i);
    row.head.journal_size += SizeOf(record);
  }
  row.packed_head = batch.head;
  PutDocument(connection, row);
  return {};
}

Status CreateNow(SqliteConnection& connection, const StoreKey& key, const Packed& head,
                 const PackedPieces& snapshot) {
  if (FindDocument(connection, key)) {
    return Error{ErrorCode::kSessionExists, key.name + " is stored already", "session_id"};
  }
  DocumentRow row;
  row.head.key = key;
  row.head.epoch = Epoch::kFirst;
  row.head.snapshot_size = SizeOf(snapshot);
  row.packed_head = head;
  PutDocument(connection, row);
  row.id = connection.database().getLastInsertRowid();
  for (std::size_t i = 0; i < snapshot.size(); ++i) {
    PutPiece(connection, row.id, {RowPart::kSnapshot, 0}, snapshot, i);
  }
  return {};
}

// From here on the new snapshot counts; what it covers goes.
Status SwitchSnapshot(SqliteConnection& connection, const StoreKey& key, Epoch epoch,
                      std::int64_t number, std::size_t size) {
  PLIANT_ASSIGN_OR_RETURN(DocumentRow row, OwnedDocument(connection, key, epoch));
  if (number <= row.head.snapshot_number || number > row.head.last_number) return {};
  DropRows(connection, row.id, RowPart::kRecord, 0, number);
  DropRows(connection, row.id, RowPart::kSnapshot, 0, number - 1);
  row.head.snapshot_number = number;
  row.head.snapshot_size = size;
  SQLite::Statement& left =
      connection.Use("SELECT TOTAL(LENGTH(bytes)) FROM rows WHERE document = ? AND part = 1");
  left.bind(1, row.id);
  left.executeStep();
  row.head.journal_size = static_cast<std::size_t>(left.getColumn(0).getDouble());
  PutDocument(connection, row);
  return {};
}

}  // namespace

Result<std::unique_ptr<SqliteStore>> SqliteStore::Open(const Options& options) {
  PLIANT_ASSIGN_OR_RETURN(DirectoryLock lock, DirectoryLock::Take(options.directory));
  std::unique_ptr<SqliteStore> store(new SqliteStore(options, std::move(lock)));
  PLIANT_ASSIGN_OR_RETURN(
      store->writer_,
      SqliteConnection::Open(store->path(), SqliteConnection::Mode::kWrite, options.vfs));
  PLIANT_ASSIGN_OR_RETURN(
      store->reader_,
      SqliteConnection::Open(store->path(), SqliteConnection::Mode::kRead, options.vfs));
  store->thread_ = std::thread([self = store.get()] { self->RunWriter(); });
  return store;
}

SqliteStore::SqliteStore(const Options& options, DirectoryLock lock)
    : options_(options), lock_(std::move(lock)), queue_(kStoreQueueBytesMax) {}

SqliteStore::~SqliteStore() {
  queue_.Close();
  if (thread_.joinable()) thread_.join();
}

std::string SqliteStore::path() const { return options_.directory + "/" + kDatabaseFile; }

// --- Writes -------------------------------------------------------------------------------------

void SqliteStore::Create(const StoreKey& key, Draft draft, Done done) {
  const std::size_t size = draft.head.size() + draft.snapshot.size();
  Queue([key, head = PackHead(draft.head, key),
         snapshot = PackPieces(draft.snapshot, key, {RowPart::kSnapshot, 0})](
            SqliteConnection& connection) { return CreateNow(connection, key, head, snapshot); },
        size, std::move(done));
}

Result<Epoch> SqliteStore::Claim(const StoreKey& key) {
  auto epoch = std::make_shared<Epoch>(Epoch::kNone);
  PLIANT_RETURN_IF_ERROR(Wait([key, epoch](SqliteConnection& connection) -> Status {
    std::optional<DocumentRow> row = FindDocument(connection, key);
    if (!row) {
      return Error{ErrorCode::kSessionNotFound, "nothing is stored of " + key.name, "session_id"};
    }
    row->head.epoch = Epoch(static_cast<std::int64_t>(row->head.epoch) + 1);
    PutDocument(connection, *row);
    *epoch = row->head.epoch;
    return {};
  }));
  return *epoch;
}

Status SqliteStore::Renew(const StoreKey& key, Epoch epoch) {
  return Wait([key, epoch](SqliteConnection& connection) -> Status {
    PLIANT_ASSIGN_OR_RETURN(const DocumentRow row, OwnedDocument(connection, key, epoch));
    return {};
  });
}

Status SqliteStore::Release(const StoreKey& key, Epoch epoch) {
  return Wait([key, epoch](SqliteConnection& connection) -> Status {
    PLIANT_ASSIGN_OR_RETURN(DocumentRow row, OwnedDocument(connection, key, epoch));
    row.head.epoch = Epoch(static_cast<std::int64_t>(epoch) + 1);
    PutDocument(connection, row);
    return {};
  });
}

void SqliteStore::Append(const StoreKey& key, Epoch epoch, StoreBatch batch, Done done) {
  const std::size_t size = SizeOf(batch);
  PackedBatch packed{.first = batch.first, .records = {}, .head = PackHead(batch.head, key)};
  std::int64_t number = batch.first;
  for (const Bytes& record : batch.records) {
    packed.records.push_back(PackPieces(record, key, {RowPart::kRecord, number++}));
  }
  Queue([key, epoch, packed = std::move(packed)](
            SqliteConnection& connection) { return AppendNow(connection, key, epoch, packed); },
        size, std::move(done));
}

// Each piece is a write of its own, so that other documents get their turn in between.
void SqliteStore::PutSnapshot(const StoreKey& key, Epoch epoch, StoreSnapshot snapshot, Done done) {
  const RowPlace place{RowPart::kSnapshot, snapshot.number};
  const auto pieces = std::make_shared<const PackedPieces>(PackPieces(snapshot.bytes, key, place));
  snapshot.bytes = {};
  // The first piece that fails; the others and the switch are then left out.
  const auto failed = std::make_shared<std::optional<Error>>();
  for (std::size_t i = 0; i < pieces->size(); ++i) {
    Queue(
        [key, epoch, place, pieces, failed, i](SqliteConnection& connection) -> Status {
          if (*failed) return **failed;
          PLIANT_ASSIGN_OR_RETURN(const DocumentRow row, OwnedDocument(connection, key, epoch));
          if (place.number > row.head.snapshot_number) {
            PutPiece(connection, row.id, place, *pieces, i);
          }
          return {};
        },
        (*pieces)[i].bytes.size(),
        [failed](const Status& status) {
          if (!status.ok() && !*failed) *failed = status.error();
        });
  }
  Queue(
      [key, epoch, pieces, failed,
       number = snapshot.number](SqliteConnection& connection) -> Status {
        if (*failed) return **failed;
        return SwitchSnapshot(connection, key, epoch, number, SizeOf(*pieces));
      },
      0, std::move(done));
}

void SqliteStore::Delete(const StoreKey& key, Epoch epoch, Done done) {
  Queue(
      [key, epoch](SqliteConnection& connection) -> Status {
        PLIANT_ASSIGN_OR_RETURN(const DocumentRow row, OwnedDocument(connection, key, epoch));
        DropRows(connection, row.id, RowPart::kRecord, 0, INT64_MAX);
        DropRows(connection, row.id, RowPart::kSnapshot, 0, INT64_MAX);
        SQLite::Statement& drop = connection.Use("DELETE FROM documents WHERE id = ?");
        drop.bind(1, row.id);
        drop.exec();
        return {};
      },
      0, std::move(done));
}

void SqliteStore::Queue(Work work, std::size_t bytes, Done done) {
  queue_.Put(Write{std::move(work), std::move(done)}, bytes);
}

Status SqliteStore::Wait(Work work) {
  std::promise<Status> promise;
  Queue(std::move(work), 0, [&promise](const Status& status) { promise.set_value(status); });
  return promise.get_future().get();
}

// --- The thread that writes ---------------------------------------------------------------------

void SqliteStore::RunWriter() {
  for (;;) {
    std::vector<Write> writes = queue_.Take(kStoreGroupMax);
    if (writes.empty()) return;
    Run(std::move(writes));
    if (writer_ != nullptr) writer_->Checkpoint(queue_.empty() ? kIdlePages : kPagesMax);
  }
}

void SqliteStore::Run(std::vector<Write> writes) {
  std::vector<Status> results = Try(writes);
  if (results.empty() && writes.size() == 1) results.emplace_back(last_error_);
  if (!results.empty()) {
    for (std::size_t i = 0; i < writes.size(); ++i) writes[i].done(results[i]);
    return;
  }
  // Whoever is to blame fails alone.
  for (Write& write : writes) {
    std::vector<Write> one;
    one.push_back(std::move(write));
    Run(std::move(one));
  }
}

// Carries out writes in one transaction: what became of each, or nothing if all of it failed, for
// `last_error_`.
std::vector<Status> SqliteStore::Try(const std::vector<Write>& writes) {
  if (writer_ == nullptr) {
    auto opened = SqliteConnection::Open(path(), SqliteConnection::Mode::kWrite, options_.vfs);
    if (!opened.ok()) {
      last_error_ = opened.error();
      return {};
    }
    writer_ = std::move(opened).value();
  }
  try {
    std::vector<Status> results;
    results.reserve(writes.size());
    writer_->Run("BEGIN IMMEDIATE");
    for (const Write& write : writes) results.push_back(write.work(*writer_));
    writer_->Run("COMMIT");
    return results;
  } catch (const SQLite::Exception& exception) {
    last_error_ = SqliteConnection::ToError(exception, path());
    writer_->RollBack();
    // What it holds in memory may no longer be what the disk holds.
    if (last_error_.code != ErrorCode::kResourceExhausted) writer_ = nullptr;
    return {};
  }
}

// --- Reads --------------------------------------------------------------------------------------

template <class Value>
Result<Value> SqliteStore::Read(const std::function<Result<Value>(SqliteConnection&)>& work) {
  const std::lock_guard lock(read_mutex_);
  try {
    if (reader_ == nullptr) {
      PLIANT_ASSIGN_OR_RETURN(
          reader_, SqliteConnection::Open(path(), SqliteConnection::Mode::kRead, options_.vfs));
    }
    reader_->Run("BEGIN");
    Result<Value> value = work(*reader_);
    reader_->RollBack();
    return value;
  } catch (const SQLite::Exception& exception) {
    if (reader_ != nullptr) reader_->RollBack();
    reader_ = nullptr;
    return SqliteConnection::ToError(exception, path());
  }
}

Result<StoredDocument> SqliteStore::Load(const StoreKey& key) {
  return Read<StoredDocument>([&](SqliteConnection& connection) -> Result<StoredDocument> {
    const std::optional<DocumentRow> row = FindDocument(connection, key);
    if (!row) {
      return Error{ErrorCode::kSessionNotFound, "nothing is stored of " + key.name, "session_id"};
    }
    return ReadDocument(connection, *row);
  });
}

Result<std::vector<StoredHead>> SqliteStore::List(DocumentKind kind) {
  using Heads = std::vector<StoredHead>;
  return Read<Heads>([&](SqliteConnection& connection) -> Result<Heads> {
    Heads heads;
    for (DocumentRow& row : AllDocuments(connection, kind)) {
      Result<Bytes> head = UnpackHead(row);
      heads.push_back(std::move(row.head));
      if (head.ok()) heads.back().head = std::move(head).value();
    }
    return heads;
  });
}

}  // namespace pliant::server
