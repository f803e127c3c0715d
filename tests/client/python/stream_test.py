"""The edit stream and the replica against a scripted server: lost connections, wrong hashes."""

import os
import random
import signal
import sys
import threading

import grpc
import numpy as np
import pytest

import pliant
from fake_server import FakeMesh, FakeService, RefusingService, element_hash, serve
from pliant.replica import element_hash_sum
from pliant.v1 import errors_pb2

SEED = 1996


def random_meshes(count, seed=SEED):
    """Unrelated heaps of elements in random slots: a replica does not care what they mean."""
    rng = random.Random(seed)

    def heap(row):
        return {slot: row() for slot in rng.sample(range(200), rng.randint(1, 150))}

    def change(elements, row):
        kept = {slot: value for slot, value in elements.items() if rng.random() < 0.8}
        kept.update({rng.randrange(300): row() for _ in range(rng.randint(0, 30))})
        return kept

    def vertex():
        return rng.uniform(-1, 1), rng.choice([0.0, -0.0, 1e-300, rng.random()])

    mesh = FakeMesh(heap(vertex), {}, {})
    for step in range(count):
        slots = list(mesh.vertices)

        def triangle():
            return (*rng.choices(slots, k=3), rng.randint(-2**31, 2**31 - 1))

        def edge():
            return (*rng.choices(slots, k=2), rng.randint(-5, 5))

        mesh = FakeMesh(mesh.vertices, change(mesh.triangles, triangle), change(mesh.edges, edge))
        # Corners of the kept triangles may go: only rows of live vertices are compared then.
        yield FakeMesh(mesh.vertices,
                       {i: t for i, t in mesh.triangles.items() if set(t[:3]) <= set(slots)},
                       {i: e for i, e in mesh.edges.items() if set(e[:2]) <= set(slots)})
        mesh = FakeMesh(change(mesh.vertices, vertex) or {0: vertex()}, mesh.triangles, mesh.edges)


def check_view(view, mesh):
    """`view` is `mesh`, renumbered by hand."""
    slots = sorted(mesh.vertices)
    row = {slot: i for i, slot in enumerate(slots)}
    triangles = [mesh.triangles[i] for i in sorted(mesh.triangles)]
    edges = [mesh.edges[i] for i in sorted(mesh.edges)]
    assert view.vertex_ids.tolist() == slots
    assert view.points.tobytes() == np.array([mesh.vertices[i] for i in slots]).tobytes()
    assert view.triangles.tolist() == [[row[v] for v in t[:3]] for t in triangles]
    assert view.triangle_tags.tolist() == [t[3] for t in triangles]
    assert view.edges.tolist() == [[row[v] for v in e[:2]] for e in edges]
    assert view.edge_tags.tolist() == [e[2] for e in edges]
    assert view.triangle_ids.tolist() == sorted(mesh.triangles)
    assert view.edge_ids.tolist() == sorted(mesh.edges)
    for array in (view.points, view.triangles, view.edges, view.edge_tags, view.triangle_tags):
        assert array.flags.c_contiguous and not array.flags.writeable


@pytest.fixture
def start(tmp_path):
    """Starts a session on a scripted server: start(service, **options) -> Session."""
    started = []

    def start_session(service, **options):
        address = f"unix:{tmp_path}/fake{len(started)}"
        started.append(serve(service, address))
        client = pliant.connect(address)
        started.insert(0, client)
        domain = pliant.Domain(np.zeros((3, 2)), [[0, 1], [1, 2], [2, 0]])
        return client.create_session(domain=domain, metric=pliant.metric.size(1), **options)

    yield start_session
    for one in started:
        one.close() if isinstance(one, pliant.Client) else one.stop(0)


def test_hash_is_the_scalar_formula():
    rng = np.random.default_rng(SEED)
    for kind, words in ((1, 2), (2, 4), (3, 3)):
        ids = rng.integers(0, 2**31, 50).astype(np.int32)
        contents = [rng.integers(0, 2**64, 50, np.uint64) for _ in range(words)]
        expected = sum(element_hash(kind, int(ids[i]), [int(word[i]) for word in contents])
                       for i in range(50)) % 2**64
        assert int(element_hash_sum(kind, ids, contents)) == expected


@pytest.mark.parametrize("chunk_bytes", [65536, 40])
def test_replica_follows_every_revision(start, chunk_bytes):
    meshes = list(random_meshes(20))
    session = start(FakeService(meshes, chunk_bytes=chunk_bytes))
    before = session.mesh
    check_view(before, meshes[0])
    for revision, mesh in enumerate(meshes[1:], 2):
        diff = session.advance()
        assert (diff.base_revision, diff.revision) == (revision - 1, revision)
        assert session.mesh is session.mesh
        check_view(session.mesh, mesh)
    check_view(before, meshes[0])


