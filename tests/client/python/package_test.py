"""The package as a whole: its first example, the example program, the installed copy."""

import doctest
import os
import pathlib
import subprocess
import sys

import numpy as np
import pytest

import pliant
import pliant.geometry
import pliant.metric

ROOT = pathlib.Path(__file__).resolve().parents[3]


@pytest.mark.parametrize("module", [pliant.geometry, pliant.metric])
def test_examples_in_modules(module):
    result = doctest.testmod(module)
    assert result.attempted > 0 and result.failed == 0


@pytest.mark.server
def test_first_example():
    flags = doctest.ELLIPSIS | doctest.IGNORE_EXCEPTION_DETAIL
    result = doctest.testmod(pliant, optionflags=flags)
    assert result.attempted > 8 and result.failed == 0


@pytest.mark.server
def test_moving_front(client, monkeypatch, capsys):
    monkeypatch.syspath_prepend(str(ROOT / "client" / "examples"))
    import moving_front
    mesh = moving_front.run(client, steps=3, h_min=0.01, h_max=0.1)
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 5
    # The mesh has followed: its triangles are where the front is now, no longer where it was.
    error = moving_front.interpolation_error
    radius = 0.6 + 0.02 * 3

    def distance(points):
        return np.median(np.abs(np.hypot(*(points - moving_front.CENTRE).T) - radius))

    even = np.stack(np.meshgrid(*2 * [np.linspace(0, 1, 50)]), axis=-1).reshape(-1, 2)
    assert distance(mesh.points[mesh.triangles].mean(axis=1)) < 0.5 * distance(even)
    assert error(mesh, radius) < 0.1 and error(mesh, radius) < 0.8 * error(mesh, 0.6)


@pytest.mark.server
def test_moving_front_as_a_program():
    result = subprocess.run(
        [sys.executable, ROOT / "client" / "examples" / "moving_front.py", "--steps", "1",
         "--h-min", "0.02"], capture_output=True, text=True)
    assert result.returncode == 0 and len(result.stdout.splitlines()) == 3, result.stderr


def test_installed_copy(tmp_path):
    build = os.environ.get("PLIANT_BUILD_DIR")
    if not build:
        pytest.skip("PLIANT_BUILD_DIR is not set")
    subprocess.run(["cmake", "--install", build, "--prefix", tmp_path, "--component", "python"],
                   check=True, capture_output=True)
    [package] = tmp_path.glob("lib/python3*/*-packages/pliant")
    result = subprocess.run(
        [sys.executable, "-c", "import pliant; print(pliant.__file__, pliant.connect.__name__)"],
        env={**os.environ, "PYTHONPATH": str(package.parent)}, capture_output=True, text=True)
    assert result.stdout.split() == [str(package / "__init__.py"), "connect"], result.stderr
