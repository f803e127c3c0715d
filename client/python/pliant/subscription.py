"""Following a session that somebody else edits."""

import math
import time
from typing import Optional, Tuple

from pliant import arrays, backoff, calls, errors, replica
from pliant.v1 import session_pb2

# While it waits to connect again, so often it looks whether it was closed.
_LOOK_S = 0.1


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
        self._absent_region_tags: Tuple[int, ...] = ()
        self._is_closed = False
        # While the connection is lost: its outage, and when to connect again.
        self._outage, self._next_try = backoff.Outage(reconnect_s), 0.0
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

    @property
    def absent_region_tags(self) -> Tuple[int, ...]:
        """Those of the `region_tags` asked for that no triangle had at the last change: not there
        yet, any more, or at all. If it names all of them, `mesh` is empty."""
        return self._absent_region_tags

    def next(self, timeout_s: Optional[float] = None) -> Optional[replica.Change]:
        """The next change, applied to `mesh`; None if none comes within `timeout_s`.

        Raises:
            NotFound: the session has been deleted.
            Unavailable: the connection was lost and did not come back.
        """
        deadline = None if timeout_s is None else time.monotonic() + timeout_s
        while True:
            try:
                response = self._receive(deadline)
            except TimeoutError:
                return None
            except (StopIteration, errors.Unavailable, errors.Cancelled) as error:
                self._lose(error)
                continue
            change = self._take(response)
            if change is not None:
                return change

    def close(self) -> None:
        """Ends the subscription. Again: does nothing."""
        self._is_closed = True
        answers = self._answers
        if answers is not None:
            answers.cancel()

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
        # Waiting makes gRPC look for a lost server; else it would notice within 5 s only.
        is_again = self._outage.end < math.inf
        self._answers = calls.Receiver(lambda: subscribe(request, wait_for_ready=is_again))
        if self._is_closed:
            self._answers.cancel()

    def _receive(self, deadline):
        """The next message; TimeoutError if none comes before `deadline`."""
        while self._answers is None:
            now = time.monotonic()
            if self._is_closed:
                raise StopIteration
            if now >= self._next_try:
                self._connect()
            elif deadline is not None and now >= deadline:
                raise TimeoutError
            else:
                time.sleep(min(_LOOK_S, self._next_try - now,
                               _LOOK_S if deadline is None else deadline - now))
        # After an outage the first message comes at once, whatever the session does.
        limit = self._outage.end if deadline is None else min(deadline, self._outage.end)
        try:
            response = self._answers.next(
                None if limit == math.inf else max(0, limit - time.monotonic()))
        except TimeoutError:
            if limit == deadline:
                raise
            raise errors.Unavailable("UNAVAILABLE", "the server does not answer") from None
        self._outage = backoff.Outage(self._reconnect_s)
        return response

    def _lose(self, error):
        """Lets the connection go; raises the error if it is not to be taken up again."""
        self._answers = None
        if self._is_closed:
            raise StopIteration from None
        if not isinstance(error, errors.Error):
            error = errors.Unavailable("UNAVAILABLE", "the server ended the subscription")
        try:
            self._next_try = self._outage.next_try(error)
        except errors.Error:
            # Who asks again wants it to be tried again.
            self._outage, self._next_try = backoff.Outage(self._reconnect_s), 0.0
            raise

    def _take(self, response):
        event = response.WhichOneof("event")
        if event == "chunk":
            self._blobs.add(response.chunk)
            return None
        if event not in ("diff", "snapshot"):
            return None
        change = replica.change_from_wire(getattr(response, event), self._blobs,
                                          is_snapshot=event == "snapshot")
        self._absent_region_tags = tuple(response.absent_region_tags)
        try:
            self._mirror.apply(change)
        except errors.ReplicaMismatch:
            # The copy is empty now, and what follows would not fit: the whole mesh comes.
            self._answers.cancel()
            self._connect()
            raise
        return change
