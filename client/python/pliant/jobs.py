"""Jobs: remeshing that nobody waits for."""

import random
import time
from dataclasses import dataclass
from datetime import datetime, timezone
from typing import Any, Callable, List, Optional

from pliant import arrays, calls, diff, downloads, errors, geometry, inputs, quality, replica
from pliant import options as opts
from pliant.v1 import edit_pb2, job_pb2, job_pb2_grpc, mesh_pb2

# Pauses between two looks at a job: doubled each time.
_PAUSE_S_MIN, _PAUSE_S_MAX = 0.02, 2.0


@dataclass(frozen=True)
class JobReport:
    """What a job that is done has done.

    Attributes:
        revision, vertex_count, triangle_count, state_hash: of its mesh.
        stop_reason: "CONVERGED", or which limit ended it, e.g. "VISIT_BUDGET".
        active_count: vertices that the loop has not finished; 0 if converged.
        visit_count, move_count, insertion_count, deletion_count, swap_count: of the loop.
        troubles: places where the metric is not met, `pliant.Trouble`s.
        compute_us, elapsed_us: in the core, and from the beginning to the commit, microseconds.
    """

    revision: int
    vertex_count: int
    triangle_count: int
    state_hash: int
    stop_reason: str
    active_count: int
    visit_count: int
    move_count: int
    insertion_count: int
    deletion_count: int
    swap_count: int
    troubles: tuple
    compute_us: int
    elapsed_us: int


@dataclass(frozen=True)
class JobInfo:
    """A job in short.

    Attributes:
        job_id: its name.
        state: "QUEUED", "RUNNING", "DONE", "FAILED" or "CANCELLED".
        priority: as submitted.
        progress: a `pliant.Progress` while it runs, else None.
        report, quality: `JobReport` and `pliant.Quality` when it is done, else None.
        error: the `pliant.Error` of one that failed, else None.
        create_time, end_time, expire_time: when it was submitted, ended and will be dropped; the
            latter two are None before its end.
    """

    job_id: str
    state: str
    priority: int
    progress: Optional[diff.Progress]
    report: Optional[JobReport]
    quality: Optional[quality.Quality]
    error: Optional[errors.Error]
    create_time: datetime
    end_time: Optional[datetime]
    expire_time: Optional[datetime]

    @property
    def ended(self) -> bool:
        """True if nothing about it will change any more."""
        return self.state in ("DONE", "FAILED", "CANCELLED")


