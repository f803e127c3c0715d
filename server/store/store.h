#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/result.h"

/// Where a server keeps what must survive it. The store knows documents, not sessions: what the
/// bytes mean is their owner's business (server/record.h for sessions).
namespace pliant::server {

/// What a document is.
enum class DocumentKind : std::int32_t { kSession = 1, kJob = 2 };

/// Names a document.
struct StoreKey {
  DocumentKind kind = DocumentKind::kSession;
  std::string tenant = {};
  std::string name = {};

  friend auto operator<=>(const StoreKey&, const StoreKey&) = default;
};

/// Who may write to a document: grows with every claim, and only the greatest one writes.
enum class Epoch : std::int64_t { kNone = 0, kFirst = 1 };

/// Records that are written together, all or none.
struct StoreBatch {
  std::int64_t first = 1;           ///< Number of the first of them: the last one's plus one.
  std::vector<Bytes> records = {};  ///< In order; may be empty.
  Bytes head = {};                  ///< Replaces the document's head.
};

/// What a document is without the records up to one of them.
struct StoreSnapshot {
  std::int64_t number = 0;  ///< Of the last record that it covers; 0: none.
  Bytes bytes = {};
};

/// A document as a list shows it.
struct StoredHead {
  StoreKey key = {};
  Epoch epoch = Epoch::kNone;
  Bytes head = {};
  std::int64_t last_number = 0;      ///< Of the records.
  std::int64_t snapshot_number = 0;  ///< Records up to this one are in the snapshot.
  std::size_t snapshot_size = 0;     ///< In bytes, as stored.
  std::size_t journal_size = 0;      ///< Of the records after it, in bytes, as stored.
};

/// A whole document.
struct StoredDocument {
  StoredHead head = {};
  Bytes snapshot = {};
  std::vector<Bytes> records = {};  ///< Those after the snapshot, in order.
};

/// Documents that survive the process: a head, a snapshot and a journal of records each.
///
/// Made for one owner at a time: Claim gives an epoch, and every write names it; one that names an
/// older one is refused in the same transaction that would have written, so that a server that
/// lost a document can never write to it (fencing). Engines for several servers add leases, which
/// Renew prolongs.
///
/// Writes are queued and end with `done`, called once, on any thread, also where the call itself
/// finds the error. Writes to one document take effect in the order of their calls. Several
/// documents share a transaction (group commit); one that fails does not harm the others. When
/// `done` says ok, the write survives a crash of the machine; otherwise nothing of it is there, or,
/// where the process ends before `done`, all of it or nothing.
///
/// Errors of all functions: kResourceExhausted (no space left), kFileUnwritable (read-only),
/// kDataCorrupt (what is stored is not what was written), kUnavailable (input/output error),
/// kSessionNotFound (no such document), kSessionBusy (the epoch is not the current one).
///
/// *Threads*: all functions from any thread. Writes wait while the queue is full.
class Store {
 public:
  using Done = std::function<void(const Status&)>;

  /// What a document begins with.
  struct Draft {
    Bytes head = {};
    Bytes snapshot = {};
  };

  virtual ~Store() = default;

  /// Makes a document, claimed with Epoch::kFirst. Error: kSessionExists.
  virtual void Create(const StoreKey& key, Draft draft, Done done) = 0;

  /// Makes the caller the only one who writes; waits until that is durable.
  virtual Result<Epoch> Claim(const StoreKey& key) = 0;
  /// Still the owner. An engine without leases only checks.
  virtual Status Renew(const StoreKey& key, Epoch epoch) = 0;
  /// No longer the owner: later writes with this epoch are refused.
  virtual Status Release(const StoreKey& key, Epoch epoch) = 0;

  /// Error: kInternal where `batch.first` is not the next number.
  virtual void Append(const StoreKey& key, Epoch epoch, StoreBatch batch, Done done) = 0;

  /// Replaces the snapshot and drops the records that it covers; until then the old ones stand. An
  /// older snapshot than the present one is left out. Written in parts, between other writes.
  virtual void PutSnapshot(const StoreKey& key, Epoch epoch, StoreSnapshot snapshot, Done done) = 0;

  virtual void Delete(const StoreKey& key, Epoch epoch, Done done) = 0;

  /// Everything that was durable when the call began.
  virtual Result<StoredDocument> Load(const StoreKey& key) = 0;

  /// The documents of a kind, oldest first. @par Cost O(documents), without their contents
  virtual Result<std::vector<StoredHead>> List(DocumentKind kind) = 0;
};

}  // namespace pliant::server
