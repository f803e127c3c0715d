"""Following a session of the real pliantd."""

import threading

import numpy as np
import pytest

import pliant
from pliant import backoff
from resume_test import DOMAIN, Proxy

pytestmark = pytest.mark.server


@pytest.fixture
def session(client):
    with client.create_session(domain=DOMAIN, metric=pliant.metric.size(0.1),
                               with_metric=True) as made:
        yield made


def check_same(mesh, other):
    assert (mesh.revision, mesh.state_hash) == (other.revision, other.state_hash)
    assert mesh.points.tobytes() == other.points.tobytes()
    assert mesh.triangles.tobytes() == other.triangles.tobytes()
    assert np.array_equal(mesh.metrics, other.metrics)


def test_it_follows_every_revision(client, session):
    with client.subscribe(session.session_id, with_metric=True) as follower:
        first = next(follower)
        assert (first.base_revision, first.revision) == (0, 1)
        check_same(follower.mesh, session.mesh)
        assert np.isfinite(follower.mesh.metrics).all()
        assert follower.next(timeout_s=0.05) is None
        for size in (0.08, 0.05, 0.07):
            session.update_metric(pliant.metric.size(size))
            change = next(follower)
            assert (change.base_revision, change.revision) == (session.revision - 1,
                                                               session.revision)
            check_same(follower.mesh, session.mesh)
            assert np.allclose(follower.mesh.metrics[:, 0], 1 / size**2)
    assert list(follower) == []


def test_it_follows_parts_of_the_mesh(client):
    # Two squares, regions 1 and 2; what each follower has is compared with a filter of the whole.
    domain = pliant.Domain([[0, 0], [1, 0], [2, 0], [2, 1], [1, 1], [0, 1]],
                           [[0, 1], [1, 2], [2, 3], [3, 4], [4, 5], [5, 0], [1, 4]],
                           regions=[[0.5, 0.5, 1], [1.5, 0.5, 2]])
    with client.create_session(domain=domain, metric=pliant.metric.size(0.2)) as session, \
            client.subscribe(session.session_id, region_tags=[2]) as right, \
            client.subscribe(session.session_id, only_vertices=True) as points:
        for size in ("0.1", "0.05 + 0.1*abs(x - 1.1)", "0.3"):
            session.update_metric(pliant.metric.size(size))
            for follower in (right, points):
                while follower.revision < session.revision:
                    next(follower)
            mesh = session.mesh
            wanted = mesh.triangle_tags == 2
            corners = mesh.vertex_ids[mesh.triangles[wanted]]
            assert np.array_equal(right.mesh.triangle_ids, mesh.triangle_ids[wanted])
            assert np.array_equal(right.mesh.vertex_ids[right.mesh.triangles], corners)
            assert np.array_equal(right.mesh.vertex_ids, np.unique(corners))
            both = np.isin(mesh.vertex_ids[mesh.edges], corners).all(axis=1)
            assert both.any() and not both.all()
            assert np.array_equal(right.mesh.edge_ids, mesh.edge_ids[both])
            assert points.mesh.points.tobytes() == mesh.points.tobytes()
            assert len(points.mesh.triangles) == len(points.mesh.edges) == 0


def test_it_tells_which_regions_are_not_there(client):
    square = dict(points=[[0, 0], [1, 0], [1, 1], [0, 1]],
                  segments=[[0, 1], [1, 2], [2, 3], [3, 0]])
    tagged = [pliant.Domain(**square, regions=[[0.5, 0.5, tag]]) for tag in (1, 7)]
    with client.create_session(domain=tagged[0], metric=pliant.metric.size(0.3)) as session, \
            client.subscribe(session.session_id, region_tags=[9, 7, 1, 7]) as some, \
            client.subscribe(session.session_id, region_tags=[7]) as later:
        assert later.absent_region_tags == ()
        next(some), next(later)
        assert (some.absent_region_tags, later.absent_region_tags) == ((7, 9), (7,))
        assert len(later.mesh.triangles) == 0
        session.replace_domain(tagged[1])
        next(some), next(later)
        assert (some.absent_region_tags, later.absent_region_tags) == ((1, 9), ())
        assert later.mesh.state_hash == session.mesh.state_hash


def test_one_who_comes_late_gets_everything_at_once(client, session):
    with client.subscribe(session.session_id) as follower:
        next(follower)
        for _ in range(30):
            session.advance()
        while follower.revision < session.revision:
            next(follower)
        assert follower.mesh.state_hash == session.mesh.state_hash
        assert np.isnan(follower.mesh.metrics).all()


def test_a_lost_connection_is_taken_up_again(client, session, tmp_path):
    proxy = Proxy(str(tmp_path / "proxy"), client.address.removeprefix("unix:"))
    with pliant.connect(proxy.address) as far, far.subscribe(
            session.session_id, with_metric=True) as follower:
        next(follower)
        for byte_count in (1, 3000, 20_000):
            proxy.cut_after("down", byte_count)
            session.update_metric(pliant.metric.size(0.03 if byte_count == 3000 else 0.04))
            while follower.revision < session.revision:
                next(follower)
            check_same(follower.mesh, session.mesh)
        assert proxy.cut_count == 3


def test_it_ends_with_the_session_and_when_it_is_closed(client, session):
    follower = client.subscribe(session.session_id)
    next(follower)
    session.delete()
    with pytest.raises(pliant.NotFound):
        next(follower)
    with pytest.raises(pliant.NotFound):
        next(client.subscribe("nobody"))


def test_pauses_grow_and_are_spread():
    made = [pause for pause, _ in zip(backoff.pauses(), range(12))]
    assert 0.01 <= made[0] <= 0.02
    assert all(1 <= pause <= 2 for pause in made[8:])
    assert len(set(made)) == len(made)


def test_progress_is_told(client):
    seen = []
    with client.create_session(domain=DOMAIN, metric=pliant.metric.size(0.1)) as session:
        session.stage_metric(pliant.metric.size(0.005))
        diff = session.advance(on_progress=seen.append)
        assert seen and all(0 < one.visit_count < diff.visit_count for one in seen)
        assert seen[-1].active_count > 0 and seen[-1].elapsed_ms >= 100


def test_unfinished_revisions_are_told(client):
    seen = []
    with client.create_session(domain=DOMAIN, metric=pliant.metric.size(0.1)) as session:
        def see(change):
            assert session.revision == session.mesh.revision == change.revision
            seen.append((change.base_revision, change.revision))

        session.stage_metric(pliant.metric.size(0.005))
        diff = session.advance(commit_interval_ms=50, on_change=see)
        assert len(seen) > 1
        assert seen == [(revision, revision + 1) for revision in range(1, session.revision)]
        assert (diff.base_revision, diff.revision, diff.stop_reason) == (*seen[-1], "CONVERGED")
        assert session.mesh.state_hash == session.download().state_hash


def test_a_subscriber_in_a_thread_of_its_own(client, session):
    seen = []
    with client.subscribe(session.session_id) as follower:
        def follow():
            for change in follower:
                seen.append(change.revision)

        thread = threading.Thread(target=follow)
        thread.start()
        for _ in range(5):
            session.advance()
        while not seen or seen[-1] < session.revision:
            pass
        follower.close()
        thread.join(10)
        assert not thread.is_alive() and seen == sorted(seen)
