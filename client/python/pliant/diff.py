"""What an advance changed."""

from dataclasses import dataclass
from typing import Optional

from pliant.replica import Change
from pliant.v1 import edit_pb2


@dataclass(frozen=True)
class Trouble:
    """A place where the metric is not met.

    Attributes:
        kind: "SIZE_JUMP", "CROSSED" (directions), "GEOMETRY" (smaller than the wanted size),
            "CURVATURE" (more than the aspect ratio allows), "VERTEX_LIMIT",
            "FROZEN" (constraints are in the way) or "UNSETTLED".
        vertex_count: vertices of bad triangles there.
        place_count: above 1 where several places of one kind were put together.
        center: (x, y) of the worst triangle, domain units.
        box: (x_min, y_min, x_max, y_max) around the bad triangles, domain units.
        q_min: least quality of a triangle there.
        length_min, length_max: of the edges there, in the metric; 1 is what was asked for.
    """

    kind: str
    vertex_count: int
    place_count: int
    center: tuple
    box: tuple
    q_min: float
    length_min: float
    length_max: float


def make_trouble(message) -> Trouble:
    """The Trouble in a `Trouble` message."""
    kind = edit_pb2.TroubleKind.Name(message.kind).removeprefix("TROUBLE_KIND_")
    box = message.box
    return Trouble(kind, message.vertex_count, message.place_count,
                   (message.center_x, message.center_y),
                   (box.x_min, box.y_min, box.x_max, box.y_max),
                   message.q_min, message.length_min, message.length_max)


@dataclass(frozen=True)
class LimitReport:
    """What one kind of limit did to the metric.

    Attributes:
        vertex_count: vertices of the whole mesh at which it holds.
        ratio_max: greatest ratio of wanted lengths before and after all limits, among the vertices
            that this update changed.
        worst_vertex_id: vertex with that ratio; -1 for none.
        complexity_before, complexity_after: integral of sqrt(det M) over the mesh without and with
            all limits; a mesh has about 2/sqrt(3) times as many vertices.
    """

    vertex_count: int
    ratio_max: float
    worst_vertex_id: int
    complexity_before: float
    complexity_after: float


