// The calls on revisions: keep, go back, let go, copy; see service.h.
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/convert_reply.h"
#include "server/convert_request.h"
#include "server/error_status.h"
#include "server/service.h"
#include "server/stored_form.h"

namespace pliant::server {
namespace {

// Runs `work` on a worker between two updates of a session; what it returns ends the call. Request
// and response live as long as the call.
grpc::ServerUnaryReactor* RunBetweenUpdates(const ServiceContext& context,
                                            grpc::CallbackServerContext* call,
                                            const std::string& id,
                                            std::function<Status(const CommittedState&)> work) {
  grpc::ServerUnaryReactor* reactor = call->DefaultReactor();
  const auto finish = [reactor](const Status& status) {
    reactor->Finish(status.ok() ? grpc::Status::OK : ToGrpcStatus(status.error()));
  };
  const std::optional<std::string> tenant = context.access->TenantOf(*call);
  if (!tenant) {
    reactor->Finish(Access::Refusal());
    return reactor;
  }
  const Result<std::shared_ptr<Session>> session = context.registry->Find(*tenant, id);
  if (!session.ok()) {
    finish(session.error());
    return reactor;
  }
  const Status posted = (*session)->Post(
      [finish, work = std::move(work)](const Result<const CommittedState*>& state) {
        const Status done = state.ok() ? work(**state) : Status(state.error());
        if (!done.ok()) {
          finish(done);
        } else {
          (*state)->session->WhenDurable(finish);
        }
      });
  if (!posted.ok()) finish(posted);
  return reactor;
}

grpc::ServerUnaryReactor* Refused(grpc::ServerUnaryReactor* reactor) {
  reactor->Finish(Access::Refusal());
  return reactor;
}

Result<Revision> RevisionOr(std::int64_t wanted, Revision current, const char* field) {
  if (wanted > 0) return Revision(wanted);
  if (wanted == 0) return current;
  return Error{ErrorCode::kOutOfRange, std::string(field) + " is negative", field};
}

}  // namespace

grpc::ServerUnaryReactor* SessionServiceImpl::SaveRevision(grpc::CallbackServerContext* call,
                                                           const v1::SaveRevisionRequest* request,
                                                           v1::SaveRevisionResponse* response) {
  return RunBetweenUpdates(context_, call, request->session_id(),
                           [request, response](const CommittedState& state) -> Status {
                             PLIANT_ASSIGN_OR_RETURN(
                                 const Revision revision,
                                 RevisionOr(request->revision(), state.revision, "revision"));
                             response->set_revision(static_cast<std::int64_t>(revision));
                             return state.session->SaveRevision(revision);
                           });
}

grpc::ServerUnaryReactor* SessionServiceImpl::RollbackTo(grpc::CallbackServerContext* call,
                                                         const v1::RollbackToRequest* request,
                                                         v1::RollbackToResponse* response) {
  return RunBetweenUpdates(
      context_, call, request->session_id(),
      [request, response](const CommittedState& state) -> Status {
        PLIANT_RETURN_IF_ERROR(CheckUpdateId(request->update_id()));
        // The same as if the editor had sent it.
        v1::EditRequest update;
        update.set_update_id(request->update_id());
        update.mutable_rollback()->set_to_revision(request->to_revision());
        PLIANT_ASSIGN_OR_RETURN(
            const Session::RolledBack done,
            state.session->RollbackTo(Revision(request->to_revision()), request->update_id(),
                                      FingerprintOf(update)));
        response->set_revision(static_cast<std::int64_t>(done.revision));
        response->set_state_hash(done.state_hash);
        return {};
      });
}

grpc::ServerUnaryReactor* SessionServiceImpl::Release(grpc::CallbackServerContext* call,
                                                      const v1::ReleaseRequest* request,
                                                      v1::ReleaseResponse* response) {
  return RunBetweenUpdates(
      context_, call, request->session_id(),
      [request, response](const CommittedState& state) -> Status {
        response->set_revision(static_cast<std::int64_t>(state.revision));
        return state.session->Release({request->revisions().begin(), request->revisions().end()});
      });
}

grpc::ServerUnaryReactor* SessionServiceImpl::Fork(grpc::CallbackServerContext* call,
                                                   const v1::ForkRequest* request,
                                                   v1::ForkResponse* response) {
  grpc::ServerUnaryReactor* reactor = call->DefaultReactor();
  const auto finish = [reactor](const Status& status) {
    reactor->Finish(status.ok() ? grpc::Status::OK : ToGrpcStatus(status.error()));
  };
  const std::optional<std::string> tenant = context_.access->TenantOf(*call);
  if (!tenant) return Refused(reactor);
  const Result<std::shared_ptr<Session>> session =
      context_.registry->Find(*tenant, request->session_id());
  if (!session.ok()) {
    finish(session.error());
    return reactor;
  }
  const Status posted = (*session)->Post([this, finish, tenant = *tenant, request,
                                          response](const Result<const CommittedState*>& state) {
    const Status begun = state.ok() ? BeginFork(**state, tenant, *request, *response, finish)
                                    : Status(state.error());
    if (!begun.ok()) finish(begun);
  });
  if (!posted.ok()) finish(posted);
  return reactor;
}

// Calls `finish` when the fork is there, or returns why it will not be.
Status SessionServiceImpl::BeginFork(const CommittedState& state, const std::string& tenant,
                                     const v1::ForkRequest& request, v1::ForkResponse& response,
                                     const std::function<void(const Status&)>& finish) {
  if (!request.new_session_id().empty()) {
    PLIANT_RETURN_IF_ERROR(CheckSessionId(request.new_session_id()));
  }
  PLIANT_ASSIGN_OR_RETURN(const Revision revision,
                          RevisionOr(request.revision(), state.revision, "revision"));
  PLIANT_ASSIGN_OR_RETURN(const std::string id,
                          context_.registry->Reserve(tenant, request.new_session_id()));
  const auto fork =
      std::make_shared<Session>(EnvironmentOf(context_, tenant, id, state.session->durability()),
                                id, state.session->info().labels);
  const auto publish = [this, tenant, id, fork, &response, finish](const Status& status) {
    if (!status.ok()) {
      context_.registry->Remove(tenant, id);
    } else {
      context_.registry->Publish(tenant, fork);
      context_.session.log->Info("fork", {{"session", id}});
      *response.mutable_session() = ToSession(fork->info());
    }
    finish(status);
  };
  Result<SessionMemory> memory = state.session->Fork(revision);
  if (!memory.ok()) {
    context_.registry->Remove(tenant, id);
    return memory.error();
  }
  const auto begin = std::make_shared<SessionMemory>(std::move(memory).value());
  fork->Start([begin]() -> Result<SessionMemory> { return std::move(*begin); }, publish);
  return {};
}

}  // namespace pliant::server
