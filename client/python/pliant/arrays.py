"""Arguments to arrays, and arrays to and from the wire.

The wire carries little-endian bytes with a type and a shape. `as_floats` and `as_integers` check
an argument once; `BlobSender` and `BlobReceiver` split and join what is too large for one message.
"""

import sys

import numpy as np

from pliant.errors import Error, InvalidInput, first_row
from pliant.v1 import array_pb2

# Limits of the protocol (proto/README.md, "Arrays").
INLINE_BYTES_MAX = 64 * 1024
CHUNK_BYTES_MAX = 512 * 1024

_DTYPES = {
    array_pb2.DTYPE_FLOAT64: np.dtype("<f8"),
    array_pb2.DTYPE_INT32: np.dtype("<i4"),
    array_pb2.DTYPE_INT64: np.dtype("<i8"),
    array_pb2.DTYPE_FLOAT32: np.dtype("<f4"),
    array_pb2.DTYPE_UINT8: np.dtype("u1"),
}
_WIRE_DTYPES = {dtype: wire for wire, dtype in _DTYPES.items()}


def as_floats(field, value, column_count):
    """`value` as a C-contiguous little-endian float64 array of shape (n, column_count).

    Accepts whatever NumPy converts without loss. Raises InvalidInput that names `field`.
    """
    given = _as_array(field, value)
    _check_shape(field, given, column_count)
    if given.dtype.kind not in "iuf" and given.size:
        raise InvalidInput("ARRAY_TYPE", f"{field} must hold numbers that fit float64; "
                           f"got dtype {given.dtype}", field=field)
    return _convert(field, given.reshape(_shape(given, column_count)), "<f8")


def as_integers(field, value, column_count=None):
    """`value` as a C-contiguous little-endian int32 array of shape (n,) or (n, column_count).

    Accepts whatever NumPy converts without loss, floats with whole values included; masks of bool
    are refused, because a mask in place of indices is a mistake. Raises InvalidInput.
    """
    given = _as_array(field, value)
    _check_shape(field, given, column_count)
    if given.dtype.kind not in "iuf" and given.size:
        hint = "; np.flatnonzero turns a mask into indices" if given.dtype.kind == "b" else ""
        raise InvalidInput("ARRAY_TYPE", f"{field} must hold whole numbers that fit int32; "
                           f"got dtype {given.dtype}{hint}", field=field)
    return _convert(field, given.reshape(_shape(given, column_count)), "<i4")


def check_rows(field, array, row_count, what):
    """Raises InvalidInput unless `array` has one row for each of `row_count` things."""
    if len(array) != row_count:
        raise InvalidInput("ARRAY_LENGTH", f"{field} has {len(array)} rows; expected {row_count}, "
                           f"one for each {what}", field=field)


def _as_array(field, value):
    if value is None:
        raise InvalidInput("EMPTY", f"{field} is required", field=field)
    try:
        return np.asarray(value)
    except ValueError as error:
        raise InvalidInput("ARRAY_LENGTH", f"{field} is no regular array: {error}",
                           field=field) from None


def _shape(given, column_count):
    """The wanted shape; an empty list has no columns that could be wrong."""
    return (len(given),) if column_count is None else (len(given), column_count)


def _check_shape(field, given, column_count):
    expected = "(n,)" if column_count is None else f"(n, {column_count})"
    is_empty = given.ndim >= 1 and given.shape[0] == 0
    fits = given.ndim == 1 if column_count is None else (
        given.ndim == 2 and given.shape[1] == column_count)
    if not fits and not (is_empty and given.ndim <= 2):
        raise InvalidInput("ARRAY_LENGTH", f"{field} must have shape {expected}; "
                           f"got {given.shape}", field=field)


