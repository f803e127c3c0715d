#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/base/stop_signal.h"
#include "server/clock.h"
#include "server/diff_history.h"
#include "server/followers.h"
#include "server/inbox.h"
#include "server/limits.h"
#include "server/log.h"
#include "server/memory_budget.h"
#include "server/record.h"
#include "server/saved_state.h"
#include "server/scheduler.h"
#include "server/session_journal.h"
#include "server/session_messages.h"
#include "server/staged_engine.h"
#include "server/tenant_account.h"
#include "server/undo_history.h"
#include "server/update_results.h"

namespace pliant::server {

/// The other end of a session's edit stream.
///
/// *Threads*: all functions from any thread; none calls back into the session.
class Editor {
 public:
  virtual ~Editor() = default;
  /// The oldest command that waits; nothing if none does, or while there is no room for answers.
  /// Whoever makes that change wakes the session.
  virtual std::optional<SessionCommand> NextCommand() = 0;
  /// Shows the commands that NextCommand would give, in order, until `look` says false.
  virtual void LookAhead(const std::function<bool(const SessionCommand&)>& look) const = 0;
  /// The last command taken is answered in full.
  virtual void CommandDone() = 0;
  /// Answers that nobody asked for may be made: the reader keeps up.
  [[nodiscard]] virtual bool HasRoom() const = 0;
  /// Queues an event. Progress may be dropped if there is no room.
  virtual void Send(SessionEvent event) = 0;
  /// Sends what is queued and a closing event, then ends the stream with this error.
  virtual void Close(const Error& error) = 0;
};

/// What a call (GetMesh, GetQuality) sees of a session between two updates.
class Session;
struct CommittedState {
  const Engine& engine;
  Revision revision;
  std::int64_t applied_update_id;
  std::int64_t active_count;
  /// Updates that the engine's metric has, but the session's revision has not yet.
  std::int32_t staged_count;
  MeshSummary summary;
  /// For calls that do something: RollbackTo, SaveRevision, Release, Fork and GoOn may be called.
  Session* session = nullptr;
};
/// A call, run on a worker: with the state, or with why there is none.
using SessionCall = std::function<void(const Result<const CommittedState*>&)>;
/// The rest of a call that takes long, run slice after slice like an advance: works until about
/// `slice_end`, and says true when the call is answered. If what it looks at is gone it is called
/// once more, with the reason, and answers that at once.
using SessionCallRest = std::function<bool(const Status& session, Clock::Time slice_end)>;

/// Makes the memory that a session begins with.
using SessionReader = std::function<Result<SessionMemory>()>;

/// One persistent mesh with its editor and readers; a task that computes in slices.
///
/// *Invariants*: the engine is seen by others only at a commit. Every command is answered exactly
/// once and in order, except progress. A repeated update is answered and not applied.
/// *Threads*: RPC threads call the functions of the first group, which only queue; RunSlice runs
/// on one worker at a time and owns everything without a note. `mutex_` guards what carries its
/// note; no foreign function is called under it but Scheduler::Wake.
class Session final : public Task, public std::enable_shared_from_this<Session> {
 public:
  /// What a session uses of its server; all outlive it.
  struct Environment {
    const Clock* clock = nullptr;
    Scheduler* scheduler = nullptr;
    const Log* log = nullptr;
    EngineFactory factory;
    /// What brings back a session that is stored.
    EngineLoader loader = {};
    const SessionCodec* codec = nullptr;
    /// Where the session is kept; null: in memory only.
    std::shared_ptr<Journal> journal = {};
    Durability durability = Durability::kStrict;
    /// Is told how much memory the session holds; null: nobody asks.
    MemoryBudget* budget = nullptr;
    /// Called from a worker when a bug has ended the session: nobody should find it any more.
    std::function<void(const std::string& session_id)> on_broken;
    /// Visits between two looks at the clock.
    std::int64_t visits_per_step = kVisitsPerStep;
    /// Diffs of any session, and what this one was created to keep: see kept_bytes.h.
    std::size_t history_bytes_max = kHistoryBytesMax;
    std::optional<std::int64_t> history_bytes_asked = {};
    /// Of the tenant; null: nobody counts.
    std::shared_ptr<TenantAccount> account = nullptr;
  };

  Session(Environment environment, std::string session_id,
          std::map<std::string, std::string> labels);
  /// One that is stored: it is loaded when somebody needs it.
  Session(Environment environment, SessionInfo stored);

