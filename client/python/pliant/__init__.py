"""Pliant: anisotropic triangle meshes that follow a changing metric.

A session is one persistent mesh on a server. Tell it what mesh you want, get the mesh; tell it what
changed, get the diff. `pliant.start_local()` runs a private server, `pliant.connect(...)` goes to
one that is there.

>>> import numpy as np
>>> import pliant
>>> client = pliant.start_local()
>>> square = pliant.Domain([[0, 0], [1, 0], [1, 1], [0, 1]], [[0, 1], [1, 2], [2, 3], [3, 0]],
...                        tags=[1, 2, 3, 4])
>>> session = client.create_session(domain=square, metric=pliant.metric.size("0.1"))
>>> session.revision, session.mesh.points.shape[1], session.mesh.triangles.dtype
(1, 2, dtype('int32'))

A solver sends tensors m11, m12, m22 at the nodes that it has; here the wanted size is halved on the
left. The returned diff is already applied to `session.mesh`.

>>> h = np.where(session.mesh.points[:, 0] < 0.4, 0.05, 0.1)
>>> tensors = np.stack([1 / h**2, 0 * h, 1 / h**2], axis=1)
>>> diff = session.update_metric(tensors)
>>> diff.converged, diff.revision, diff.insertion_count > 20
(True, 2, True)
>>> session.quality().integrated.share_sqrt2 > 0.8
True

What is wrong is refused with its place, and changes nothing.

>>> session.update_metric([[1, 0, -1]], vertex_ids=session.mesh.vertex_ids[:1])
Traceback (most recent call last):
    ...
pliant.errors.InvalidInput: NOT_POSITIVE_DEFINITE: ...
>>> session.delete()
>>> client.close()
"""

from pliant import errors, metric, motion, options
from pliant.client import Client, SessionInfo, connect
from pliant.diff import Diff, LimitReport, Progress, Trouble
from pliant.errors import (
    AlreadyExists, Cancelled, DataCorrupt, DeadlineExceeded, Error, FailedPrecondition, Internal,
    InvalidInput, NotFound, ReplicaMismatch, ResourceExhausted, SessionBusy, Unauthenticated,
    Unavailable,
    Unimplemented)
from pliant.fields import FieldRows, TransferRows
from pliant.geometry import Domain, Mesh
from pliant.jobs import JobInfo, JobReport
from pliant.local import start_local
from pliant.options import Advance
from pliant.quality import Histogram, LengthStatistics, Quality
from pliant.replica import Change, Counts, MeshView
from pliant.session import Session
from pliant.subscription import Subscription

__all__ = [
    "Advance", "AlreadyExists", "Cancelled", "Change", "Client", "Counts", "DataCorrupt",
    "DeadlineExceeded", "Diff", "Domain", "Error", "FailedPrecondition", "FieldRows", "Histogram",
    "Internal", "InvalidInput", "JobInfo", "JobReport", "LengthStatistics", "LimitReport", "Mesh",
    "MeshView", "NotFound", "Progress", "Quality", "ReplicaMismatch", "ResourceExhausted",
    "Session", "SessionBusy", "SessionInfo", "Subscription", "TransferRows", "Trouble",
    "Unauthenticated", "Unavailable", "Unimplemented", "connect", "errors", "metric", "motion",
    "options", "start_local",
]
