"""Fixtures and the choice of tests: those that need a real pliantd run where PLIANTD names one."""

import os

import pytest

import pliant


def pytest_collection_modifyitems(items):
    if os.environ.get("PLIANTD"):
        return
    for item in items:
        if item.get_closest_marker("server"):
            item.add_marker(pytest.mark.skip(reason="PLIANTD is not set"))


@pytest.fixture(scope="session")
def client():
    """A client of a private server, the one that PLIANTD names; one for all tests."""
    with pliant.start_local() as started:
        yield started
