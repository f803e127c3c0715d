"""A server that plays a script: for what a correct server never does, or rarely.

It moves through given meshes, one for each advance, and can drop the stream at a given point, lie
about its hash, or send its arrays in many chunks. Diffs are made from dictionaries, hashes by the
scalar formula of proto/README.md: neither shares code with the package.
"""

import concurrent.futures
import struct
import threading

import grpc
import numpy as np

from pliant.v1 import array_pb2, edit_pb2, errors_pb2, mesh_pb2, session_pb2, session_pb2_grpc

_MASK = 2**64 - 1


def mix(x):
    x = ((x ^ (x >> 30)) * 0xBF58476D1CE4E5B9) & _MASK
    x = ((x ^ (x >> 27)) * 0x94D049BB133111EB) & _MASK
    return x ^ (x >> 31)


def element_hash(kind, slot, words):
    state = mix((kind << 32) + slot)
    for word in words:
        state = mix((state + 0x9E3779B97F4A7C15 + word) & _MASK)
    return state


class FakeMesh:
    """Slots to contents: vertices (x, y), triangles (a, b, c, tag), edges (a, b, tag)."""

    def __init__(self, vertices, triangles, edges):
        self.vertices, self.triangles, self.edges = vertices, triangles, edges

    def state_hash(self):
        def bits(x):
            return struct.unpack("<Q", struct.pack("<d", x))[0]

        total = sum(element_hash(1, i, map(bits, xy)) for i, xy in self.vertices.items())
        for kind, elements in ((2, self.triangles), (3, self.edges)):
            total += sum(element_hash(kind, i, (value & 0xFFFFFFFF for value in row))
                         for i, row in elements.items())
        return total & _MASK

    def counts(self):
        return mesh_pb2.MeshCounts(vertex_count=len(self.vertices), edge_count=len(self.edges),
                                   triangle_count=len(self.triangles))


def to_array(values, dtype, column_count, chunks, chunk_bytes):
    """A wire array; longer than `chunk_bytes` it goes into `chunks` as a blob."""
    array = np.array(values, dtype).reshape((-1, column_count) if column_count else (-1,))
    wire = array_pb2.Array(dtype={"<f8": 1, "<i4": 2}[dtype], shape=array.shape)
    raw = array.tobytes()
    if len(raw) <= chunk_bytes:
        wire.data = raw
        return wire
    blob_id = 1 + max((chunk.blob_id for chunk in chunks), default=to_array.last_blob_id)
    to_array.last_blob_id = wire.blob_id = blob_id
    for offset in range(0, len(raw), chunk_bytes):
        chunks.append(array_pb2.BlobChunk(blob_id=blob_id, total_bytes=len(raw),
                                          offset_bytes=offset,
                                          data=raw[offset:offset + chunk_bytes]))
    return wire


to_array.last_blob_id = 0


def fill(message, before, after, chunk_bytes):
    """Fills a MeshDiff or MeshSnapshot; returns the chunks that go ahead."""
    chunks = []

    def put(name, values, dtype, column_count=None):
        getattr(message, name).CopyFrom(
            to_array(values, dtype, column_count, chunks, chunk_bytes))

    for kind, plural in (("vertex", "vertices"), ("triangle", "triangles"), ("edge", "edges")):
        old, new = getattr(before, plural), getattr(after, plural)
        if isinstance(message, mesh_pb2.MeshDiff):
            put(f"removed_{plural}", sorted(old.keys() - new.keys()), "<i4")
        ids = sorted(i for i in new if old.get(i) != new[i])
        put(f"{kind}_ids", ids, "<i4")
        if kind == "vertex":
            put("vertex_positions", [new[i] for i in ids], "<f8", 2)
        else:
            width = {"triangle": 3, "edge": 2}[kind]
            put(f"{kind}_vertices", [new[i][:width] for i in ids], "<i4", width)
            put(f"{kind}_tags", [new[i][width] for i in ids], "<i4")
    message.counts.CopyFrom(after.counts())
    message.state_hash = after.state_hash()
    return chunks


NOTHING = FakeMesh({}, {}, {})


