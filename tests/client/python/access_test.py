"""Tokens and certificates of the real pliantd."""

import subprocess
import time

import grpc
import pytest

import pliant
from pliant.local import find_pliantd
from resume_test import DOMAIN

pytestmark = pytest.mark.server


@pytest.fixture
def start(tmp_path):
    """Starts a server with these flags at a free port: start(*flags) -> address."""
    servers = []

    def start_server(*flags):
        ready = tmp_path / f"ready{len(servers)}"
        servers.append(subprocess.Popen(
            [find_pliantd(), "--listen", "localhost:0", "--port-file", ready, "--drain-ms", "200",
             *flags], stderr=subprocess.DEVNULL))
        while not ready.exists() or not ready.read_text().strip():
            assert servers[-1].poll() is None
            time.sleep(0.01)
        return "localhost:" + ready.read_text().strip().rpartition(":")[2]

    yield start_server
    for server in servers:
        server.terminate()
        server.wait()


def certificate(folder, name, signer=None):
    """(certificate, key) as PEM files, for localhost; signed by `signer` or by itself."""
    cert, key = folder / f"{name}.pem", folder / f"{name}.key"
    command = ["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256",
               "-nodes", "-days", "2", "-subj", f"/CN={name}", "-addext",
               "subjectAltName=DNS:localhost", "-keyout", key, "-out", cert]
    if signer is not None:
        command += ["-CA", signer[0], "-CAkey", signer[1], "-addext",
                    "basicConstraints=critical,CA:FALSE"]
    subprocess.run(command, check=True, capture_output=True)
    return cert, key


def test_tokens(start, tmp_path):
    tokens = tmp_path / "tokens"
    tokens.write_text("aaaaaaaaaaaaaaaa wing\nbbbbbbbbbbbbbbbb rotor\n")
    address = start("--tokens", tokens)
    with pytest.raises(pliant.Unauthenticated) as caught:
        pliant.connect(address)
    assert caught.value.code == "UNAUTHENTICATED"
    with pytest.raises(PermissionError):
        pliant.connect(address, token="cccccccccccccccc")
    with pliant.connect(address, token="aaaaaaaaaaaaaaaa") as wing, pliant.connect(
            address, token="bbbbbbbbbbbbbbbb") as rotor:
        session = wing.create_session(domain=DOMAIN, metric=pliant.metric.size(0.3),
                                      session_id="s")
        assert session.update_metric(pliant.metric.size(0.2)).revision == 2
        assert session.download().state_hash == session.mesh.state_hash
        assert next(wing.subscribe("s")).revision == 2
        assert rotor.list_sessions() == []
        for use in (rotor.open_session, lambda name: next(rotor.subscribe(name))):
            with pytest.raises(pliant.NotFound):
                use("s")


def test_a_certificate_that_is_replaced_holds_without_a_restart(start, tmp_path):
    cert, key = certificate(tmp_path, "first")
    address = start("--tls-cert", cert, "--tls-key", key)
    first = cert.read_bytes()
    with pliant.connect(address, tls_roots=first) as client:
        assert client.list_sessions() == []
    new_cert, new_key = certificate(tmp_path, "second")
    key.write_bytes(new_key.read_bytes())
    cert.write_bytes(new_cert.read_bytes())
    deadline = time.monotonic() + 30
    while True:
        try:
            pliant.connect(address, tls_roots=new_cert.read_bytes()).close()
            break
        except pliant.Unavailable:
            assert time.monotonic() < deadline, "the new certificate is not used"
    with pytest.raises(pliant.Unavailable):
        pliant.connect(address, tls_roots=first)
    with pytest.raises((pliant.Unavailable, grpc.RpcError)):
        pliant.connect(address)


def test_clients_need_certificates_where_that_is_asked_for(start, tmp_path):
    ca = certificate(tmp_path, "ca")
    cert, key = certificate(tmp_path, "server")
    address = start("--tls-cert", cert, "--tls-key", key, "--tls-client-ca", ca[0])
    mine = certificate(tmp_path, "client", signer=ca)
    stranger = certificate(tmp_path, "stranger")
    roots = cert.read_bytes()
    with pliant.connect(address, tls_roots=roots, tls_cert=mine[0].read_bytes(),
                        tls_key=mine[1].read_bytes()) as client:
        assert client.list_sessions() == []
    with pytest.raises(pliant.Unavailable):
        pliant.connect(address, tls_roots=roots)
    with pytest.raises(pliant.Unavailable):
        pliant.connect(address, tls_roots=roots, tls_cert=stranger[0].read_bytes(),
                       tls_key=stranger[1].read_bytes())
