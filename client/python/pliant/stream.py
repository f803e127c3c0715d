"""The edit stream of one session: requests go out, answers come in, the replica follows.

Used by `Session` under its lock; nothing here is public.
"""

import queue
import time

import grpc

from pliant import arrays, calls, errors, replica
from pliant.v1 import edit_pb2

# How long the server may take to end a stream that the client has closed.
_CLOSE_S_MAX = 2.0


class EditStream:
    """One call of Edit, on a session whose copy is `mirror`; after an exception it is of no use.

    Every change that comes is applied to `mirror` and appended to the list `changes`.

    Args:
        wait_s: so long a server is waited for that is out of reach, or mute. None: not at all if it
            is out of reach, and for ever if it is mute.
    """

    def __init__(self, stub, session_id, mirror, changes, parts=(), wait_s=None):
        self._mirror = mirror
        self._changes = changes
        self._sender = arrays.BlobSender()
        self._blobs = arrays.BlobReceiver()
        self._closing = None
        self._unanswered = []
        self._requests = queue.SimpleQueue()
        requests = iter(self._requests.get, None)
        self._call = calls.Receiver(
            lambda: stub.Edit(requests, wait_for_ready=wait_s is not None))
        self._requests.put(edit_pb2.EditRequest(open=edit_pb2.OpenEdit(
            session_id=session_id, mirror_revision=mirror.revision, parts=parts)))
        try:
            response = self._receive(wait_s)
            self.opened = response.opened
            while mirror.revision < response.revision:
                self._receive()
        except BaseException:
            self.cancel()
            raise

    def run(self, commands, on_progress=None, on_change=None, on_sent=None):
        """Sends `commands` and returns the answer to each, in order.

        Args:
            commands: (update_id, name of the command, function of a BlobSender that makes it).
            on_progress: called with each Progress message that comes meanwhile.
            on_change: called without arguments after each change.
            on_sent: called without arguments when all is on its way.
        """
        self._unanswered = [update_id for update_id, _, _ in commands]
        for update_id, name, make in commands:
            request = edit_pb2.EditRequest(update_id=update_id, **{name: make(self._sender)})
            for chunk in self._sender.take_chunks():
                self._requests.put(edit_pb2.EditRequest(chunk=chunk))
            self._requests.put(request)
        if on_sent is not None:
            on_sent()
        answers = {}
        while self._unanswered:
            response = self._receive()
            if response.WhichOneof("event") == "progress" and on_progress is not None:
                on_progress(response.progress)
            if response.WhichOneof("event") in ("diff", "snapshot") and on_change is not None:
                on_change()
            if (response.WhichOneof("event") in ("accepted", "rejected", "advanced")
                    and response.update_id in self._unanswered):
                answers[response.update_id] = response
                self._unanswered.remove(response.update_id)
        return [answers[update_id] for update_id, _, _ in commands]

    def _receive(self, timeout_s=None):
        """The next message that is neither a chunk nor a farewell; diffs are applied."""
        while True:
            try:
                response = self._call.next(timeout_s)
            except TimeoutError:
                raise errors.Unavailable("UNAVAILABLE", "the server does not answer") from None
            except StopIteration:
                raise self._closing or errors.Unavailable(
                    "UNAVAILABLE", "the server ended the stream") from None
            except errors.Error as error:
                raise self._closing or error from None
            event = response.WhichOneof("event")
            if event == "chunk":
                self._blobs.add(response.chunk)
            elif event == "closing":
                self._closing = errors.from_detail(response.closing.error,
                                                   grpc.StatusCode.UNAVAILABLE)
            elif event in ("diff", "snapshot"):
                change = replica.change_from_wire(getattr(response, event), self._blobs,
                                                  is_snapshot=event == "snapshot")
                self._mirror.apply(change)
                self._changes.append(change)
                return response
            else:
                return response

    def cancel_advance(self, update_id):
        """Asks for the end of an advance, which is answered all the same. From any thread."""
        self._requests.put(edit_pb2.EditRequest(
            cancel=edit_pb2.Cancel(advance_update_id=update_id)))

    def close(self):
        """Ends the call and waits until the server has let go of the session.

        What has no answer is cancelled: a loop that runs stops, and commits what it has.
        """
        for update_id in self._unanswered:
            self.cancel_advance(update_id)
        self._requests.put(None)
        deadline = time.monotonic() + _CLOSE_S_MAX
        try:
            while True:
                self._call.next(max(0, deadline - time.monotonic()))
        except (StopIteration, TimeoutError, errors.Error):
            pass
        finally:
            self._call.cancel()

    def cancel(self):
        """Ends the call at once, whatever it is doing."""
        self._requests.put(None)
        self._call.cancel()

    def __del__(self):
        # gRPC's thread that waits for requests would live for ever.
        self._requests.put(None)
