"""The local copy of a session's mesh: diffs go in, arrays come out.

The state is what the server has: slots, some of them free. `Replica.apply` writes the rows of a
diff at their slots and then compares counts and state hash with the server's, so that a difference
is found at the revision where it arises. `Replica.view` numbers the live elements 0..n-1.
"""

from dataclasses import dataclass
from typing import List, Optional

import numpy as np

from pliant import fields
from pliant.errors import ReplicaMismatch

# Slots are int32; one that is far beyond all others is garbage, not a mesh.
_SLOTS_MAX = 2**31 - 1

_VERTEX, _TRIANGLE, _EDGE = 1, 2, 3
_GOLDEN = np.uint64(0x9E3779B97F4A7C15)


@dataclass(frozen=True)
class Counts:
    """Live elements of a revision; edges are the constrained ones."""

    vertices: int
    triangles: int
    edges: int


@dataclass(frozen=True, eq=False)
class Change:
    """What leads from one revision to another, as it came from the wire; see `Diff`."""

    base_revision: int
    revision: int
    removed_vertices: np.ndarray
    removed_triangles: np.ndarray
    removed_edges: np.ndarray
    vertex_ids: np.ndarray
    vertex_positions: np.ndarray
    triangle_ids: np.ndarray
    triangle_vertices: np.ndarray
    triangle_tags: np.ndarray
    edge_ids: np.ndarray
    edge_vertices: np.ndarray
    edge_tags: np.ndarray
    counts: Counts
    state_hash: int
    metric_vertex_ids: np.ndarray
    metrics: np.ndarray
    fields: List[fields.FieldRows]
    dropped_fields: List[str]
    transfer: Optional[fields.TransferRows]


def no_change(mirror: "Replica") -> Change:
    """The Change from the mirror's revision to itself."""
    def none(dtype, *shape):
        return np.empty((0, *shape), dtype)

    ids, pairs = none("<i4"), none("<i4", 2)
    return Change(
        base_revision=mirror.revision, revision=mirror.revision, removed_vertices=ids,
        removed_triangles=ids, removed_edges=ids, vertex_ids=ids,
        vertex_positions=none("<f8", 2), triangle_ids=ids, triangle_vertices=none("<i4", 3),
        triangle_tags=ids, edge_ids=ids, edge_vertices=pairs, edge_tags=ids, counts=mirror.counts,
        state_hash=mirror.state_hash, metric_vertex_ids=ids, metrics=none("<f8", 3), fields=[],
        dropped_fields=[], transfer=None)


def change_from_wire(message, blobs, is_snapshot) -> Change:
    """The Change of a `MeshDiff`, or of a `MeshSnapshot`, which is a diff from nothing."""
    def ids(name):
        return blobs.array(getattr(message, name), name, "<i4")

    def rows(name, dtype, column_count):
        return blobs.array(getattr(message, name), name, dtype, column_count)

    nothing = np.empty(0, "<i4")
    counts = message.counts
    field_rows, dropped_names = fields.fields_from_wire(message, blobs)
    return Change(
        base_revision=0 if is_snapshot else message.base_revision, revision=message.revision,
        removed_vertices=nothing if is_snapshot else ids("removed_vertices"),
        removed_triangles=nothing if is_snapshot else ids("removed_triangles"),
        removed_edges=nothing if is_snapshot else ids("removed_edges"),
        vertex_ids=ids("vertex_ids"), vertex_positions=rows("vertex_positions", "<f8", 2),
        triangle_ids=ids("triangle_ids"), triangle_vertices=rows("triangle_vertices", "<i4", 3),
        triangle_tags=ids("triangle_tags"), edge_ids=ids("edge_ids"),
        edge_vertices=rows("edge_vertices", "<i4", 2), edge_tags=ids("edge_tags"),
        counts=Counts(counts.vertex_count, counts.triangle_count, counts.edge_count),
        state_hash=message.state_hash,
        metric_vertex_ids=blobs.array(message.metric.vertex_ids, "metric.vertex_ids", "<i4"),
        metrics=blobs.array(message.metric.tensors, "metric.tensors", "<f8", 3),
        fields=field_rows, dropped_fields=dropped_names,
        transfer=None if is_snapshot else fields.rows_from_wire(message, blobs))


