"""Promise Resumable: when my connection breaks I go on, and nothing I sent is applied twice.

The connection goes through a proxy that cuts it after a given count of bytes, in either direction:
in the middle of tensors on their way to the server, or of a diff on its way back.
"""

import os
import signal
import socket
import subprocess
import threading
import time

import numpy as np
import pytest

import pliant

pytestmark = pytest.mark.server
DOMAIN = pliant.Domain([[0, 0], [1, 0], [1, 1], [0, 1]], [[0, 1], [1, 2], [2, 3], [3, 0]])


class Proxy:
    """Passes bytes between clients at `address` and the Unix socket `target`."""

    def __init__(self, path, target):
        self.address = f"unix:{path}"
        self._target = target
        self._left = {"up": None, "down": None}
        self.cut_count = 0
        self._mute = set()
        self._live = set()
        self._listener = socket.socket(socket.AF_UNIX)
        self._listener.bind(path)
        self._listener.listen()
        threading.Thread(target=self._accept, daemon=True).start()

    def cut_after(self, direction, byte_count):
        """Cuts the connection once this many further bytes went up or down."""
        self._left[direction] = byte_count

    def fall_silent(self):
        """Lets the connections that there are stay open, but nothing comes through any more."""
        self._mute |= self._live

    def _accept(self):
        while True:
            try:
                client, _ = self._listener.accept()
            except OSError:
                return
            server = socket.socket(socket.AF_UNIX)
            server.connect(self._target)
            self._live |= {client, server}
            for source, sink, direction in ((client, server, "up"), (server, client, "down")):
                threading.Thread(target=self._pass, args=(source, sink, direction),
                                 daemon=True).start()

    def _pass(self, source, sink, direction):
        try:
            while data := source.recv(4096):
                if source in self._mute:
                    continue
                left = self._left[direction]
                if left is not None:
                    self._left[direction] = left - len(data)
                    if left <= len(data):
                        self._left[direction] = None
                        self.cut_count += 1
                        break
                sink.sendall(data)
        except OSError:
            pass
        for end in (source, sink):
            try:
                end.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass


@pytest.mark.parametrize("direction,byte_count", [
    ("up", 100), ("up", 30_000), ("down", 1), ("down", 20_000), ("down", 200_000)])
def test_a_cut_connection(client, tmp_path, direction, byte_count):
    proxy = Proxy(str(tmp_path / "proxy"), client.address.removeprefix("unix:"))
    with pliant.connect(proxy.address) as far, far.create_session(
            domain=DOMAIN, metric=pliant.metric.size(0.02)) as session, client.create_session(
            domain=DOMAIN, metric=pliant.metric.size(0.02)) as twin:
        x = session.mesh.points[:, 0]
        tensors = np.stack([(1 + x) / 0.015**2, 0 * x, (1 + x) / 0.015**2], axis=1)
        proxy.cut_after(direction, byte_count)
        diff = session.update_metric(tensors)
        assert proxy.cut_count == 1
        assert diff.revision == session.revision == 2
        twin.update_metric(tensors)
        assert session.mesh.state_hash == twin.mesh.state_hash == session.download().state_hash
        assert session.update_metric(pliant.metric.size(0.1)).base_revision == 2


class Server:
    """A pliantd on a Unix socket in `folder` that goes away and comes back."""

    def __init__(self, folder, *arguments):
        self._ready = folder / "ready"
        self.address = f"unix:{folder}/socket"
        self._command = [os.environ["PLIANTD"], "--listen", self.address, "--port-file",
                         self._ready, "--drain-ms", "1000", *arguments]
        self.start()

    def start(self):
        self._ready.unlink(missing_ok=True)
        self._process = subprocess.Popen(self._command, stderr=subprocess.DEVNULL)
        while not self._ready.exists():
            assert self._process.poll() is None

    def stop(self, how=signal.SIGTERM):
        self._process.send_signal(how)
        self._process.wait()


@pytest.fixture
def server(tmp_path):
    made = Server(tmp_path)
    yield made
    made.stop(signal.SIGKILL)


@pytest.fixture
def stored(tmp_path):
    """A server that keeps its sessions on disk."""
    (tmp_path / "data").mkdir()
    made = Server(tmp_path, "--data", tmp_path / "data")
    yield made
    made.stop(signal.SIGKILL)


ENDS = pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGTERM])


@ENDS
def test_a_server_that_ends(server, how):
    with pliant.connect(server.address) as client:
        session = client.create_session(domain=DOMAIN, metric=pliant.metric.size(0.1),
                                        reconnect_s=0.2)
        server.stop(how)
        with pytest.raises(pliant.Unavailable):
            session.advance()
        with pytest.raises(ConnectionError):
            session.quality()
        assert session.revision == session.mesh.revision == 1
        server.start()
        with pytest.raises(pliant.NotFound):
            session.advance()


