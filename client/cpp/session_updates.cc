// Session, the part that stages updates and makes the short calls on revisions.

#include <optional>
#include <utility>

#include "client/cpp/convert.h"
#include "client/cpp/convert_updates.h"
#include "client/cpp/grpc_error.h"
#include "client/cpp/session_impl.h"

namespace pliant::client {

namespace {

/// @param update  of the replica's revision, whatever it says
/// @param ahead   what is displaced; null: nothing
template <class Impl>
Status SendTensors(Impl& session, VertexTensors update, const std::optional<MetricLimits>& limits,
                   const TensorsAhead* ahead = nullptr) {
  update.revision = session.replica().revision();
  return session.Update([&](wire::ColumnWriter& columns) {
    v1::EditRequest request;
    *request.mutable_metric() = ToWire(update, columns);
    if (limits) *request.mutable_metric()->mutable_limits() = ToWire(*limits);
    if (ahead != nullptr) {
      *request.mutable_metric()->mutable_displacement() =
          DisplacementToWire(ahead->displaced, ahead->by, update.revision, columns);
    }
    return request;
  });
}

}  // namespace

Status Session::UpdateMetric(const MetricSpec& metric) {
  return impl_->Update([&](wire::ColumnWriter& columns) {
    v1::EditRequest request;
    *request.mutable_metric() = ToWire(metric, columns);
    return request;
  });
}

Status Session::UpdateTensors(std::span<const VertexId> vertices, std::span<const Metric> tensors,
                              const std::optional<MetricLimits>& limits) {
  return SendTensors(*impl_, {.vertices = vertices, .tensors = tensors}, limits);
}

Status Session::UpdateTensors(std::span<const VertexId> vertices, std::span<const Metric> tensors,
                              const FunctionsSpec& functions,
                              const std::optional<MetricLimits>& limits) {
  return SendTensors(*impl_, {.vertices = vertices, .tensors = tensors, .functions = &functions},
                     limits);
}

Status Session::UpdateTensors(const TensorsAhead& ahead, const FunctionsSpec* functions,
                              const std::optional<MetricLimits>& limits) {
  return SendTensors(*impl_,
                     {.vertices = ahead.vertices, .tensors = ahead.tensors, .functions = functions},
                     limits, &ahead);
}

Status Session::UpdateFunctions(const FunctionsSpec& functions,
                                const std::optional<MetricLimits>& limits) {
  return SendTensors(*impl_, {.functions = &functions, .none = true}, limits);
}

Status Session::UpdateLimits(const MetricLimits& limits) {
  return impl_->Update([&](wire::ColumnWriter&) {
    v1::EditRequest request;
    *request.mutable_metric()->mutable_limits() = ToWire(limits);
    return request;
  });
}

Status Session::Displace(std::span<const VertexId> vertices, std::span<const Vec2> by) {
  const Revision revision = impl_->replica().revision();
  return impl_->Update([&](wire::ColumnWriter& columns) {
    v1::EditRequest request;
    *request.mutable_metric()->mutable_displacement() =
        DisplacementToWire(vertices, by, revision, columns);
    return request;
  });
}

Status Session::ReplaceDomain(const Domain& domain) {
  return impl_->Update([&](wire::ColumnWriter& columns) {
    v1::EditRequest request;
    *request.mutable_domain()->mutable_domain() = ToWire(domain, columns);
    return request;
  });
}

Status Session::MoveBoundary(const MotionRequest& motion) {
  const Revision revision = impl_->replica().revision();
  return impl_->Update([&](wire::ColumnWriter& columns) {
    v1::EditRequest request;
    *request.mutable_boundary() = ToWire(motion, revision, columns);
    return request;
  });
}

Status Session::MoveNodes(std::span<const VertexId> vertices, std::span<const Vec2> positions,
                          ImpossibleMotion on_impossible) {
  const NodePositions nodes{.revision = impl_->replica().revision(),
                            .vertices = vertices,
                            .positions = positions,
                            .on_impossible = on_impossible};
  return impl_->Update([&](wire::ColumnWriter& columns) {
    v1::EditRequest request;
    *request.mutable_nodes() = ToWire(nodes, columns);
    return request;
  });
}

Status Session::SetFields(const FieldUpdate& fields) {
  const Revision revision = impl_->replica().revision();
  return impl_->Update([&](wire::ColumnWriter& columns) {
    v1::EditRequest request;
    *request.mutable_fields() = ToWire(fields, revision, columns);
    return request;
  });
}

Status Session::Freeze(const Constraints& constraints) {
  const Revision revision = impl_->replica().revision();
  return impl_->Update([&](wire::ColumnWriter& columns) {
    v1::EditRequest request;
    *request.mutable_constraints() = ToWire(constraints, revision, columns);
    return request;
  });
}

Status Session::SetOptions(const Options& options) {
  return impl_->Update([&](wire::ColumnWriter&) {
    v1::EditRequest request;
    *request.mutable_options() = AllToWire(options);
    return request;
  });
}

Status Session::Discard() { return impl_->Discard(); }

Result<AdvanceReport> Session::Rollback(Revision to_revision) {
  return impl_->Rollback(to_revision);
}

Result<Revision> Session::SaveRevision(Revision revision) {
  PLIANT_RETURN_IF_ERROR(impl_->Await());
  const Connection& connection = impl_->connection();
  v1::SaveRevisionRequest request;
  request.set_session_id(id());
  // By its number, so that a second try does not keep a later one.
  request.set_revision(
      static_cast<std::int64_t>(revision == Revision::kNone ? replica().revision() : revision));
  return connection.Persist([&]() -> Result<Revision> {
    const auto context = connection.NewContext(connection.options().call_timeout);
    v1::SaveRevisionResponse response;
    const auto status = connection.sessions().SaveRevision(context.get(), request, &response);
    if (!status.ok()) return CallError(connection, status);
    return Revision{response.revision()};
  });
}

Status Session::Release(std::span<const Revision> revisions) {
  PLIANT_RETURN_IF_ERROR(impl_->Await());
  Connection& connection = impl_->connection();
  const auto context = connection.NewContext(connection.options().call_timeout);
  v1::ReleaseRequest request;
  request.set_session_id(id());
  for (const Revision revision : revisions) {
    request.add_revisions(static_cast<std::int64_t>(revision));
  }
  v1::ReleaseResponse response;
  const auto status = connection.sessions().Release(context.get(), request, &response);
  if (!status.ok()) return CallError(connection, status);
  return {};
}

Result<std::string> Session::Fork(Revision revision, const std::string& wished_id) {
  PLIANT_RETURN_IF_ERROR(impl_->Await());
  Connection& connection = impl_->connection();
  const auto context = connection.NewContext(connection.options().transfer_timeout);
  v1::ForkRequest request;
  request.set_session_id(id());
  request.set_revision(static_cast<std::int64_t>(revision));
  request.set_new_session_id(wished_id);
  v1::ForkResponse response;
  const auto status = connection.sessions().Fork(context.get(), request, &response);
  if (!status.ok()) return CallError(connection, status);
  return response.session().session_id();
}

Result<MeshReplica> Session::GetMesh() {
  PLIANT_RETURN_IF_ERROR(impl_->Await());
  return impl_->connection().GetMesh(impl_->id(), Parts::kMesh);
}

Result<Quality> Session::GetQuality() {
  PLIANT_RETURN_IF_ERROR(impl_->Await());
  return impl_->connection().GetQuality(impl_->id());
}

const MeshDiff& Session::last_change() const { return impl_->last_change(); }

}  // namespace pliant::client
