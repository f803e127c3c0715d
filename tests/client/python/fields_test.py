"""Fields and transfer rows against the real pliantd."""

import numpy as np
import pytest

import pliant

pytestmark = pytest.mark.server
SQUARE = pliant.Domain([[0, 0], [1, 0], [1, 1], [0, 1]], [[0, 1], [1, 2], [2, 3], [3, 0]])


@pytest.fixture
def session(client):
    with client.create_session(domain=SQUARE, metric=pliant.metric.size("0.1"),
                               with_transfer=True) as session:
        yield session


def integral(mesh, values):
    a, b, c = (mesh.points[mesh.triangles[:, i]] for i in range(3))
    areas = ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]) / 2
    return (areas * (values if len(values) == len(areas) else
                     values[mesh.triangles].mean(axis=1))).sum()


def refine(session, step):
    return session.update_metric(pliant.metric.size(f"0.05 + 0.1*abs(x - {0.2 * step})"))


def test_rows_carry_a_clients_values_as_the_server_carries_its_own(session):
    # Goal: the same bits on both ends, for scalars and vectors.
    values = np.stack([np.sin(5 * session.mesh.points[:, 0]), session.mesh.points[:, 1] ** 2], 1)
    assert session.set_field("v", values).empty
    for step in range(3):
        before = session.mesh
        diff = refine(session, step)
        assert diff.transfer.vertex_ids.tolist() == diff.vertex_ids.tolist()
        assert (diff.transfer.weights.sum(axis=1) == 1).all()
        values = diff.transfer.carry(values, before, session.mesh)
        assert (session.field("v") == values).all()


def test_linear_functions_constants_and_integrals_are_kept(session):
    points = session.mesh.points
    session.set_field("plane", points @ [2, -3])
    session.set_field("one", np.full(len(points), 0.1), transfer="bounded")
    session.set_field("mass", (points[:, 0] > 0.5) * 1.0, transfer="conservative")
    centers = session.mesh.points[session.mesh.triangles].mean(axis=1)
    session.set_field("cells", centers[:, 0] ** 2, location="triangle", transfer="conservative")
    mass = [integral(session.mesh, session.field(name)) for name in ("mass", "cells")]
    for step in range(3):
        assert refine(session, step).insertion_count > 0
        assert np.allclose(session.field("plane"), session.mesh.points @ [2, -3], atol=1e-12)
        assert (session.field("one") == 0.1).all()
        now = [integral(session.mesh, session.field(name)) for name in ("mass", "cells")]
        assert np.allclose(now, mass, rtol=1e-12)
    assert session.field_names == ["cells", "mass", "one", "plane"]
    assert session.drop_field("one").dropped_fields == ["one"]
    with pytest.raises(pliant.FailedPrecondition):
        session.field("one")


def test_a_new_client_gets_the_fields_with_the_snapshot(session, client):
    session.set_field("u", session.mesh.points[:, 0])
    refine(session, 1)
    expected = session.field("u")
    session.close()
    other = client.open_session(session.session_id)
    assert (other.field("u") == expected).all()
    other.close()


def test_some_values_can_be_changed(session):
    session.set_field("u", np.zeros(len(session.mesh.points)))
    ids = session.mesh.vertex_ids[[2, 5]]
    diff = session.set_field("u", [1.5, 2.5], ids=ids)
    assert diff.fields[0].ids.tolist() == ids.tolist()
    assert session.field("u")[[2, 5]].tolist() == [1.5, 2.5]
    assert session.field("u").sum() == 4


def test_mistakes_are_named(session):
    with pytest.raises(pliant.InvalidInput) as caught:
        session.set_field("u", [1.0, 2.0])
    assert (caught.value.code, caught.value.field) == ("ARRAY_LENGTH", "fields.u")
    values = np.zeros(len(session.mesh.points))
    with pytest.raises(pliant.InvalidInput) as caught:
        session.set_field("No name", values)
    assert (caught.value.code, caught.value.field) == ("OUT_OF_RANGE", "fields.name")
    values[3] = np.nan
    with pytest.raises(pliant.InvalidInput) as caught:
        session.set_field("u", values)
    assert (caught.value.code, caught.value.index) == ("NOT_FINITE", 3)
    with pytest.raises(pliant.InvalidInput):
        session.set_field("u", values, transfer="magic")


def test_the_mesh_follows_a_solution(session):
    # Goal: the cycle of a user, by values and by the name of a field; the wanted count comes out.
    def shock(mesh):
        return np.tanh(30 * (mesh.points[:, 0] - 0.5))

    def share_of_ideal(complexity):
        # As core/README.md counts it: the interior's share, and half of the boundary's vertices.
        boundary = len(session.mesh.edges)
        return len(session.mesh.points) / (2 / 3 ** 0.5 * complexity + boundary / 2 + 1)

    for _ in range(5):
        session.update_metric(pliant.metric.solution(shock(session.mesh), complexity=400))
    assert abs(share_of_ideal(400) - 1) < 0.1
    near = np.abs(session.mesh.points[:, 0] - 0.5) < 0.1
    assert near.mean() > 0.5, "half of the vertices stand where the solution bends"
    session.set_field("u", shock(session.mesh))
    session.update_metric(pliant.metric.solution("u", complexity=800))
    assert abs(share_of_ideal(800) - 1) < 0.1
    with pytest.raises(pliant.InvalidInput):
        session.update_metric(pliant.metric.solution("nothing", complexity=400))


@pytest.mark.parametrize("shape", [(5,), (2, 3)])
def test_a_field_of_another_shape_is_refused(client, shape):
    with client.create_session(domain=SQUARE, metric=pliant.metric.size(0.5)) as session:
        count = len(session.mesh.points)
        with pytest.raises(pliant.InvalidInput, match=r"expected \(n,\) for a scalar") as caught:
            session.set_field("u", np.zeros((count, *shape)))
        assert caught.value.field == "fields.u"
        assert session.revision == 1
