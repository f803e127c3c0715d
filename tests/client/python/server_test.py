"""The package against the real pliantd."""

import threading
import time

import numpy as np
import pytest

import pliant

pytestmark = pytest.mark.server
SEED = 1996
SQUARE = [[0, 0], [1, 0], [1, 1], [0, 1]]
LOOP = np.array([[0, 1], [1, 2], [2, 3], [3, 0]])
# The unit square with a square hole, and a wall from the hole's corner to the outer corner.
HOLE = [[0.4, 0.4], [0.6, 0.4], [0.6, 0.6], [0.4, 0.6]]


def square(**options):
    return pliant.Domain(SQUARE, LOOP, **options)


def isotropic(sizes):
    """(n, 3) tensors for wanted edge lengths."""
    sizes = np.asarray(sizes, float)
    return np.stack([1 / sizes**2, 0 * sizes, 1 / sizes**2], axis=1)


def areas(mesh):
    a, b, c = (mesh.points[mesh.triangles[:, i]] for i in range(3))
    return ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]) / 2


def check_mesh(mesh, area):
    """A conforming triangulation of the given area whose boundary is listed in `edges`."""
    assert (areas(mesh) > 0).all()
    assert np.isclose(areas(mesh).sum(), area, rtol=1e-12)
    assert np.unique(mesh.triangles).tolist() == list(range(len(mesh.points)))
    sides = np.sort(mesh.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    unique, uses = np.unique(sides, axis=0, return_counts=True)
    assert uses.max() <= 2
    constrained = {tuple(sorted(edge)) for edge in mesh.edges.tolist()}
    assert {tuple(edge) for edge in unique[uses == 1].tolist()} <= constrained
    assert constrained <= {tuple(edge) for edge in unique.tolist()}


def check_same(mesh, other):
    """Two views are equal bit for bit."""
    for name, value in vars(mesh).items():
        theirs = getattr(other, name)
        if isinstance(value, np.ndarray):
            assert (value.dtype, value.shape) == (theirs.dtype, theirs.shape), name
            assert value.tobytes() == theirs.tobytes(), name
        else:
            assert value == theirs, name


@pytest.fixture
def session(client):
    """A square with elements of size 0.1."""
    with client.create_session(domain=square(tags=[1, 2, 3, 4]),
                               metric=pliant.metric.size(0.1)) as made:
        yield made


def test_domain_with_a_hole_regions_and_tags(client):
    domain = pliant.Domain(SQUARE + HOLE, np.concatenate([LOOP, LOOP + 4, [[2, 6], [0, 4]]]),
                           tags=[1, 2, 3, 4, 5, 5, 5, 5, 9, -9], holes=[[0.5, 0.5]],
                           regions=[[0.9, 0.1, 7], [0.1, 0.9, -8]])
    with client.create_session(domain=domain, metric=pliant.metric.size("0.05 + 0.05*x")) as one:
        mesh = one.mesh
        check_mesh(mesh, 0.96)
        assert 200 < len(mesh.points) < 800
        middle = mesh.points[mesh.triangles].mean(axis=1)
        assert (mesh.triangle_tags == np.where(middle[:, 0] > middle[:, 1], 7, -8)).all()
        ends = mesh.points[mesh.edges]
        for tag, axis, value in ((1, 1, 0), (2, 0, 1), (3, 1, 1), (4, 0, 0)):
            on_side = (ends[:, :, axis] == value).all(axis=1)
            assert on_side.any() and (mesh.edge_tags[on_side] == tag).all()
        lengths = {tag: np.hypot(*(ends[:, 1] - ends[:, 0])[mesh.edge_tags == tag].T).sum()
                   for tag in (1, 5, 9, -9)}
        assert lengths == pytest.approx({1: 1, 5: 0.8, 9: 0.4 * 2**0.5, -9: 0.4 * 2**0.5})


def test_mesh_with_tensors(client, session):
    start = pliant.Mesh(session.mesh.points, session.mesh.triangles, session.mesh.edges,
                        session.mesh.edge_tags, np.arange(len(session.mesh.triangles)))
    with client.create_session(mesh=start, metric=isotropic(np.full(len(start.points), 0.1)),
                               no_insert=True, no_swap=True, no_move=True) as frozen:
        assert frozen.mesh.points.tobytes() == start.points.tobytes()

        def rows(mesh):
            first = mesh.triangles.argmin(axis=1)
            turned = np.take_along_axis(mesh.triangles, (first[:, None] + [0, 1, 2]) % 3, axis=1)
            return sorted(map(tuple, np.column_stack([turned, mesh.triangle_tags]).tolist()))

        assert rows(frozen.mesh) == rows(start)
    with client.create_session(mesh=session.mesh, metric=isotropic(
            0.03 + 0.1 * session.mesh.points[:, 0])) as refined:
        check_mesh(refined.mesh, 1)
        assert len(refined.mesh.points) > 1.5 * len(session.mesh.points)
        assert set(refined.mesh.edge_tags) == {1, 2, 3, 4}


def test_tensors_at_a_few_vertices(session):
    session.update_metric(pliant.metric.size(0.02))
    before = session.mesh
    near = np.flatnonzero(np.hypot(*(before.points - 0.5).T) < 0.05)[::-1]
    diff = session.update_metric(isotropic(np.full(len(near), 0.01)), before.vertex_ids[near])
    check_mesh(session.mesh, 1)
    assert diff.converged and diff.active_count == 0 and diff.visit_count > 0
    assert diff.insertion_count > 10
    assert diff.counts.vertices == len(session.mesh.points) > len(before.points)
    # Local: the rest of the mesh is not in the diff, and is as it was.
    assert 0 < len(diff.triangle_ids) < 0.3 * len(before.triangles)
    rows = session.mesh.rows_of(np.setdiff1d(before.vertex_ids, np.concatenate(
        [diff.vertex_ids, diff.removed_vertices])))
    assert (rows >= 0).all() and len(rows) > 0.7 * len(before.points)
    old_rows = before.rows_of(session.mesh.vertex_ids[rows])
    assert session.mesh.points[rows].tobytes() == before.points[old_rows].tobytes()


def test_the_same_metric_again_is_an_empty_diff(session):
    tensors = isotropic(0.05 + 0.1 * session.mesh.points[:, 1])
    session.update_metric(tensors)
    settled = isotropic(0.05 + 0.1 * session.mesh.points[:, 1])
    session.update_metric(settled)
    before = session.mesh
    diff = session.update_metric(isotropic(0.05 + 0.1 * before.points[:, 1]))
    assert diff.empty and diff.converged and diff.revision == before.revision + 1
    assert session.mesh.points.tobytes() == before.points.tobytes()


def test_replica_is_what_the_server_has_at_every_revision(session):
    rng = np.random.default_rng(SEED)
    check_same(session.mesh, session.download())
    for step in range(12):
        points = session.mesh.points
        if step % 3 == 0:
            centre = rng.random(2)
            session.update_metric(isotropic(
                0.03 + 0.2 * np.hypot(*(points - centre).T)))
        elif step % 3 == 1:
            chosen = rng.permutation(session.mesh.vertex_ids)[:20]
            session.update_metric(isotropic(rng.uniform(0.02, 0.3, 20)), chosen)
        else:
            session.update_metric(pliant.metric.size("0.04 + 0.1*x"), advance=pliant.Advance(
                visits_max=50))
        check_same(session.mesh, session.download())
        check_mesh(session.mesh, 1)


def test_a_budget_leaves_work_for_the_next_advance(session):
    diff = session.update_metric(pliant.metric.size(0.03), advance=pliant.Advance(visits_max=20))
    assert (diff.stop_reason, diff.converged) == ("VISIT_BUDGET", False)
    assert diff.active_count > 0
    check_mesh(session.mesh, 1)
    diff = session.advance()
    assert diff.converged and session.quality().active_count == 0


def test_a_cancel_keeps_what_is_done(session):
    session.update_metric(pliant.metric.size(0.1))
    session.stage_metric(pliant.metric.size(0.0012))
    diff = session.advance(on_progress=lambda _: session.cancel())
    assert diff.stop_reason == "CANCELLED" and diff.active_count > 0
    for size in (0.0011, 0.0013):
        # Also before there is anything to cancel, and while the update is on its way.
        is_done = threading.Event()
        other = threading.Thread(
            target=lambda: [session.cancel() for _ in iter(lambda: is_done.wait(0.005), True)])
        other.start()
        diff = session.update_metric(pliant.metric.size(size))
        is_done.set()
        other.join()
        assert diff.stop_reason in ("CANCELLED", "STAGING") and diff.revision == session.revision
        assert (diff.stop_reason == "STAGING") == (diff.revision == diff.base_revision)
    session.cancel()
    diff = session.update_metric(pliant.metric.size(0.2))
    assert diff.converged
    check_mesh(session.mesh, 1)


def test_callbacks_look_and_cancel_and_do_nothing_else(session):
    refused, sizes = [], []

    def meddle(_):
        for call in (session.advance, session.close, session.delete,
                     lambda: session.update_metric(pliant.metric.size(0.1))):
            with pytest.raises(pliant.FailedPrecondition, match="callbacks") as caught:
                call()
            refused.append(caught.value.code)
        sizes.append(len(session.mesh.points))
        session.cancel()

    session.stage_metric(pliant.metric.size(0.002))
    assert session.advance(on_progress=meddle).stop_reason == "CANCELLED"
    assert refused[:4] == ["PROTOCOL_ORDER"] * 4 and sizes
    session.advance(visits_max=1, on_change=meddle)
    assert len(refused) == 4 * len(sizes) > 4

    def fail(_):
        raise pliant.Unavailable("UNAVAILABLE", "something else is out of reach")

    session.stage_metric(pliant.metric.size(0.0018))
    with pytest.raises(pliant.Unavailable, match="something else"):
        session.advance(on_progress=fail)
    assert session.update_metric(pliant.metric.size(0.1)).converged
    assert session.mesh.state_hash == session.download().state_hash


def test_staged_updates_are_committed_together(session):
    mesh = session.mesh
    session.stage_metric(pliant.metric.size(0.05))
    assert session.mesh is mesh
    with pytest.raises(pliant.InvalidInput, match="NOT_POSITIVE_DEFINITE"):
        session.stage_metric([[1, 2, 1]], mesh.vertex_ids[:1])
    assert session.advance().empty
    session.stage_metric(pliant.metric.size(0.05))
    session.stage_metric(h_max=0.04)
    assert session.advance().counts.vertices > 3 * len(mesh.points)


def test_same_seed_same_bits(client):
    def build(size="0.03 + 0.1*x", **options):
        with client.create_session(domain=square(), metric=pliant.metric.size(size),
                                   **options) as one:
            return one.mesh.state_hash

    assert build(seed=5) == build(seed=5)
    # Only large meshes are built in levels.
    assert build(0.015, variant="nested") == build(0.015) != build(0.015, variant="cooled")
    assert build(variant="paper", seed=5) != build(variant="paper", seed=6)
    assert len({build(smoothing=name) for name in ("pliant", "laplacian", "lennard_jones",
                                                   "bubble")}) == 4


def test_quality(session):
    quality = session.quality()
    mesh = session.mesh
    sides = np.sort(mesh.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    edges = np.unique(sides, axis=0)
    lengths = np.hypot(*(mesh.points[edges[:, 0]] - mesh.points[edges[:, 1]]).T) / 0.1
    assert (quality.revision, quality.vertex_count) == (1, len(mesh.points))
    assert (quality.triangle_count, quality.edge_count) == (len(mesh.triangles), len(edges))
    assert quality.averaged.mean == pytest.approx(lengths.mean())
    assert quality.averaged.max == pytest.approx(lengths.max())
    assert quality.integrated.share_125 == pytest.approx(
        ((lengths >= 0.8) & (lengths <= 1.25)).mean(), abs=0.01)
    assert quality.complexity == pytest.approx(100)
    histogram = quality.averaged.histogram
    assert histogram.counts.sum() == len(edges)
    expected, _ = np.histogram(np.clip(lengths, 0, histogram.high - 1e-9), histogram.edges)
    assert np.abs(histogram.counts - expected).sum() <= 2
    assert quality.angle_deg.counts.sum() == 3 * len(mesh.triangles)


REFUSED_DOMAINS = [
    ("CROSSING_SEGMENTS", "domain.segments", {0, 2}, SQUARE, [[0, 2], [2, 3], [3, 1], [1, 0]]),
    ("INDEX_OUT_OF_RANGE", "domain.segments", {3}, SQUARE, [[0, 1], [1, 2], [2, 3], [3, 4]]),
    ("NOT_FINITE", "domain.points", {2}, [[0, 0], [1, 0], [1, np.nan], [0, 1]], LOOP),
    ("DUPLICATE_POINT", "domain.points", {0, 3}, [[0, 0], [1, 0], [1, 1], [0, 0]], LOOP),
]


@pytest.mark.parametrize("code,field,indices,points,segments", REFUSED_DOMAINS)
def test_refused_domains(client, code, field, indices, points, segments):
    before = len(client.list_sessions())
    with pytest.raises(pliant.InvalidInput) as caught:
        client.create_session(domain=pliant.Domain(points, segments),
                              metric=pliant.metric.size(0.1))
    error = caught.value
    assert (error.code, error.field) == (code, field)
    assert {error.index, error.other_index} - {-1} == indices
    assert error.message and len(client.list_sessions()) == before


def test_refused_metrics_change_nothing(client, session):
    mesh = session.mesh
    few = mesh.vertex_ids[[5, 3, 8]]
    good = isotropic([0.1, 0.1, 0.1])

    def changed(row, value):
        tensors = good.copy()
        tensors[row] = value
        return tensors

    free = int(mesh.vertex_ids.max()) + 1
    refused = [
        ("NOT_FINITE", 1, changed(1, [np.nan, 0, 1]), few),
        ("NOT_POSITIVE_DEFINITE", 2, changed(2, [1, 2, 1]), few),
        ("INDEX_OUT_OF_RANGE", 1, good, [few[0], free, few[1]]),
        ("DUPLICATE_ID", 2, good, [few[0], few[1], few[0]]),
    ]
    for code, index, tensors, vertex_ids in refused:
        with pytest.raises(pliant.InvalidInput) as caught:
            session.update_metric(tensors, vertex_ids)
        assert (caught.value.code, caught.value.index) == (code, index)
        assert session.mesh is mesh
    with pytest.raises(pliant.InvalidInput) as caught:
        session.update_metric(pliant.metric.size("0.1 + * x"))
    assert caught.value.code == "EXPRESSION_SYNTAX" and caught.value.index >= 0
    with pytest.raises(pliant.InvalidInput, match="expected .* one for each vertex"):
        session.update_metric(good)
    with pytest.raises(pliant.InvalidInput) as caught:
        session.update_metric(good, few, h_max=-0.05)
    assert caught.value.field == "metric.limits.size_max"
    with pytest.raises(pliant.FailedPrecondition):
        session.update_metric(good, few, time=1)
    assert session.update_metric(pliant.metric.size(0.1)).revision == 2
    check_same(session.mesh, session.download())


def test_sessions_are_listed_opened_and_deleted(client):
    made = client.create_session(domain=square(), metric=pliant.metric.size(0.2),
                                 session_id="listed", labels={"case": "list"})
    with pytest.raises(pliant.AlreadyExists):
        client.create_session(domain=square(), metric=pliant.metric.size(0.2),
                              session_id="listed")
    [info] = [one for one in client.list_sessions() if one.session_id == "listed"]
    assert (info.revision, info.vertex_count) == (1, len(made.mesh.points))
    assert info.labels == {"case": "list"}
    with pytest.raises(pliant.SessionBusy):
        client.open_session("listed")
    made.close()
    with client.open_session("listed") as again:
        check_same(again.mesh, made.mesh)
        again.update_metric(pliant.metric.size(0.1))
    # Tensors that belong to the mesh before somebody else's update are not taken for the new one.
    with pytest.raises(pliant.Error, match="REVISION_MISMATCH"):
        made.update_metric(isotropic(np.full(len(made.mesh.points), 0.3)))
    assert made.revision == 2
    check_same(made.mesh, again.mesh)
    made.delete()
    assert "listed" not in [one.session_id for one in client.list_sessions()]
    with pytest.raises(pliant.NotFound) as caught:
        client.open_session("listed")
    assert caught.value.code == "SESSION_NOT_FOUND"


def test_large_mesh(client, capsys):
    def timed(what, function):
        began = time.perf_counter()
        result = function()
        with capsys.disabled():
            print(f"\n    {what}: {(time.perf_counter() - began) * 1e3:.1f} ms", end="")
        return result

    size = (2 / 3**0.5 / 100_000)**0.5
    with timed("create", lambda: client.create_session(
            domain=square(), metric=pliant.metric.size(size))) as large:
        mesh = timed(f"compact view, {large.mesh.points.shape[0]} vertices",
                     lambda: large._mirror._make_view())
        assert 80_000 < len(mesh.points) < 120_000
        tensors = isotropic(np.full(len(mesh.points), size))
        assert timed("same tensors again", lambda: large.update_metric(tensors)).empty
        near = np.flatnonzero(np.hypot(*(mesh.points - 0.5).T) < 0.018)
        diff = timed(f"half the size at {len(near)} vertices", lambda: large.update_metric(
            4 * tensors[near], mesh.vertex_ids[near]))
        assert 0 < len(diff.triangle_ids) < 0.1 * len(mesh.triangles)
        check_same(large.mesh, timed("download", large.download))


def test_a_jump_of_the_size_is_reported_as_trouble(client):
    with client.create_session(domain=square(), metric=pliant.metric.size(0.05)) as one:
        assert one.update_metric(pliant.metric.size(0.051)).troubles == ()
        diff = one.update_metric(pliant.metric.size("x < 0.5 ? 0.2 : 0.01"), automatic=False)
        jumps = [trouble for trouble in diff.troubles if trouble.kind == "SIZE_JUMP"]
        assert jumps and len(diff.troubles) <= 32
        for trouble in jumps:
            x_min, y_min, x_max, y_max = trouble.box
            assert x_min <= trouble.center[0] <= x_max and y_min <= trouble.center[1] <= y_max
            assert x_min < 0.55 and x_max > 0.2
            assert trouble.vertex_count >= 3 and trouble.place_count >= 1
            assert trouble.q_min < 0.4 or trouble.length_min < 0.5 or trouble.length_max > 2.5


def test_a_hole_moves_and_keeps_its_vertices(client):
    domain = pliant.Domain(SQUARE + HOLE, np.concatenate([LOOP, LOOP + 4]),
                           tags=[1, 2, 3, 4, 5, 5, 5, 5], holes=[[0.5, 0.5]])
    with client.create_session(domain=domain, metric=pliant.metric.size(0.05)) as one:
        diff = one.move_boundary({5: pliant.motion.Translation(0.2, -0.1)})
        assert diff.motion_fraction == 1
        check_mesh(one.mesh, 0.96)
        corners = one.mesh.points[np.searchsorted(one.mesh.vertex_ids, [4, 5, 6, 7])]
        assert (corners == np.array(HOLE) + [0.2, -0.1]).all()

        one.move_boundary({(5,): pliant.motion.Rotation((0.7, 0.4), np.pi / 2)},
                          metric_follow_length=2)
        check_mesh(one.mesh, 0.96)
        before = one.mesh
        with pytest.raises(pliant.errors.InvalidInput) as refused:
            one.move_boundary({5: pliant.motion.Translation(0.4, 0)})
        assert refused.value.code == "CROSSING_SEGMENTS"
        assert refused.value.field == "edges" and refused.value.index in before.edge_ids
        check_same(one.mesh, before)
        diff = one.move_boundary({5: pliant.motion.Translation(0.4, 0)}, stop_if_impossible=True)
        assert 0.45 < diff.motion_fraction < 0.5
        check_mesh(one.mesh, 0.96)


def test_nodes_move_where_they_are_told_to(session):
    mesh = session.mesh
    x, y = mesh.points.T
    bump = (16 * x * (1 - x) * y * (1 - y))[:, None]
    wanted = mesh.points + 0.02 * bump * [[1.0, 0.5]]
    diff = session.move_nodes(wanted, advance=pliant.Advance(visits_max=1))
    assert diff.motion_fraction == 1
    same = (session.mesh.points == wanted).all(axis=1)
    assert (~same).sum() <= 1  # The loop was let to one vertex.
    given = session.mesh.vertex_ids[:2]
    session.move_nodes([[-0.1, -0.1], [1.1, 0.0]], vertex_ids=given)
    check_mesh(session.mesh, areas(session.mesh).sum())
    assert (session.mesh.points[:2] == [[-0.1, -0.1], [1.1, 0.0]]).all()
    with pytest.raises(pliant.errors.InvalidInput) as refused:
        session.move_nodes([[0, 0], [1, np.nan]], vertex_ids=given)
    assert (refused.value.code, refused.value.index) == ("NOT_FINITE", 1)
    mesh = session.mesh
    inner = np.setdiff1d(np.arange(len(mesh.points)), mesh.edges)[:2]
    for place, code in (([3, 0.5], "POINT_OUTSIDE_DOMAIN"),
                        (mesh.points[inner[0]], "DUPLICATE_POINT")):
        with pytest.raises(pliant.errors.InvalidInput) as refused:
            session.move_nodes([mesh.points[inner[0]], place], vertex_ids=mesh.vertex_ids[inner])
        assert refused.value.code == code
        assert refused.value.field == "nodes.vertices.positions"
        assert refused.value.index == (1 if code == "POINT_OUTSIDE_DOMAIN" else 0)
        check_same(session.mesh, mesh)
    with pytest.raises(pliant.errors.InvalidInput):
        session.move_boundary()
