"""Motions of tagged boundaries, for `Session.move_boundary`."""

from dataclasses import dataclass
from typing import Any, Sequence, Tuple

from pliant import arrays, errors
from pliant.v1 import motion_pb2


class Motion:
    """Base of all motions; `to_wire` gives the message for some tags."""

    def to_wire(self, tags) -> motion_pb2.TagMotion:
        raise NotImplementedError


@dataclass(frozen=True)
class Translation(Motion):
    """By a vector, in domain units."""

    x: float
    y: float

    def to_wire(self, tags):
        return motion_pb2.TagMotion(tags=tags,
                                    translation=motion_pb2.Translation(x=self.x, y=self.y))


@dataclass(frozen=True)
class Rotation(Motion):
    """About a point, counter-clockwise; on its way everything follows circles."""

    center: Tuple[float, float]
    angle_rad: float

    def to_wire(self, tags):
        return motion_pb2.TagMotion(tags=tags, rotation=motion_pb2.Rotation(
            center_x=self.center[0], center_y=self.center[1], angle_rad=self.angle_rad))


@dataclass(frozen=True)
class Affine(Motion):
    """x' = A x + b, on straight lines; the determinant of A is positive."""

    matrix: Sequence[Sequence[float]]
    shift: Tuple[float, float] = (0, 0)

    def to_wire(self, tags):
        (a11, a12), (a21, a22) = self.matrix
        return motion_pb2.TagMotion(tags=tags, affine=motion_pb2.Affine(
            a11=a11, a12=a12, a21=a21, a22=a22, b1=self.shift[0], b2=self.shift[1]))


@dataclass(frozen=True)
class Path(Motion):
    """Displacement sum of coefficients[k-1] s^k for s from 0 to 1; 1 to 16 coefficients (x, y)."""

    coefficients: Sequence[Tuple[float, float]]

    def to_wire(self, tags):
        return motion_pb2.TagMotion(tags=tags, path=motion_pb2.PolynomialPath(
            x=[c[0] for c in self.coefficients], y=[c[1] for c in self.coefficients]))


def boundary_command(revision, motions, positions, vertex_ids, stop, follow):
    """The edit command of `Session.move_boundary`."""
    if not motions and positions is None:
        raise errors.InvalidInput("EMPTY", "nothing to move: give motions or positions",
                                  field="boundary")
    if positions is not None and vertex_ids is None:
        raise errors.InvalidInput("EMPTY", "positions need vertex_ids", field="vertex_ids")
    tag_motions = [_by_tags(tags, motion) for tags, motion in (motions or {}).items()]
    vertices = _positions(positions, vertex_ids)

    def make(sender):
        message = motion_pb2.BoundaryUpdate(tags=tag_motions, on_impossible=_choice(stop),
                                            metric_follow_length=follow)
        if vertices is not None:
            message.vertices.CopyFrom(_to_wire(sender, revision, vertices))
        return message

    return "boundary", make


def nodes_command(revision, positions, vertex_ids, stop):
    """The edit command of `Session.move_nodes`."""
    vertices = _positions(positions, vertex_ids)

    def make(sender):
        return motion_pb2.NodeUpdate(vertices=_to_wire(sender, revision, vertices),
                                     on_impossible=_choice(stop))

    return "nodes", make


def _by_tags(tags: Any, motion: Any) -> motion_pb2.TagMotion:
    if not isinstance(motion, Motion):
        raise errors.InvalidInput("ARRAY_TYPE", f"{motion!r} is no motion; make one with "
                                  "pliant.motion", field="motions")
    return motion.to_wire([tags] if isinstance(tags, int) else list(tags))


def _positions(positions, vertex_ids):
    if positions is None:
        return None
    rows = arrays.as_floats("positions", positions, 2)
    if vertex_ids is None:
        return rows, None
    ids = arrays.as_integers("vertex_ids", vertex_ids)
    arrays.check_rows("positions", rows, len(ids), "entry of vertex_ids")
    return rows, ids


def _to_wire(sender, revision, vertices):
    rows, ids = vertices
    message = motion_pb2.VertexPositions(revision=revision, positions=sender.array(rows))
    if ids is not None:
        message.vertex_ids.CopyFrom(sender.array(ids))
    return message


def _choice(stop):
    return (motion_pb2.IMPOSSIBLE_MOTION_STOP if stop else motion_pb2.IMPOSSIBLE_MOTION_REFUSE)
