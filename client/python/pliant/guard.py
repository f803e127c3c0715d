"""Runs a program until it ends or the owner is gone. Not to be imported: `LocalServer` runs it.

    guard.py OWNER_PID FOLDER PROGRAM [ARGUMENT...]

The owner is gone when it closes our standard input or when its process ends; the second matters
where a forked child of the owner still holds the other end of the pipe. Then the program gets
SIGTERM, after 2 s SIGKILL, and FOLDER is removed. Should the guard itself be killed, the kernel
ends the program.
"""

import ctypes
import os
import select
import shutil
import signal
import subprocess
import sys

# gRPC lets a server end only when its clients notice, which an idle one does every 5 s. A private
# server has nothing to lose, so it does not wait for that.
_GRACE_S = 2
_PR_SET_PDEATHSIG = 1


def main():
    owner_pid, folder, command = int(sys.argv[1]), sys.argv[2], sys.argv[3:]
    # Ctrl-C on the terminal is for the owner, who decides what it means.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    libc = ctypes.CDLL(None)
    owner, ends = select.poll(), select.poll()
    for poll in (owner, ends):
        poll.register(0, select.POLLIN | select.POLLHUP)
        watch(poll, owner_pid)
    # If the owner died before we could watch it, we are somebody else's child by now.
    if os.getppid() != owner_pid:
        shutil.rmtree(folder, ignore_errors=True)
        return 1
    try:
        # The guard has one thread, so the death signal means the death of the guard.
        program = subprocess.Popen(
            command, stdin=subprocess.DEVNULL,
            preexec_fn=lambda: libc.prctl(_PR_SET_PDEATHSIG, signal.SIGKILL))
    except OSError as error:
        print(error, file=sys.stderr, flush=True)
        return 127
    # Where the kernel has no pidfds we look now and then.
    pause_ms = None if watch(ends, program.pid) is not None else 200
    while not ends.poll(pause_ms) and program.poll() is None:
        pass
    # A program that ends by itself leaves its log for the owner to read.
    owner_is_gone = bool(owner.poll(0))
    status = end(program)
    if owner_is_gone:
        shutil.rmtree(folder, ignore_errors=True)
    return status


def watch(poll, pid):
    """Adds the end of process `pid` to `poll`; None if this kernel cannot."""
    try:
        descriptor = os.pidfd_open(pid)
    except (AttributeError, OSError):
        return None
    poll.register(descriptor, select.POLLIN)
    return descriptor


def end(program):
    """Ends `program` if it still runs; its exit status."""
    if program.poll() is None:
        program.terminate()
        try:
            program.wait(_GRACE_S)
        except subprocess.TimeoutExpired:
            program.kill()
    return program.wait()


if __name__ == "__main__":
    sys.exit(main())
