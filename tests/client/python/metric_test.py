"""Goal: metrics of every kind and their limits, against a real server."""

import math

import numpy as np
import pytest

import pliant
from server_test import SQUARE, check_mesh, isotropic, square

pytestmark = pytest.mark.server


def test_time_and_limits(client):
    with client.create_session(domain=square(), metric=pliant.metric.size("0.05 + 0.1*t"),
                               h_max=0.1) as one:
        fine = len(one.mesh.points)
        one.update_metric(time=1.0)
        coarse = len(one.mesh.points)
        one.update_metric(hmax=0.2)
        assert fine > 2 * coarse > 2 * len(one.mesh.points)
        one.update_metric(pliant.metric.size("x < 0.5 ? 0.02 : 0.2"), automatic=False)
        jump = len(one.mesh.points)
        one.update_metric(hgrad=1.2)
        assert len(one.mesh.points) > 1.1 * jump


def test_limits_change_with_tensors_and_after_them(client):
    with client.create_session(domain=square(), metric=pliant.metric.size("0.1"),
                               automatic=False) as one:
        sizes = np.where(one.mesh.points[:, 0] < 0.5, 0.01, 0.2)
        diff = one.update_metric(isotropic(sizes), hgrad=1.5)
        assert diff.limits["GRADATION"].vertex_count > 0
        graded = len(one.mesh.points)
        assert one.quality().q_min > 0.5
        diff = one.update_metric(hgrad=0, automatic=False)
        assert diff.limits == {} and len(one.mesh.points) < graded
        one.update_metric(h_min=0.05)
        assert len(one.mesh.points) < graded / 4
        with pytest.raises(pliant.InvalidInput) as error:
            one.update_metric(hgrad=0.5)
        assert error.value.field == "metric.limits.gradation"


def test_the_first_mesh_tells_where_its_metric_is_not_met(client):
    jump = pliant.metric.size("x < 0.5 ? 0.01 : 0.2")
    with client.create_session(domain=square(), metric=jump, automatic=False) as one:
        first = one.last_diff
        assert first.stop_reason == "CONVERGED" and first.revision == 1
        assert first.troubles and first.troubles[0].kind == "SIZE_JUMP"
        assert first.insertion_count > 0
        assert one.last_diff is first
        cured = one.update_metric(hgrad=1.5)
        assert one.last_diff is cured and not cured.troubles
        one.close()
        with client.open_session(one.session_id) as other:
            assert other.last_diff is None


def test_limits_report_what_they_did(client):
    jump = pliant.metric.size("x < 0.5 ? 0.02 : 0.2")
    with client.create_session(domain=square(), metric=jump, automatic=False) as one:
        assert one.update_metric(pliant.metric.size("x < 0.5 ? 0.02 : 0.18")).limits == {}
        assert one.quality("raw").complexity == one.quality().complexity
        limits = one.update_metric(hgrad=1.3).limits
        report = limits["GRADATION"]
        assert report.vertex_count > 10 and report.ratio_max > 2
        assert report.worst_vertex_id in one.mesh.vertex_ids
        # Integrals of 1 / h^2; right of the jump sizes grow by ln(1.3) of the distance from it.
        fine = 0.5 / 0.02**2
        growth = math.log(1.3)
        graded = (1 / 0.02 - 1 / (0.02 + 0.5 * growth)) / growth
        assert report.complexity_before == pytest.approx(fine + 0.5 / 0.18**2, rel=0.02)
        assert report.complexity_after == pytest.approx(fine + graded, rel=0.02)
        raw, limited = one.quality("raw"), one.quality()
        assert (raw.basis, limited.basis) == ("raw", "limited")
        assert raw.complexity < 0.95 * limited.complexity
        assert one.update_metric(hgrad=0).limits == {}
        with pytest.raises(ValueError, match="'raw'"):
            one.quality("both")


def test_geometry_limits_the_size_at_short_segments(client):
    points = [[0, 0], [1, 0], [1, 0.02], [1, 1], [0, 1]]
    domain = pliant.Domain(points, [[i, (i + 1) % 5] for i in range(5)], tags=[1] * 5)
    with client.create_session(domain=domain, metric=pliant.metric.size(0.2),
                               hgrad=1.5, geometry=1) as one:
        def count_near():
            return int((np.hypot(*(one.mesh.points - [1, 0.01]).T) < 0.1).sum())
        near = count_near()
        diff = one.update_metric(hgrad=1.4)
        assert diff.limits["GEOMETRY"].vertex_count == 2
        one.update_metric(geometry=0)
        assert near >= 2 * count_near()