@dataclass(frozen=True, eq=False)
class MeshView:
    """The mesh of one revision, numbered 0..n-1 in ascending order of slot.

    All arrays are C-contiguous and read-only, and stay as they are when the session goes on.

    Attributes:
        revision: which.
        points: (n, 2) float64, domain units.
        triangles: (m, 3) int32 rows of `points`, counter-clockwise.
        triangle_tags: (m,) int32 regions.
        edges: (e, 2) int32 rows of `points`: constrained edges, along their input segment.
        edge_tags: (e,) int32.
        vertex_ids: (n,) int32 slots of the rows of `points`: ids that a vertex keeps for life.
        triangle_ids: (m,) int32 slots of the rows of `triangles`.
        edge_ids: (e,) int32 slots of the rows of `edges`.
        state_hash: as proto/README.md defines it; equal meshes with equal slots have equal hashes.
        metrics: (n, 3) float64 tensors m11, m12, m22 that the mesh follows at `points`, limits
            applied; NaN unless asked for by `with_metric`.
    """

    revision: int
    points: np.ndarray
    triangles: np.ndarray
    triangle_tags: np.ndarray
    edges: np.ndarray
    edge_tags: np.ndarray
    vertex_ids: np.ndarray
    triangle_ids: np.ndarray
    edge_ids: np.ndarray
    state_hash: int
    metrics: np.ndarray

    def rows_of(self, vertex_ids) -> np.ndarray:
        """(k,) rows of `points` of the slots `vertex_ids`; -1 for slots that are free.

        Carries values from one revision to the next: `old.rows_of(new.vertex_ids)`. Note that a
        diff lists new vertices too, because they may live in a slot that was free before.
        """
        wanted = np.asarray(vertex_ids)
        if len(self.vertex_ids) == 0:
            return np.full(wanted.shape, -1)
        rows = np.searchsorted(self.vertex_ids, wanted)
        found = self.vertex_ids[np.minimum(rows, len(self.vertex_ids) - 1)] == wanted
        return np.where(found, rows, -1)


