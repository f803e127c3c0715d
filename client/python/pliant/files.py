"""Sessions as files: kept elsewhere, or taken to another server."""

import numpy as np

from pliant import arrays, calls, downloads
from pliant.v1 import session_pb2


class FileCalls:
    """The calls of a `Client` on files; it has the stub `_sessions` and `_persist`."""

    def export_session(self, session_id: str) -> bytes:
        """A session at its current revision as the bytes of a file, opaque.

        Raises:
            NotFound: there is none of that name, or it has no mesh yet.
            FailedPrecondition: updates are staged.
            ResourceExhausted: the file would be larger than what can be imported.
        """
        request = session_pb2.ExportSessionRequest(session_id=session_id)

        def download():
            found = None
            for response, blobs in downloads.messages(
                    lambda: self._sessions.ExportSession(request)):
                found = blobs.array(response.file.data, "file.data", "u1").tobytes()
            if found is None:
                raise arrays.broken("the download ended without a file")
            return found

        return self._persist(download)

    def import_session(self, file: bytes, session_id: str = "") -> str:
        """Creates a session from what `export_session` gave, on this or another server.

        It goes on with the bits with which the other one goes on. `open_session` takes it up.

        Args:
            file: the bytes.
            session_id: wished name. Default: the server makes one.

        Returns:
            the name of the new session.

        Raises:
            DataCorrupt: `file` is not what was exported.
            FailedPrecondition: a newer server wrote it, code DATA_VERSION.
            AlreadyExists: `session_id` is taken.
        """
        sender = arrays.BlobSender()
        data = sender.array(np.frombuffer(file, np.uint8))
        message = session_pb2.ImportSession(session_id=session_id,
                                            file=session_pb2.SessionFile(data=data))

        def requests():
            for chunk in sender.take_chunks():
                yield session_pb2.ImportSessionRequest(chunk=chunk)
            last = session_pb2.ImportSessionRequest()
            getattr(last, "import").CopyFrom(message)
            yield last

        return calls.call(self._sessions.ImportSession, requests()).session.session_id
