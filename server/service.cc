#include "server/service.h"

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/convert_reply.h"
#include "server/convert_request.h"
#include "server/creation.h"
#include "server/download.h"
#include "server/error_status.h"
#include "server/limits.h"
#include "server/request_id.h"
#include "server/session_stream.h"
#include "server/subscribe_stream.h"
#include "server/unary.h"

namespace pliant::server {
namespace {

// The revision that a reader asked for must be the current one: others are not kept yet.
Status CheckRevision(std::int64_t wanted, const CommittedState& state) {
  const auto current = static_cast<std::int64_t>(state.revision);
  if (wanted == 0 || wanted == current) return {};
  return Error{ErrorCode::kRevisionNotFound,
               "revision " + std::to_string(wanted) + " is not kept; the oldest and newest is " +
                   std::to_string(current),
               "revision"};
}

Result<std::vector<v1::GetMeshResponse>> MeshMessages(const Result<const CommittedState*>& result,
                                                      const v1::GetMeshRequest& request,
                                                      const ReplyContext& wanted) {
  PLIANT_ASSIGN_OR_RETURN(const CommittedState* state, result);
  PLIANT_RETURN_IF_ERROR(CheckRevision(request.revision(), *state));
  if (wanted.parts.metric || wanted.parts.fields)
    PLIANT_RETURN_IF_ERROR(CheckNothingStaged(*state));
  ReplyContext context = wanted;
  context.applied_update_id = state->applied_update_id;
  std::vector<v1::GetMeshResponse> messages =
      InMessages<v1::GetMeshResponse>(ToMeshSnapshot(state->engine.Snapshot(), context));
  for (v1::GetMeshResponse& message : messages) {
    message.set_revision(static_cast<std::int64_t>(state->revision));
  }
  return messages;
}

/// A GetQuality that is being answered.
class QualityCall {
 public:
  /// @param reactor  the call's, which it has one of.
  QualityCall(const grpc::CallbackServerContext& call, grpc::ServerUnaryReactor& reactor,
              const Clock& clock, v1::QualityReport& report)
      : call_(call), reactor_(reactor), clock_(clock), report_(report) {}

  Status Begin(const Result<const CommittedState*>& result, MetricBasis basis) {
    PLIANT_ASSIGN_OR_RETURN(const CommittedState* state, result);
    PLIANT_RETURN_IF_ERROR(CheckNothingStaged(*state));
    state_.set_basis(basis == MetricBasis::kRaw ? v1::METRIC_BASIS_RAW : v1::METRIC_BASIS_LIMITED);
    state_.set_revision(static_cast<std::int64_t>(state->revision));
    state_.set_active_count(state->active_count);
    *state_.mutable_counts() = ToMeshCounts(state->summary);
    measurement_ = state->engine.Measure(basis);
    return {};
  }

  /// A SessionCallRest.
  bool Continue(const Status& session, Clock::Time slice_end) {
    if (!session.ok()) {
      End(session);
      return true;
    }
    do {
      if (call_.IsCancelled()) {
        End(Error{ErrorCode::kCancelled, "the client is gone", {}});
        return true;
      }
      if (!measurement_->Continue()) {
        report_ = ToQualityReport(measurement_->Take());
        report_.MergeFrom(state_);
        End({});
        return true;
      }
    } while (clock_.Now() < slice_end);
    return false;
  }

  /// Once, last of all.
  void End(const Status& status) {
    reactor_.Finish(status.ok() ? grpc::Status::OK : ToGrpcStatus(status.error()));
  }