  /// Builds the engine on a worker, then calls `done` there. Once, first of all.
  /// @param form  the input as it came, for the journal; SessionCodec reads it
  void Start(EngineInput input, std::function<void(const Status&)> done, Bytes form = {});

  /// The same for one that goes on where another one was. Charges its tenant for the reading.
  /// @param read  called on a worker; may throw
  void Start(SessionReader read, std::function<void(const Status&)> done);

  /// Makes this the session's editor. Error: kSessionBusy while there is another one.
  Status Attach(std::shared_ptr<Editor> editor);
  /// The editor is gone; its commands that were not begun are dropped, and so is an update that is
  /// being staged, unless it is too late to leave everything as it was; an advance goes on.
  void Detach(const Editor* editor);
  /// Tells a subscriber what it misses from now on, beginning with a diff, a snapshot or, if its
  /// revision is the current one, a bookmark. Error: kResourceExhausted.
  Status Subscribe(std::shared_ptr<Subscriber> subscriber, Revision mirror_revision);
  void Unsubscribe(const Subscriber* subscriber);
  /// A subscriber is ready for more.
  void WakeForSubscriber();
  /// Ends the advance with this id early, now or when it begins, or refuses the update with this id
  /// that is being staged.
  void CancelAdvance(std::int64_t update_id);
  /// Queues a call; the answer waits for a running advance. Error: kResourceExhausted.
  Status Post(SessionCall call);
  /// Ends the session: its editor and waiting calls get the error, its memory is freed.
  void Close(Error error);
  /// Ends the session and forgets what is stored of it; `done` when that is durable. Errors:
  /// kSessionNotFound while it is being deleted; those of Store: then it is stored still.
  void Delete(Error error, std::function<void(const Status&)> done);
  /// A session that has a journal and nothing to do leaves memory until the next call.
  void RequestSleep();
  /// True if updates have to come with their form.
  [[nodiscard]] bool is_stored() const { return journal_ != nullptr; }
  [[nodiscard]] Durability durability() const { return environment_.durability; }
  /// The server shuts down: a running advance commits what it has, then the editor is closed.
  void Drain(Error error);
  /// Ends the session as Close does, if nobody has used it since `before`: it has neither editor
  /// nor subscriber, and no call waits. @return true if it did
  bool CloseIfIdle(Clock::Time before, Error error);
  /// There is something to do.
  void Wake() { environment_.scheduler->Wake(shared_from_this()); }
  [[nodiscard]] SessionInfo info() const;
  /// What decides whether the session should sleep.
  struct Rest {
    Clock::Time last_used = {};
    std::int64_t bytes = 0;  ///< In memory, roughly.
    bool may_sleep = false;  ///< It is stored, in memory, and has nothing to do.
  };
  [[nodiscard]] Rest rest() const;
  [[nodiscard]] const std::string& session_id() const { return session_id_; }

  // Run by workers, from within a call.

  /// The call has not answered yet and goes on in later slices. Until it has, the session does
  /// nothing but tell its subscribers: the state that the call was given stays as it is.
  void GoOn(SessionCallRest rest);

  /// What a rollback has led to.
  struct RolledBack {
    Revision revision = Revision::kNone;
    std::uint64_t state_hash = 0;
  };
  /// Goes back to a revision that is kept, under a new number; editor and subscribers get the diff.
  /// A repeated update_id goes back once. Errors: kProtocolOrder, kRevisionNotFound,
  /// kResourceExhausted while the editor does not read.
  /// @param update  as that of a RollbackUpdate that says the same
  Result<RolledBack> RollbackTo(Revision to_revision, std::int64_t update_id,
                                const Fingerprint& update);
  /// Keeps a revision. Errors: kRevisionNotFound, kResourceExhausted.
  Status SaveRevision(Revision revision);
  /// Errors: kRevisionNotFound.
  Status Release(const std::vector<std::int64_t>& revisions);
  /// What another session starts from, to go on from a revision of this one.
  /// Errors: kProtocolOrder, kRevisionNotFound.
  [[nodiscard]] Result<SessionMemory> Fork(Revision revision) const;
  /// What another session starts from, to go on as this one: with saved revisions and answers, but
  /// without history. Errors: kProtocolOrder while updates are staged. @par Cost as Fork
  [[nodiscard]] Result<SessionMemory> Copy() const;
  /// Does something when all that the session did so far is on disk, whatever it promises.
  void WhenStored(std::function<void(const Status&)> action);
  /// Does something when all that the session did so far is durable, as far as it promises that.
  void WhenDurable(std::function<void(const Status&)> action);