@dataclass(frozen=True, eq=False)
class Diff(Change):
    """What an advance changed, and how it ended.

    All arrays are read-only and sorted by slot; they look at the received bytes in place. Slots
    that are not named are untouched, bit for bit. A slot that a removed element leaves may come
    back in a later diff with another element.

    Attributes:
        base_revision, revision: the diff leads from one to the other. A base of 0 means that the
            arrays hold the whole mesh (first diff of a session, or a new start after the
            connection was lost).
        removed_vertices, removed_triangles, removed_edges: (k,) int32 slots that are free now.
        vertex_ids: (n,) int32 slots of new and moved vertices.
        vertex_positions: (n, 2) float64, domain units.
        triangle_ids: (n,) int32 slots of new and changed triangles.
        triangle_vertices: (n, 3) int32 slots of their corners, counter-clockwise.
        triangle_tags: (n,) int32.
        edge_ids: (n,) int32 slots of new and changed constrained edges.
        edge_vertices: (n, 2) int32 slots of their ends.
        edge_tags: (n,) int32.
        counts: live elements at `revision`: `counts.vertices`, `.triangles`, `.edges`.
        state_hash: as proto/README.md defines it; the local copy has been compared with it.
        metric_vertex_ids: (k,) int32 slots of vertices whose metric changed; empty unless the
            session was made or opened `with_metric`.
        metrics: (k, 3) float64 tensors at them.
        fields: new values of the session's fields, a list of `FieldRows`; `Session.field` has all.
        dropped_fields: names of fields that are no more.
        transfer: `TransferRows`, which carry nodal values from the mesh before to the mesh after;
            None unless the session was made or opened with `with_transfer`, and in a diff
            over several revisions.
        stop_reason: "CONVERGED", "VISIT_BUDGET", "TIME_BUDGET", "CANCELLED", "VERTEX_LIMIT",
            "VISIT_LIMIT" or "SERVER_CLOSING"; or "STAGING": the time was over, or `cancel` was
            called, before all that the call had sent was staged. Then nothing is committed,
            `revision` is `base_revision`, and staging goes on: the next `advance` commits it.
        active_count: vertices that the loop has not finished; 0 if converged.
        visit_count, move_count, insertion_count, deletion_count, swap_count: work of the loop.
        cooled_count: vertices that came to rest by their age alone: the metric cannot be met there.
        softened_count: corners that the option `boundary_tolerance` let go: they are vertices of a
            side now, or gone.
        troubles: tuple of Trouble, the places where the metric is not met among what changed, the
            largest first; empty while vertices are active.
        motion_fraction: share of the motion that was done, 0 to 1; None if nothing was to move.
        durable_revision: greatest revision that is on the server's disk; None if the session is
            kept in memory only.
        limits: what limits did to the metric, by stage ("GEOMETRY", "ROTATION", "GRADATION"); a
            stage that changed nothing is absent.
        compute_us: time of the loop and the commit in the core, microseconds; without what was
            staged before, where motions are carried out.
        elapsed_us: from when the server had the advance, or had ended the one before it, to its
            answer, microseconds.
    """

    stop_reason: str
    active_count: int
    visit_count: int
    move_count: int
    insertion_count: int
    deletion_count: int
    swap_count: int
    cooled_count: int
    softened_count: int
    troubles: tuple
    motion_fraction: Optional[float]
    durable_revision: Optional[int]
    compute_us: int
    elapsed_us: int
    limits: "dict[str, LimitReport]"

    @property
    def converged(self) -> bool:
        """True if the loop finished: no vertex is active."""
        return self.stop_reason == "CONVERGED"

    @property
    def empty(self) -> bool:
        """True if the mesh is as before."""
        return not any(map(len, (self.removed_vertices, self.removed_triangles, self.removed_edges,
                                 self.vertex_ids, self.triangle_ids, self.edge_ids)))

    def __repr__(self):
        return (f"Diff({self.base_revision} -> {self.revision}, {self.stop_reason.lower()}: "
                f"{len(self.vertex_ids)} vertices, {len(self.triangle_ids)} triangles written, "
                f"{len(self.removed_vertices)}, {len(self.removed_triangles)} removed)")


@dataclass(frozen=True)
class Progress:
    """How a running advance is doing.

    Attributes:
        active_count: vertices that still wait for a visit.
        visit_count: visits so far in this advance.
        vertex_count: vertices now.
        elapsed_ms: since the server had it, as `Diff.elapsed_us`.
    """

    active_count: int
    visit_count: int
    vertex_count: int
    elapsed_ms: int


def progress_from_wire(message) -> Progress:
    """The Progress of its message."""
    return Progress(message.active_count, message.visit_count, message.vertex_count,
                    message.elapsed_ms)


def make_diff(change: Change, advanced) -> Diff:
    """The Diff for an applied change and the `AdvanceResult` message that came with it."""
    reason = edit_pb2.StopReason.Name(advanced.stop_reason)
    return Diff(
        **vars(change), stop_reason=reason.removeprefix("STOP_REASON_"),
        active_count=advanced.active_count, visit_count=advanced.visit_count,
        move_count=advanced.move_count, insertion_count=advanced.insertion_count,
        deletion_count=advanced.deletion_count, swap_count=advanced.swap_count,
        cooled_count=advanced.cooled_count, softened_count=advanced.softened_count,
        troubles=tuple(map(make_trouble, advanced.troubles)),
        motion_fraction=_optional(advanced, "motion_fraction"),
        durable_revision=_optional(advanced, "durable_revision"),
        compute_us=advanced.compute_us,
        elapsed_us=advanced.elapsed_us,
        limits={_stage(report): LimitReport(
            vertex_count=report.vertex_count, ratio_max=report.ratio_max,
            worst_vertex_id=report.worst_vertex_id,
            complexity_before=report.complexity_before,
            complexity_after=report.complexity_after) for report in advanced.limits})


def _optional(message, name: str):
    return getattr(message, name) if message.HasField(name) else None


def _stage(report) -> str:
    return edit_pb2.LimitStage.Name(report.stage).removeprefix("LIMIT_STAGE_")