def test_an_advance_that_is_due_before_all_is_staged_changes_nothing(start):
    meshes = list(random_meshes(2))
    service = FakeService(meshes, faults=[None, "staging"])
    session = start(service)
    seen = session.mesh
    diff = session.update_metric(pliant.metric.size(2), advance=pliant.Advance(time_ms_max=1))
    assert (diff.stop_reason, diff.converged, diff.empty) == ("STAGING", False, True)
    assert diff.base_revision == diff.revision == session.revision == 1
    assert (diff.counts.vertices, diff.state_hash) == (len(seen.points), meshes[0].state_hash())
    assert session.mesh is seen and service.discard_count == 0
    diff = session.advance()
    assert diff.converged and diff.revision == 2 and service.discard_count == 0
    check_view(session.mesh, meshes[1])


@pytest.mark.parametrize("fault", ["hash", "count"])
def test_a_difference_is_found_and_healed(start, fault):
    meshes = list(random_meshes(3))
    session = start(FakeService(meshes, faults=[None, fault]))
    with pytest.raises(pliant.ReplicaMismatch) as caught:
        session.advance()
    assert caught.value.code == "REPLICA_MISMATCH"
    check_view(session.mesh, meshes[1])
    assert session.revision == 2
    session.advance()
    check_view(session.mesh, meshes[2])


@pytest.mark.parametrize("fault", ["drop before", "drop after", "closing"])
def test_a_lost_connection_applies_nothing_twice(start, fault):
    meshes = list(random_meshes(3))
    service = FakeService(meshes, faults=[None, fault])
    session = start(service)
    diff = session.update_metric(pliant.metric.size(2))
    assert diff.revision == session.revision == 2
    check_view(session.mesh, meshes[1])
    assert len(service.applied) == len(set(service.applied)) == 2
    assert session.advance().base_revision == 2


@pytest.mark.parametrize("fault", [None, "drop before", "drop after"])
def test_a_change_is_told_once(start, fault):
    session = start(FakeService(random_meshes(2), faults=[None, fault]))
    seen = []
    session.advance(on_change=seen.append)
    assert [(change.base_revision, change.revision) for change in seen] == [(1, 2)]


def test_an_announced_end_is_taken_up_again_or_says_why(start):
    shutdown = errors_pb2.ErrorDetail(reason="UNAVAILABLE", message="the server shuts down")
    gone = errors_pb2.ErrorDetail(reason="SESSION_NOT_FOUND", message="it was deleted", code=5)
    session = start(FakeService(random_meshes(3), faults=[None, shutdown, None, gone]))
    assert session.advance().revision == 2
    with pytest.raises(pliant.NotFound, match="it was deleted"):
        session.advance()


def test_an_interrupt_leaves_a_session_that_works(start):
    meshes = list(random_meshes(2))
    service = FakeService(meshes, faults=[None, "hang"])
    session = start(service)

    def interrupt():
        service.is_hanging.wait()
        os.kill(os.getpid(), signal.SIGINT)

    thread = threading.Thread(target=interrupt)
    thread.start()
    with pytest.raises(KeyboardInterrupt):
        session.update_metric(pliant.metric.size(2))
    thread.join()
    assert service.cancelled[-1]
    check_view(session.mesh, meshes[0])
    # Half of the call that was broken off is not committed by the next one.
    assert session.advance().revision == 2
    assert service.discard_count == 1
    check_view(session.mesh, meshes[1])


# Goal: Ctrl-C at the worst moment, while grpcio holds a lock of the whole channel, hangs nothing.
# Method: a profiler of the main thread raises KeyboardInterrupt between the taking of a lock by
# grpcio and its `with` block; as a client should give it no such moment, a signal comes later.
def test_an_interrupt_breaks_no_other_call(start):
    service = FakeService(list(random_meshes(2)), faults=[None, "hang"])
    session = start(service)
    has_struck = threading.Event()

    def strike(frame, event, _):
        caller = frame.f_back
        if (event == "return" and frame.f_code is threading.Condition.__enter__.__code__
                and f"{os.sep}grpc{os.sep}" in caller.f_code.co_filename
                and caller.f_code.co_name != "__del__"):  # Exceptions do not leave that.
            sys.setprofile(None)
            has_struck.set()
            raise KeyboardInterrupt

    def interrupt():
        if service.is_hanging.wait(10) and not has_struck.is_set():
            os.kill(os.getpid(), signal.SIGINT)

    def give_up(*_):
        raise TimeoutError("the session hangs after an interrupt")

    thread = threading.Thread(target=interrupt)
    thread.start()
    sys.setprofile(strike)
    with pytest.raises(KeyboardInterrupt):
        session.update_metric(pliant.metric.size(2))
    sys.setprofile(None)
    service.is_hanging.set()
    old_handler = signal.signal(signal.SIGALRM, give_up)
    signal.setitimer(signal.ITIMER_REAL, 10)
    try:
        service.faults.clear()
        session.advance()
        assert session.revision == service.revision
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, old_handler)
        thread.join()


