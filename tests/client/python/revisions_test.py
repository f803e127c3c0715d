"""Going back in time, against the real pliantd."""

import pytest

import pliant
from resume_test import DOMAIN

pytestmark = pytest.mark.server


def test_a_step_is_taken_again(client):
    with client.create_session(domain=DOMAIN, metric=pliant.metric.size(0.1)) as session:
        before = session.mesh
        session.update_metric(pliant.metric.size(0.05))
        after = session.mesh
        diff = session.rollback(1)
        assert (diff.base_revision, diff.revision, diff.converged) == (2, 3, True)
        assert session.mesh.points.tobytes() == before.points.tobytes()
        assert session.mesh.state_hash == before.state_hash
        session.update_metric(pliant.metric.size(0.05))
        assert session.mesh.points.tobytes() == after.points.tobytes()
        with pytest.raises(pliant.NotFound, match="oldest"):
            session.rollback(17)


def test_saved_revisions_and_forks(client):
    with client.create_session(domain=DOMAIN, metric=pliant.metric.size(0.1)) as session:
        first = session.mesh
        assert session.save_revision() == 1
        session.update_metric(pliant.metric.size(0.05))
        name = session.fork(revision=1)
        with client.open_session(name) as fork:
            assert fork.revision == 1 and fork.mesh.state_hash == first.state_hash
            fork.update_metric(pliant.metric.size(0.05))
            assert fork.mesh.state_hash == session.mesh.state_hash
            fork.delete()
        session.release(1)
        with pytest.raises(pliant.NotFound):
            session.release(1)
