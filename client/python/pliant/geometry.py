"""Domains and meshes that a session can start from."""

from typing import Any, Optional

import numpy as np

from pliant.arrays import as_floats, as_integers, check_rows
from pliant.errors import InvalidInput
from pliant.v1 import mesh_pb2


class Domain:
    """A polygonal domain: points, and segments that bound it or must be edges of every mesh.

    What can be reached from far away, or from a hole, without crossing a segment is outside.
    Segments with the domain on both sides are internal constraints. Loops may touch and share
    points; a point on no segment becomes a fixed vertex.

    Args:
        points: (n, 2) coordinates x, y in domain units, n >= 3.
        segments: (m, 2) rows of `points`, m >= 3.
        tags: (m,) int32, any values; every mesh edge on a segment carries its tag. Default 0.
        holes: (h, 2) one point inside each hole.
        regions: (r, 3) rows of x, y, tag: triangles of the region around (x, y) carry the tag.
            Regions without a point carry 0.

    Shapes and types are checked here, geometry by the server when the session is created:
    CROSSING_SEGMENTS, OPEN_LOOP, POINT_ON_SEGMENT and so on, with indices.

    Raises:
        InvalidInput: an argument has a wrong shape or holds what the type cannot represent.

    >>> square = Domain([[0, 0], [1, 0], [1, 1], [0, 1]], [[0, 1], [1, 2], [2, 3], [3, 0]])
    >>> square.points.dtype, square.segments.shape
    (dtype('float64'), (4, 2))
    """

    def __init__(self, points: Any, segments: Any, tags: Any = None, holes: Any = None,
                 regions: Any = None):
        self.points: np.ndarray = as_floats("domain.points", points, 2)
        self.segments: np.ndarray = as_integers("domain.segments", segments, 2)
        self.tags: Optional[np.ndarray] = None
        if tags is not None:
            self.tags = as_integers("domain.segment_tags", tags)
            check_rows("domain.segment_tags", self.tags, len(self.segments), "segment")
        self.holes: Optional[np.ndarray] = (
            None if holes is None else as_floats("domain.holes", holes, 2))
        self.region_points: Optional[np.ndarray] = None
        self.region_tags: Optional[np.ndarray] = None
        if regions is not None:
            rows = as_floats("domain.region_points", regions, 3)
            self.region_points = np.ascontiguousarray(rows[:, :2])
            self.region_tags = as_integers("domain.region_tags", rows[:, 2])

    def to_wire(self, sender):
        """The message, its arrays made by `sender`."""
        return mesh_pb2.Domain(
            points=sender.array(self.points), segments=sender.array(self.segments),
            segment_tags=sender.array(self.tags), holes=sender.array(self.holes),
            region_points=sender.array(self.region_points),
            region_tags=sender.array(self.region_tags))


class Mesh:
    """An existing triangulation.

    Args:
        points: (n, 2) coordinates x, y in domain units.
        triangles: (m, 3) rows of `points`, counter-clockwise.
        edges: (e, 2) rows of `points`: constrained edges. Boundary edges that are not listed become
            constrained with tag 0.
        edge_tags: (e,) int32, any values. Default 0.
        triangle_tags: (m,) int32, any values: regions. Default 0.

    Shapes and types are checked here; orientation, conformity and manifold edges by the server:
    TRIANGLE_ORIENTATION, NOT_CONFORMING and so on, with indices.

    Raises:
        InvalidInput: an argument has a wrong shape or holds what the type cannot represent.
    """

    def __init__(self, points: Any, triangles: Any, edges: Any = None, edge_tags: Any = None,
                 triangle_tags: Any = None):
        self.points: np.ndarray = as_floats("mesh.points", points, 2)
        self.triangles: np.ndarray = as_integers("mesh.triangles", triangles, 3)
        self.edges: Optional[np.ndarray] = (
            None if edges is None else as_integers("mesh.edges", edges, 2))
        self.edge_tags: Optional[np.ndarray] = None
        if edge_tags is not None:
            if self.edges is None:
                raise InvalidInput("ARRAY_LENGTH", "mesh.edge_tags without mesh.edges",
                                   field="mesh.edge_tags")
            self.edge_tags = as_integers("mesh.edge_tags", edge_tags)
            check_rows("mesh.edge_tags", self.edge_tags, len(self.edges), "edge")
        self.triangle_tags: Optional[np.ndarray] = None
        if triangle_tags is not None:
            self.triangle_tags = as_integers("mesh.triangle_tags", triangle_tags)
            check_rows("mesh.triangle_tags", self.triangle_tags, len(self.triangles), "triangle")

    def to_wire(self, sender):
        """The message, its arrays made by `sender`."""
        return mesh_pb2.MeshInput(
            points=sender.array(self.points), triangles=sender.array(self.triangles),
            triangle_tags=sender.array(self.triangle_tags), edges=sender.array(self.edges),
            edge_tags=sender.array(self.edge_tags))


def as_mesh(mesh: Any) -> Mesh:
    """`mesh` as a Mesh: it is one, or has its attributes, as `Session.mesh` does."""
    if isinstance(mesh, Mesh):
        return mesh
    if not hasattr(mesh, "points") or not hasattr(mesh, "triangles"):
        raise InvalidInput("ARRAY_TYPE", f"mesh must be a pliant.Mesh or the mesh of a session; "
                           f"got {type(mesh).__name__}", field="mesh")
    return Mesh(mesh.points, mesh.triangles, mesh.edges, mesh.edge_tags, mesh.triangle_tags)
