"""A solver that moves its boundary nodes by itself, against the real pliantd."""

import math

import numpy as np
import pytest

import pliant

pytestmark = pytest.mark.server

DISC = {
    "points": [(math.cos(2 * math.pi * i / 40), math.sin(2 * math.pi * i / 40)) for i in range(40)],
    "segments": [(i, (i + 1) % 40) for i in range(40)],
}


def stretched_and_back(client, **options):
    """Edges of the boundary before, at most, and after."""
    with client.create_session(domain=pliant.Domain(**DISC), metric=pliant.metric.size("0.15"),
                               **options) as session:
        counts = [len(session.mesh.edges)]
        scale = np.array([1.0, 1.0])
        for step in range(12):
            factor = 1.12 if step < 6 else 1 / 1.12
            scale = np.array([factor, math.sqrt(factor)])
            bend = 1 + (0.03 if step < 6 else -0.03) * session.mesh.points[:, :1]
            session.move_nodes(session.mesh.points * scale * np.hstack([np.ones_like(bend), bend]))
            counts.append(len(session.mesh.edges))
        assert session.quality().q_mean > 0.9
        return counts[0], max(counts), counts[-1]


def test_corners_that_are_not_needed_go(client):
    before, most, after = stretched_and_back(client, boundary_tolerance=0.02)
    assert most > 1.3 * before
    assert after < 1.15 * before
    before, most, after = stretched_and_back(client)
    assert after > 1.3 * before, "without the option all corners stay"


def test_the_option_changes_later_and_is_checked(client):
    with client.create_session(domain=pliant.Domain(**DISC),
                               metric=pliant.metric.size("0.4")) as session:
        ids = session.mesh.vertex_ids.copy()
        assert len(session.mesh.edges) == 40 and session.last_diff.softened_count == 0
        with pytest.raises(pliant.InvalidInput) as caught:
            session.set_options(boundary_tolerance=-1)
        assert caught.value.code == "OUT_OF_RANGE"
        assert caught.value.field == "options.boundary_tolerance"
        session.set_options(boundary_tolerance=0.05)
        moved = session.mesh.points + [0.5, 0]
        diff = session.move_nodes(moved)
        assert len(session.mesh.edges) < 30
        assert diff.softened_count >= 10
        assert set(diff.removed_vertices) <= set(ids)