class FakeService(session_pb2_grpc.SessionServiceServicer):
    """One session that plays `meshes`. `faults` are taken one for each advance: None, "hash"
    or "count" (the diff lies), "drop before" (the advance is lost), "drop after" (its answer is
    lost, the diff came), "closing" (a server that shuts down: gRPC cancels this stream, and the
    next one at once), an ErrorDetail (the server announces the end of the stream), "forget" (it
    dies, and knows no update when it is back) or "hang" (it runs until the client cancels it or
    leaves)."""

    def __init__(self, meshes, faults=(), chunk_bytes=65536):
        self.meshes = [NOTHING] + list(meshes)
        self.faults = list(faults)
        self.chunk_bytes = chunk_bytes
        self.revision = 0
        self.answers = {}
        self.applied, self.cancelled = [], []
        self.received = {}
        self.deleted = self.is_closing = False
        self.staged_count = self.discard_count = 0
        self.is_hanging = threading.Event()
        self.editor = threading.Lock()

    def CreateSession(self, request_iterator, context):
        blobs = {}
        for request in request_iterator:
            if request.WhichOneof("message") == "chunk":
                blobs.setdefault(request.chunk.blob_id, bytearray()).extend(request.chunk.data)
                assert len(request.chunk.data) <= 512 * 1024
            else:
                assert request.ByteSize() <= 2**20
                self.received = {"create": request.create, "blobs": blobs}
        return session_pb2.CreateSessionResponse(
            session=session_pb2.Session(session_id="fake", revision=self.revision))

    def GetSession(self, request, context):
        return session_pb2.GetSessionResponse()

    def DeleteSession(self, request, context):
        self.deleted = True
        return session_pb2.DeleteSessionResponse(revision=self.revision)

    def Edit(self, request_iterator, context):
        # A client that comes again may be faster than the end of its old call.
        with self.editor:
            yield from self.edit(request_iterator, context)

    def edit(self, request_iterator, context):
        for request in request_iterator:
            command = request.WhichOneof("command")
            if self.is_closing:
                self.is_closing = False
                context.abort(grpc.StatusCode.CANCELLED, "CANCELLED")
            if command == "open":
                yield self.response(opened=edit_pb2.Opened(
                    last_update_id=max(self.answers, default=0), staged_count=self.staged_count))
                yield from self.catch_up(request.open.mirror_revision)
            elif request.update_id in self.answers:
                yield self.answers[request.update_id]
            elif command in ("metric", "discard"):
                self.staged_count = self.staged_count + 1 if command == "metric" else 0
                self.discard_count += command == "discard"
                yield self.answer(request, accepted=edit_pb2.UpdateAccepted(
                    staged_count=self.staged_count))
            elif command == "advance":
                yield from self.advance(request, request_iterator, context)

    def advance(self, request, requests, context):
        fault = self.faults.pop(0) if self.faults else None
        if fault == "drop before":
            context.abort(grpc.StatusCode.UNAVAILABLE, "connection reset")
        if fault == "closing":
            self.is_closing = True
            context.abort(grpc.StatusCode.CANCELLED, "CANCELLED")
        if fault == "forget":
            self.answers.clear()
            self.staged_count = 0
            context.abort(grpc.StatusCode.UNAVAILABLE, "killed")
        if isinstance(fault, errors_pb2.ErrorDetail):
            yield self.response(closing=edit_pb2.Closing(error=fault))
            context.abort(grpc.StatusCode.UNAVAILABLE, "the stream ends")
        if fault == "hang":
            self.is_hanging.set()
            self.cancelled += [later.cancel.advance_update_id == request.update_id
                               for later in requests if later.HasField("cancel")]
            return
        if fault == "staging":
            yield self.answer(request, advanced=edit_pb2.AdvanceResult(
                base_revision=self.revision, revision=self.revision,
                stop_reason=edit_pb2.STOP_REASON_STAGING))
            return
        self.staged_count = 0
        base, self.revision = self.revision, self.revision + 1
        self.applied.append(request.update_id)
        answer = self.answer(request, advanced=edit_pb2.AdvanceResult(
            base_revision=base, revision=self.revision, stop_reason=1))
        diff = mesh_pb2.MeshDiff(base_revision=base, revision=self.revision)
        for chunk in fill(diff, self.meshes[base], self.meshes[self.revision], self.chunk_bytes):
            yield self.response(chunk=chunk)
        if fault == "hash":
            diff.state_hash ^= 1
        if fault == "count":
            diff.counts.triangle_count += 1
        yield self.response(diff=diff)
        if fault == "drop after":
            context.abort(grpc.StatusCode.UNAVAILABLE, "connection reset")
        yield answer

    def catch_up(self, mirror_revision):
        if mirror_revision == self.revision:
            return
        snapshot = mesh_pb2.MeshSnapshot(revision=self.revision)
        for chunk in fill(snapshot, NOTHING, self.meshes[self.revision], self.chunk_bytes):
            yield self.response(chunk=chunk)
        yield self.response(snapshot=snapshot)

    def answer(self, request, **event):
        response = edit_pb2.EditResponse(update_id=request.update_id, revision=self.revision,
                                         **event)
        self.answers[request.update_id] = response
        return response

    def response(self, **event):
        return edit_pb2.EditResponse(revision=self.revision, **event)


class FakeServerService(session_pb2_grpc.ServerServiceServicer):
    def GetServerInfo(self, request, context):
        return session_pb2.GetServerInfoResponse(version="fake", limits={"vertices": 7})


class RefusingService(session_pb2_grpc.SessionServiceServicer):
    """Refuses everything with the given ErrorDetail, as a correct server does."""

    def __init__(self, detail, status):
        self.detail, self.status = detail, status

    def DeleteSession(self, request, context):
        packed = errors_pb2.ErrorStatus(code=self.status.value[0], message=self.detail.message)
        packed.details.add().Pack(errors_pb2.BadRequest())
        packed.details.add().Pack(self.detail)
        context.set_trailing_metadata(
            (("grpc-status-details-bin", packed.SerializeToString()),))
        context.abort(self.status, self.detail.message)

    def ListSessions(self, request, context):
        context.abort(self.status, "no details here")


def serve(service, address):
    """A running grpc.Server with `service` at `address`; stop() ends it."""
    server = grpc.server(concurrent.futures.ThreadPoolExecutor(max_workers=8))
    session_pb2_grpc.add_SessionServiceServicer_to_server(service, server)
    session_pb2_grpc.add_ServerServiceServicer_to_server(FakeServerService(), server)
    server.add_insecure_port(address)
    server.start()
    return server
