"""Promise Resumable: when my connection breaks I go on, and nothing I sent is applied twice.

The connection goes through a proxy that cuts it after a given count of bytes, in either direction:
in the middle of tensors on their way to the server, or of a diff on its way back.
"""

import os
import signal
import socket
import subprocess
import threading

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
        self._listener = socket.socket(socket.AF_UNIX)
        self._listener.bind(path)
        self._listener.listen()
        threading.Thread(target=self._accept, daemon=True).start()

    def cut_after(self, direction, byte_count):
        """Cuts the connection once this many further bytes went up or down."""
        self._left[direction] = byte_count

    def _accept(self):
        while True:
            try:
                client, _ = self._listener.accept()
            except OSError:
                return
            server = socket.socket(socket.AF_UNIX)
            server.connect(self._target)
            for source, sink, direction in ((client, server, "up"), (server, client, "down")):
                threading.Thread(target=self._pass, args=(source, sink, direction),
                                 daemon=True).start()

    def _pass(self, source, sink, direction):
        try:
            while data := source.recv(4096):
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


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGTERM])
def test_a_server_that_ends(server, monkeypatch, how):
    monkeypatch.setattr(pliant.session.stream, "_BUSY_S_MAX", 0.2)
    with pliant.connect(server.address) as client:
        session = client.create_session(domain=DOMAIN, metric=pliant.metric.size(0.1))
        server.stop(how)
        with pytest.raises(pliant.Unavailable):
            session.advance()
        with pytest.raises(ConnectionError):
            session.quality()
        assert session.revision == session.mesh.revision == 1


def test_a_session_deleted_under_its_editor(client):
    session = client.create_session(domain=DOMAIN, metric=pliant.metric.size(0.1))
    pliant.Session(client._sessions, session.session_id, is_owner=True).delete()
    for _ in range(2):
        with pytest.raises(pliant.NotFound):
            session.advance()
    assert session.mesh.revision == 1