def test_a_stage_that_the_server_has_lost_is_not_committed_in_part(start):
    service = FakeService(random_meshes(3), faults=[None, "forget"])
    session = start(service)
    session.stage_metric(pliant.metric.size(2))
    with pytest.raises(pliant.FailedPrecondition, match="stage it again") as caught:
        session.update_metric(pliant.metric.size(3))
    assert caught.value.code == "UPDATE_REJECTED"
    assert session.revision == 1
    assert session.advance().revision == 2


def test_what_is_staged_survives_a_lost_connection(start):
    service = FakeService(random_meshes(2), faults=[None, "drop before"])
    session = start(service)
    session.stage_metric(pliant.metric.size(2))
    assert session.advance().revision == 2
    assert service.discard_count == 0


def test_a_server_that_stays_lost_is_unavailable_and_may_come_back(start, tmp_path):
    service = FakeService(random_meshes(4), faults=[None] + ["drop before"] * 99)
    session = start(service, reconnect_s=0.3)
    with pytest.raises(pliant.Unavailable):
        session.advance()
    assert 3 <= 99 - len(service.faults) <= 10, "pauses grow"
    # It is patient with a connection that is lost many times, but not for long.
    service.faults[:] = ["drop before"] * 3
    assert session.advance().revision == 2
    assert session.advance().revision == 3
    with pytest.raises(pliant.Unavailable, match="start_local"):
        pliant.connect(f"unix:{tmp_path}/nobody")


def test_leaving_the_block_deletes_only_what_was_created(start):
    service = FakeService(random_meshes(2))
    with start(service) as session:
        session.close()
        session.advance()
    assert service.deleted
    session.delete()
    with pytest.raises(pliant.NotFound):
        session.advance()


def test_large_arrays_are_uploaded_in_chunks(start, tmp_path):
    service = FakeService(random_meshes(1))
    server = serve(service, f"unix:{tmp_path}/upload")
    points = np.random.default_rng(SEED).random((100_000, 2))
    segments = np.stack([np.arange(100_000), np.roll(np.arange(100_000), -1)], 1)
    with pliant.connect(f"unix:{tmp_path}/upload") as client:
        client.create_session(domain=pliant.Domain(points, segments), metric=pliant.metric.size(1),
                              hmin=0.5, h_max=2, seed=7, variant="paper", no_move=True)
    server.stop(0)
    create, blobs = service.received["create"], service.received["blobs"]
    assert bytes(blobs[create.domain.points.blob_id]) == points.tobytes()
    assert bytes(blobs[create.domain.segments.blob_id]) == segments.astype("<i4").tobytes()
    assert not create.domain.HasField("holes")
    assert (create.metric.limits.size_min, create.metric.limits.size_max) == (0.5, 2)
    assert (create.options.seed, create.options.variant) == (7, 2)
    assert list(create.options.restrictions) == [3]


def test_refusals_become_exceptions(tmp_path):
    detail = errors_pb2.ErrorDetail(reason="SESSION_NOT_FOUND", field="session_id", index=4,
                                    other_index=-1, message="no such session", code=5)
    server = serve(RefusingService(detail, grpc.StatusCode.NOT_FOUND), f"unix:{tmp_path}/refuse")
    with pliant.connect(f"unix:{tmp_path}/refuse") as client:
        assert (client.version, client.limits) == ("fake", {"vertices": 7})
        with pytest.raises(pliant.NotFound) as caught:
            pliant.Session(client._sessions, "gone", True).delete()
        assert (caught.value.code, caught.value.index) == ("SESSION_NOT_FOUND", 4)
        assert str(caught.value) == "SESSION_NOT_FOUND: session_id[4]: no such session"
        with pytest.raises(LookupError, match="no details here"):
            client.list_sessions()
    server.stop(0)
