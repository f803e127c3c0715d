"""A session: one persistent mesh on the server, and its copy here."""

import threading
from typing import Any, Callable, List, Optional

import numpy as np

from pliant import arrays, backoff, calls, constraints, diff, downloads, editor, errors
from pliant import fields, geometry
from pliant import inputs, motion, quality, replica
from pliant import metric as metrics
from pliant import options as opts
from pliant.v1 import edit_pb2, metric_pb2, motion_pb2, session_pb2

# Between two calls of `on_progress`.
_PROGRESS_MS = 100


class Session:
    """One persistent mesh on the server, and a verified copy of it here.

    Made by `Client.create_session` and `Client.open_session`. The mesh changes only by
    `update_metric` and `advance`; each commits one revision and brings a `Diff`, which is already
    applied to `mesh` when the call returns. A refused call leaves mesh and session as they were.

    If the connection is lost, also because the server is started anew, a call connects again, with
    growing pauses, repeats what had no answer and goes on; nothing is applied twice. Where that
    fails for `reconnect_s` seconds, it raises `Unavailable`, and later calls try again and go on
    where the session is. A call that is broken off so, or by Ctrl-C, empties the stage.

    Leaving a `with` block deletes a session that `create_session` made and closes one that
    `open_session` opened. A session that is not deleted lives on in the server.

    Threads: calls from several threads are taken one after the other, but for `cancel`.
    """

    def __init__(self, stub, session_id: str, is_owner: bool, parts=(),
                 reconnect_s: float = 60.0):
        self._stub = stub
        self._session_id = session_id
        self._is_owner = is_owner
        self._lock = threading.RLock()
        self._reconnect_s = reconnect_s
        self._editor = editor.Editor(stub, session_id, list(parts), reconnect_s)
        self._mirror, self._changes = self._editor.mirror, self._editor.changes
        self._last_diff: Optional[diff.Diff] = None
        self._is_deleted = False

    @property
    def last_diff(self) -> Optional[diff.Diff]:
        """What the last call that committed has returned; after `create_session` that of the first
        mesh: why its loop ended, and where the metric is not met. None before any."""
        return self._last_diff

    @property
    def session_id(self) -> str:
        """The name under which `Client.open_session` finds it again."""
        return self._session_id

    @property
    def revision(self) -> int:
        """Revision of `mesh`: it grows by one with every advance. 0: no mesh yet."""
        return self._mirror.revision

    @property
    def mesh(self) -> replica.MeshView:
        """The mesh of the current revision, numbered 0..n-1; the same object until it changes.

        Raises:
            FailedPrecondition: the session has no mesh yet.
        """
        with self._lock:
            if self._mirror.revision == 0:
                self._ensure_stream()
            if self._mirror.revision == 0:
                raise errors.FailedPrecondition(
                    "REVISION_NOT_FOUND", "the session has no mesh yet; call advance() first")
            return self._mirror.view()

    def update_metric(self, metric: Any = None, vertex_ids: Any = None, *,
                      time: Optional[float] = None, displacement: Any = None,
                      advance: Optional[opts.Advance] = None, **limits) -> diff.Diff:
        """Changes the metric, lets the mesh follow, and returns what changed.

        Only what the change affects is touched; the same metric again costs next to nothing and
        brings an empty diff.

        Args:
            metric: (n, 3) tensors m11, m12, m22 in 1 / (domain unit)^2, row i at `mesh.points[i]`;
                or (k, 3) together with `vertex_ids`; or a `pliant.metric`. None keeps the metric,
                for a change of `time` or limits.
            vertex_ids: (k,) slots, entries of `mesh.vertex_ids`, in any order, none twice; the
                other vertices keep their metric.
            time: value of t in expressions from now on.
            displacement: where the metric's features (a front) have moved since the last update, as
                (vertex_ids, vectors) with (k, 2) vectors in domain units: vertices go along, which
                makes the update several times cheaper. With `metric` None their metric goes along.
                Tensors sent with it are those of where it leads: row i at `mesh.points[i]` plus its
                vector, if it has one. Not together with a solution (UNIMPLEMENTED).
            advance: how long the loop may run. Default: until converged.
            **limits: `h_min`, `h_max`, `hgrad`, `rotation`, `anisotropy_max` from now on, as in
                `pliant.options.Limits`. They hold for tensors too, for those of the other vertices
                as well; what bounds have cut off tensors is lost when the bounds are lifted.

        Raises:
            InvalidInput: NOT_POSITIVE_DEFINITE, NOT_FINITE, INDEX_OUT_OF_RANGE, DUPLICATE_ID,
                ARRAY_LENGTH, EXPRESSION_SYNTAX and so on, `index` the first bad row as given.
        """
        with self._lock:
            command = self._metric_command(metric, vertex_ids, time, limits, displacement)
            return self._advance([command], advance)

    def stage_metric(self, metric: Any = None, vertex_ids: Any = None, *,
                     time: Optional[float] = None, **limits) -> None:
        """Like `update_metric`, but the mesh waits for the next `advance`.

        Several staged updates are committed together; where they overlap the later one wins. A
        refused one empties the whole stage.
        """
        with self._lock:
            command = self._metric_command(metric, vertex_ids, time, limits)
            [answer] = self._run([command])
            if answer.WhichOneof("event") == "rejected":
                self._run([("discard", lambda _: edit_pb2.Discard())])
                raise errors.from_detail(answer.rejected.error)

    def replace_domain(self, domain: geometry.Domain, *,
                       advance: Optional[opts.Advance] = None) -> diff.Diff:
        """Gives the session another domain, and returns what changed.

        Holes appear, merge and vanish, parts come and go. Whatever both domains have in common
        keeps its ids and positions; the new points are in the mesh with the coordinates given.
        Values and tensors at vertices go on in new area as at the nearest point of the old one.

        Args:
            domain: a `pliant.Domain`, as at creation.
            advance: how long the loop may run. Default: until converged.

        Raises:
            InvalidInput: as at creation, for instance CROSSING_SEGMENTS with `index` and
                `other_index`; the session stays as it was.
            FailedPrecondition: FROZEN if something frozen would change.
            Unimplemented: a field is conservative.
        """
        with self._lock:
            return self._advance([inputs.domain_command(domain)], advance)

    def move_boundary(self, motions: Any = None, positions: Any = None, vertex_ids: Any = None, *,
                      stop_if_impossible: bool = False, metric_follow_length: float = 0,
                      advance: Optional[opts.Advance] = None) -> diff.Diff:
        """Moves parts of the boundary or of internal constraints, and returns what changed.

        Vertices that the loop put on a moved edge ride along. Everything moves at the same time.

        Args:
            motions: {tag or (tag, ...): motion}, motions made by `pliant.motion`.
            positions: (k, 2) new positions of the vertices `vertex_ids`; they arrive bit for bit.
                Where they leave the line of their edge, the boundary has corners from then on.
            vertex_ids: (k,) slots, entries of `mesh.vertex_ids`, none twice.
            stop_if_impossible: go as far as boundaries do not cross; `Diff.motion_fraction` tells
                how far. Default: such a motion is refused.
            metric_follow_length: vertices within this many wanted edge lengths of what moves, and
                their metric, go with it (boundary layers).
            advance: how long the loop may run. Default: until converged.

        Raises:
            InvalidInput: CROSSING_SEGMENTS if boundaries would cross (`field` "edges", `index` and
                `other_index`: the slots of the constrained edges that meet, entries of
                `mesh.edge_ids`), INDEX_OUT_OF_RANGE, NOT_FINITE and so on.
        """
        with self._lock:
            command = motion.boundary_command(self._seen_revision(), motions, positions, vertex_ids,
                                              stop_if_impossible, metric_follow_length)
            return self._advance([command], advance)

    def move_nodes(self, positions: Any, vertex_ids: Any = None, *,
                   stop_if_impossible: bool = False,
                   advance: Optional[opts.Advance] = None) -> diff.Diff:
        """Moves any vertices, as Lagrangian and ALE solvers do, and returns what changed.

        All arrive at their positions bit for bit; afterwards the loop may smooth or delete those
        in the interior where the metric asks for it. Nodes of a side that leave its line are
        corners from then on, which stay, unless the option `boundary_tolerance` says how far the
        boundary may move to get rid of those that the metric does not need.

        Args:
            positions: (n, 2), row i for `mesh.vertex_ids[i]`; or (k, 2) with `vertex_ids`.
            vertex_ids: (k,) slots, none twice.
            stop_if_impossible, advance: as for `move_boundary`.

        Those in the interior may be sent anywhere inside, past others and across holes.

        Raises:
            InvalidInput: as for `move_boundary`; and POINT_OUTSIDE_DOMAIN, POINT_ON_SEGMENT or
                DUPLICATE_POINT (`index`: the row of `positions`) where a vertex in the interior
                would lie outside, on a constrained edge, or where another one comes to be.
        """
        with self._lock:
            command = motion.nodes_command(self._seen_revision(), positions, vertex_ids,
                                           stop_if_impossible)
            return self._advance([command], advance)

    def set_field(self, name: str, values: Any, ids: Any = None, *, location: str = "vertex",
                  transfer: Optional[str] = None) -> diff.Diff:
        """Makes or changes a solution field that lives on the server and follows the mesh.

        The values are committed at once, as a revision that changes no vertex. Every later commit
        carries them from the old mesh to the new one.

        Args:
            name: 1 to 64 characters of a-z, 0-9 and _.
            values: (n,), (n, 2) vectors or (n, 3) symmetric tensors (11, 12, 22), row i at
                `mesh.points[i]`, or at `mesh.triangles[i]` with location "triangle".
            ids: (k,) slots, ascending, to change only some values of a field that is there.
            location: "vertex" or "triangle".
            transfer: "linear" (at first), "bounded" (no new extrema) or "conservative" (keeps the
                integral) from now on.
        """
        with self._lock:
            revision = self._seen_revision()
            command = fields.command(revision, self._mirror.counts, name, values, ids, location,
                                     transfer)
            return self._advance([command], None)

    def drop_field(self, name: str) -> diff.Diff:
        """The server forgets a field."""
        with self._lock:
            self._ensure_stream()
            revision = self._mirror.revision
            return self._advance([("fields", lambda _: motion_pb2.FieldUpdate(
                revision=revision, dropped_names=[name]))], None)

    def field(self, name: str) -> np.ndarray:
        """Values of a field at the points or triangles of `mesh`, in their order."""
        with self._lock:
            return self._mirror.fields.values(name, self.mesh)

    @property
    def field_names(self) -> List[str]:
        """Fields of the current revision, ascending."""
        return self._mirror.fields.names()

    def advance(self, visits_max: Optional[int] = None, time_ms_max: Optional[int] = None,
                on_progress: Optional[Callable[[diff.Progress], None]] = None,
                commit_interval_ms: Optional[int] = None,
                on_change: Optional[Callable[[replica.Change], None]] = None) -> diff.Diff:
        """Commits what is staged and runs the loop until converged, or as long as allowed.

        Without a limit it goes on, if the server shuts down, when there is a server again within
        `reconnect_s`; the `Diff` is then that of its last part.

        Args:
            visits_max: at most this many visits of vertices, > 0.
            time_ms_max: at most this long, in ms from when the server has it, > 0.
            on_progress: called with a `pliant.Progress` ten times a second while the loop runs.
            commit_interval_ms: commit an unfinished revision this often, >= 10, so that `mesh` and
                subscribers follow while the loop runs; less often if the reader does not keep up.
                The `Diff` is then the last part of what changed.
            on_change: called with every `pliant.Change`, the last included; `mesh` is at it then.

        Both may look at the session and `cancel`; what changes it is refused there.
        """
        with self._lock:
            return self._advance([], opts.Advance(visits_max, time_ms_max), on_progress,
                                 commit_interval_ms, on_change)

    def cancel(self) -> None:
        """Ends the loop of a call that runs in another thread, or in whose `on_progress` this is:
        the mesh so far is committed, and that call returns, `Diff.stop_reason` "CANCELLED", or
        "STAGING" if what it has sent is not staged yet; the next `advance` goes on. Without such a
        call nothing happens. Where that call waits for a lost server, it ends when there is one
        again.
        """
        self._editor.cancel()

    def freeze(self, vertex_ids: Any = None, edge_ids: Any = None, regions: Any = None, *,
               no_insert: bool = False, no_swap: bool = False, no_move: bool = False,
               no_surf: bool = False) -> diff.Diff:
        """Says what must be left alone from now on, in place of what had to be before.

        What is frozen keeps its bits, ids and tags in every revision until other constraints
        replace these (`thaw` lifts all) or a rollback goes behind them. `Diff.troubles` of kind
        "FROZEN" tell what it costs in quality. Committed at once, together with what is staged.

        Args:
            vertex_ids: (k,) slots of vertices that stay in place.
            edge_ids: (k,) slots of constrained edges that are not split; their ends stay.
            regions: tags of regions whose triangles stay.
            no_insert, no_swap, no_move: the loop inserts and deletes, swaps, moves nothing.
            no_surf: the loop leaves constrained edges and the vertices on them alone.

        These four bind the loop alone: `move_nodes`, `move_boundary` and `replace_domain` do what
        they say, and what is in the way makes room. What is frozen they must not change: FROZEN.

        Raises:
            InvalidInput: INDEX_OUT_OF_RANGE or DUPLICATE_ID, `index` the first bad row.
        """
        with self._lock:
            command = constraints.command(
                self._seen_revision(), vertex_ids, edge_ids, regions,
                {"NO_INSERT": no_insert, "NO_SWAP": no_swap, "NO_MOVE": no_move,
                 "NO_SURFACE": no_surf})
            return self._advance([command], None)

    def thaw(self) -> diff.Diff:
        """Lifts all that `freeze` and the options no_insert, no_swap, ... forbid."""
        return self.freeze()

    def set_options(self, **options) -> diff.Diff:
        """Changes how the loop works, and whether limits hold: `h_min`, `h_max`, `hgrad`,
        `rotation`, `anisotropy_max` as in `update_metric`, all others as in
        `pliant.options.SessionOptions` but for `seed` and `variant`, which stay, and no_insert
        and so on, which are `freeze`'s. Committed at once, together with what is staged.
        """
        with self._lock:
            limits, loop = opts.split(options)
            commands = []
            if loop != opts.SessionOptions():
                message = loop.to_wire()
                commands.append(("options", lambda _: message))
            if limits != opts.Limits() or not commands:
                commands.append(self._metric_command(
                    None, None, None, {name: value for name, value in vars(limits).items()
                                       if value is not None}))
            return self._advance(commands, None)

    def rollback(self, revision: int) -> diff.Diff:
        """Goes back to an earlier revision, bit for bit, metric and loop included; the session's
        revision goes on counting.

        Raises:
            NotFound: the revision is no longer kept; the message names the oldest that is.
        """
        with self._lock:
            return self._finish_by("rollback", edit_pb2.Rollback(to_revision=revision), [], None)

    def save_revision(self, revision: int = 0) -> int:
        """Keeps a revision (0: the current one) within reach of `rollback`; returns it."""
        # By its number, so that a second try does not keep a later one.
        request = session_pb2.SaveRevisionRequest(session_id=self._session_id,
                                                  revision=revision or self._mirror.revision)
        return self._persist(lambda: calls.call(self._stub.SaveRevision, request)).revision

    def release(self, *revisions: int) -> None:
        """Lets go of saved revisions."""
        calls.call(self._stub.Release, session_pb2.ReleaseRequest(
            session_id=self._session_id, revisions=revisions))

    def fork(self, session_id: str = "", revision: int = 0) -> str:
        """Creates a second session from a revision (0: the current one); returns its name, for
        `Client.open_session`."""
        response = calls.call(self._stub.Fork, session_pb2.ForkRequest(
            session_id=self._session_id, revision=revision, new_session_id=session_id))
        return response.session.session_id

    def quality(self, basis: str = "limited") -> quality.Quality:
        """Measures the mesh of the current revision.

        Args:
            basis: against the metric that it follows ("limited") or, without limits, the one that
                was sent ("raw").
        """
        request = session_pb2.GetQualityRequest(
            session_id=self._session_id, basis=quality.basis_to_wire(basis))
        response = self._persist(lambda: calls.call(self._stub.GetQuality, request))
        return quality.from_wire(response.quality)

    def download(self) -> replica.MeshView:
        """The mesh afresh from the server, independent of the local copy.

        `mesh` is the same, bit for bit, and costs nothing; this is for checks.
        """
        request = session_pb2.GetMeshRequest(session_id=self._session_id)
        get_mesh = self._stub.GetMesh
        return self._persist(lambda: downloads.mesh(lambda: get_mesh(request)))

    def delete(self) -> None:
        """Ends the session and frees what the server holds of it. Again: does nothing."""
        with self._lock:
            if self._is_deleted:
                return
            self.close()
            calls.call(self._stub.DeleteSession,
                 session_pb2.DeleteSessionRequest(session_id=self._session_id))
            self._is_deleted = True

    def start(self, advance: Optional[opts.Advance] = None) -> None:
        """Connects the local copy, and makes the first mesh if there is none. Used by `Client`."""
        with self._lock:
            self._ensure_stream()
            if self._is_owner and self._mirror.revision == 0:
                self._advance([], advance)

    def close(self) -> None:
        """Lets go of the session, which lives on in the server; another client may edit it."""
        with self._lock:
            self._editor.close()

    def __enter__(self) -> "Session":
        return self

    def __exit__(self, exception_type, *exception) -> None:
        try:
            if self._is_owner:
                self.delete()
            else:
                self.close()
        except errors.Error:
            # The exception that ends the block says more than one from tidying up.
            if exception_type is None:
                raise

    def __repr__(self):
        counts = self._mirror.counts
        return (f"Session({self._session_id!r}, revision {self.revision}, "
                f"{counts.vertices} vertices, {counts.triangles} triangles)")

    def _persist(self, attempt):
        return backoff.persist(self._reconnect_s, attempt)

    def _seen_revision(self):
        if self._mirror.revision == 0:
            self._ensure_stream()
        return self._mirror.revision

    def _metric_command(self, metric, vertex_ids, time, limits, displacement=None):
        if self._mirror.revision == 0:
            self._ensure_stream()
        limits_message = opts.make_limits(limits).to_wire()
        if metric is None and time is None and limits_message is None and displacement is None:
            raise errors.InvalidInput("EMPTY", "nothing to update: give a metric, time or a limit",
                                      field="metric")
        source = None if metric is None else metrics.as_metric(metric, vertex_ids)
        moved = None if displacement is None else metrics.as_displacement(displacement)
        if isinstance(source, metrics.Vertices) and source.vertex_ids is None:
            arrays.check_rows("metric.tensors", source.tensors,
                              self._mirror.counts.vertices, "vertex of the mesh")
        # The revision that the caller has seen; if it is no longer the current one, the server
        # refuses tensors that belong to it.
        revision = self._mirror.revision

        def make(sender):
            message = metric_pb2.MetricUpdate(time=time, limits=limits_message)
            if source is not None:
                message.sources.extend(source.sources(sender, revision))
            if moved is not None:
                message.displacement.CopyFrom(moved.to_wire(sender, revision))
            return message

        return "metric", make

    def _advance(self, commands, advance, on_progress=None, commit_interval_ms=None,
                 on_change=None):
        message = (advance or opts.Advance()).to_wire()
        if on_progress is not None:
            message.progress_interval_ms = _PROGRESS_MS
        if commit_interval_ms is not None:
            message.commit_interval_ms = commit_interval_ms
        with self._editor.cancellable():
            done = self._finish_by("advance", message, commands, on_progress, on_change)
            # Who sets no limit wants it converged, by the next server if this one shuts down.
            goes_on = advance is None or advance == opts.Advance()
            while (done.stop_reason == "SERVER_CLOSING" and goes_on
                   and not self._editor.is_cancelled):
                try:
                    done = self._finish_by("advance", message, [], on_progress, on_change)
                except errors.Unavailable:
                    break  # What is committed is committed.
        return done

    def _finish_by(self, name, message, commands, on_progress, on_change=None):
        """Runs commands of which the last one, `name`, makes a revision; its Diff."""
        answers = self._run(commands + [(name, lambda _: message)], on_progress, on_change)
        for answer in answers:
            if answer.WhichOneof("event") == "rejected":
                raise errors.from_detail(answer.rejected.error)
        advanced = answers[-1].advanced
        change = self._changes[-1] if self._changes else None
        if change is None and advanced.stop_reason == edit_pb2.STOP_REASON_STAGING:
            change = replica.no_change(self._mirror)
        if change is None or change.revision != advanced.revision:
            raise errors.Error("PROTOCOL_ORDER", f"no diff came for revision {advanced.revision}")
        self._last_diff = diff.make_diff(change, advanced)
        return self._last_diff

    def _run(self, commands, on_progress=None, on_change=None):
        """Answers to (name, function that makes the message) pairs, sent on the stream."""
        self._editor.check_free()
        self._changes.clear()
        self._ensure_stream()
        return self._editor.run(commands, on_progress, on_change)

    def _ensure_stream(self):
        if self._is_deleted:
            raise errors.NotFound("SESSION_NOT_FOUND", f"session {self._session_id!r} is deleted")
        self._editor.connect()
