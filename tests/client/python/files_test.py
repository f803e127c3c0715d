"""Sessions as files, against the real pliantd."""

import numpy as np
import pytest

import pliant

pytestmark = pytest.mark.server
SQUARE = [[0, 0], [1, 0], [1, 1], [0, 1]]
LOOP = [[0, 1], [1, 2], [2, 3], [3, 0]]


def test_an_imported_session_goes_on_with_the_same_bits(client):
    domain = pliant.Domain(SQUARE, LOOP, tags=[1, 2, 3, 4])
    with client.create_session(domain=domain, metric=pliant.metric.size("0.01")) as session:
        file = client.export_session(session.session_id)
        assert isinstance(file, bytes) and len(file) > 1 << 20, "in several chunks"
        name = client.import_session(file, session_id="copy")
        assert name == "copy"
        with pytest.raises(pliant.AlreadyExists):
            client.import_session(file, session_id="copy")
        copy = client.open_session(name)
        h = np.where(session.mesh.points[:, 0] < 0.3, 0.008, 0.015)
        tensors = np.stack([1 / h**2, 0 * h, 1 / h**2], axis=1)
        for one in (session, copy):
            one.update_metric(tensors)
        for part in ("points", "triangles", "edges"):
            assert getattr(copy.mesh, part).tobytes() == getattr(session.mesh, part).tobytes()
        copy.delete()


def test_what_is_no_file_is_refused(client):
    for data in (b"", b"no session", bytes(100_000)):
        with pytest.raises(pliant.DataCorrupt) as caught:
            client.import_session(data)
        assert caught.value.field == "file"
    with pytest.raises(pliant.NotFound):
        client.export_session("nobody")


def test_history_is_bounded_at_creation(client):
    domain = pliant.Domain(SQUARE, LOOP, tags=[1, 2, 3, 4])
    size = pliant.metric.size("0.3")
    with pytest.raises(pliant.InvalidInput) as caught:
        client.create_session(domain=domain, metric=size,
                              history_bytes_max=client.limits["history_bytes"] + 1)
    assert (caught.value.code, caught.value.field) == ("OUT_OF_RANGE", "options.history_bytes_max")
    with client.create_session(domain=domain, metric=size, history_bytes_max=0) as session:
        session.update_metric(pliant.metric.size(0.2))
        with pytest.raises(pliant.NotFound):
            session.rollback(1)
        asked = {one.session_id: one.history_bytes_max for one in client.list_sessions()}
        assert asked[session.session_id] == 0
    with client.create_session(domain=domain, metric=size) as session:
        session.update_metric(pliant.metric.size(0.2))
        assert session.rollback(1).revision == 3
        asked = {one.session_id: one.history_bytes_max for one in client.list_sessions()}
        assert asked[session.session_id] is None


def test_durability_is_chosen_at_creation(client):
    domain = pliant.Domain(SQUARE, LOOP, tags=[1, 2, 3, 4])
    size = pliant.metric.size("0.3")
    client.create_session(domain=domain, metric=size, durability="none").delete()
    with pytest.raises(pliant.Unimplemented, match="memory only"):
        client.create_session(domain=domain, metric=size, durability="strict")
    with pytest.raises(pliant.InvalidInput) as caught:
        client.create_session(domain=domain, metric=size, durability="always")
    assert caught.value.field == "options.durability"
