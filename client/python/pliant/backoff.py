"""When to try again after a connection was lost, and when to give up."""

import math
import random
import time
from typing import Any, Callable, Iterator

from pliant import errors

# Pauses before connecting again grow from the first to the last.
_PAUSE_S_FIRST, _PAUSE_S_LAST = 0.02, 2.0


def persist(bound_s: float, attempt: Callable[[], Any]) -> Any:
    """What `attempt`, a call that does no harm twice, returns: made again while the server is out
    of reach, for `bound_s` seconds at most."""
    outage = Outage(bound_s)
    while True:
        try:
            return attempt()
        except errors.Unavailable as error:
            outage.pause(error)


def pauses() -> Iterator[float]:
    """Seconds to wait before each further try: doubled each time, and spread at random, so that
    clients that lost one server do not come back all at once."""
    pause_s = _PAUSE_S_FIRST
    while True:
        yield pause_s * random.uniform(0.5, 1)
        pause_s = min(2 * pause_s, _PAUSE_S_LAST)


class Outage:
    """Tries for `bound_s` seconds from the first failure on."""

    def __init__(self, bound_s: float):
        self._bound_s = bound_s
        # When to give up, by time.monotonic().
        self.end = math.inf
        self._pauses = pauses()

    def next_try(self, error: Exception) -> float:
        """The time, by time.monotonic(), of the next try after one that failed with `error`,
        which is raised if there is to be none."""
        now = time.monotonic()
        if self.end == math.inf:
            self.end = now + self._bound_s
        at = now + next(self._pauses)
        if at > self.end:
            raise error
        return at

    def pause(self, error: Exception) -> None:
        """Sleeps until the next try, or raises `error`."""
        at = self.next_try(error)
        time.sleep(max(0, at - time.monotonic()))

    def left_s(self) -> float:
        """Seconds until the end; the whole bound if nothing has failed yet."""
        return max(0, min(self._bound_s, self.end - time.monotonic()))
