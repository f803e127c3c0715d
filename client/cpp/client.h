#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "client/cpp/job_types.h"
#include "client/cpp/mesh_replica.h"
#include "client/cpp/session.h"
#include "client/cpp/subscription.h"
#include "client/cpp/types.h"
#include "core/base/bytes.h"
#include "core/base/result.h"
#include "core/metric/metric_spec.h"
#include "core/pliant/quality.h"

namespace pliant::client {

class Connection;

/// A connection to a pliantd.
///
/// Errors of all calls: what the server refused, with code, field and indices as it saw them;
/// kUnavailable if it cannot be reached; kDeadlineExceeded.
/// *Threads*: any number. Copies share the connection, which lives as long as any of them or a
/// Session.
class Client {
 public:
  /// Connects and asks the server who it is.
  ///
  /// @param address  "localhost:7447", "unix:relative/path.sock" or "unix:///absolute/path.sock".
  /// @param options  certificates and a token for servers on other machines.
  static Result<Client> Connect(const std::string& address, const ConnectOptions& options = {});

  [[nodiscard]] const std::string& address() const;
  [[nodiscard]] const ServerInfo& server_info() const;

  /// Creates a session and opens it. It is at revision 0; the first Advance makes the first mesh.
  /// The input is checked in full by the server. Errors: those of TriangulateDomain or of imported
  /// meshes, MakeMetricField, options; kSessionExists, kResourceExhausted.
  Result<std::unique_ptr<Session>> CreateSession(const Start& start, const MetricSpec& metric,
                                                 const SessionSettings& settings = {});

  /// Opens a session that exists; its replica starts with a snapshot. Fails with kSessionNotFound,
  /// or kSessionBusy while another editor has it.
  Result<std::unique_ptr<Session>> OpenSession(const std::string& session_id,
                                               Parts parts = Parts::kMesh);

  /// Follows a session that anybody edits. What is wrong with the id shows in the first Next.
  std::unique_ptr<Subscription> Subscribe(const std::string& session_id,
                                          const SubscribeOptions& options = {});

  /// Fails with kSessionNotFound.
  Result<SessionInfo> GetSession(const std::string& session_id);
  /// All sessions, oldest first.
  Result<std::vector<SessionInfo>> ListSessions();
  /// Ends a session and frees what it holds; returns its last revision.
  Result<Revision> DeleteSession(const std::string& session_id);

  /// The mesh of the current revision. Fails with kRevisionNotFound before the first commit.
  Result<MeshReplica> GetMesh(const std::string& session_id, Parts parts = Parts::kMesh);
  Result<Quality> GetQuality(const std::string& session_id);

  // Sessions as files. In client_files.cc.

  /// A session at its current revision as the bytes of a file, opaque. Fails with
  /// kRevisionNotFound before the first commit, kProtocolOrder while updates are staged, kTooLarge.
  Result<Bytes> ExportSession(const std::string& session_id);
  /// Creates a session from such bytes, on this or another server: it goes on with the same bits.
  /// Errors: kDataCorrupt, kDataVersion; kSessionExists, kTooLarge, kResourceExhausted.
  /// @param session_id  wished id; empty: the server makes one.
  Result<SessionInfo> ImportSession(std::span<const std::byte> file,
                                    const std::string& session_id = {});

  // Jobs: remeshing that nobody waits for. In client_jobs.cc.

  /// Puts a job into the server's queue. Arrays that are wrong by themselves are refused here; how
  /// they fit together shows in JobInfo::error. Errors: kJobExists, kResourceExhausted.
  Result<JobInfo> SubmitJob(const Start& start, const MetricSpec& metric,
                            const JobSettings& settings = {});
  /// Fails with kJobNotFound, also when the job's time is over.
  Result<JobInfo> GetJob(const std::string& job_id);
  /// All jobs, newest first.
  Result<std::vector<JobInfo>> ListJobs();
  /// Stops a job; one that has ended stays as it is.
  Result<JobInfo> CancelJob(const std::string& job_id);
  /// The mesh of a job that is done. Fails with kJobNotDone.
  Result<MeshReplica> FetchResult(const std::string& job_id, Parts parts = Parts::kMesh);
  /// Asks, ever more rarely, until the job has ended; a server that is out of reach for a while is
  /// waited for. Fails with kDeadlineExceeded or kCancelled where `wait` says so.
  Result<JobInfo> WaitForJob(const std::string& job_id, const JobWait& wait = {});

 private:
  explicit Client(std::shared_ptr<Connection> connection);
  std::shared_ptr<Connection> connection_;
};

}  // namespace pliant::client