# Goal: an editor needs no word about a server that is away for a while: not while it waits, not in
# the middle of an advance, and not where it had given up.
@ENDS
def test_a_server_that_comes_back(stored, how):
    with pliant.connect(stored.address) as client:
        session = client.create_session(domain=DOMAIN, metric=pliant.metric.size(0.1))

        def come_back():
            time.sleep(0.7)
            stored.start()

        def leave(pause_s):
            time.sleep(pause_s)
            stored.stop(how)
            come_back()

        session.stage_metric(pliant.metric.size(0.3))
        stored.stop(how)
        thread = threading.Thread(target=come_back)
        thread.start()
        diff = session.advance()
        thread.join()
        assert (diff.base_revision, session.revision) == (1, 2)
        assert session.quality().vertex_count < 60, "what was staged is not lost"

        thread = threading.Thread(target=leave, args=[0.1])
        thread.start()
        # One that shuts down ends the loop; the next one goes on with it.
        assert session.update_metric(pliant.metric.size("0.005 + 0*x")).converged
        thread.join()
        assert session.advance().converged
        assert session.mesh.state_hash == session.download().state_hash

        with client.open_session(session.fork(), reconnect_s=0.1) as impatient:
            stored.stop(how)
            with pytest.raises(pliant.Unavailable):
                impatient.update_metric(pliant.metric.size(0.2))
            stored.start()
            assert impatient.update_metric(pliant.metric.size(0.3)).revision >= 2
            assert impatient.mesh.state_hash == impatient.download().state_hash


def test_a_subscription_keeps_its_timeout_while_the_server_is_away(stored):
    with pliant.connect(stored.address) as client:
        session = client.create_session(domain=DOMAIN, metric=pliant.metric.size(0.1))
        with client.subscribe(session.session_id) as follower:
            assert next(follower).revision == 1
            stored.stop(signal.SIGKILL)
            for _ in range(4):
                start = time.monotonic()
                assert follower.next(timeout_s=0.2) is None
                assert 0.19 < time.monotonic() - start < 0.35
            stored.start()
            session.update_metric(pliant.metric.size(0.2))
            assert next(follower).revision == 2
            assert follower.mesh.state_hash == session.mesh.state_hash
        with client.subscribe(session.session_id, reconnect_s=0.3) as follower:
            next(follower)
            stored.stop(signal.SIGKILL)
            with pytest.raises(pliant.Unavailable):
                follower.next(timeout_s=5)
            stored.start()
            session.advance()
            assert next(follower).revision == 3


def test_a_connection_that_falls_silent_is_made_again(client, tmp_path):
    proxy = Proxy(str(tmp_path / "proxy"), client.address.removeprefix("unix:"))
    with pliant.connect(proxy.address, keepalive_s=0.5) as far:
        session = far.create_session(domain=DOMAIN, metric=pliant.metric.size(0.3))
        proxy.fall_silent()
        assert session.update_metric(pliant.metric.size(0.2)).revision == 2
        proxy.fall_silent()
        assert session.quality().vertex_count == len(session.mesh.points)
        session.delete()


@ENDS
def test_calls_that_do_no_harm_twice_wait_for_the_server(stored, how):
    with pliant.connect(stored.address) as client:
        session = client.create_session(domain=DOMAIN, metric=pliant.metric.size(0.2))
        for call in (session.quality, session.download, session.save_revision, client.list_sessions,
                     lambda: client.export_session(session.session_id), client.list_jobs):
            stored.stop(how)
            timer = threading.Timer(0.1, stored.start)
            timer.start()
            call()
            timer.join()


def test_what_another_editor_has_had_is_staged_again(client, tmp_path):
    proxy = Proxy(str(tmp_path / "proxy"), client.address.removeprefix("unix:"))
    with pliant.connect(proxy.address) as far, far.create_session(
            domain=DOMAIN, metric=pliant.metric.size(0.3)) as session:
        session.stage_metric(pliant.metric.size(0.2))
        session.close()
        with client.open_session(session.session_id) as other:
            other.advance()  # It has thrown away what was nobody's wish.
        with pytest.raises(pliant.FailedPrecondition, match="another editor"):
            session.advance()
        assert session.update_metric(pliant.metric.size(0.2)).revision == 3


def test_an_interrupt_stops_the_server_too(client):
    with client.create_session(domain=DOMAIN, metric=pliant.metric.size(0.1)) as session:
        timer = threading.Timer(0.3, os.kill, [os.getpid(), signal.SIGINT])
        timer.start()
        with pytest.raises(KeyboardInterrupt):
            session.update_metric(pliant.metric.size("0.0012 + 0*x"))  # Half a minute.
        start = time.monotonic()
        session.update_metric(pliant.metric.size(0.3), advance=pliant.Advance(visits_max=1))
        assert time.monotonic() - start < 3
        assert session.mesh.state_hash == session.download().state_hash


def test_a_session_that_is_busy_for_a_moment(client):
    with client.create_session(domain=DOMAIN, metric=pliant.metric.size(0.3)) as session:
        with pytest.raises(pliant.SessionBusy):
            client.open_session(session.session_id)
        timer = threading.Timer(0.15, session.close)
        timer.start()
        with client.open_session(session.session_id) as other:
            assert other.revision == 1
        timer.join()


def test_a_session_deleted_under_its_editor(client):
    session = client.create_session(domain=DOMAIN, metric=pliant.metric.size(0.1))
    pliant.Session(client._sessions, session.session_id, is_owner=True).delete()
    for _ in range(2):
        with pytest.raises(pliant.NotFound):
            session.advance()
    assert session.mesh.revision == 1
