"""What is frozen stays, and options that change, against the real pliantd."""

import numpy as np
import pytest

import pliant
from resume_test import DOMAIN

pytestmark = pytest.mark.server


@pytest.fixture
def session(client):
    with client.create_session(domain=DOMAIN, metric=pliant.metric.size("0.15")) as session:
        yield session


def test_frozen_vertices_and_edges_keep_their_bits(session):
    mesh = session.mesh
    vertices = mesh.vertex_ids[np.abs(mesh.points - 0.5).max(axis=1) < 0.3]
    edges = mesh.edge_ids[::3]
    ends = mesh.vertex_ids[mesh.edges[::3]]
    assert session.freeze(vertices, edges, no_swap=True).empty
    diff = session.update_metric(pliant.metric.size("0.05"))
    assert diff.swap_count == 0
    now = session.mesh
    assert (now.points[now.rows_of(vertices)] == mesh.points[mesh.rows_of(vertices)]).all()
    kept = {edge: tuple(end) for edge, end in zip(now.edge_ids, now.vertex_ids[now.edges])}
    assert [kept[edge] for edge in edges] == [tuple(end) for end in ends]
    assert {trouble.kind for trouble in diff.troubles} == {"FROZEN"}
    assert min(trouble.q_min for trouble in diff.troubles) < 0.4
    diff = session.thaw()
    assert diff.swap_count > 0
    assert not any(trouble.kind == "FROZEN" for trouble in diff.troubles)


def test_no_surf_and_regions(session):
    count = len(session.mesh.edges)
    session.freeze(no_surf=True)
    session.update_metric(pliant.metric.size("0.05"))
    assert len(session.mesh.edges) == count
    before = session.mesh
    session.freeze(regions=[0])
    assert session.update_metric(pliant.metric.size("0.1")).vertex_ids.size == 0
    assert session.mesh.points.tobytes() == before.points.tobytes()


def test_modes_bind_the_loop_and_not_what_a_client_moves(session):
    session.freeze(no_insert=True, no_swap=True, no_move=True, no_surf=True)
    positions = session.mesh.points * [1.25, 0.9] + [3, 4]
    diff = session.move_nodes(positions)
    assert session.mesh.points.tobytes() == positions.tobytes()
    assert (diff.insertion_count, diff.deletion_count, diff.swap_count, diff.move_count) == (0,) * 4
    frozen = session.mesh.vertex_ids[7:8]
    session.freeze(frozen)
    with pytest.raises(pliant.FailedPrecondition) as caught:
        session.move_nodes(session.mesh.points + 1)
    refused = caught.value
    assert (refused.code, refused.field, refused.index) == ("FROZEN", "vertices", frozen[0])


def test_mistakes_are_named(session):
    with pytest.raises(pliant.InvalidInput) as caught:
        session.freeze([0, 1, 100_000])
    assert (caught.value.code, caught.value.index) == ("INDEX_OUT_OF_RANGE", 2)
    assert caught.value.field == "constraints.frozen_vertices"
    with pytest.raises(pliant.InvalidInput) as caught:
        session.freeze(regions=[44])
    assert caught.value.field == "constraints.frozen_regions"
    with pytest.raises(pliant.FailedPrecondition) as caught:
        session.set_options(seed=3)
    assert caught.value.field == "options.seed"
    tags = dict.fromkeys(session.mesh.edge_tags.tolist(), pliant.motion.Translation(0.01, 0))
    session.freeze(edge_ids=session.mesh.edge_ids)
    with pytest.raises(pliant.FailedPrecondition) as caught:
        session.move_boundary(tags)
    assert caught.value.code == "FROZEN"


def test_options_change(session):
    session.set_options(metric_tolerance=0.9, h_min=0.01)
    assert session.update_metric(pliant.metric.size("0.14")).empty
    session.set_options(metric_tolerance=0)
    assert not session.update_metric(pliant.metric.size("0.139")).empty
