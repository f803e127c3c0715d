"""A private server for one program."""

import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time
from typing import Any, Optional, Sequence

from pliant import errors
from pliant.client import Client

_GUARD = pathlib.Path(__file__).with_name("guard.py")


def start_local(pliantd: Any = None, *, arguments: Sequence[str] = (),
                timeout_s: float = 20.0) -> Client:
    """Starts a private `pliantd` on a temporary Unix socket and connects to it.

    The server ends with the client (`close`, end of the `with` block), with the interpreter, and
    also when the interpreter is killed.

    Args:
        pliantd: the program. Default: the environment variable PLIANTD, else the build or
            installation that the package is part of, else what PATH has.
        arguments: further arguments of the program.
        timeout_s: how long the server may take to answer.

    Raises:
        Unavailable: the program was not found, or did not start; the message has its last words.
    """
    server = LocalServer(find_pliantd(pliantd), arguments)
    try:
        server.wait_until_ready(timeout_s)
        return Client(server.address, server)
    except BaseException:
        server.stop()
        raise


def find_pliantd(pliantd: Any = None) -> str:
    """Path of the program, as `start_local` says. Raises Unavailable if there is none."""
    wished = pliantd or os.environ.get("PLIANTD")
    if wished:
        found = shutil.which(os.fspath(wished))
        if found is None:
            raise errors.Unavailable("FILE_NOT_FOUND", f"{wished} is no program that can be run",
                                     field="pliantd")
        return found
    package = pathlib.Path(__file__).resolve().parent
    # <build>/python/pliant and <prefix>/lib/python3/dist-packages/pliant both have a bin/ above.
    for folder in list(package.parents)[:5]:
        candidate = folder / "bin" / "pliantd"
        if os.access(candidate, os.X_OK):
            return str(candidate)
    found = shutil.which("pliantd")
    if found is None:
        raise errors.Unavailable(
            "FILE_NOT_FOUND", "pliantd was not found; set the environment variable PLIANTD to its "
            "path, or add its folder to PATH", field="pliantd")
    return found


class LocalServer:
    """A running pliantd and its folder of temporary files.

    The process below us is guard.py, which runs the server and ends it when we are gone.
    """

    def __init__(self, pliantd: str, arguments: Sequence[str]):
        self._folder = tempfile.mkdtemp(prefix="pliant-")
        self._log_path = os.path.join(self._folder, "pliantd.log")
        socket = os.path.join(self._folder, "socket")
        self.address = f"unix:{socket}"
        if not any(argument.startswith("--drain-ms") for argument in arguments):
            # Nobody but us is connected, and we have let go before we end the server.
            arguments = ["--drain-ms", "1000", *arguments]
        with open(self._log_path, "wb") as log:
            # -I -S: the guard needs nothing but the standard library, and starts in 10 ms.
            self._guard: Optional[subprocess.Popen] = subprocess.Popen(
                [sys.executable or "python3", "-I", "-S", str(_GUARD), str(os.getpid()),
                 self._folder, pliantd, "--listen", self.address, *arguments],
                stdin=subprocess.PIPE, stdout=log, stderr=log, start_new_session=True)
        self._socket = socket

    def wait_until_ready(self, timeout_s: float) -> None:
        """Returns once the socket is there. Raises Unavailable if that does not happen."""
        deadline = time.monotonic() + timeout_s
        while not os.path.exists(self._socket):
            status = self._guard.poll()
            if status is not None:
                raise errors.Unavailable(
                    "UNAVAILABLE", f"pliantd ended with status {status}; its last words: "
                    f"{self._last_words()}")
            if time.monotonic() > deadline:
                raise errors.Unavailable(
                    "UNAVAILABLE", f"pliantd did not listen within {timeout_s} s; its last words: "
                    f"{self._last_words()}")
            time.sleep(0.005)

    def stop(self) -> None:
        """Ends the server and waits until it is gone. Again: does nothing."""
        guard, self._guard = self._guard, None
        if guard is None:
            return
        guard.stdin.close()
        guard.wait()
        shutil.rmtree(self._folder, ignore_errors=True)

    def _last_words(self):
        try:
            with open(self._log_path, errors="replace") as log:
                return log.read()[-2000:].strip() or "(none)"
        except OSError:
            return "(none)"
