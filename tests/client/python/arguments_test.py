"""What the package accepts and refuses before anything is sent."""

import fractions
import pickle

import numpy as np
import pytest

import pliant
from pliant import arrays, options

TRIANGLE = [[0, 0], [1, 0], [0, 1]]
LOOP = [[0, 1], [1, 2], [2, 0]]


@pytest.mark.parametrize("points", [
    TRIANGLE, tuple(map(tuple, TRIANGLE)), np.array(TRIANGLE, np.int8),
    np.array(TRIANGLE, np.float32), np.array(TRIANGLE, ">f8"), np.array(TRIANGLE, np.longdouble),
    np.array(TRIANGLE, np.uint64), np.array(TRIANGLE, float, order="F"),
    np.array([[0, 9, 0], [1, 9, 0], [0, 9, 1]], float)[:, ::2]])
def test_points_of_any_lossless_type(points):
    domain = pliant.Domain(points, LOOP)
    assert domain.points.dtype == "<f8" and domain.points.flags.c_contiguous
    assert domain.points.tolist() == [[0, 0], [1, 0], [0, 1]]


@pytest.mark.parametrize("segments", [
    LOOP, np.array(LOOP, np.int64), np.array(LOOP, np.uint8), np.array(LOOP, float)])
def test_indices_of_any_lossless_type(segments):
    assert pliant.Domain(TRIANGLE, segments).segments.dtype == "<i4"


def test_nan_passes_so_that_the_server_names_it():
    assert np.isnan(pliant.Domain([[0, np.nan]], LOOP).points[0, 1])


def test_no_copy_of_what_already_fits():
    points = np.array(TRIANGLE, float)
    assert np.shares_memory(pliant.Domain(points, LOOP).points, points)


def test_empty_lists_are_arrays_without_rows():
    assert pliant.Domain(TRIANGLE, LOOP, holes=[]).holes.shape == (0, 2)
    assert pliant.Mesh(TRIANGLE, [[0, 1, 2]], [], []).edges.shape == (0, 2)


REFUSED = [
    (lambda: pliant.Domain([[0, 0, 0]], LOOP), "ARRAY_LENGTH", "domain.points", r"\(n, 2\).*1, 3"),
    (lambda: pliant.Domain([0, 0], LOOP), "ARRAY_LENGTH", "domain.points", r"\(n, 2\)"),
    (lambda: pliant.Domain([[0], [1, 2]], LOOP), "ARRAY_LENGTH", "domain.points", "regular"),
    (lambda: pliant.Domain([["a", "b"]], LOOP), "ARRAY_TYPE", "domain.points", "float64"),
    (lambda: pliant.Domain([[1j, 0]], LOOP), "ARRAY_TYPE", "domain.points", "complex"),
    (lambda: pliant.Domain(None, LOOP), "EMPTY", "domain.points", "required"),
    (lambda: pliant.Domain([[fractions.Fraction(1, 3), 0]], LOOP), "ARRAY_TYPE",
     "domain.points", "object"),
    (lambda: pliant.Domain(np.array([[0, 0], [2**53 + 1, 0]]), LOOP), "ARRAY_TYPE",
     "domain.points", "9007199254740993"),
    (lambda: pliant.Domain(TRIANGLE, [[0, 1.5]]), "ARRAY_TYPE", "domain.segments", "1.5"),
    (lambda: pliant.Domain(TRIANGLE, [[0, np.nan]]), "ARRAY_TYPE", "domain.segments", "nan"),
    (lambda: pliant.Domain(TRIANGLE, [[0, 2**31]]), "ARRAY_TYPE", "domain.segments", "2147483648"),
    (lambda: pliant.Domain(TRIANGLE, LOOP, tags=[1, 2]), "ARRAY_LENGTH", "domain.segment_tags",
     "2 rows; expected 3"),
    (lambda: pliant.Domain(TRIANGLE, LOOP, regions=[[0, 0, 0.5]]), "ARRAY_TYPE",
     "domain.region_tags", "0.5"),
    (lambda: pliant.Mesh(TRIANGLE, [[0, 1, 2]], edge_tags=[1]), "ARRAY_LENGTH", "mesh.edge_tags",
     "without"),
    (lambda: pliant.Mesh(TRIANGLE, [[0, 1, 2]], triangle_tags=[1, 2]), "ARRAY_LENGTH",
     "mesh.triangle_tags", "expected 1"),
    (lambda: pliant.metric.vertices(np.ones((3, 4))), "ARRAY_LENGTH", "metric.tensors",
     r"\(n, 3\)"),
    (lambda: pliant.metric.vertices(np.ones((3, 3)), [True, False, True]), "ARRAY_TYPE",
     "metric.vertex_ids", "flatnonzero"),
    (lambda: pliant.metric.vertices(np.ones((3, 3)), [1, 2]), "ARRAY_LENGTH",
     "metric.tensors", "vertex_ids"),
    (lambda: pliant.metric.background(pliant.Mesh(TRIANGLE, [[0, 1, 2]]), np.ones((2, 3))),
     "ARRAY_LENGTH", "metric.tensors", "expected 3"),
    (lambda: pliant.metric.expression("1; 0"), "EXPRESSION_SYNTAX", "metric.expression", "M11"),
    (lambda: pliant.metric.background([1], np.ones((1, 3))), "ARRAY_TYPE", "mesh", "list"),
    (lambda: options.split({"variant": "papr"})[1].to_wire(), "OUT_OF_RANGE", "options.variant",
     "must be one of .*cooled.*paper.*; got 'papr'"),
]


@pytest.mark.parametrize("make,code,field,message", REFUSED)
def test_refused_with_the_name_of_the_argument(make, code, field, message):
    with pytest.raises(pliant.InvalidInput, match=message) as caught:
        make()
    assert (caught.value.code, caught.value.field) == (code, field)
    assert isinstance(caught.value, ValueError)


def test_first_lost_row_is_named():
    with pytest.raises(pliant.InvalidInput) as caught:
        arrays.as_integers("ids", [0, 1, 2.5, 3.5])
    assert caught.value.index == 2


def test_options_have_the_names_that_users_know():
    limits, others = options.split({"hmin": 1, "h_max": 2, "hgrad": 1.3, "seed": 3})
    assert (limits.h_min, limits.h_max, limits.hgrad, others.seed) == (1, 2, 1.3, 3)
    with pytest.raises(TypeError, match="h_min.*twice"):
        options.split({"hmin": 1, "h_min": 2})
    with pytest.raises(TypeError, match="unknown option 'hmn'; the options are .*hmin"):
        options.split({"hmn": 1})
    with pytest.raises(TypeError, match="later"):
        options.make_limits({"seed": 1})
    assert options.Limits().to_wire() is None


def test_errors_survive_pickling():
    error = pliant.InvalidInput("NOT_FINITE", "bad", field="domain.points", index=3)
    copy = pickle.loads(pickle.dumps(error))
    assert type(copy) is pliant.InvalidInput and vars(copy) == vars(error)
    assert str(copy) == "NOT_FINITE: domain.points[3]: bad"
