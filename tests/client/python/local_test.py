"""start_local: the server is there when it should be, and gone when its owner is."""

import os
import pathlib
import select
import signal
import stat
import subprocess
import sys
import textwrap

import pytest

import pliant
from pliant import local

HERE = pathlib.Path(__file__).parent
SERVE = """\
    import signal, sys
    sys.path.insert(0, {here!r})
    from fake_server import FakeService, serve
    assert sys.argv[1] == "--listen"
    server = serve(FakeService([]), sys.argv[2])
    signal.sigwait([{signal}])
    """
# An owner that starts a server and then does as told by its standard input.
OWNER = """\
    import glob, os, pliant, sys
    client = pliant.start_local()
    folder = os.path.dirname(client.address[len("unix:"):])
    guard = client._server._guard.pid
    children = open(f"/proc/{guard}/task/{guard}/children").read().split()
    if len(sys.argv) > 1 and os.fork() == 0:
        os.execvp("sleep", ["sleep", "600"])
    print(guard, children[0], folder, flush=True)
    exec(sys.stdin.readline())
    """


def script(path, body):
    path.write_text(f"#!{sys.executable}\n" + textwrap.dedent(body))
    path.chmod(path.stat().st_mode | stat.S_IXUSR)
    return str(path)


@pytest.fixture(params=["fake", "real"])
def pliantd(request, tmp_path):
    """Path of a server: a scripted one that ends with SIGTERM only, or the real one."""
    if request.param == "real":
        if not os.environ.get("PLIANTD"):
            pytest.skip("PLIANTD is not set")
        return os.environ["PLIANTD"]
    return script(tmp_path / "pliantd", SERVE.format(here=str(HERE), signal="signal.SIGTERM"))


def is_gone(pid, timeout_ms=20_000):
    """True once the process has ended."""
    try:
        descriptor = os.pidfd_open(pid)
    except ProcessLookupError:
        return True
    poll = select.poll()
    poll.register(descriptor, select.POLLIN)
    return bool(poll.poll(timeout_ms))


def start_owner(pliantd, *arguments):
    """An interpreter that has started a server: (process, guard's pid, server's pid, folder)."""
    owner = subprocess.Popen([sys.executable, "-c", textwrap.dedent(OWNER), *arguments],
                             stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
                             env={**os.environ, "PLIANTD": pliantd})
    guard, server, folder = owner.stdout.readline().split()
    return owner, int(guard), int(server), folder


def test_ends_with_the_client(pliantd):
    client = pliant.start_local(pliantd)
    folder = os.path.dirname(client.address.removeprefix("unix:"))
    guard = client._server._guard
    assert client.version and os.path.exists(folder)
    client.close()
    client.close()
    assert guard.returncode is not None and not os.path.exists(folder)


@pytest.mark.parametrize("last_line", ["pass", "raise SystemExit(3)", "os._exit(1)"])
def test_ends_with_the_interpreter(pliantd, last_line):
    owner, guard, server, folder = start_owner(pliantd)
    owner.communicate(last_line + "\n")
    assert is_gone(guard) and is_gone(server) and not os.path.exists(folder)


@pytest.mark.parametrize("arguments", [[], ["fork"]])
def test_ends_when_the_interpreter_is_killed(pliantd, arguments):
    # With a forked child: it holds our end of the pipe open and must not keep the server alive.
    owner, guard, server, folder = start_owner(pliantd, *arguments)
    children = pathlib.Path(f"/proc/{owner.pid}/task/{owner.pid}/children").read_text().split()
    owner.kill()
    owner.wait()
    assert is_gone(guard) and is_gone(server) and not os.path.exists(folder)
    for child in map(int, children):
        if child != guard:
            os.kill(child, signal.SIGKILL)


def test_ends_when_the_guard_is_killed(pliantd):
    owner, guard, server, _ = start_owner(pliantd)
    os.kill(guard, signal.SIGKILL)
    assert is_gone(server)
    owner.communicate("client.close()\n")
    assert owner.returncode == 0


def test_two_servers_do_not_meet(pliantd):
    with pliant.start_local(pliantd) as one, pliant.start_local(pliantd) as other:
        assert one.address != other.address


def test_says_why_it_did_not_start(tmp_path, monkeypatch):
    dies = script(tmp_path / "dies", "import sys\nsys.exit('no room left')\n")
    with pytest.raises(pliant.Unavailable, match="status 1.*no room left"):
        pliant.start_local(dies)
    silent = script(tmp_path / "silent", "import signal\nsignal.sigwait([signal.SIGTERM])\n")
    with pytest.raises(pliant.Unavailable, match="did not listen within 0.2 s"):
        pliant.start_local(silent, timeout_s=0.2)
    monkeypatch.setenv("PLIANTD", str(tmp_path / "missing"))
    with pytest.raises(pliant.Unavailable, match="missing is no program"):
        pliant.start_local()


def test_finds_the_program(tmp_path, monkeypatch):
    monkeypatch.delenv("PLIANTD", raising=False)
    package = tmp_path / "prefix" / "lib" / "python3" / "dist-packages" / "pliant"
    package.mkdir(parents=True)
    monkeypatch.setattr(local, "__file__", str(package / "local.py"))
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(pliant.Unavailable, match="set the environment variable PLIANTD"):
        local.find_pliantd()
    on_path = script(tmp_path / "pliantd", "")
    assert local.find_pliantd() == on_path
    (tmp_path / "prefix" / "bin").mkdir()
    beside = script(tmp_path / "prefix" / "bin" / "pliantd", "")
    assert local.find_pliantd() == beside
    named = script(tmp_path / "named", "")
    monkeypatch.setenv("PLIANTD", named)
    assert local.find_pliantd() == named
    assert local.find_pliantd(on_path) == on_path