def test_limits_come_into_force_where_no_mesh_follows_the_metric(client):
    jump = pliant.metric.size("x < 0.5 ? 0.01 : 0.2")
    with client.create_session(domain=square(), metric=jump) as one:
        assert one.quality().q_min > 0.7
        diff = one.update_metric(pliant.metric.size("x < 0.4 ? 0.01 : 0.2"))
        assert not diff.troubles
        assert diff.limits["GRADATION"].vertex_count > 0
        diff = one.update_metric(hgrad=0)
        assert diff.troubles
        assert diff.limits == {}
    with client.create_session(domain=square(), metric=jump, automatic=False) as one:
        assert one.quality().q_min < 0.4


def test_smoothing_takes_noise_out_of_tensors(client):
    errors = {}
    for smoothing in (0, 2):
        with client.create_session(domain=square(), metric=pliant.metric.size(0.05),
                                   tensor_smoothing=smoothing) as one:
            noise = np.random.default_rng(1).uniform(-0.4, 0.4, len(one.mesh.points))
            diff = one.update_metric(isotropic(0.05 * np.exp(noise)))
            assert ("SMOOTHING" in diff.limits) == (smoothing > 0)
            errors[smoothing] = abs(np.log(one.quality().complexity * 0.05 ** 2))
            if smoothing:
                assert diff.limits["SMOOTHING"].vertex_count > 0.9 * len(noise)
                again = one.update_metric(pliant.metric.size(0.05), tensor_smoothing=0)
                assert again.limits == {}
    assert errors[2] < 0.6 * errors[0]
    with pytest.raises(pliant.InvalidInput, match="smoothing_count"):
        client.create_session(domain=square(), metric=pliant.metric.size(0.2), tensor_smoothing=9)


def test_limits_hold_for_tensors(client):
    with client.create_session(domain=square(), metric=pliant.metric.size(0.2),
                               h_min=0.1) as one:
        one.update_metric(isotropic(np.full(len(one.mesh.points), 0.01)))
        lengths = one.quality().averaged
        assert one.quality().complexity == pytest.approx(100) and 0.8 < lengths.mean < 1.3
        one.update_metric(h_min=0.05)
        assert one.quality().complexity == pytest.approx(100), "what bounds have cut off is lost"
        one.update_metric(isotropic(np.full(len(one.mesh.points), 0.01)))
        assert one.quality().complexity == pytest.approx(400)


def test_anisotropic_expression_and_background(client):
    with client.create_session(domain=square(), seed=3, metric=pliant.metric.expression(
            "1/0.02^2; 0; 1/0.2^2")) as one:
        edges = one.mesh.points[one.mesh.triangles] - one.mesh.points[
            np.roll(one.mesh.triangles, 1, axis=1)]
        across, along = np.abs(edges).reshape(-1, 2).mean(axis=0)
        assert 4 < along / across < 20
        tensors = np.tile([1 / 0.02**2, 0, 1 / 0.2**2], (4, 1))
        coarse = pliant.Mesh(SQUARE, [[0, 1, 2], [0, 2, 3]])
        with client.create_session(domain=square(), seed=3,
                                   metric=pliant.metric.background(coarse, tensors)) as other:
            check_mesh(other.mesh, 1)
            assert len(other.mesh.points) == pytest.approx(len(one.mesh.points), rel=0.1)


def test_intersection_of_a_size_a_grid_and_formulas(client):
    # Goal: the finest of all holds. The minimum of sizes written out as a formula gives the same
    # mesh; with a grid, whose sizes are right up to rounding only, about as many vertices.
    x, y = np.meshgrid(np.linspace(0, 1, 5), np.linspace(0, 1, 3))
    tensors = np.stack([1 / 0.05**2 + 0 * x, 0 * x, 1 / 0.05**2 + 0 * y], axis=-1)
    parts = [pliant.metric.size("0.03 + 0.1*x"), pliant.metric.grid([0, 0], [0.25, 0.5], tensors),
             pliant.metric.expression("1; 0; 1")]
    with client.create_session(domain=square(), metric=pliant.metric.intersection(*parts)) as one, \
            client.create_session(domain=square(),
                                  metric=pliant.metric.size("min(0.05, 0.03 + 0.1*x)")) as other:
        check_mesh(one.mesh, 1)
        assert len(one.mesh.points) == pytest.approx(len(other.mesh.points), rel=0.05)
        with client.create_session(domain=square(), metric=pliant.metric.intersection(
                parts[0], pliant.metric.size(0.05))) as formulas:
            assert (formulas.mesh.points == other.mesh.points).all()
        diff = one.update_metric(pliant.metric.intersection(parts[0], pliant.metric.size(0.02)))
        assert diff.insertion_count > 0
        assert len(one.mesh.points) > 1.5 * len(other.mesh.points)
        tensors = pliant.metric.vertices(np.tile([1.0, 0, 1], (len(one.mesh.points), 1)))
        with pytest.raises(pliant.Unimplemented) as refused:
            one.update_metric(pliant.metric.intersection(tensors, parts[0], tensors))
        assert refused.value.field == "metric.sources"


