"""gRPC calls that an interrupt cannot break.

grpcio takes locks in the thread that makes a call or reads an answer, some of them for the whole
channel. Ctrl-C raises KeyboardInterrupt between any two steps of the main thread; where that is
between taking such a lock and entering its `with` block, the lock is never given back, and every
call on the channel hangs from then on. So calls are made and read in threads of their own, and the
caller waits at a SimpleQueue, which is safe to be interrupted at.
"""

# Not threading.Thread: its start() waits at a lock of the kind that is to be avoided.
import _thread
import queue
import time

import grpc

from pliant import errors

# Messages that are read ahead of their reader.
_AHEAD_COUNT = 4
# A signal that comes just before the main thread falls asleep does not wake it, so it looks often.
_LOOK_S = 0.1


def call(method, request, **options):
    """A call with one answer. Raises an Error instead of a grpc.RpcError.

    A call that the caller leaves by an exception is cancelled.
    """
    answers, running, is_left = queue.SimpleQueue(), [], []

    def work():
        try:
            running.append(method.future(request, **options))
            if is_left:
                running[0].cancel()
            answers.put((running[0].result(), None))
        except BaseException as error:  # pylint: disable=broad-except
            answers.put((None, _error_of(error)))

    _thread.start_new_thread(work, ())
    try:
        answer, error = _get(answers, None)
    except BaseException:
        is_left.append(True)
        _thread.start_new_thread(_cancel_all, (running,))
        raise
    if error is not None:
        raise error
    return answer


class Receiver:
    """The answers of a streaming call.

    Args:
        start: a function that makes the call and returns what grpc calls it by.

    After an exception out of `next` other than StopIteration it should be cancelled. If it is
    dropped, the call is cancelled.
    """

    def __init__(self, start):
        self._messages = queue.SimpleQueue()
        # What the thread may still read ahead; None ends it.
        self._permits = queue.SimpleQueue()
        self._running, self._is_left = [], []
        for _ in range(_AHEAD_COUNT):
            self._permits.put(True)
        # Static: a thread that referred to this object would keep it for ever.
        _thread.start_new_thread(_read, (start, self._running, self._is_left, self._permits,
                                         self._messages))

    def next(self, timeout_s=None):
        """The next message.

        Raises:
            StopIteration: the call has ended well.
            Error: it has ended otherwise.
            TimeoutError: nothing came within `timeout_s`; wait again if you like.
        """
        message, error = _get(self._messages, timeout_s)
        if error is None:
            self._permits.put(True)
            return message
        self._messages.put((None, error))
        raise error

    def cancel(self):
        """Ends the call at once, whatever it is doing. Again: does nothing."""
        if self._is_left:
            return
        self._is_left.append(True)
        self._permits.put(None)
        _thread.start_new_thread(_cancel_all, (self._running,))

    def __del__(self):
        try:
            self.cancel()
        except (AttributeError, RuntimeError, TypeError):
            pass  # The interpreter is ending, and everything with it.


def _get(source, timeout_s):
    deadline = None if timeout_s is None else time.monotonic() + timeout_s
    while True:
        left_s = _LOOK_S if deadline is None else deadline - time.monotonic()
        try:
            return source.get(timeout=min(_LOOK_S, max(0, left_s)))
        except queue.Empty:
            if left_s <= 0:
                raise TimeoutError from None


def _read(start, running, is_left, permits, messages):
    try:
        running.append(start())
        if is_left:
            running[0].cancel()
        while permits.get():
            messages.put((next(running[0]), None))
    except BaseException as error:  # pylint: disable=broad-except
        messages.put((None, _error_of(error)))


def _error_of(error):
    # To be called here, not by the reader: it takes a lock of the call.
    return errors.from_rpc(error) if isinstance(error, grpc.RpcError) else error


def _cancel_all(running):
    for one in running:
        one.cancel()
