"""What can go wrong, as exceptions.

Every exception of the package is an `Error`. It carries the precise cause as `code`, e.g.
"CROSSING_SEGMENTS" (proto/README.md lists them all), and names the offending input by `field` and
`index` in the caller's own numbering. The class tells the kind, for `except` clauses.
"""

import grpc
import numpy as np

from pliant.v1 import errors_pb2


class Error(Exception):
    """Something was refused or failed.

    Attributes:
        code: the precise cause, e.g. "CROSSING_SEGMENTS". Names never change; new ones may come.
        message: what was wrong, where, what was expected, what to do; for people.
        field: the offending argument, e.g. "domain.segments"; "" if there is none.
        index: first offending row of that argument, or position in an expression; where `field` is
            "vertices", "edges" or "triangles", the slot of such an element; -1 if none.
        other_index: the second row where two clash (the other crossing segment); -1 if none.
        reference: for bugs of the server (code INTERNAL), what to quote in a report; else "".
        retry_after_ms: when trying again makes sense, in ms from now; 0 if that is not known.
    """

    def __init__(self, code, message, *, field="", index=-1, other_index=-1, reference="",
                 retry_after_ms=0):
        self.code = code
        self.message = message
        self.field = field
        self.index = index
        self.other_index = other_index
        self.reference = reference
        self.retry_after_ms = retry_after_ms
        super().__init__(message)

    def __str__(self):
        where = self.field if self.index < 0 else f"{self.field}[{self.index}]"
        parts = [self.code, where, self.message, self.reference and f"reference {self.reference}"]
        return ": ".join(part for part in parts if part)

    def __reduce__(self):
        # The default would call __init__ with the message alone, and a pool of workers would hang.
        return _restore, (type(self), vars(self))


class InvalidInput(Error, ValueError):
    """An argument is wrong: `field` and `index` say which and where. The session is unchanged."""


class NotFound(Error, LookupError):
    """There is no such session, revision or job."""


class AlreadyExists(Error):
    """The wished id of a session or job is taken."""


class FailedPrecondition(Error):
    """The call does not fit the state of session or job, e.g. REVISION_MISMATCH, JOB_NOT_DONE."""


class SessionBusy(Error):
    """Somebody else edits the session."""


class ResourceExhausted(Error):
    """A limit of the server was reached."""


class Cancelled(Error):
    """The call was cancelled."""


class DeadlineExceeded(Error, TimeoutError):
    """The call took longer than allowed."""


class Unavailable(Error, ConnectionError):
    """The server cannot be reached, or went away."""


class Unauthenticated(Error, PermissionError):
    """The server wants a token, or does not know the one that was given."""


class Unimplemented(Error, NotImplementedError):
    """This version of the server does not have that yet; proto/README.md lists what is missing."""


class ReplicaMismatch(Error):
    """The local copy of the mesh differs from the server's; the next call downloads it afresh."""


class DataCorrupt(Error):
    """Bytes are not what was written: a damaged file, or what the server has stored."""


class Internal(Error):
    """A bug of the server; `reference` identifies it in the server's log."""


_CLASSES = {
    grpc.StatusCode.INVALID_ARGUMENT: InvalidInput,
    grpc.StatusCode.OUT_OF_RANGE: InvalidInput,
    grpc.StatusCode.NOT_FOUND: NotFound,
    grpc.StatusCode.ALREADY_EXISTS: AlreadyExists,
    grpc.StatusCode.FAILED_PRECONDITION: FailedPrecondition,
    grpc.StatusCode.ABORTED: SessionBusy,
    grpc.StatusCode.RESOURCE_EXHAUSTED: ResourceExhausted,
    grpc.StatusCode.CANCELLED: Cancelled,
    grpc.StatusCode.DEADLINE_EXCEEDED: DeadlineExceeded,
    grpc.StatusCode.UNAUTHENTICATED: Unauthenticated,
    grpc.StatusCode.UNAVAILABLE: Unavailable,
    grpc.StatusCode.UNIMPLEMENTED: Unimplemented,
    grpc.StatusCode.DATA_LOSS: ReplicaMismatch,
    grpc.StatusCode.INTERNAL: Internal,
}
# What grpcio says of calls that this process has cancelled. It is also gRPC's word for calls that
# reach a server while it shuts down.
_CANCELLED_HERE = ("Locally cancelled by application!", "Channel closed!",
                   "Channel closed due to fork")
_STATUS_OF_NUMBER = {status.value[0]: status for status in grpc.StatusCode}


def from_detail(detail, status=None):
    """The exception for an `ErrorDetail` message; `status` where the detail has no code."""
    status = _STATUS_OF_NUMBER.get(detail.code) if detail.code else status
    kind = DataCorrupt if detail.reason == "DATA_CORRUPT" else _CLASSES.get(status, Error)
    return kind(
        detail.reason or (status.name if status else "UNKNOWN"), detail.message,
        field=detail.field, index=detail.index, other_index=detail.other_index,
        reference=detail.reference, retry_after_ms=detail.retry_after_ms)


def from_rpc(rpc_error):
    """The exception for a call that ended with a gRPC status."""
    status = rpc_error.code()
    for key, value in rpc_error.trailing_metadata() or ():
        if key != "grpc-status-details-bin":
            continue
        details = errors_pb2.ErrorStatus.FromString(value).details
        for packed in details:
            detail = errors_pb2.ErrorDetail()
            if packed.Unpack(detail):
                return from_detail(detail, status)
    message = rpc_error.details() or "no details"
    if status == grpc.StatusCode.CANCELLED and message not in _CANCELLED_HERE:
        return Unavailable("UNAVAILABLE", "the server shuts down; connect again later")
    return _CLASSES.get(status, Error)(status.name, message)


def _restore(cls, attributes):
    attributes = dict(attributes)
    return cls(attributes.pop("code"), attributes.pop("message"), **attributes)


def first_row(mask):
    """Index of the first row of `mask` that is true or holds something true; -1 if none."""
    rows = np.flatnonzero(mask if mask.ndim == 1 else mask.any(axis=1))
    return int(rows[0]) if len(rows) else -1
