"""What sessions and jobs start from: the same message for both."""

from pliant import arrays, errors, geometry
from pliant import metric as metrics
from pliant import options as opts
from pliant.v1 import metric_pb2, motion_pb2, session_pb2


def message_of(sender, domain, mesh, metric, options):
    """The `CreateSession` message of a domain or a mesh, a metric and a dictionary of options.

    Raises:
        InvalidInput: what the client can see is wrong, as in `Client.create_session`.
    """
    if (domain is None) == (mesh is None):
        raise errors.InvalidInput("EMPTY", "give either a domain or a mesh", field="domain")
    if domain is not None:
        _check_domain(domain)
    if metric is None:
        raise errors.InvalidInput("EMPTY", "metric is required", field="metric")
    limits, session_options = opts.split(options)
    source = metrics.as_metric(metric)
    if mesh is not None:
        mesh = geometry.as_mesh(mesh)
        if isinstance(source, metrics.Vertices) and source.vertex_ids is None:
            arrays.check_rows("metric.tensors", source.tensors, len(mesh.points),
                              "point of the mesh")
    elif isinstance(source, metrics.Vertices):
        raise errors.InvalidInput("ARRAY_TYPE", "tensors belong to the vertices of a mesh; for "
                                  "a domain use pliant.metric.background, expression or size",
                                  field="metric")
    return session_pb2.CreateSession(
        domain=domain and domain.to_wire(sender), mesh=mesh and mesh.to_wire(sender),
        options=session_options.to_wire(),
        metric=metric_pb2.MetricUpdate(sources=source.sources(sender, 0),
                                       limits=limits.to_wire()))


def domain_command(domain):
    """The edit command of `Session.replace_domain`."""
    _check_domain(domain)
    return "domain", lambda sender: motion_pb2.DomainUpdate(domain=domain.to_wire(sender))


def _check_domain(domain):
    if not isinstance(domain, geometry.Domain):
        raise errors.InvalidInput("ARRAY_TYPE", "domain must be a pliant.Domain; got "
                                  f"{type(domain).__name__}", field="domain")