def finest(h, tensor):
    """Of sizes and one diagonal tensor."""
    h = np.asarray(h)
    return np.stack([np.maximum(1 / h**2, tensor[0]), 0 * h, np.maximum(1 / h**2, tensor[2])], -1)


def metric_error(session, h, tensor):
    """How far vertices are from the finest of a formula and a tensor, at most."""
    x, y = session.mesh.points.T
    wanted = finest(h(x, y), tensor)
    return (np.abs(session.mesh.metrics - wanted) / wanted.max(axis=1, keepdims=True)).max()


def test_tensors_and_a_formula_hold_together(client):
    # Goal: tensors of a solver and the formula of a layer, through updates of either. The tensors
    # are the same everywhere, so that they are known between vertices too.
    tensor, layer = [60.0, 0, 250.0], pliant.metric.size("0.015 + 0.3*abs(y - t)")

    def tensors(session):
        return pliant.metric.vertices(np.tile(tensor, (len(session.mesh.points), 1)))

    with client.create_session(domain=square(), metric=pliant.metric.size(0.1),
                               automatic=False, with_metric=True) as one:
        first = one.revision
        one.update_metric(pliant.metric.intersection(tensors(one), layer))
        check_mesh(one.mesh, 1)
        assert metric_error(one, lambda x, y: 0.015 + 0.3 * abs(y), tensor) < 0.06
        again = one.update_metric(pliant.metric.intersection(tensors(one), layer))
        assert again.empty
        layered = one.mesh.points.copy()

        one.update_metric(time=0.5)
        check_mesh(one.mesh, 1)
        assert metric_error(one, lambda x, y: 0.015 + 0.3 * abs(y - 0.5), tensor) < 0.06
        # Only the formula, then only some tensors, which the formula outlives.
        none = pliant.metric.vertices(np.zeros((0, 3)), np.zeros(0, dtype=int))
        one.update_metric(pliant.metric.intersection(none, pliant.metric.size("0.05 + x")))
        assert metric_error(one, lambda x, y: 0.05 + x, tensor) < 0.06
        count = len(one.mesh.points)
        one.update_metric(pliant.metric.vertices([[40000.0, 0, 40000.0]], one.mesh.vertex_ids[:1]))
        assert len(one.mesh.points) > count
        one.update_metric(tensors(one))
        assert metric_error(one, lambda x, y: 1 + 0 * x, tensor) < 0.06
        with pytest.raises(pliant.FailedPrecondition, match="time"):
            one.update_metric(time=1.0)

        one.rollback(first + 1)
        assert (one.mesh.points == layered).all()
        with client.open_session(one.fork(), with_metric=True) as other:
            for session in (one, other):
                session.update_metric(time=0.25)
            assert (one.mesh.points == other.mesh.points).all()
            assert metric_error(other, lambda x, y: 0.015 + 0.3 * abs(y - 0.25), tensor) < 0.06
        with pytest.raises(pliant.InvalidInput) as refused:
            one.update_metric(pliant.metric.intersection(
                tensors(one), pliant.metric.size("sqrt(x - 2)")))
        assert refused.value.code == "EXPRESSION_VALUE"


def test_a_solution_and_a_formula_hold_together(client):
    with client.create_session(domain=square(), metric=pliant.metric.size(0.08)) as one:
        values = np.tanh(20 * (one.mesh.points[:, 0] - 0.5))
        one.update_metric(pliant.metric.intersection(
            pliant.metric.solution(values, complexity=150),
            pliant.metric.size("y < 0.1 ? 0.02 : 1")))
        wall = one.mesh.points[:, 1] < 0.1
        assert wall.sum() > 200 and (~wall).sum() > 80


def test_a_session_begins_with_tensors_and_a_formula(client):
    coarse = pliant.Mesh(SQUARE, [[0, 1, 2], [0, 2, 3]])
    tensors = np.tile([25.0, 0, 100.0], (4, 1))
    with client.create_session(mesh=coarse, with_metric=True,
                               automatic=False, metric=pliant.metric.intersection(
            pliant.metric.size("0.03 + 0.3*x"), pliant.metric.vertices(tensors))) as one:
        assert metric_error(one, lambda x, y: 0.03 + 0.3 * x, tensors[0]) < 0.06