class _Column:
    """Slots of one kind of element: integer or float rows, a tag each, and which are live."""

    def __init__(self, kind, dtype, column_count):
        self._kind = kind
        self.rows = np.zeros((0, column_count), dtype)
        self.tags = np.zeros(0, np.int32)
        self.live = np.zeros(0, bool)
        self.count = 0

    def write(self, removed, ids, rows, tags, uses=None):
        """Frees `removed`, writes the others; returns the change of the state hash.

        Args:
            uses: by slot of a vertex, how often rows name it; kept up to date.
        """
        if not len(removed) and not len(ids) and not len(rows) and not len(tags):
            return np.uint64(0)
        _check_ids(removed, len(self.live))
        _check_ids(ids, _SLOTS_MAX)
        if len(rows) != len(ids) or len(tags) != len(ids) or not self.live[removed].all():
            raise _mismatch("the diff does not fit the local copy")
        if len(ids):
            self._grow(int(ids[-1]) + 1)
        before = np.concatenate([removed, ids[self.live[ids]]])
        difference = self._hash(ids, rows, tags) - self._hash(
            before, self.rows[before], self.tags[before])
        if uses is not None:
            _count_uses(uses, self.rows[before], -1)
            _count_uses(uses, rows, 1)
        self.live[removed] = False
        self.rows[ids] = rows
        self.tags[ids] = tags
        self.count += len(ids) - len(before)
        self.live[ids] = True
        return difference

    def _grow(self, slot_count):
        missing = slot_count - len(self.live)
        if missing <= 0:
            return
        # Half as much again, so that growth costs O(1) per slot in the long run.
        missing = max(missing, len(self.live) // 2)
        self.rows = np.concatenate(
            [self.rows, np.zeros((missing, self.rows.shape[1]), self.rows.dtype)])
        self.tags = np.concatenate([self.tags, np.zeros(missing, np.int32)])
        self.live = np.concatenate([self.live, np.zeros(missing, bool)])

    def _hash(self, ids, rows, tags):
        words = [] if self._kind == _VERTEX else [_words(tags)]
        if self.rows.dtype.kind == "f":
            columns = [np.ascontiguousarray(column).view(np.uint64) for column in rows.T]
        else:
            columns = [_words(column) for column in rows.T]
        return element_hash_sum(self._kind, ids, columns + words)


def element_hash_sum(kind, ids, words):
    """Sum modulo 2^64 of the hashes of elements: proto/README.md, "State hash".

    Args:
        kind: 1 vertex, 2 triangle, 3 constrained edge.
        ids: (k,) slots.
        words: sequence of (k,) uint64: the contents in order.
    """
    state = _mix(np.uint64(kind << 32) + _words(ids))
    for word in words:
        state = _mix(state + _GOLDEN + word)
    return state.sum(dtype=np.uint64)


def _words(integers):
    """int32 as the wire's 64-bit words: by their 32 bits, not by their value."""
    return np.ascontiguousarray(integers).view(np.uint32).astype(np.uint64)


def _mix(x):
    """The finalizer of splitmix64 on an array of uint64; overflow wraps, as it must."""
    x = (x ^ (x >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    x = (x ^ (x >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return x ^ (x >> np.uint64(31))


def _count_uses(uses, rows, sign):
    """Adds how often `rows` name each slot; O(rows) unless they are most of the mesh."""
    if not rows.size:
        return
    if rows.min() < 0 or rows.max() >= len(uses):
        raise _mismatch("the diff names a corner that does not exist")
    if 4 * rows.size > len(uses):
        uses += sign * np.bincount(rows.ravel(), minlength=len(uses))
    else:
        slots, counts = np.unique(rows, return_counts=True)
        uses[slots] += sign * counts


def _check_ids(ids, slot_count):
    """Slots ascend, so that the ends bound them all and no two writes hit one row."""
    if len(ids) and (ids[0] < 0 or ids[-1] >= slot_count or (ids[1:] <= ids[:-1]).any()):
        raise _mismatch("the diff names slots out of order or that do not exist")


def _mismatch(message):
    return ReplicaMismatch("REPLICA_MISMATCH", f"{message}; the next call downloads the mesh "
                           "afresh. Please report this")


class Replica:
    """Mirrors one session.

    Invariants: between calls of `apply` that return, counts and hash are those that the server
    stated for `revision`. After `apply` raised, the replica is empty at revision 0.
    """

    def __init__(self):
        self._clear()

    def _clear(self):
        self.revision = 0
        self._vertices = _Column(_VERTEX, np.float64, 2)
        self._triangles = _Column(_TRIANGLE, np.int32, 3)
        self._edges = _Column(_EDGE, np.int32, 2)
        self._uses = np.zeros(0, np.int64)  # Corners and ends of live elements at each vertex.
        self._metrics = np.zeros((0, 3))
        self._hash = np.uint64(0)
        self._view: Optional[MeshView] = None
        self.fields = fields.FieldTable()

    @property
    def counts(self) -> Counts:
        """Live elements."""
        return Counts(self._vertices.count, self._triangles.count, self._edges.count)

    @property
    def state_hash(self) -> int:
        """Of what is here."""
        return int(self._hash)

    def apply(self, change: Change):
        """Goes to `change.revision`. Raises ReplicaMismatch, and is empty then."""
        if change.base_revision == 0:
            self._clear()
        base_revision = self.revision
        try:
            if change.base_revision != base_revision:
                raise _mismatch(f"a diff from revision {change.base_revision} came, but the local "
                                f"copy is at {base_revision}")
            self._write(change)
            if self.counts != change.counts or int(self._hash) != change.state_hash:
                raise _mismatch(
                    f"at revision {change.revision} the local copy has {self.counts}, hash "
                    f"{int(self._hash):016x}; the server {change.counts}, hash "
                    f"{change.state_hash:016x}")
        except Exception:
            self._clear()
            raise

    def _write(self, change):
        no_tags = np.zeros(len(change.vertex_ids), np.int32)
        with np.errstate(over="ignore"):
            self._hash += self._vertices.write(change.removed_vertices, change.vertex_ids,
                                               change.vertex_positions, no_tags)
            missing = len(self._vertices.live) - len(self._uses)
            if missing > 0:
                self._uses = np.concatenate([self._uses, np.zeros(missing, np.int64)])
            self._hash += self._triangles.write(
                change.removed_triangles, change.triangle_ids, change.triangle_vertices,
                change.triangle_tags, self._uses)
            self._hash += self._edges.write(change.removed_edges, change.edge_ids,
                                            change.edge_vertices, change.edge_tags, self._uses)
        self._check_corners(change)
        self._write_metrics(change.metric_vertex_ids, change.metrics)
        self.fields.write(change.fields, change.dropped_fields)
        self.revision = change.revision
        self._view = None

    def _check_corners(self, change):
        """Corners and ends live. The hash would tell, unless the server has summed up the same."""
        if self._uses[change.removed_vertices].any():
            raise _mismatch("the diff removes a vertex that is still a corner")
        for rows in (change.triangle_vertices, change.edge_vertices):
            if not self._vertices.live[rows].all():
                raise _mismatch("the diff names a corner that does not exist")

    def _write_metrics(self, ids, metrics):
        missing = len(self._vertices.live) - len(self._metrics)
        if missing > 0:
            self._metrics = np.concatenate([self._metrics, np.full((missing, 3), np.nan)])
        _check_ids(ids, len(self._metrics))
        if len(ids) != len(metrics):
            raise _mismatch("the diff has not one tensor for each vertex that it names")
        self._metrics[ids] = metrics

    def view(self) -> MeshView:
        """The mesh, numbered 0..n-1; made once per revision. O(mesh)."""
        if self._view is None:
            self._view = self._make_view()
        return self._view

    def _make_view(self):
        vertex_ids, triangle_ids, edge_ids = (
            np.flatnonzero(column.live).astype(np.int32)
            for column in (self._vertices, self._triangles, self._edges))
        row_of_slot = np.full(len(self._vertices.live), -1, np.int32)
        row_of_slot[vertex_ids] = np.arange(len(vertex_ids), dtype=np.int32)
        arrays = {
            "points": self._vertices.rows[vertex_ids],
            "triangles": row_of_slot[self._triangles.rows[triangle_ids]],
            "triangle_tags": self._triangles.tags[triangle_ids],
            "edges": row_of_slot[self._edges.rows[edge_ids]],
            "edge_tags": self._edges.tags[edge_ids],
            "metrics": self._metrics[vertex_ids],
            "vertex_ids": vertex_ids,
            "triangle_ids": triangle_ids,
            "edge_ids": edge_ids,
        }
        for array in arrays.values():
            array.flags.writeable = False
        return MeshView(revision=self.revision, state_hash=int(self._hash), **arrays)
