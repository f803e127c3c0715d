"""What mesh is wanted.

A metric is a symmetric positive definite tensor field M in 1 / (domain unit)^2: an edge vector e
has the wanted length if e' M e = 1. M = I / h^2 asks for edges of length h in every direction.
Arrays of tensors have rows m11, m12, m22.

>>> expression("1/0.05^2; 0; 1/0.2^2")
Expression(m11='1/0.05^2', m12='0', m22='1/0.2^2')
>>> size("0.1 + 0.2*x")
Size(h='0.1 + 0.2*x')
"""

from dataclasses import dataclass
from typing import Any, Optional

import numpy as np

from pliant import geometry
from pliant.arrays import as_floats, as_integers, check_rows
from pliant.errors import InvalidInput
from pliant.fields import field_values
from pliant.v1 import mesh_pb2, metric_pb2


class Metric:
    """Base of all descriptions of a metric; `to_wire` gives the message of one source."""

    def sources(self, sender, revision):
        """The sources that the server intersects: most metrics are one."""
        return [self.to_wire(sender, revision)]


@dataclass(frozen=True)
class Expression(Metric):
    """Three expressions in x, y (domain units) and t; see `expression`."""

    m11: str
    m12: str
    m22: str

    def to_wire(self, sender, revision):
        del sender, revision
        return metric_pb2.MetricSource(expression=metric_pb2.ExpressionMetric(
            m11=self.m11, m12=self.m12, m22=self.m22))


@dataclass(frozen=True)
class Size(Metric):
    """One expression for the wanted edge length; see `size`."""

    h: str

    def to_wire(self, sender, revision):
        del sender, revision
        return metric_pb2.MetricSource(size=metric_pb2.SizeMetric(size=self.h))


class Background(Metric):
    """Tensors at the vertices of another mesh; see `background`."""

    def __init__(self, mesh: Any, tensors: Any):
        self.mesh = geometry.as_mesh(mesh)
        self.tensors: np.ndarray = as_floats("metric.tensors", tensors, 3)
        check_rows("metric.tensors", self.tensors, len(self.mesh.points),
                   "point of the background mesh")

    def to_wire(self, sender, revision):
        del revision
        return metric_pb2.MetricSource(background=metric_pb2.BackgroundMetric(
            mesh=self.mesh.to_wire(sender), tensors=sender.array(self.tensors)))


class Grid(Metric):
    """Tensors at the nodes of a regular grid; see `grid`."""

    def __init__(self, origin: Any, step: Any, tensors: Any):
        self.origin: np.ndarray = as_floats("metric.grid.origin", [origin], 2)[0]
        self.step: np.ndarray = as_floats("metric.grid.step", [step], 2)[0]
        values = np.asarray(tensors, dtype=float)
        if values.ndim != 3 or values.shape[2] != 3:
            raise InvalidInput("ARRAY_SHAPE", "metric.grid.tensors must have the shape (rows, "
                               f"columns, 3); got {values.shape}", field="metric.grid.tensors")
        self.column_count = values.shape[1]
        self.tensors = as_floats("metric.grid.tensors", values.reshape(-1, 3), 3)

    def to_wire(self, sender, revision):
        del revision
        return metric_pb2.MetricSource(grid=metric_pb2.GridMetric(
            origin_x=self.origin[0], origin_y=self.origin[1], step_x=self.step[0],
            step_y=self.step[1], column_count=self.column_count,
            tensors=sender.array(self.tensors)))


class Intersection(Metric):
    """Several metrics at once; see `intersection`."""

    def __init__(self, parts):
        self.parts = parts

    def sources(self, sender, revision):
        return [source for part in self.parts for source in part.sources(sender, revision)]


class Vertices(Metric):
    """Tensors at vertices of the session's own mesh; see `vertices`."""

    def __init__(self, tensors: Any, vertex_ids: Any = None):
        self.tensors: np.ndarray = as_floats("metric.tensors", tensors, 3)
        self.vertex_ids: Optional[np.ndarray] = None
        if vertex_ids is not None:
            self.vertex_ids = as_integers("metric.vertex_ids", vertex_ids)
            check_rows("metric.tensors", self.tensors, len(self.vertex_ids),
                       "entry of vertex_ids")

    def to_wire(self, sender, revision):
        return metric_pb2.MetricSource(vertices=metric_pb2.VertexMetric(
            revision=revision, vertex_ids=sender.array(self.vertex_ids),
            tensors=sender.array(self.tensors)))


class Displacement:
    """How vertices go along with a feature of the metric."""

    def __init__(self, vertex_ids: Any, vectors: Any):
        self.vertex_ids: np.ndarray = as_integers("metric.displacement.vertex_ids", vertex_ids)
        self.vectors: np.ndarray = as_floats("metric.displacement.displacements", vectors, 2)
        check_rows("metric.displacement.displacements", self.vectors, len(self.vertex_ids),
                   "entry of vertex_ids")

    def to_wire(self, sender, revision):
        return metric_pb2.MetricDisplacement(
            revision=revision, vertex_ids=sender.array(self.vertex_ids),
            displacements=sender.array(self.vectors))


def as_displacement(pair: Any) -> Displacement:
    """The displacement of `Session.update_metric`: (vertex_ids, vectors)."""
    if isinstance(pair, Displacement):
        return pair
    if not isinstance(pair, tuple) or len(pair) != 2:
        raise InvalidInput("ARRAY_TYPE", "displacement must be (vertex_ids, vectors)",
                           field="metric.displacement")
    return Displacement(*pair)