 private:
  const grpc::CallbackServerContext& call_;
  grpc::ServerUnaryReactor& reactor_;
  const Clock& clock_;
  v1::QualityReport& report_;
  v1::QualityReport state_;  // What is not measured.
  std::unique_ptr<Measurement> measurement_;
};

Result<MetricBasis> ConvertBasis(const v1::GetQualityRequest& request) {
  if (!request.has_basis() || request.basis() == v1::METRIC_BASIS_LIMITED) {
    return MetricBasis::kLimited;
  }
  if (request.basis() == v1::METRIC_BASIS_RAW) return MetricBasis::kRaw;
  return Error{ErrorCode::kOutOfRange, "basis is no known basis", "basis"};
}

}  // namespace

Status CheckNothingStaged(const CommittedState& state) {
  if (state.staged_count == 0) return {};
  return Error{ErrorCode::kProtocolOrder,
               std::to_string(state.staged_count) +
                   " updates are staged, so the metric of the revision is not at hand: advance or "
                   "discard first",
               {}};
}

Session::Environment EnvironmentOf(const ServiceContext& context, const std::string& tenant,
                                   const std::string& id, Durability durability) {
  Session::Environment environment = context.session;
  environment.on_broken = [registry = context.registry, tenant](const std::string& name) {
    registry->Remove(tenant, name);
  };
  environment.account = context.accounts->Of(tenant);
  environment.durability = durability;
  if (context.keeper != nullptr && durability != Durability::kNone) {
    environment.journal = context.keeper->JournalOf(tenant, id);
  }
  return environment;
}

grpc::ServerReadReactor<v1::CreateSessionRequest>* SessionServiceImpl::CreateSession(
    grpc::CallbackServerContext* call, v1::CreateSessionResponse* response) {
  return new Creation(context_, call, response);
}

grpc::ServerUnaryReactor* SessionServiceImpl::GetSession(grpc::CallbackServerContext* call,
                                                         const v1::GetSessionRequest* request,
                                                         v1::GetSessionResponse* response) {
  const std::optional<std::string> tenant = context_.access->TenantOf(*call);
  if (!tenant) return Refuse(call);
  const Result<std::shared_ptr<Session>> session =
      context_.registry->Find(*tenant, request->session_id());
  if (!session.ok()) return End(call, session.error());
  *response->mutable_session() = ToSession((*session)->info());
  return End(call, {});
}

grpc::ServerUnaryReactor* SessionServiceImpl::ListSessions(grpc::CallbackServerContext* call,
                                                           const v1::ListSessionsRequest* request,
                                                           v1::ListSessionsResponse* response) {
  const std::optional<std::string> tenant = context_.access->TenantOf(*call);
  if (!tenant) return Refuse(call);
  const Result<std::int64_t> after = ConvertPageToken(request->page_token());
  if (!after.ok()) return End(call, after.error());
  const Result<std::size_t> count_max = ConvertPageSize(request->page_size());
  if (!count_max.ok()) return End(call, count_max.error());
  const SessionRegistry::Page page = context_.registry->List(*tenant, *after, *count_max);
  for (const std::shared_ptr<Session>& session : page.sessions) {
    *response->add_sessions() = ToSession(session->info());
  }
  if (page.next != 0) response->set_next_page_token(std::to_string(page.next));
  return End(call, {});
}

grpc::ServerUnaryReactor* SessionServiceImpl::DeleteSession(grpc::CallbackServerContext* call,
                                                            const v1::DeleteSessionRequest* request,
                                                            v1::DeleteSessionResponse* response) {
  const std::optional<std::string> tenant = context_.access->TenantOf(*call);
  if (!tenant) return Refuse(call);
  const Result<std::shared_ptr<Session>> session =
      context_.registry->Find(*tenant, request->session_id());
  if (!session.ok()) return End(call, session.error());
  response->set_revision(static_cast<std::int64_t>((*session)->info().revision));
  grpc::ServerUnaryReactor* reactor = call->DefaultReactor();
  (*session)->Delete(
      {ErrorCode::kSessionNotFound, "session " + request->session_id() + " was deleted",
       "session_id"},
      [this, reactor, tenant = *tenant, id = request->session_id(),
       request_id = RequestIdOf(*call)](const Status& status) {
        if (status.ok()) {
          context_.registry->Remove(tenant, id);
          context_.session.log->Info("delete", {{"session", id}, {"request", request_id}});
        }
        reactor->Finish(status.ok() ? grpc::Status::OK : ToGrpcStatus(status.error()));
      });
  return reactor;
}

grpc::ServerBidiReactor<v1::EditRequest, v1::EditResponse>* SessionServiceImpl::Edit(
    grpc::CallbackServerContext* call) {
  return EditStream::Begin({.registry = context_.registry,
                            .tenant = context_.access->TenantOf(*call),
                            .calls = context_.calls,
                            .log = context_.session.log,
                            .clock = context_.session.clock,
                            .limits = context_.limits,
                            .request_id = RequestIdOf(*call)});
}

grpc::ServerWriteReactor<v1::SubscribeResponse>* SessionServiceImpl::Subscribe(
    grpc::CallbackServerContext* call, const v1::SubscribeRequest* request) {
  return SubscribeStream::Begin({.registry = context_.registry,
                                 .tenant = context_.access->TenantOf(*call),
                                 .calls = context_.calls,
                                 .log = context_.session.log,
                                 .request_id = RequestIdOf(*call),
                                 .bookmark_interval = context_.bookmark_interval},
                                *request);
}

grpc::ServerWriteReactor<v1::GetMeshResponse>* SessionServiceImpl::GetMesh(
    grpc::CallbackServerContext* call, const v1::GetMeshRequest* request) {
  using MeshDownload = Download<v1::GetMeshResponse>;
  const auto begin = [&](MeshDownload* download, const std::string& tenant) -> Status {
    PLIANT_ASSIGN_OR_RETURN(const std::shared_ptr<Session> session,
                            context_.registry->Find(tenant, request->session_id()));
    ReplyContext wanted;
    PLIANT_ASSIGN_OR_RETURN(wanted.parts, ConvertParts(request->parts()));
    PLIANT_ASSIGN_OR_RETURN(wanted.numbering, NumberingOf(*request));
    // The request lives as long as the call.
    return session->Post([download, request, wanted](const Result<const CommittedState*>& state) {
      auto messages = MeshMessages(state, *request, wanted);
      if (messages.ok()) {
        download->Run(std::move(messages).value());
      } else {
        download->Fail(messages.error());
      }
    });
  };
  return OpenDownload<v1::GetMeshResponse>(downloads_, *context_.calls,
                                           context_.access->TenantOf(*call), begin);
}

grpc::ServerUnaryReactor* SessionServiceImpl::GetQuality(grpc::CallbackServerContext* call,
                                                         const v1::GetQualityRequest* request,
                                                         v1::GetQualityResponse* response) {
  const std::optional<std::string> tenant = context_.access->TenantOf(*call);
  if (!tenant) return Refuse(call);
  const Result<std::shared_ptr<Session>> session =
      context_.registry->Find(*tenant, request->session_id());
  if (!session.ok()) return End(call, session.error());
  const Result<MetricBasis> basis = ConvertBasis(*request);
  if (!basis.ok()) return End(call, basis.error());
  grpc::ServerUnaryReactor* reactor = call->DefaultReactor();
  const auto answer = std::make_shared<QualityCall>(*call, *reactor, *context_.session.clock,
                                                    *response->mutable_quality());
  const Status posted =
      (*session)->Post([answer, basis = *basis](const Result<const CommittedState*>& state) {
        if (const Status begun = answer->Begin(state, basis); !begun.ok()) {
          answer->End(begun);
          return;
        }
        (*state)->session->GoOn([answer](const Status& there, Clock::Time slice_end) {
          return answer->Continue(there, slice_end);
        });
      });
  if (!posted.ok()) answer->End(posted);
  return reactor;
}

grpc::ServerUnaryReactor* ServerServiceImpl::GetServerInfo(grpc::CallbackServerContext* call,
                                                           const v1::GetServerInfoRequest*,
                                                           v1::GetServerInfoResponse* response) {
  if (!context_.access->TenantOf(*call)) return Refuse(call);
  response->set_version(PLIANT_VERSION);
  for (const char* capability : {"create.domain",
                                 "create.mesh",
                                 "edit.metric",
                                 "edit.boundary",
                                 "edit.nodes",
                                 "edit.domain",
                                 "edit.fields",
                                 "edit.constraints",
                                 "edit.options",
                                 "edit.discard",
                                 "edit.advance",
                                 "edit.rollback",
                                 "metric.expression",
                                 "metric.size",
                                 "metric.vertices",
                                 "metric.background",
                                 "metric.grid",
                                 "metric.intersection",
                                 "metric.beside_tensors",
                                 "metric.solution",
                                 "metric.displacement",
                                 "limits.size_min",
                                 "limits.size_max",
                                 "limits.anisotropy_max",
                                 "limits.gradation",
                                 "limits.rotation",
                                 "limits.geometry",
                                 "limits.gap_element_count",
                                 "limits.smoothing_count",
                                 "limits.automatic",
                                 "part.metric",
                                 "part.fields",
                                 "part.transfer",
                                 "numbering.dense",
                                 "subscribe",
                                 "subscribe.region_tags",
                                 "subscribe.positions",
                                 "subscribe.dense",
                                 "revisions",
                                 "files",
                                 "jobs",
                                 "quality.limited",
                                 "quality.raw"}) {
    response->add_capabilities(capability);
  }
  auto& limits = *response->mutable_limits();
  limits["message_bytes"] = kMessageBytesMax;
  limits["chunk_bytes"] = static_cast<std::int64_t>(kChunkBytesMax);
  limits["upload_bytes"] = static_cast<std::int64_t>(kUploadBytesMax);
  limits["blobs_pending"] = static_cast<std::int64_t>(kBlobsPendingMax);
  limits["update_results"] = static_cast<std::int64_t>(kUpdateResultsMax);
  limits["region_tags"] = kRegionTagsMax;
  limits["history_bytes"] = kKeptBytesMax;
  limits["expression_length"] = static_cast<std::int64_t>(kExpressionLengthMax);
  limits["sessions"] = static_cast<std::int64_t>(context_.sessions_max);
  limits["vertices"] = context_.limits.vertices_max;
  limits["jobs"] = static_cast<std::int64_t>(context_.jobs_max);
  limits["job_keep_ms"] = kJobKeepMsMax;
  return End(call, {});
}

}  // namespace pliant::server
