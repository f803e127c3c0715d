"""Jobs of the package against the real pliantd."""

import datetime

import numpy as np
import pytest

import pliant

pytestmark = pytest.mark.server
SQUARE = [[0, 0], [1, 0], [1, 1], [0, 1]]
LOOP = [[0, 1], [1, 2], [2, 3], [3, 0]]
# Runs for minutes unless it is stopped.
ENDLESS = "0.0007"


def square():
    return pliant.Domain(SQUARE, LOOP, tags=[1, 2, 3, 4])


def submit(client, size, **options):
    return client.submit_job(domain=square(), metric=pliant.metric.size(size), **options)


def test_a_job_makes_the_mesh_of_a_session(client):
    size = "0.01 + 0.05*x"
    submitted = submit(client, size, job_id="bits", priority=4, keep_ms=60_000, seed=5)
    assert (submitted.job_id, submitted.state, submitted.priority) == ("bits", "QUEUED", 4)
    assert not submitted.ended and submitted.end_time is None
    job = client.wait_for_job("bits")
    assert job.ended and job.state == "DONE" and job.error is None
    assert job.report.stop_reason == "CONVERGED" and job.report.active_count == 0
    assert job.expire_time - job.end_time == datetime.timedelta(seconds=60)
    assert job.quality.q_mean > 0.9
    mesh = client.fetch_result("bits", with_metric=True)
    with client.create_session(domain=square(), metric=pliant.metric.size(size), seed=5,
                               with_metric=True) as session:
        for name in ("points", "triangles", "edges", "metrics"):
            assert getattr(mesh, name).tobytes() == getattr(session.mesh, name).tobytes(), name
        assert job.report.vertex_count == len(session.mesh.points)
    assert np.isnan(client.fetch_result("bits").metrics).all(), "nobody asked for it"


def test_jobs_are_listed_and_cancelled(client):
    ids = [submit(client, ENDLESS).job_id for _ in range(2)]
    assert [job.job_id for job in client.list_jobs()][:2] == ids[::-1], "the newest first"
    with pytest.raises(pliant.DeadlineExceeded):
        client.wait_for_job(ids[0], timeout_s=0.05)

    class Works(Exception):
        pass

    def look(job):
        if job.progress and job.progress.visit_count:
            raise Works

    with pytest.raises(Works):
        client.wait_for_job(ids[0], on_look=look)
    with pytest.raises(pliant.FailedPrecondition, match="JOB_NOT_DONE"):
        client.fetch_result(ids[0])
    for job_id in ids:
        assert client.cancel_job(job_id).state == "CANCELLED"
        assert client.wait_for_job(job_id).state == "CANCELLED"


def test_refusals_say_what_is_wrong(client):
    submit(client, "0.5", job_id="taken")
    with pytest.raises(pliant.AlreadyExists, match="JOB_EXISTS"):
        submit(client, "0.5", job_id="taken")
    with pytest.raises(pliant.NotFound, match="JOB_NOT_FOUND"):
        client.get_job("nobody")
    with pytest.raises(pliant.InvalidInput) as refused:
        submit(client, "0.5", keep_ms=-1)
    assert refused.value.field == "keep_ms"
    with pytest.raises(pliant.InvalidInput):
        client.submit_job(domain=square())
    crossing = pliant.Domain(SQUARE, [[0, 2], [2, 1], [1, 3], [3, 0]])
    job = client.submit_job(domain=crossing, metric=pliant.metric.size("0.1"))
    failed = client.wait_for_job(job.job_id)
    assert failed.state == "FAILED" and isinstance(failed.error, pliant.InvalidInput)
    assert (failed.error.code, failed.error.index) == ("CROSSING_SEGMENTS", 0)
