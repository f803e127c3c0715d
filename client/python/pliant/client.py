"""The connection to a server."""

import atexit
import weakref
from dataclasses import dataclass
from typing import Any, List, Mapping, Optional, Sequence

from pliant import arrays, backoff, calls, channel, errors, files, geometry, inputs, jobs
from pliant import options as opts
from pliant.session import Session
from pliant.subscription import Subscription
from pliant.v1 import edit_pb2, mesh_pb2, session_pb2, session_pb2_grpc

_CONNECT_S_MAX = 10.0


@dataclass(frozen=True)
class SessionInfo:
    """A session in a list.

    Attributes:
        session_id: its name.
        revision: current revision; 0 before the first mesh.
        vertex_count, triangle_count: size of its mesh.
        active_count: vertices that its loop has not finished.
        labels: as given when it was created.
        history_bytes_max: likewise; None: that was left to the server.
    """

    session_id: str
    revision: int
    vertex_count: int
    triangle_count: int
    active_count: int
    labels: Mapping[str, str]
    history_bytes_max: Optional[int] = None


class Client(jobs.JobCalls, files.FileCalls):
    """A connection to one server; made by `connect` and `start_local`.

    Attributes:
        address: of the server.
        version: of the server, e.g. "0.1.0".
        capabilities: names of optional things that the server has.
        limits: limits of the server by name, e.g. "vertices".

    Threads: may be used from several threads. Do not fork a process that has a client.
    """

    def __init__(self, address: str, server: Any = None, reconnect_s: float = 60.0, **security):
        self.address = address
        self._reconnect_s = reconnect_s
        self._server = server
        self._channel = channel.make(address, **security)
        super().__init__(self._channel)
        self._sessions = session_pb2_grpc.SessionServiceStub(self._channel)
        self._open: weakref.WeakSet = weakref.WeakSet()
        get_info = session_pb2_grpc.ServerServiceStub(self._channel).GetServerInfo
        # A server that we have just started may need a moment more; any other one is there or not.
        info = calls.call(get_info, session_pb2.GetServerInfoRequest(), timeout=_CONNECT_S_MAX,
                    wait_for_ready=server is not None)
        if server is not None:
            # The connection first: a server that ends waits for connections that nobody polls.
            atexit.register(self.close)
        self.version: str = info.version
        self.capabilities = frozenset(info.capabilities)
        self.limits = dict(info.limits)

    def create_session(self, *, domain: Optional[geometry.Domain] = None, mesh: Any = None,
                       metric: Any = None, session_id: str = "",
                       labels: Optional[Mapping[str, str]] = None,
                       advance: Optional[opts.Advance] = None, with_metric: bool = False,
                       with_transfer: bool = False, durability: Optional[str] = None,
                       history_bytes_max: Optional[int] = None, reconnect_s: float = 60.0,
                       **options) -> Session:
        """Creates a session and its first mesh.

        Args:
            domain: a `pliant.Domain` to be meshed; or
            mesh: a `pliant.Mesh` (or the mesh of another session) to start from.
            metric: required: a `pliant.metric`, or with `mesh` (n, 3) tensors m11, m12, m22 in
                1 / (domain unit)^2, one row for each of its points.
            session_id: wished name, 1 to 64 characters of [A-Za-z0-9_.-]. Default: the server
                makes one.
            labels: free text by key, at most 16.
            advance: how long the first run may take. Default: until converged.
            with_metric: keep the metric that the mesh follows in `mesh.metrics` too.
            with_transfer: every `Diff` brings the rows that carry nodal values to the new mesh.
            durability: when a revision is on the server's disk: "none", "relaxed" (soon) or
                "strict" (before it is acknowledged). Default: strict where the server has a store.
            history_bytes_max: how much of earlier revisions the server keeps: four fifths for ways
                back (`Session.rollback`), the rest for readers that are behind; 0 to
                `limits["history_bytes"]`. Default: about six times the mesh.
            reconnect_s: how long a call tries to take up a lost connection.
            **options: h_min, h_max (or hmin, hmax), hgrad, rotation, anisotropy_max as in
                `pliant.options.Limits`; seed, variant, smoothing, no_insert, no_swap, no_move and
                so on as in `pliant.options.SessionOptions`.

        Returns:
            the session, at revision 1. As the target of `with` it is deleted at the end.

        Raises:
            InvalidInput: `field` and `index` name the first thing that is wrong, e.g. code
                CROSSING_SEGMENTS, field "domain.segments", index and other_index the segments.
            AlreadyExists: `session_id` is taken.
        """
        sender = arrays.BlobSender()
        message = inputs.message_of(sender, domain, mesh, metric, options)
        message.session_id = session_id
        message.labels.update(labels or {})
        if durability is not None:
            message.options.durability = opts.durability_to_wire(durability)
        if history_bytes_max is not None:
            message.options.history_bytes_max = history_bytes_max
        session = self._session(self._upload(message, sender), True,
                                _parts(with_metric, with_transfer), reconnect_s)
        try:
            session.start(advance)
        except BaseException:
            session.delete()
            raise
        return session

    def open_session(self, session_id: str, with_metric: bool = False,
                     with_transfer: bool = False, reconnect_s: float = 60.0) -> Session:
        """Takes up a session that exists, with its present mesh.

        Args:
            session_id: its name.
            with_metric: keep the metric that the mesh follows in `mesh.metrics` too.
            with_transfer: every `Diff` brings the rows that carry nodal values to the new mesh.
            reconnect_s: how long a call tries to take up a lost connection.

        Raises:
            NotFound: there is none of that name.
            SessionBusy: another client edits it, and half a second later still does.
        """
        session = self._session(session_id, False, _parts(with_metric, with_transfer), reconnect_s)
        session.start()
        return session

    def subscribe(self, session_id: str, with_metric: bool = False, reconnect_s: float = 60.0, *,
                  region_tags: Sequence[int] = (), only_vertices: bool = False) -> Subscription:
        """Follows a session that anybody edits: its mesh, and every change of it.

        Args:
            session_id: its name.
            with_metric: bring the metric that the mesh follows too.
            reconnect_s: how long to try to take up a lost connection.
            region_tags: only triangles of these regions, their corners, and constrained edges
                between such corners. One that no triangle has is no mistake, as it may come with
                another domain: `Subscription.absent_region_tags` names it. Default: all.
            only_vertices: neither triangles nor edges: points that move, come and go.

        Raises (at the first change):
            InvalidArgument: more than 4,096 tags.
        """
        request = session_pb2.SubscribeRequest(
            session_id=session_id, region_tags=region_tags,
            parts=[mesh_pb2.MESH_PART_METRIC] if with_metric else [])
        if only_vertices:
            request.mirror_mode = edit_pb2.MIRROR_MODE_POSITIONS
        made = Subscription(self._sessions, request, reconnect_s)
        self._open.add(made)
        return made

    def list_sessions(self) -> List[SessionInfo]:
        """All sessions of the server, oldest first."""
        found, token = [], ""
        while True:
            request = session_pb2.ListSessionsRequest(page_token=token)
            page = self._persist(lambda: calls.call(self._sessions.ListSessions, request))
            found += [SessionInfo(one.session_id, one.revision, one.counts.vertex_count,
                                  one.counts.triangle_count, one.active_count, dict(one.labels),
                                  one.history_bytes_max if one.HasField("history_bytes_max")
                                  else None)
                      for one in page.sessions]
            token = page.next_page_token
            if not token:
                return found

    def close(self) -> None:
        """Ends the connection, and the server too if `start_local` started it."""
        for session in list(self._open):
            session.close()
        self._channel.close()
        if self._server is not None:
            atexit.unregister(self.close)
            self._server.stop()

    def __enter__(self) -> "Client":
        return self

    def __exit__(self, *exception) -> None:
        self.close()

    def __repr__(self):
        return f"Client({self.address!r}, version {self.version})"

    def _persist(self, attempt):
        return backoff.persist(self._reconnect_s, attempt)

    def _session(self, session_id, is_owner, parts, reconnect_s):
        session = Session(self._sessions, session_id, is_owner, parts, reconnect_s)
        self._open.add(session)
        return session

    def _upload(self, message, sender):
        def requests():
            for chunk in sender.take_chunks():
                yield session_pb2.CreateSessionRequest(chunk=chunk)
            yield session_pb2.CreateSessionRequest(create=message)

        response = calls.call(self._sessions.CreateSession, requests())
        return response.session.session_id


