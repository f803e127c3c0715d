"""The editor of one session: a stream that is made again when it is lost, and what is staged.

Used by `Session` under its lock; nothing here is public.
"""

import contextlib
import time
from typing import List, Optional

from pliant import backoff, diff, errors, replica, stream
from pliant.v1 import edit_pb2

# How long a session may still be busy with an editor that has just gone, and with the connection
# that this client has just lost, which the server may notice later than the client.
_BUSY_S_FIRST, _BUSY_S_AGAIN = 0.5, 5.0
# Commands after which nothing is staged.
_ENDS_OF_STEPS = ("advance", "rollback", "discard")
# Time for a server that is there to answer.
_WAIT_S_MIN = 1.0


class _FromCallback(BaseException):
    """An Error that a callback has raised, which says nothing of the stream."""


def _told_apart(callback):
    """The callback, whose Errors are none of the stream; None stays None."""
    def call(*arguments):
        try:
            callback(*arguments)
        except errors.Error as error:
            raise _FromCallback(error) from None

    return callback and call


class Editor:
    """Runs commands, and keeps the copy `mirror` and the list `changes` up to date meanwhile."""

    def __init__(self, stub, session_id, parts, reconnect_s):
        self._stub = stub
        self._session_id = session_id
        self._parts = parts
        self._reconnect_s = reconnect_s
        self.mirror = replica.Replica()
        self.changes: List[replica.Change] = []
        self._stream: Optional[stream.EditStream] = None
        self._was_open = False
        # What an editor that is gone, or a call that was broken off, has staged is nobody's wish.
        self._must_discard = True
        self._last_update_id = 0
        # The last update that earlier calls have staged; 0: the stage is empty.
        self._staged_id = 0
        # For `cancel`, which any thread may call: whether there is something to cancel, whether
        # that is asked, and the advance that runs (0: none, or not yet).
        self._may_cancel = self.is_cancelled = False
        self._advance_id = 0
        self._is_running = False

    @contextlib.contextmanager
    def cancellable(self):
        """While it lasts, `cancel` ends the advances that run in it."""
        self.check_free()
        self.is_cancelled, self._may_cancel = False, True
        try:
            yield
        finally:
            self._may_cancel, self._advance_id = False, 0

    def cancel(self):
        """Ends the advance that runs, or is about to. From any thread, without any lock: see
        calls.py. Who sends the advance looks at `is_cancelled` after it."""
        if not self._may_cancel:
            return
        self.is_cancelled = True
        update_id, running = self._advance_id, self._stream
        if update_id and running is not None:
            running.cancel_advance(update_id)

    def run(self, commands, on_progress=None, on_change=None):
        """Answers to (name, function that makes the message) pairs, after `connect`."""
        try:
            self._is_running = True
            return self._run(commands, _told_apart(on_progress), _told_apart(on_change))
        except _FromCallback as raised:
            raise raised.args[0] from None
        finally:
            self._is_running = False

    def check_free(self):
        """Refuses what a callback of a call that runs must not do."""
        if self._is_running:
            raise errors.FailedPrecondition(
                "PROTOCOL_ORDER", "a call of this session runs, and this is one of its callbacks: "
                "`cancel` and looking at things are possible here; do the rest when it returns")

    def _run(self, commands, on_progress, on_change):
        told_count = len(self.changes)

        def tell():
            nonlocal told_count
            while told_count < len(self.changes):
                told_count += 1
                on_change(self.changes[told_count - 1])

        first = self._last_update_id + 1
        numbered = [(first + i, *command) for i, command in enumerate(commands)]
        self._advance_id = numbered[-1][0] if numbered[-1][1] == "advance" else 0
        self._last_update_id += len(numbered)
        self._must_discard = True
        # Updates that wait for a later advance: what becomes of them must be known.
        only_stages = numbered[-1][1] not in _ENDS_OF_STEPS
        outage = backoff.Outage(self._reconnect_s)
        while True:
            start = time.monotonic()
            try:
                answers = self._run_once(numbered, on_progress, on_change and tell)
                break
            except errors.Unavailable as error:
                # A server that commands kill again and again is given up; one that is lost long
                # after the last time is not.
                if time.monotonic() - start > self._reconnect_s:
                    outage = backoff.Outage(self._reconnect_s)
                outage.pause(error)
                # Commands that the server has seen are answered again, not applied again.
                self._open_stream(outage, only_stages)
        self._must_discard = False
        self._staged_id = numbered[-1][0] if answers[-1].accepted.staged_count else 0
        if on_change is not None:
            tell()  # What came when the stream was made again.
        return answers

    def connect(self):
        """Makes the stream if there is none, and empties the stage where that is nobody's wish."""
        if self._must_discard:
            self._staged_id = 0
        outage = backoff.Outage(self._reconnect_s)
        while self._stream is None:
            opened = self._open_stream(outage, self._staged_id > 0)
            if not self._must_discard or not opened.staged_count:
                continue
            self._last_update_id += 1
            try:
                self._run_once([(self._last_update_id, "discard", lambda _: edit_pb2.Discard())])
            except errors.Unavailable as error:
                outage.pause(error)
        self._must_discard = False

    def close(self):
        """Lets go of the session."""
        self.check_free()
        if self._stream is not None:
            self._stream.close()
            self._stream = None

    def _run_once(self, numbered, on_progress=None, on_change=None):
        on_wire = on_progress and (lambda message: on_progress(diff.progress_from_wire(message)))
        try:
            return self._stream.run(numbered, on_wire, on_change, self._cancel_if_asked)
        except errors.Error:
            self._stream.cancel()
            self._stream = None
            raise
        except BaseException:
            # KeyboardInterrupt, or from on_progress: nobody waits for what was sent any more, and
            # answers to it would be taken for later ones.
            broken, self._stream = self._stream, None
            broken.close()
            raise

    def _cancel_if_asked(self):
        # The number in the way of a thread that came too early for it, or for this stream.
        if self.is_cancelled and self._advance_id:
            self._stream.cancel_advance(self._advance_id)

    def _open_stream(self, outage, has_half_a_step):
        """A stream at last, unless the outage ends before; returns its `Opened`."""
        busy = backoff.Outage(_BUSY_S_AGAIN if self._was_open else _BUSY_S_FIRST)
        while self._stream is None:
            # Waiting makes gRPC look for the server; else it would notice within 5 s only.
            wait_s = max(_WAIT_S_MIN, outage.left_s()) if self._was_open else None
            try:
                self._stream = stream.EditStream(self._stub, self._session_id, self.mirror,
                                                 self.changes, self._parts, wait_s)
            except errors.SessionBusy as error:
                busy.pause(error)
            except errors.Unavailable as error:
                if not self._was_open:
                    raise
                outage.pause(error)
        self._was_open = True
        opened = self._stream.opened
        # Numbers after ours: another editor has had what is staged, and may have committed it in
        # its own revision, or thrown it away.
        is_overtaken = opened.last_update_id > self._last_update_id
        self._last_update_id = max(self._last_update_id, opened.last_update_id)
        is_lost = opened.last_update_id < self._staged_id  # A session not on disk at once.
        if is_lost or (is_overtaken and has_half_a_step):
            # The rest would be half of a step.
            self._stream.cancel()
            self._stream, self._staged_id, self._must_discard = None, 0, True
            raise errors.FailedPrecondition(
                "UPDATE_REJECTED", "what was staged was lost together with the connection, or "
                "another editor has taken it; stage it again")
        return opened