def _convert(field, given, dtype):
    with np.errstate(all="ignore"):
        converted = np.ascontiguousarray(given, dtype=dtype)
        if np.can_cast(given.dtype, dtype, "safe") and given.dtype.kind == converted.dtype.kind:
            return converted
        back = converted.astype(given.dtype)
    lost = (back != given) & (given == given)
    if converted.dtype.kind == "i":
        lost |= given != given
    if lost.any():
        row = first_row(lost)
        raise InvalidInput("ARRAY_TYPE", f"{field}[{row}] = {given[row].tolist()} cannot be "
                           f"represented as {np.dtype(dtype).name}", field=field, index=row)
    return converted


class BlobSender:
    """Turns arrays into wire arrays for one stream, and keeps the chunks that must go ahead."""

    def __init__(self):
        self._blob_id = 0
        self._chunks = []

    def array(self, values):
        """The wire form of `values`; None stays None (an absent array)."""
        if values is None:
            return None
        message = array_pb2.Array(dtype=_WIRE_DTYPES[values.dtype], shape=values.shape)
        if values.nbytes <= INLINE_BYTES_MAX:
            message.data = values.tobytes()
            return message
        self._blob_id += 1
        message.blob_id = self._blob_id
        raw = memoryview(values).cast("B")
        for offset in range(0, values.nbytes, CHUNK_BYTES_MAX):
            self._chunks.append(array_pb2.BlobChunk(
                blob_id=self._blob_id, total_bytes=values.nbytes, offset_bytes=offset,
                data=bytes(raw[offset:offset + CHUNK_BYTES_MAX])))
        return message

    def take_chunks(self):
        """The chunks of the arrays made since the last call; they go before their message."""
        chunks, self._chunks = self._chunks, []
        return chunks


class BlobReceiver:
    """Joins the chunks of one stream and looks up the arrays that name them."""

    def __init__(self):
        self._blobs = {}
        self._filled_bytes = {}

    def add(self, chunk):
        """Takes one chunk. Raises Error, code PROTOCOL_ORDER, if it does not continue its blob."""
        filled = self._filled_bytes.get(chunk.blob_id, 0)
        blob = self._blobs.get(chunk.blob_id)
        if blob is None:
            blob = self._blobs[chunk.blob_id] = bytearray(chunk.total_bytes)
        end = filled + len(chunk.data)
        if chunk.offset_bytes != filled or end > len(blob):
            raise broken(f"chunk of blob {chunk.blob_id} at byte {chunk.offset_bytes}, "
                          f"expected {filled} of {len(blob)}")
        blob[filled:end] = chunk.data
        self._filled_bytes[chunk.blob_id] = end

    def array(self, message, name, dtype, column_count=None):
        """The array `message` as a read-only NumPy view of the received bytes, without a copy.

        An absent array is one without rows. Raises Error if type, shape and bytes disagree.
        """
        dtype = np.dtype(dtype)
        tail = () if column_count is None else (column_count,)
        if message.WhichOneof("storage") is None and not message.shape:
            return np.empty((0,) + tail, dtype)
        raw = self._bytes(message, name)
        shape = tuple(message.shape)
        row_bytes = dtype.itemsize * (column_count or 1)
        if (_DTYPES.get(message.dtype) != dtype or shape[1:] != tail
                or shape[0] * row_bytes != len(raw)):
            raise broken(f"array {name} has dtype {message.dtype}, shape {shape} and "
                          f"{len(raw)} bytes; expected {dtype} with rows of {row_bytes} bytes")
        values = np.frombuffer(raw, dtype).reshape(shape)
        values.flags.writeable = False
        return values

    def _bytes(self, message, name):
        if message.WhichOneof("storage") != "blob_id":
            return message.data
        blob = self._blobs.pop(message.blob_id, None)
        filled = self._filled_bytes.pop(message.blob_id, 0)
        if blob is None or filled != len(blob):
            raise broken(f"array {name} names blob {message.blob_id}, which is not complete")
        return blob


def broken(message):
    """The Error for a server that says what it may not."""
    return Error("PROTOCOL_ORDER", f"{message}; the server does not keep to the protocol")


if sys.byteorder != "little":
    raise ImportError("pliant needs a little-endian machine")