def connect(address: str = "localhost:7447", *, token: Optional[str] = None,
            tls_roots: Optional[bytes] = None, tls_cert: Optional[bytes] = None,
            tls_key: Optional[bytes] = None, keepalive_s: float = 20.0,
            reconnect_s: float = 60.0) -> Client:
    """Connects to a server.

    Args:
        address: "host:port", or "unix:/path/of/socket".
        token: what the server knows us by, if it wants a token.
        tls_roots: PEM text: who signs the server's certificate. Default: no encryption.
        tls_cert, tls_key: PEM texts: our own certificate and key, where the server wants them.
        keepalive_s: while a call waits and nothing comes, the server is asked so often whether it
            is there; one that has not answered after half as long counts as lost. Not less than
            10, which a pliantd takes as an attack. 0: never.
        reconnect_s: how long calls that do no harm twice (lists, downloads, ...) try to reach a
            server that was lost; those of a session have their own.

    Raises:
        Unauthenticated: the server wants a token, or does not know this one.
        Unavailable: no server answers there within 10 seconds.
    """
    try:
        return Client(address, token=token, tls_roots=tls_roots, tls_cert=tls_cert,
                      tls_key=tls_key, keepalive_s=keepalive_s, reconnect_s=reconnect_s)
    except (errors.Unavailable, errors.DeadlineExceeded) as error:
        raise errors.Unavailable(
            "UNAVAILABLE", f"no pliantd answers at {address} ({error.message}); is it running? "
            "pliant.start_local() starts a private one") from None


def _parts(with_metric, with_transfer):
    """What comes beside the mesh. Fields cost nothing where there are none."""
    parts = [mesh_pb2.MESH_PART_FIELDS]
    if with_metric:
        parts.append(mesh_pb2.MESH_PART_METRIC)
    if with_transfer:
        parts.append(mesh_pb2.MESH_PART_TRANSFER)
    return parts
