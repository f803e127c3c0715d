"""The local copy of a mesh, against changes made by hand."""

import numpy as np
import pytest

from pliant import errors, replica


def change(base, revision, vertices=(), triangles=(), edges=(), removed=((), (), ()), counts=None,
           state_hash=0):
    """A Change; `vertices`, `triangles` and `edges` map slots to rows."""
    def ids(slots):
        return np.array(sorted(slots), "<i4")

    def rows(items, dtype, columns):
        return np.array([items[slot] for slot in sorted(items)], dtype).reshape(-1, columns)

    vertices, triangles, edges = dict(vertices), dict(triangles), dict(edges)
    return replica.Change(
        base_revision=base, revision=revision, removed_vertices=ids(removed[0]),
        removed_triangles=ids(removed[1]), removed_edges=ids(removed[2]),
        vertex_ids=ids(vertices), vertex_positions=rows(vertices, "<f8", 2),
        triangle_ids=ids(triangles), triangle_vertices=rows(triangles, "<i4", 3),
        triangle_tags=np.zeros(len(triangles), "<i4"), edge_ids=ids(edges),
        edge_vertices=rows(edges, "<i4", 2), edge_tags=np.zeros(len(edges), "<i4"),
        counts=counts, state_hash=state_hash, metric_vertex_ids=ids(()),
        metrics=np.zeros((0, 3)), fields=[], dropped_fields=[], transfer=None)


def summary(vertices, triangles, edges):
    """Counts and hash of a whole mesh, as a server would state them."""
    whole = change(0, 1, vertices, triangles, edges)
    with np.errstate(over="ignore"):
        total = np.uint64(0)
        for kind, ids, columns in (
                (1, whole.vertex_ids, [np.ascontiguousarray(c).view(np.uint64)
                                       for c in whole.vertex_positions.T]),
                (2, whole.triangle_ids, list(whole.triangle_vertices.T) + [whole.triangle_tags]),
                (3, whole.edge_ids, list(whole.edge_vertices.T) + [whole.edge_tags])):
            words = [c if c.dtype == np.uint64 else c.astype(np.uint64) for c in columns]
            total += replica.element_hash_sum(kind, ids, words)
    return {"counts": replica.Counts(len(vertices), len(triangles), len(edges)),
            "state_hash": int(total)}


POINTS = {0: (0, 0), 1: (1, 0), 2: (1, 1), 3: (0, 1)}
TRIANGLES = {0: (0, 1, 2), 1: (0, 2, 3)}
EDGES = {0: (0, 1), 1: (2, 3)}


def square():
    mirror = replica.Replica()
    mirror.apply(change(0, 1, POINTS, TRIANGLES, EDGES, **summary(POINTS, TRIANGLES, EDGES)))
    return mirror


def without(items, *slots):
    return {slot: row for slot, row in items.items() if slot not in slots}


@pytest.mark.parametrize("triangles, edges", [((1,), ()), ((), (1,))])
def test_a_server_that_lies_takes_no_vertex_from_under_an_element(triangles, edges):
    # Goal: counts and hash are those of the mesh without the vertex, but something still has it.
    left = (without(POINTS, 3), without(TRIANGLES, *triangles), without(EDGES, *edges))
    with pytest.raises(errors.ReplicaMismatch, match="still a corner"):
        square().apply(change(1, 2, removed=((3,), triangles, edges), **summary(*left)))


def test_a_vertex_goes_with_all_that_has_it():
    left = (without(POINTS, 3), without(TRIANGLES, 1), without(EDGES, 1))
    mirror = square()
    mirror.apply(change(1, 2, removed=((3,), (1,), (1,)), **summary(*left)))
    assert mirror.view().triangles.tolist() == [[0, 1, 2]]
    # And where an element gets other corners instead.
    mirror = square()
    turned = {1: (0, 1, 2)}
    left = (without(POINTS, 3), {**TRIANGLES, **turned}, without(EDGES, 1))
    mirror.apply(change(1, 2, triangles=turned, removed=((3,), (), (1,)), **summary(*left)))
    assert mirror.revision == 2


@pytest.mark.parametrize("corner", [-1, 3, 4, 1000])
def test_no_element_comes_with_a_corner_that_is_free(corner):
    left = (without(POINTS, 3), {0: TRIANGLES[0]}, {0: EDGES[0]})
    mirror = square()
    mirror.apply(change(1, 2, removed=((3,), (1,), (1,)), **summary(*left)))
    bad = {1: (0, 2, corner)}
    with pytest.raises(errors.ReplicaMismatch, match="corner that does not exist"):
        mirror.apply(change(2, 3, triangles=bad, **summary(left[0], {**left[1], **bad}, left[2])))
    assert mirror.revision == 0