  /// Never throws: a bug of the engine ends in HandleBug.
  Outcome RunSlice(Clock::Time slice_end) override;

 private:
  struct StartRequest {
    EngineInput input;
    std::function<void(const Status&)> done;
    Bytes form;
    SessionReader read = {};  // Instead of the input.
  };
  // An advance that is not finished.
  struct RunningAdvance {
    std::shared_ptr<Editor> editor;
    std::int64_t update_id = 0;
    AdvanceSpec spec;
    Clock::Time begin;
    std::chrono::nanoseconds compute{0};
    Revision base_revision = Revision::kNone;
    Progress progress;                      // Since the last commit...
    LoopCounts committed_counts;            // ...and what this advance has committed before.
    std::optional<double> motion_fraction;  // Of the motions that were staged for it.
    std::int64_t softened_count = 0;
    Clock::Time last_progress;
    Clock::Time last_commit;
  };

  // The update that is being staged.
  struct Staging {
    const UpdateCommand* command = nullptr;
    std::int64_t command_id = 0;
    bool is_put_off = false;  // It is answered.
  };
  // What waits behind it.
  struct Behind {
    bool is_discarded = false;      // A discard comes next.
    bool has_due_advance = false;   // An advance should be answered by now...
    std::int32_t update_count = 0;  // ...before which so many updates wait.
  };
  class StagingWatch;

  Outcome RunUnguarded(Clock::Time slice_end);
  // In session_store.cc.
  bool Settled();
  void Submit();
  Status Load();
  Status Need();
  void Sleep();
  void Adopt(SessionMemory memory);
  Status BeginFrom(EngineInput input, const Bytes& form);
  Status BeginFrom(SessionMemory memory);
  void LoseMemory(const Error& error);
  [[nodiscard]] bool MaySleep() const;
  void PublishRest();
  [[nodiscard]] Bytes Head() const;
  [[nodiscard]] std::optional<Revision> DurableRevision() const;
  std::unique_ptr<SessionJournal> MakeJournal();
  void RecordAnswer(const SessionEvent* answer, StageEffect effect, const Bytes& form = {});
  void RecordCommit(const MeshDiff& diff, const RevisionDelta* delta, std::int64_t update_id);
  void RecordSaved();
  void DeleteStored();
  bool Build();
  bool HandleOneThing();
  // In session_calls.cc.
  void HandleCall(const SessionCall& call);
  bool ContinueCall(Clock::Time slice_end);
  void EndCall(const Error& error);
  bool ServeFollowers(Clock::Time slice_end);
  void SendMissed(const std::shared_ptr<Editor>& editor, Revision mirror_revision);
  void HandleOpen(const std::shared_ptr<Editor>& editor, const OpenCommand& open);
  void HandleUpdate(const std::shared_ptr<Editor>& editor, const UpdateCommand& command);
  void AnswerAgain(const std::shared_ptr<Editor>& editor, const UpdateCommand& command);
  // In session_staging.cc.
  void StageUpdate(const std::shared_ptr<Editor>& editor, const UpdateCommand& command);
  void StagePutOff();
  void EndPutOff(std::int64_t update_id, const Status& status);
  void LookBehind();
  [[nodiscard]] Behind SeeBehind(const Editor& editor);
  [[nodiscard]] bool IsDue(const AdvanceSpec& advance) const;
  [[nodiscard]] Clock::Time BeginOf(const AdvanceSpec& advance, Clock::Time now) const;
  void AnswerDue(const std::shared_ptr<Editor>& editor, const Behind& behind);
  void AnswerPutOff(const std::shared_ptr<Editor>& editor, const UpdateCommand& command);
  void AnswerUncommitted(const std::shared_ptr<Editor>& editor, const UpdateCommand& command);
  void BeginAdvance(const std::shared_ptr<Editor>& editor, std::int64_t update_id,
                    const AdvanceSpec& spec);
  bool IsCancelled(std::int64_t update_id);
  bool ContinueAdvance(Clock::Time slice_end);
  [[nodiscard]] std::int64_t VisitsOf(const RunningAdvance& advance) const;
  void TellProgress(Clock::Time now);
  void CommitOnTheWay(Clock::Time now);
  std::shared_ptr<const MeshDiff> Commit(const RunningAdvance& advance);
  void Publish(const std::shared_ptr<const MeshDiff>& diff, std::int64_t update_id);
  Result<std::shared_ptr<const MeshDiff>> GoBack(Revision to_revision, std::int64_t update_id);
  void HandleRollback(const std::shared_ptr<Editor>& editor, std::int64_t update_id,
                      Revision to_revision);
  [[nodiscard]] SessionEvent RolledBackEvent(std::int64_t update_id, Revision base) const;
  void FinishAdvance(AdvanceEnd end);
  void FailAdvance(const Error& error);
  void Answer(const std::shared_ptr<Editor>& editor, SessionEvent event, StageEffect effect,
              const Bytes& form = {});
  void Tell(const std::shared_ptr<Editor>& editor, SessionEvent event);
  void Reject(const std::shared_ptr<Editor>& editor, std::int64_t update_id, const Error& error,
              StageEffect effect);
  [[nodiscard]] SessionEvent MakeEvent(std::int64_t update_id) const;
  void HandleBug(const std::string& what);
  bool Recover();
  void TearDown(const Error& error);
  void PublishInfo();
  [[nodiscard]] SessionUsage Usage() const;
  /// Enters what the session uses now into its tenant's account.
  void ReportUsage();
  [[nodiscard]] Status CheckRoom(const SessionUsage& wanted) const;
  [[nodiscard]] Status CheckCompute() const;
  void Charge(std::chrono::nanoseconds time) const;
  [[nodiscard]] std::shared_ptr<Editor> CurrentEditor() const;

