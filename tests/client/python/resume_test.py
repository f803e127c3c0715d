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


def test_a_server_that_dies(tmp_path, monkeypatch):
    monkeypatch.setattr(pliant.session.stream, "_BUSY_S_MAX", 0.2)
    path = tmp_path / "socket"
    server = subprocess.Popen(
        [os.environ["PLIANTD"], "--listen", f"unix:{path}", "--port-file", tmp_path / "ready"],
        stderr=subprocess.DEVNULL)
    while not (tmp_path / "ready").exists():
        assert server.poll() is None
    client = pliant.connect(f"unix:{path}")
    session = client.create_session(domain=DOMAIN, metric=pliant.metric.size(0.1))
    server.send_signal(signal.SIGKILL)
    server.wait()
    with pytest.raises(pliant.Unavailable):
        session.advance()
    with pytest.raises(ConnectionError):
        session.quality()
    assert session.revision == session.mesh.revision == 1
    client.close()