def expression(tensor: str) -> Expression:
    """A metric by expressions: "M11; M12; M22" in the variables x, y (domain units) and t.

    Operators + - * / ^, comparisons, c ? a : b, and sqrt abs min max exp log sin cos tan atan2.
    A text that does not parse is refused by the server: EXPRESSION_SYNTAX, `index` the position.
    """
    parts = [part.strip() for part in tensor.split(";")]
    if len(parts) != 3 or not all(parts):
        raise InvalidInput("EXPRESSION_SYNTAX", "metric.expression must be three expressions "
                           f'"M11; M12; M22"; got {tensor!r}', field="metric.expression")
    return Expression(*parts)


def size(h: str) -> Size:
    """An isotropic metric by one expression for the wanted edge length in domain units, > 0.

    The same grammar as `expression`. A number serves as well: size(0.1).
    """
    return Size(h if isinstance(h, str) else repr(float(h)))


def background(mesh: Any, tensors: Any) -> Background:
    """Tensors at the points of another mesh, log-Euclidean in between.

    Args:
        mesh: a `pliant.Mesh`, or the mesh of a session. Outside it the value at its nearest point
            holds.
        tensors: (n, 3) m11, m12, m22 in 1 / (domain unit)^2, one row for each point of `mesh`.
    """
    return Background(mesh, tensors)


def grid(origin: Any, step: Any, tensors: Any) -> Grid:
    """Tensors at the nodes of a regular grid, log-Euclidean in between.

    Outside the grid the value at its nearest point holds.

    Args:
        origin: (2,) the node of tensors[0, 0], domain units.
        step: (2,) distance of columns and of rows, > 0, domain units.
        tensors: (rows, columns, 3) m11, m12, m22 in 1 / (domain unit)^2, at least 2 x 2 nodes;
            tensors[j, i] is at origin + (i, j) * step.
    """
    return Grid(origin, step, tensors)


def intersection(*parts: Metric) -> Intersection:
    """Several metrics at once: in every direction the finest holds.

    Args:
        parts: at most 16 of `expression`, `size`, `background`, `grid`, and at most one of
            `vertices` and `solution` among them (UNIMPLEMENTED if more). The others stay beside
            such values: they are asked where a vertex is, whenever it moves, until all vertices
            get tensors without them, or another metric comes. `vertices` with ids replaces only
            the tensors of these vertices; with no ids at all, only the other parts.
    """
    if not parts or not all(isinstance(part, Metric) for part in parts):
        raise InvalidInput("EMPTY", "give at least one metric, each made by a function of "
                           "pliant.metric", field="metric")
    return Intersection(parts)


def vertices(tensors: Any, vertex_ids: Any = None) -> Vertices:
    """Tensors at vertices of the session's own mesh, log-Euclidean in between.

    Args:
        tensors: (k, 3) m11, m12, m22 in 1 / (domain unit)^2.
        vertex_ids: (k,) slots (entries of `session.mesh.vertex_ids`), in any order, none twice;
            the other vertices keep their metric. Default: all vertices, in the order of
            `session.mesh.points`. See `intersection` for tensors together with formulas.
    """
    return Vertices(tensors, vertex_ids)


class Solution(Metric):
    """From a nodal field of the current revision; see `solution`."""

    def __init__(self, field, target, norm_exponent):
        self._field = field
        self._target = target
        self._norm_exponent = norm_exponent

    def to_wire(self, sender, revision):
        del revision
        if isinstance(self._field, str):
            field = mesh_pb2.FieldValues(name=self._field)
        else:
            field = field_values("solution", self._field, None, "vertex", sender)
        return metric_pb2.MetricSource(solution=metric_pb2.SolutionMetric(
            field=field, norm_exponent=self._norm_exponent, **self._target))


def solution(field: Any, *, complexity: Optional[float] = None, error: Optional[float] = None,
             norm_exponent: Optional[float] = None) -> Solution:
    """The metric that makes the interpolation error of a solution least, made on the server.

    A field knows only what the mesh resolves: update the metric, compute the solution on the new
    mesh, and repeat; about five rounds suffice. The target is that of the solution's metric alone,
    also where `intersection` makes it finer.

    Args:
        field: (n,) values at `session.mesh.points`, or (n, c) of which each column counts; or the
            name of a field of the session at its vertices.
        complexity: wanted integral of sqrt(det M); the mesh gets about 2 / sqrt(3) times as many
            vertices.
        error: instead, the wanted mean interpolation error in the field's unit.
        norm_exponent: p of the Lp norm of the error, >= 1. Default: 2.
    """
    if (complexity is None) == (error is None):
        raise InvalidInput("EMPTY", "give either complexity or error", field="metric.solution")
    target = {"error": error} if complexity is None else {"complexity": complexity}
    return Solution(field, target, norm_exponent)


def as_metric(value: Any, vertex_ids: Any = None) -> Metric:
    """`value` as a metric: it is one, or tensors at vertices."""
    if isinstance(value, Metric):
        if vertex_ids is not None:
            raise InvalidInput("ARRAY_TYPE", "vertex_ids go with tensors, not with a metric that "
                               "covers the domain", field="metric")
        return value
    if isinstance(value, str):
        raise InvalidInput("ARRAY_TYPE", "metric is a text; write pliant.metric.expression(...) or "
                           "pliant.metric.size(...)", field="metric")
    return Vertices(value, vertex_ids)