class JobCalls:
    """The calls of a `Client` on jobs. A job survives its client."""

    def __init__(self, channel):
        self._jobs = job_pb2_grpc.JobServiceStub(channel)

    def submit_job(self, *, domain: Optional[geometry.Domain] = None, mesh: Any = None,
                   metric: Any = None, job_id: str = "", priority: int = 0,
                   keep_ms: int = 0, advance: Optional[opts.Advance] = None,
                   **options) -> JobInfo:
        """Puts a job into the server's queue; what it makes is the first mesh of such a session.

        Args:
            domain, mesh, metric, **options: as for `create_session`.
            job_id: wished name, 1 to 64 characters of [A-Za-z0-9_.-]. Default: the server makes
                one.
            priority: greater goes first among one's own jobs.
            keep_ms: how long it is kept after its end; 0: as long as the server likes to.
            advance: how long it may run. Default: until converged.

        Raises:
            InvalidInput: an array is wrong by itself; how they fit together shows in
                `JobInfo.error`.
            AlreadyExists: `job_id` is taken.
            ResourceExhausted: the server has as many jobs as it may.
        """
        sender = arrays.BlobSender()
        message = job_pb2.SubmitJob(
            job_id=job_id, input=inputs.message_of(sender, domain, mesh, metric, options),
            advance=(advance or opts.Advance()).to_wire(), priority=priority, keep_ms=keep_ms)

        def requests():
            for chunk in sender.take_chunks():
                yield job_pb2.SubmitJobRequest(chunk=chunk)
            yield job_pb2.SubmitJobRequest(submit=message)

        return _from_wire(calls.call(self._jobs.SubmitJob, requests()).job)

    def get_job(self, job_id: str) -> JobInfo:
        """Describes a job.

        Raises:
            NotFound: there is none of that name, or its time is over.
        """
        return self._persist(lambda: self._look(job_id))

    def _look(self, job_id):
        return _from_wire(calls.call(self._jobs.GetJob, job_pb2.GetJobRequest(job_id=job_id)).job)

    def list_jobs(self) -> List[JobInfo]:
        """All jobs, newest first."""
        found, token = [], ""
        while True:
            request = job_pb2.ListJobsRequest(page_token=token)
            page = self._persist(lambda: calls.call(self._jobs.ListJobs, request))
            found += map(_from_wire, page.jobs)
            token = page.next_page_token
            if not token:
                return found

    def cancel_job(self, job_id: str) -> JobInfo:
        """Stops a job; one that has ended stays as it is."""
        request = job_pb2.CancelJobRequest(job_id=job_id)
        return _from_wire(self._persist(lambda: calls.call(self._jobs.CancelJob, request)).job)

    def fetch_result(self, job_id: str, with_metric: bool = False) -> replica.MeshView:
        """The mesh of a job that is done, numbered 0..n-1.

        Raises:
            FailedPrecondition: it is not done, or has failed or was cancelled.
        """
        request = job_pb2.FetchResultRequest(
            job_id=job_id, parts=[mesh_pb2.MESH_PART_METRIC] if with_metric else [])
        fetch = self._jobs.FetchResult
        return self._persist(lambda: downloads.mesh(lambda: fetch(request)))

    def wait_for_job(self, job_id: str, timeout_s: Optional[float] = None,
                     reconnect_s: float = 60.0,
                     on_look: Optional[Callable[[JobInfo], None]] = None) -> JobInfo:
        """Asks, ever more rarely, until the job has ended.

        Args:
            job_id: which.
            timeout_s: wait no longer than this; the job goes on. Default: for as long as it takes.
            reconnect_s: how long the server may be out of reach, say for a restart.
            on_look: called with the job each time; an exception out of it ends the waiting.

        Raises:
            DeadlineExceeded: after `timeout_s`.
        """
        begin = last_answer = time.monotonic()
        pause_s = _PAUSE_S_MIN
        while True:
            try:
                job = self._look(job_id)
                last_answer = time.monotonic()
                if job.ended:
                    return job
                if on_look is not None:
                    on_look(job)
            except errors.Unavailable:
                if time.monotonic() - last_answer >= reconnect_s:
                    raise
            left_s = _PAUSE_S_MAX if timeout_s is None else begin + timeout_s - time.monotonic()
            if left_s <= 0:
                raise errors.DeadlineExceeded(
                    "DEADLINE_EXCEEDED",
                    f"job {job_id} has not ended in {timeout_s} s; it goes on")
            time.sleep(min(pause_s * random.uniform(0.5, 1), left_s))
            pause_s = min(2 * pause_s, _PAUSE_S_MAX)


def _from_wire(job) -> JobInfo:
    def field(name, convert):
        return convert(getattr(job, name)) if job.HasField(name) else None

    return JobInfo(
        job_id=job.job_id,
        state=job_pb2.JobState.Name(job.state).removeprefix("JOB_STATE_"), priority=job.priority,
        progress=field("progress", diff.progress_from_wire), report=field("result", _report),
        quality=field("quality", quality.from_wire), error=field("error", errors.from_detail),
        create_time=_time(job.create_time), end_time=field("end_time", _time),
        expire_time=field("expire_time", _time))


def _report(result):
    reason = edit_pb2.StopReason.Name(result.stop_reason).removeprefix("STOP_REASON_")
    return JobReport(
        revision=result.revision, vertex_count=result.counts.vertex_count,
        triangle_count=result.counts.triangle_count, state_hash=result.state_hash,
        stop_reason=reason, active_count=result.active_count, visit_count=result.visit_count,
        move_count=result.move_count, insertion_count=result.insertion_count,
        deletion_count=result.deletion_count, swap_count=result.swap_count,
        troubles=tuple(map(diff.make_trouble, result.troubles)), compute_us=result.compute_us,
        elapsed_us=result.elapsed_us)


def _time(message):
    return datetime.fromtimestamp(message.seconds + message.nanos / 1e9, timezone.utc)
