#pragma once

#include <cstddef>
#include <cstdint>

/// Every bound of the server, with its reason. Tests stand at each bound and one past it.
namespace pliant::server {

// Messages.

/// Largest message that is read or sent, in bytes: a quarter of gRPC's default limit, so that no
/// client has to raise anything.
inline constexpr int kMessageBytesMax = 1 << 20;
/// Largest piece of an array in one message, in bytes: large enough that framing costs nothing,
/// small enough that a stream is never blocked for long by one message.
inline constexpr std::size_t kChunkBytesMax = 512 << 10;
/// Arrays up to this size are sent inside their message, in bytes: the dozen arrays of a diff then
/// stay below kMessageBytesMax together.
inline constexpr std::size_t kInlineBytesMax = 64 << 10;
/// Complete blobs that wait for the message that names them: more than any message has arrays.
inline constexpr std::size_t kBlobsPendingMax = 64;
/// Bytes of blobs that wait, or are being sent, on one stream: a background mesh of ten million
/// vertices fits; a client that only sends chunks is stopped here.
inline constexpr std::size_t kUploadBytesMax = std::size_t{1} << 30;

// Streams.

/// Commands of one edit stream that wait for their session. Beyond it the stream is not read, so
/// that gRPC's flow control stops the client; more would only hide latency.
inline constexpr std::size_t kInboxCommandsMax = 64;
/// Bytes of those commands; one command more may be held, whatever its size.
inline constexpr std::size_t kInboxBytesMax = 64 << 20;
/// Bytes of answers that wait for a slow reader. Beyond it the session takes no further command of
/// that stream; the answer to one command more may be held, whatever its size.
inline constexpr std::size_t kOutboxBytesMax = 8 << 20;
/// Calls (GetMesh, GetQuality) that wait for one session; beyond it they are refused and the
/// client may retry. An answer can be as large as the mesh, so few of them are held.
inline constexpr std::size_t kCallsMax = 16;
/// Answers to updates that a session remembers, so that a repeated update is not applied twice: a
/// client has at most kInboxCommandsMax unanswered, so this covers many reconnections.
inline constexpr std::size_t kUpdateResultsMax = 1024;
/// Greatest number of an update. Numbers only grow: who takes the last that there is ends a
/// session's updates for good, and a slip such as the greatest 64-bit integer must not. So a number
/// may take at most half of those that are left (UpdateResults::CheckNew). Points in time in
/// nanoseconds fit, until the year 2043.
inline constexpr std::int64_t kUpdateIdMax = std::int64_t{1} << 62;
/// Cancelled updates that a session remembers until they begin, those that begin first: more than
/// may wait in a stream, and a client that names numbers at random fills no memory.
inline constexpr std::size_t kCancelsMax = 1024;
/// Meshes that are being downloaded at once, over all sessions: a slow reader holds a copy of its
/// mesh, and this bounds how many there are.
inline constexpr int kDownloadsMax = 64;
/// Least progress interval, in ms: faster than a person or a monitor can use.
inline constexpr std::int64_t kProgressIntervalMsMin = 10;

/// Subscribers of one session: an entry and, while one reads, one message each.
inline constexpr std::size_t kSubscribersMax = 4096;
/// Regions that one subscriber names: more than domains have that people draw.
inline constexpr int kRegionTagsMax = 4096;
/// Bytes of diffs that a session keeps unless its options say less: hours of small updates, and
/// less than the mesh that they belong to where updates are large.
inline constexpr std::size_t kHistoryBytesMax = 16 << 20;
/// The same for each vertex: two whole meshes or so, beyond which a snapshot is cheaper than what
/// was missed. So a thousand small sessions stay small; but not below the least.
inline constexpr std::size_t kHistoryBytesPerVertex = 256;
inline constexpr std::size_t kHistoryBytesLeast = 256 << 10;
/// Bytes of undo data that a session keeps, beyond what saved revisions need: a raw record is about
/// three times its row in a diff.
inline constexpr std::size_t kUndoBytesMax = 64 << 20;
/// The same for each vertex: about four meshes; but not below the least, four meshes of five
/// hundred vertices.
inline constexpr std::size_t kUndoBytesPerVertex = 1024;
inline constexpr std::size_t kUndoBytesLeast = 512 << 10;
/// Of both together, as a session may ask for.
inline constexpr std::int64_t kKeptBytesMax = kUndoBytesMax + kHistoryBytesMax;
/// Saved revisions of one session: each can cost as much as the mesh.
inline constexpr std::size_t kSavedRevisionsMax = 16;
/// Time without news after which a subscriber gets a bookmark, in ms: a sign of life that costs
/// nothing, and a point to resume from. Unless configured otherwise.
inline constexpr std::int64_t kBookmarkMsDefault = 10'000;
/// Least interval of commits within one advance, in ms: a commit costs what changed, and its reader
/// has to keep up.
inline constexpr std::int64_t kCommitIntervalMsMin = 10;

// Scheduling.

/// Time that a session computes before the next one gets its turn, in ms: a small update waits for
/// at most this per busy session and worker, and switching costs nothing beside it.
inline constexpr std::int64_t kSliceMs = 2;
/// A worker that has not ended its slice after so long, in ms, is replaced until it does: work that
/// cannot be cut, such as a commit of a large mesh, must not hold up small sessions; shorter ones
/// are not worth a switch of threads.
inline constexpr std::int64_t kHandOffMs = 4 * kSliceMs;
/// Workers that may be away at once: so many stretches of large meshes share the cores and the
/// memory, and more wait. A spare thread costs its stack.
inline constexpr std::size_t kSpareWorkersMax = 16;
/// Visits between two looks at the clock: about half a slice at a microsecond a visit.
inline constexpr std::int64_t kVisitsPerStep = 1000;
/// Commands that a session handles before the next one gets its turn, however quick they are.
inline constexpr int kCommandsPerSlice = 16;
/// Worker threads at most; a configuration beyond it is a mistake.
inline constexpr int kWorkersMax = 256;

// Sessions.

/// Sessions at once unless configured otherwise: an empty one holds a few KiB.
inline constexpr std::size_t kSessionsMaxDefault = 4096;
/// Vertices of one session unless configured otherwise: about 2.5 GB in the core.
inline constexpr std::int32_t kVerticesMaxDefault = 10'000'000;
/// Memory of a session per vertex, in bytes, as the accounts of tenants count it: what the core
/// needs while it works on a large mesh. History and undo data are counted as they are.
inline constexpr std::int64_t kBytesPerVertex = 250;
/// Compute time that a limited tenant may use at once, in ms, unless configured: a first mesh of
/// some million vertices.
inline constexpr std::int64_t kTenantBurstMsDefault = 10'000;
/// What a caller is told to wait when too many calls wait for a session, in ms: an advance or two.
inline constexpr std::int64_t kCallRetryMs = 100;
/// What a caller is told to wait when the server has no room for a session, in ms.
inline constexpr std::int64_t kSessionRetryMs = 10'000;
/// Between two looks for sessions that nobody uses, in ms: far below any policy that makes sense.
inline constexpr std::int64_t kIdleCheckMs = 500;
/// Characters of a session id.
inline constexpr std::size_t kSessionIdLengthMax = 64;
/// Characters of a request id that are logged: a UUID and some more.
inline constexpr std::size_t kRequestIdLengthMax = 64;
/// Characters of one expression: a person's formula is a tenth of it; evaluation cost grows with
/// it.
inline constexpr std::size_t kExpressionLengthMax = 4096;
/// Motions by tag in one update: more than any boundary has parts that move differently.
inline constexpr std::size_t kTagMotionsMax = 4096;
/// Labels of a session and characters of a key or a value: 1,000 sessions of a list with usual
/// labels then fit into one message.
inline constexpr std::size_t kLabelsMax = 16;
inline constexpr std::size_t kLabelLengthMax = 64;
/// Sessions on one page of a list, at most and by default.
inline constexpr std::int32_t kPageSizeMax = 1000;
inline constexpr std::int32_t kPageSizeDefault = 100;

// Store.

/// Bytes that wait to be written, over all sessions; beyond it workers wait for the disk, which is
/// then slower than everything they could do.
inline constexpr std::size_t kStoreQueueBytesMax = std::size_t{256} << 20;
/// Bytes of one session with relaxed durability that wait to be written; beyond it the session
/// waits: twice a large commit.
inline constexpr std::size_t kJournalPendingBytesMax = 16 << 20;
/// Time without use after which a stored session leaves memory, in s, unless configured.
inline constexpr std::int64_t kSleepAfterSDefault = 600;
/// A journal that is smaller is not worth a snapshot, however small that would be.
inline constexpr std::size_t kJournalBytesMin = 64 << 10;
/// Writes in one transaction: so many share one wait for the disk, and fail together at first.
inline constexpr std::size_t kStoreGroupMax = 256;

// Jobs.

/// Jobs at once unless configured otherwise, in all states together: without its input and result
/// one holds a few KiB.
inline constexpr std::size_t kJobsMaxDefault = 10'000;
/// Bytes of inputs and results at which new jobs are refused, unless configured otherwise: results
/// of a hundred million vertices in all. What runs then still finds a place for its result, so the
/// bound is exceeded by at most the results of the jobs that run at once.
inline constexpr std::size_t kJobsBytesMaxDefault = std::size_t{8} << 30;
/// Time for which an ended job is kept that does not say, in h: until somebody has looked on the
/// next day.
inline constexpr std::int64_t kJobKeepHDefault = 24;
/// And at most, in h: a month; a job is no archive.
inline constexpr std::int64_t kJobKeepHMax = 720;
inline constexpr std::int64_t kJobKeepMsMax = kJobKeepHMax * 3'600'000;
/// Bytes of one page of a list of jobs: half of a message. One job more may be in it if it is
/// alone.
inline constexpr std::size_t kJobPageBytesMax = 512 << 10;

// Shutdown.

/// Time that streams get to take their last messages at shutdown, in ms, unless configured.
inline constexpr std::int64_t kDrainMsDefault = 10'000;
/// Time for short calls and the last bytes of ended ones to leave after that, in ms.
inline constexpr std::int64_t kLastWordsMs = 200;

}  // namespace pliant::server
