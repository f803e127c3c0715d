"""What comes in chunks, with a last message that names them: meshes and files."""

from pliant import arrays, calls, replica


def messages(start):
    """Yields (message, blobs) for each message of a download that is not a chunk.

    Args:
        start: as for `calls.Receiver`.
    """
    receiver, blobs = calls.Receiver(start), arrays.BlobReceiver()
    try:
        while True:
            try:
                response = receiver.next()
            except StopIteration:
                return
            if response.WhichOneof("message") == "chunk":
                blobs.add(response.chunk)
            else:
                yield response, blobs
    finally:
        receiver.cancel()


def mesh(start) -> replica.MeshView:
    """The mesh that a download has as its snapshot."""
    fresh = replica.Replica()
    for response, blobs in messages(start):
        fresh.apply(replica.change_from_wire(response.snapshot, blobs, is_snapshot=True))
    return fresh.view()