  const Environment environment_;
  const std::string session_id_;

  mutable std::mutex mutex_;
  std::optional<StartRequest> start_;               // Guarded by mutex_.
  std::shared_ptr<Editor> editor_;                  // Guarded by mutex_.
  Inbox<SessionCall> calls_;                        // Guarded by mutex_.
  std::optional<Error> close_error_;                // Guarded by mutex_.
  std::optional<Error> drain_error_;                // Guarded by mutex_.
  std::function<void(const Status&)> delete_done_;  // Guarded by mutex_.
  std::set<std::int64_t> cancelled_;                // Guarded by mutex_; see IsCancelled.
  std::int64_t running_update_id_ = 0;              // Guarded by mutex_.
  SessionInfo info_;                                // Guarded by mutex_.
  Clock::Time last_used_{};                         // Guarded by mutex_.
  Rest rest_;                                       // Guarded by mutex_.
  std::int64_t staging_update_id_ = 0;              // Guarded by mutex_.
  StopFlag stop_work_;  // Written under mutex_; the engine asks it while it stages or steps.

  Followers followers_;
  std::atomic<bool> followers_wait_ = false;  // Somebody may have to be served.

  const std::unique_ptr<SessionJournal> journal_;  // Null: in memory only.
  std::atomic<bool> sleep_wanted_ = false;
  bool asleep_ = false;       // What follows is in the journal alone, but for the numbers.
  bool memory_lost_ = false;  // It is not what the journal says, and will be loaded again.
  std::shared_ptr<const MetricSpec> recorded_spec_;  // What the journal's last commit follows.
  std::optional<MeshSummary> summary_;
  std::optional<Clock::WallTime> commit_time_;

  std::optional<StagedEngine> engine_;
  DiffHistory history_;
  UndoHistory undo_{{.bytes_max = kUndoBytesMax, .saved_max = kSavedRevisionsMax}};
  UpdateResults results_;
  std::optional<std::int64_t> history_bytes_asked_;
  Revision revision_ = Revision::kNone;
  std::int64_t applied_update_id_ = 0;
  std::int64_t active_count_ = 0;
  Mirror mirror_ = Mirror::kFull;
  std::weak_ptr<Editor> opened_;        // Who has been told where the session is, and hears news.
  bool editor_wants_transfer_ = false;  // The last one: it may come back for what it missed.
  std::optional<RunningAdvance> advance_;
  std::optional<Staging> staging_;
  std::deque<UpdateCommand> put_off_;  // Answered before they are staged, which is what comes next.
  Clock::Time last_advance_end_{};
  // What is being handled, so that a bug in it is answered too.
  std::shared_ptr<Editor> current_editor_;
  std::int64_t current_update_id_ = 0;
  // An update of this stream's step was refused because its number was used; so is its advance,
  // even if one that says the same has that number: it was another step's.
  bool step_refused_ = false;
  Fingerprint update_;  // The last one that was new, whose answer comes next or was the last.
  SessionCall current_call_;
  SessionCallRest call_rest_;  // Of a call that goes on.
  SessionUsage reported_;      // What the tenant's account knows.
  bool torn_down_ = false;
};

}  // namespace pliant::server
