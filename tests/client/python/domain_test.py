"""Another domain, and displacements, against the real pliantd."""

import numpy as np
import pytest

import pliant

pytestmark = pytest.mark.server
CORNERS = [[0, 0], [1, 0], [1, 1], [0, 1]]
LOOP = [[0, 1], [1, 2], [2, 3], [3, 0]]
SQUARE = pliant.Domain(CORNERS, LOOP)
HOLE = [[0.4, 0.4], [0.6, 0.4], [0.6, 0.6], [0.4, 0.6]]
HOLED = pliant.Domain(CORNERS + HOLE, LOOP + [[4, 5], [5, 6], [6, 7], [7, 4]],
                      holes=[[0.5, 0.5]])


def area(mesh):
    a, b, c = (mesh.points[mesh.triangles[:, i]] for i in range(3))
    return (((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]) / 2).sum()


@pytest.fixture
def session(client):
    with client.create_session(domain=SQUARE, metric=pliant.metric.size("0.04")) as session:
        yield session


def test_a_hole_opens_and_closes_and_the_rest_stays(session):
    before = dict(zip(session.mesh.vertex_ids.tolist(), session.mesh.points.tolist()))
    diff = session.replace_domain(HOLED)
    assert abs(area(session.mesh) - 0.96) < 1e-12
    assert 0 < len(diff.vertex_ids) < len(before) / 2
    after = dict(zip(session.mesh.vertex_ids.tolist(), session.mesh.points.tolist()))
    kept = [after.get(i) == p for i, p in before.items()
            if max(abs(p[0] - 0.5), abs(p[1] - 0.5)) > 0.3]
    assert kept and all(kept)
    for point in HOLE:
        assert point in session.mesh.points.tolist()
    session.replace_domain(SQUARE)
    assert abs(area(session.mesh) - 1) < 1e-12
    assert session.replace_domain(SQUARE).empty


def test_a_bad_domain_is_refused_as_at_creation(session, client):
    revision = session.revision
    bad = pliant.Domain(CORNERS, LOOP + [[0, 2], [1, 3]])
    with pytest.raises(pliant.InvalidInput) as refused:
        session.replace_domain(bad)
    with pytest.raises(pliant.InvalidInput) as at_creation:
        client.create_session(domain=bad, metric=pliant.metric.size("0.1"))
    assert refused.value.code == at_creation.value.code == "CROSSING_SEGMENTS"
    assert refused.value.index == at_creation.value.index
    assert session.revision == revision
    with pytest.raises(pliant.InvalidInput):
        session.replace_domain(CORNERS)
    session.set_field("mass", session.mesh.points[:, 0], transfer="conservative")
    with pytest.raises(pliant.Unimplemented):
        session.replace_domain(HOLED)


def front(points, x):
    """Fine across a line at x, by a tenth of what is wanted along it."""
    near = np.exp(-((points[:, 0] - x) / 0.05) ** 2)
    across = 1 / (0.05 - 0.04 * near) ** 2
    return np.stack([across, np.zeros(len(points)), np.full(len(points), 400.0)], 1)


def test_tensors_come_with_a_displacement(session):
    for _ in range(3):
        session.update_metric(front(session.mesh.points, 0.4))
    mesh = session.mesh
    near = np.abs(mesh.points[:, 0] - 0.4) < 0.1
    places = mesh.points + np.outer(near, [0.05, 0])
    vectors = np.tile([0.05, 0], (near.sum(), 1))
    together = session.update_metric(front(places, 0.45),
                                     displacement=(mesh.vertex_ids[near], vectors))
    assert together.converged
    count_near = lambda points, x: (np.abs(points[:, 0] - x) < 0.01).sum()
    assert count_near(session.mesh.points, 0.45) > 2 * count_near(session.mesh.points, 0.4)
    with pytest.raises(pliant.InvalidInput) as refused:
        session.update_metric(-front(session.mesh.points, 0.45), displacement=(
            session.mesh.vertex_ids[:1], [[0.01, 0]]))
    assert (refused.value.code, refused.value.index) == ("NOT_POSITIVE_DEFINITE", 0)
    session.set_field("u", session.mesh.points[:, 0])
    with pytest.raises(pliant.Unimplemented):
        session.update_metric(pliant.metric.solution("u", complexity=500), displacement=(
            session.mesh.vertex_ids[:1], [[0.01, 0]]))


def test_a_displacement_carries_a_front(session):
    for _ in range(3):
        session.update_metric(front(session.mesh.points, 0.4))
    mesh = session.mesh
    near = np.abs(mesh.points[:, 0] - 0.4) < 0.1
    ids, vectors = mesh.vertex_ids[near], np.tile([0.05, 0], (near.sum(), 1))
    moved = session.update_metric(displacement=(ids, vectors),
                                  advance=pliant.Advance(visits_max=1))
    assert len(moved.vertex_ids) > near.sum() / 2
    count_near = lambda points, x: (np.abs(points[:, 0] - x) < 0.01).sum()
    assert count_near(mesh.points, 0.4) > 2 * count_near(mesh.points, 0.45)
    assert count_near(session.mesh.points, 0.45) > 2 * count_near(session.mesh.points, 0.4)
    session.update_metric(front(session.mesh.points, 0.45))
    with pytest.raises(pliant.InvalidInput) as refused:
        session.update_metric(displacement=([0, 0], [[0, 0], [0, 0]]))
    assert refused.value.code == "DUPLICATE_ID"
