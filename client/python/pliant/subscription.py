"""Following a session that somebody else edits."""

import random
import time
from typing import Iterator, Optional

from pliant import arrays, calls, errors, replica
from pliant.v1 import session_pb2

# Pauses before connecting again grow from the first to the last.
_PAUSE_S_FIRST, _PAUSE_S_LAST = 0.02, 2.0


def pauses() -> Iterator[float]:
    """Seconds to wait before each further try: doubled each time, and spread at random, so that
    clients that lost one server do not come back all at once."""
    pause_s = _PAUSE_S_FIRST
    while True:
        yield pause_s * random.uniform(0.5, 1)
        pause_s = min(2 * pause_s, _PAUSE_S_LAST)


class Subscription:
    """A verified copy of a session's mesh that is kept up to date; made by `Client.subscribe`.

    Iterating brings every change, already applied to `mesh`, and waits for the next one:

        for change in client.subscribe("wing"):
            draw(subscription.mesh)

    Who reads more slowly than the session changes gets what was missed as one change, or the whole
    mesh (`base_revision` 0): the server holds nothing more for it. A lost connection is taken up
    again, with growing pauses, for `reconnect_s` seconds.

    Threads: one at a time; `close` from any.
    """

    def __init__(self, stub, request: session_pb2.SubscribeRequest, reconnect_s: float):
        self._stub = stub
        self._wanted = request
        self._reconnect_s = reconnect_s
        self._mirror = replica.Replica()
        self._is_closed = False
        self._connect()

    @property
    def revision(self) -> int:
        """Revision of `mesh`; 0: no mesh yet."""
        return self._mirror.revision

    @property
    def mesh(self) -> replica.MeshView:
        """The mesh of the last change, numbered 0..n-1; the same object until the next."""
        if self._mirror.revision == 0:
            raise errors.FailedPrecondition("REVISION_NOT_FOUND",
                                            "no mesh has come yet; wait for a change")
        return self._mirror.view()

    def next(self, timeout_s: Optional[float] = None) -> Optional[replica.Change]:
        """The next change, applied to `mesh`; None if none comes within `timeout_s`.

        Raises:
            NotFound: the session has been deleted.
            Unavailable: the connection was lost and did not come back.
        """
        deadline = None if timeout_s is None else time.monotonic() + timeout_s
        while True:
            left_s = None if deadline is None else max(0, deadline - time.monotonic())
            try:
                response = self._answers.next(left_s)
            except TimeoutError:
                return None
            except (StopIteration, errors.Unavailable, errors.Cancelled) as error:
                self._reconnect(error)
                continue
            change = self._take(response)
            if change is not None:
                return change

    def close(self) -> None:
        """Ends the subscription. Again: does nothing."""
        self._is_closed = True
        self._answers.cancel()

    def __iter__(self):
        return self

    def __next__(self) -> replica.Change:
        if self._is_closed:
            raise StopIteration
        return self.next()

    def __enter__(self) -> "Subscription":
        return self

    def __exit__(self, *exception) -> None:
        self.close()

    def _connect(self):
        request = session_pb2.SubscribeRequest()
        request.CopyFrom(self._wanted)
        request.mirror_revision = self._mirror.revision
        subscribe = self._stub.Subscribe
        self._blobs = arrays.BlobReceiver()
        self._answers = calls.Receiver(lambda: subscribe(request))

    def _reconnect(self, error):
        if self._is_closed:
            raise StopIteration from None
        deadline = time.monotonic() + self._reconnect_s
        for pause_s in pauses():
            if time.monotonic() + pause_s > deadline:
                raise error if isinstance(error, errors.Error) else errors.Unavailable(
                    "UNAVAILABLE", "the server ended the subscription")
            time.sleep(pause_s)
            self._connect()
            try:
                # The first message comes at once, whatever the session does.
                response = self._answers.next(max(0.1, deadline - time.monotonic()))
            except (StopIteration, TimeoutError, errors.Unavailable):
                continue
            self._answers.put_back(response)
            return

    def _take(self, response):
        event = response.WhichOneof("event")
        if event == "chunk":
            self._blobs.add(response.chunk)
            return None
        if event not in ("diff", "snapshot"):
            return None
        change = replica.change_from_wire(getattr(response, event), self._blobs,
                                          is_snapshot=event == "snapshot")
        try:
            self._mirror.apply(change)
        except errors.ReplicaMismatch:
            # The copy is empty now, and what follows would not fit: the whole mesh comes.
            self._answers.cancel()
            self._connect()
            raise
        return change
