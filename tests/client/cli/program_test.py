"""The program `pliant` as a user meets it: files in and out, errors, exit codes, a real server.

Runs the binaries that PLIANT and PLIANTD name (ctest sets both); without PLIANTD the tests that
need a server are skipped.
"""

import contextlib
import json
import os
import pathlib
import signal
import subprocess
import time

import meshio
import numpy as np
import pytest

PLIANT = os.environ["PLIANT"]
PLIANTD = os.environ.get("PLIANTD")
DATA = pathlib.Path(__file__).parents[2] / "data" / "cli"
PLATE = str(DATA / "plate.poly")
SIZE = ["--size", "0.05+0.1*abs(x-1)"]
JUMP = ["--size", "x < 1 ? 0.2 : 0.01"]
needs_server = pytest.mark.skipif(not PLIANTD, reason="PLIANTD is not set")


def run(*arguments, code=0, env=None, cwd=None):
    """Runs pliant, checks the exit code, returns the finished process."""
    clean = {key: value for key, value in os.environ.items() if key != "PLIANT_SERVER"}
    done = subprocess.run([PLIANT, *map(str, arguments)], capture_output=True, text=True,
                          env={**clean, **(env or {})}, cwd=cwd, timeout=120, check=False)
    assert done.returncode == code, (arguments, done.stdout, done.stderr)
    assert "terminate called" not in done.stderr and "bug of pliant" not in done.stderr
    if code == 0:
        assert done.stderr == "", done.stderr  # No terminal: no progress bar.
    else:
        assert done.stderr, "a failure says why"
    return done


@contextlib.contextmanager
def serving(folder, *options):
    """A pliantd on a Unix socket of its own: its address, and its process."""
    address = f"unix:{folder}/s"
    port_file = folder / "port"
    port_file.unlink(missing_ok=True)
    with open(folder / "log", "w", encoding="utf-8") as log:
        with subprocess.Popen([PLIANTD, "--listen", address, "--port-file", port_file, *options],
                              stdout=log, stderr=log) as process:
            while not port_file.exists():
                assert process.poll() is None, (folder / "log").read_text()
                time.sleep(0.01)
            yield address, process
            process.terminate()
            assert process.wait(timeout=30) in (0, -signal.SIGKILL)


@pytest.fixture(scope="module", name="server")
def start_server(tmp_path_factory):
    """The address of a server that all tests share."""
    with serving(tmp_path_factory.mktemp("d")) as (address, _):
        yield address


# --- Files ---------------------------------------------------------------------------------------

@pytest.fixture(scope="module", name="plate")
def make_plate(tmp_path_factory):
    """A folder with one mesh of the plate in every format that can be written."""
    folder = tmp_path_factory.mktemp("plate")
    for name in ("a.mesh", "a.meshb", "a.msh", "a.msh2", "a.vtu", "a.node"):
        run("remesh", PLATE, *SIZE, "-o", folder / name)
    return folder


def area(mesh):
    """Sum of the signed areas of all triangles."""
    p = mesh.points[:, :2]
    t = np.concatenate([block.data for block in mesh.cells if block.type == "triangle"])
    a, b = p[t[:, 1]] - p[t[:, 0]], p[t[:, 2]] - p[t[:, 0]]
    return 0.5 * np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])


@pytest.mark.parametrize("name, tag", [("a.mesh", "medit:ref"), ("a.msh", "gmsh:physical"),
                                       ("a.vtu", "tag")])
def test_meshes_are_what_an_independent_reader_sees(plate, name, tag):
    mesh = meshio.read(plate / name)
    assert area(mesh) == pytest.approx(2 - 0.04, rel=1e-12)
    tags = {"triangle": set(), "line": set()}
    for block, values in zip(mesh.cells, mesh.cell_data[tag]):
        tags.setdefault(block.type, set()).update(values)
    assert tags["triangle"] == {10, 20}
    assert tags["line"] == {1, 2, 3, 4, 5, 6}


def test_a_vtu_carries_the_metric(plate):
    metric = meshio.read(plate / "a.vtu").point_data["metric"].reshape(-1, 9)
    points = meshio.read(plate / "a.vtu").points
    size = 0.05 + 0.1 * np.abs(points[:, 0] - 1)
    assert np.allclose(metric[:, 0], size**-2, rtol=1e-9)


@pytest.mark.parametrize("name", ["a.mesh", "a.meshb", "a.msh", "a.msh2", "a.node", "a.ele"])
def test_every_format_is_read_as_the_same_mesh(plate, tmp_path, name):
    expected = json.loads(run("quality", plate / "a.mesh", *SIZE, "--json").stdout)
    assert json.loads(run("quality", plate / name, *SIZE, "--json").stdout) == expected
    run("remesh", plate / name, "--size", "0.1", "-o", tmp_path / "out.mesh")
    run("remesh", plate / "a.mesh", "--size", "0.1", "-o", tmp_path / "expected.mesh")
    assert (tmp_path / "out.mesh").read_bytes() == (tmp_path / "expected.mesh").read_bytes()


def test_tensors_of_a_file_are_followed(tmp_path):
    out = tmp_path / "out.mesh"
    run("remesh", DATA / "two_triangles.mesh", "--metric", DATA / "two_triangles.sol",
        "-o", out, "--output-metric", tmp_path / "out.sol")
    report = json.loads(run("quality", out, "--metric", tmp_path / "out.sol", "--json").stdout)
    assert report["vertex_count"] > 100
    assert report["q_mean"] > 0.9
    run("remesh", PLATE, "--metric", tmp_path / "out.sol", "--background", out,
        "-o", tmp_path / "plate.msh")


# --- The report ----------------------------------------------------------------------------------

def test_the_report_is_complete_and_right(tmp_path):
    out = tmp_path / "out.mesh"
    assert "vertices" in run("remesh", PLATE, *SIZE, "-o", out, "--json", tmp_path / "r").stdout
    report = json.loads((tmp_path / "r").read_text())
    printed = json.loads(run("remesh", PLATE, *SIZE, "-o", out, "--json").stdout)
    for timeless in (report, printed):
        seconds = timeless.pop("seconds")
        assert all(seconds[phase] >= 0 for phase in ("read", "remesh", "write"))
        assert timeless.pop("peak_memory_bytes") > 1_000_000
    assert report == printed
    mesh = meshio.read(out)
    assert report["vertex_count"] == len(mesh.points)
    assert report["triangle_count"] == len(mesh.cells_dict["triangle"])
    assert report["constrained_edge_count"] == len(mesh.cells_dict["line"])
    assert report["mode"] == "local" and report["stop"] == "converged"
    measured = json.loads(run("quality", out, *SIZE, "--json").stdout)
    assert measured.keys() == report["quality"].keys()
    for name, value in measured.items():  # Sums of other order differ in their last bits.
        assert report["quality"][name] == (value if "counts" in repr(value) else
                                           pytest.approx(value, rel=1e-12)), name
    assert sum(report["quality"]["lengths"]["counts"]) == report["quality"]["edge_count"]
    assert sum(report["quality"]["angles_deg"]["counts"]) == 3 * report["triangle_count"]


def test_options_reach_the_loop(tmp_path):
    def mesh(*options):
        size = [] if "--size" in options else SIZE
        # Some of these options leave what the program warns of: the metric is not met.
        subprocess.run([PLIANT, "remesh", PLATE, *size, *options, "-o", tmp_path / "m.mesh"],
                       check=True, capture_output=True)
        return (tmp_path / "m.mesh").read_bytes()
    default = mesh()
    assert mesh() == default
    assert mesh("--variant", "nested", "--smoothing", "pliant", "--hgrad", "0") == default
    assert mesh("--size", "0.008") != mesh("--size", "0.008", "--variant", "cooled")
    for options in (["--variant", "paper"], ["--smoothing", "laplacian"],
                    ["--no-move"], ["--no-swap"], ["--hmin", "0.08"], ["--hmax", "0.07"],
                    ["--hgrad", "1.05"], ["--speed-threshold", "0.2"]):
        assert mesh(*options) != default, options
    paper = mesh("--variant", "paper")
    assert mesh("--variant", "paper", "--seed", "1") == paper
    assert mesh("--variant", "paper", "--seed", "2") != paper
    subprocess.run([PLIANT, "remesh", PLATE, *SIZE, "--no-insert", "-o", tmp_path / "m.mesh"],
                   check=True, capture_output=True)  # Warns: the metric is not met.
    assert len(meshio.read(tmp_path / "m.mesh").points) == 10


def test_a_limit_that_ends_the_loop_is_a_warning(tmp_path):
    done = subprocess.run([PLIANT, "remesh", PLATE, *SIZE, "--visits-max", "50", "-o",
                           tmp_path / "m.mesh", "--local"], capture_output=True, text=True,
                          check=True)
    assert "--visits-max" in done.stderr and "still active" in done.stderr


@pytest.mark.parametrize("where", ["here", "server"])
def test_a_metric_that_no_mesh_follows_is_limited_and_a_note_says_so(tmp_path, where, request):
    place = ["--local"] if where == "here" else ["--server", request.getfixturevalue("server")]
    done = subprocess.run([PLIANT, "remesh", PLATE, *JUMP, "-o", tmp_path / "m.mesh", *place,
                           "--json", tmp_path / "r.json"],
                          capture_output=True, text=True, check=True)
    assert "pliant: note:" in done.stderr and "--hgrad 0" in done.stderr
    assert "warning" not in done.stderr
    report = json.loads((tmp_path / "r.json").read_text())
    assert report["troubles"] == [] and report["quality"]["q_min"] > 0.7
    assert report["limits"]["gradation_count"] > 0


def test_a_metric_that_cannot_be_met_is_a_warning_that_says_where_and_why(tmp_path):
    done = subprocess.run([PLIANT, "remesh", PLATE, *JUMP, "--hgrad", "0", "-o",
                           tmp_path / "m.mesh", "--local", "--json", tmp_path / "r.json"],
                          capture_output=True, text=True, check=True)
    assert "the metric is not met at" in done.stderr and "size_jump" in done.stderr
    assert "--hgrad 1.5 --rotation 0.7" in done.stderr
    jumps = [trouble for trouble in json.loads((tmp_path / "r.json").read_text())["troubles"]
             if trouble["kind"] == "size_jump"]
    assert jumps and all(t["box"][0] < 1.05 and t["box"][2] > 0.7 for t in jumps)


# --- Refusals ------------------------------------------------------------------------------------

@pytest.mark.parametrize("arguments, words", [
    (["remesh", DATA / "crossing.poly", *SIZE], ["CROSSING_SEGMENTS", "domain.segments[0]"]),
    (["remesh", DATA / "damaged.mesh", *SIZE], ["FILE_SYNTAX", "damaged.mesh", "line 5"]),
    (["remesh", "missing.poly", *SIZE], ["FILE_NOT_FOUND", "missing.poly"]),
    (["remesh", PLATE, "--size", "0.1+"], ["EXPRESSION_SYNTAX", "metric."]),
    (["remesh", PLATE, "--size", "x-1"], ["metric."]),
    (["remesh", PLATE, "--metric-expr", "1;2"], ["M11; M12; M22"]),
    (["remesh", PLATE, "--metric-expr", "1;2;1"], ["metric."]),
    (["remesh", PLATE, "--metric", DATA / "two_triangles.sol"], ["--background"]),
    (["remesh", PLATE, *SIZE, "--hmin", "2", "--hmax", "1"], ["OUT_OF_RANGE"]),
    (["remesh", PLATE, *SIZE, "--step", "7"], ["OUT_OF_RANGE", "options."]),
])
def test_bad_input_is_refused_with_cause_and_place(tmp_path, arguments, words):
    done = run(*arguments, "-o", tmp_path / "out.mesh", code=1)
    assert done.stdout == ""
    assert done.stderr.startswith("pliant: ") and done.stderr.count("\n") == 1
    for word in words:
        assert word in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_an_output_that_cannot_be_written_is_refused_before_the_work(tmp_path):
    assert "out.xyz" in run("remesh", "missing.poly", *SIZE, "-o", "out.xyz", code=1).stderr
    target = tmp_path / "nowhere" / "out.mesh"
    assert "nowhere" in run("remesh", PLATE, *SIZE, "-o", target, code=1).stderr


def test_of_several_metrics_the_finest_holds(tmp_path):
    # Goal: the same mesh as the minimum of both sizes written as one formula.
    both, least = tmp_path / "both.mesh", tmp_path / "least.mesh"
    run("remesh", PLATE, "--size", "0.05+0.1*x", "--metric-expr", "64; 0; 64", "-o", both)
    run("remesh", PLATE, "--size", "min(0.125, 0.05+0.1*x)", "-o", least)
    assert both.read_bytes() == least.read_bytes()


@pytest.mark.parametrize("arguments", [
    [], ["frobnicate"], ["remesh"], ["remesh", PLATE, *SIZE], ["remesh", PLATE, "-o", "a.mesh"],
    ["remesh", PLATE, *SIZE, "--background", "b.mesh", "-o", "a.mesh"],
    ["remesh", PLATE, *SIZE, "-o", "a.mesh", "--variant", "fast"],
    ["remesh", PLATE, *SIZE, "-o", "a.mesh", "--local", "--server", "x:1"],
    ["session"], ["session", "show"], ["plot", PLATE, "--ellipses", "-o", "a.svg"],
])
def test_wrong_usage_ends_with_2(arguments):
    assert "--help" in run(*arguments, code=2).stderr


@pytest.mark.parametrize("command", [
    ["remesh"], ["plot"], ["quality"], ["session"], ["session", "create"], ["session", "list"],
    ["session", "show"], ["session", "get"], ["session", "quality"], ["session", "delete"],
    ["session", "export"], ["session", "import"],
    ["job"], ["job", "list"], ["job", "show"], ["job", "wait"], ["job", "cancel"],
    ["job", "fetch"], []])
def test_every_command_has_help_with_an_example(command):
    text = run(*command, "--help").stdout
    assert "Usage: pliant" in text and "Example:\n  pliant" in text


def test_the_version_is_that_of_the_report(tmp_path):
    report = json.loads(run("remesh", PLATE, *SIZE, "-o", tmp_path / "m.vtu", "--json").stdout)
    assert run("--version").stdout == f"pliant {report['pliant_version']}\n"


def test_nobody_at_the_address_ends_with_3(tmp_path):
    nobody = f"unix:{tmp_path}/none"
    assert nobody in run("session", "list", "--server", nobody, code=3).stderr
    run("remesh", PLATE, *SIZE, "-o", tmp_path / "m.mesh", code=3, env={"PLIANT_SERVER": nobody})
    run("remesh", PLATE, *SIZE, "-o", tmp_path / "m.mesh", "--local", env={"PLIANT_SERVER": nobody})


# --- Pictures ------------------------------------------------------------------------------------

def test_plots_show_what_was_asked_for(plate, tmp_path):
    def svg(*options):
        run("plot", plate / "a.mesh", *options, "-o", tmp_path / "p.svg")
        return (tmp_path / "p.svg").read_text()
    plain = svg()
    assert plain.startswith("<?xml") or plain.startswith("<svg")
    pictures = [plain, svg("--title", "a title"), svg(*SIZE, "--ellipses"),
                svg(*SIZE, "--histograms"), svg("--window", "0,0,1,1"), svg("--quality"),
                svg("--window", "0", "0", "1", "0.5", "--stretch")]
    assert "a title" in pictures[1]
    assert len(set(pictures)) == len(pictures)
    run("plot", plate / "a.mesh", *SIZE, "--histograms", "-o", tmp_path / "p.png")
    assert (tmp_path / "p.png").read_bytes().startswith(b"\x89PNG")
    assert "--window" in run("plot", plate / "a.mesh", "--window", "1,0,0,1", "-o",
                             tmp_path / "q.svg", code=1).stderr
    assert "p.gif" in run("plot", plate / "a.mesh", "-o", tmp_path / "p.gif", code=1).stderr


# --- The server ----------------------------------------------------------------------------------

@needs_server
@pytest.mark.parametrize("options", [
    ["--size", "0.01+0.05*hypot(x,y)"], ["--metric-expr", "400; 100*x; 2500", "--hgrad", "1.3"],
    ["--size", "0.05", "--variant", "paper", "--seed", "7"],
    ["--size", "0.05", "--no-swap", "--smoothing", "laplacian", "--visits-max", "5000"]])
def test_the_server_makes_the_same_bits(server, tmp_path, options):
    def made(name, *where):
        done = subprocess.run([PLIANT, "remesh", PLATE, *options, *where, "-o",
                               tmp_path / f"{name}.vtu", "--json"], capture_output=True, text=True,
                              check=True)
        report = json.loads(done.stdout)
        for key in ("output", "seconds", "peak_memory_bytes", "mode", "server"):
            report.pop(key, None)
        return report, (tmp_path / f"{name}.vtu").read_bytes()
    assert made("remote", "--server", server) == made("local", "--local")
    assert run("session", "list", "--server", server).stdout == "", "remesh deletes its session"


@needs_server
def test_tensors_at_a_mesh_make_the_same_bits_on_the_server(server, tmp_path):
    for name, where in (("remote", ["--server", server]), ("local", ["--local"])):
        run("remesh", DATA / "two_triangles.mesh", "--metric", DATA / "two_triangles.sol", *where,
            "-o", tmp_path / f"{name}.mesh")
    assert (tmp_path / "remote.mesh").read_bytes() == (tmp_path / "local.mesh").read_bytes()


@needs_server
def test_the_life_of_a_session(server, tmp_path):
    env = {"PLIANT_SERVER": server}
    assert run("session", "create", PLATE, *SIZE, "--id", "plate", env=env).stdout == "plate\n"
    assert "SESSION_EXISTS" in run("session", "create", PLATE, *SIZE, "--id", "plate", env=env,
                                   code=1).stderr
    shown = json.loads(run("session", "show", "plate", "--json", env=env).stdout)
    assert shown["revision"] == 1 and shown["state"] == "idle"
    assert json.loads(run("session", "list", "--json", env=env).stdout) == [shown]
    assert "plate" in run("session", "list", env=env).stdout

    run("session", "get", "plate", "-o", tmp_path / "got.vtu", env=env)
    run("remesh", PLATE, *SIZE, "-o", tmp_path / "made.vtu", "--local")
    assert (tmp_path / "got.vtu").read_bytes() == (tmp_path / "made.vtu").read_bytes()
    quality = json.loads(run("session", "quality", "plate", "--json", env=env).stdout)
    assert quality["vertex_count"] == shown["vertex_count"]
    assert "complexity" in run("session", "quality", "plate", env=env).stdout

    run("session", "delete", "plate", env=env)
    assert "SESSION_NOT_FOUND" in run("session", "show", "plate", env=env, code=1).stderr


@needs_server
def test_a_session_goes_to_another_server_as_a_file(server, tmp_path):
    file = tmp_path / "plate.pliant"
    env = {"PLIANT_SERVER": server}
    run("session", "create", PLATE, *SIZE, "--id", "origin", env=env)
    shown = json.loads(run("session", "show", "origin", "--json", env=env).stdout)
    run("session", "export", "origin", "-o", file, env=env)
    with serving(tmp_path, "--data", tmp_path / "data") as (address, _):
        there = {"PLIANT_SERVER": address}
        assert run("session", "import", file, "--id", "moved", env=there).stdout == "moved\n"
        moved = json.loads(run("session", "show", "moved", "--json", env=there).stdout)
        assert moved["state_hash"] == shown["state_hash"] and moved["revision"] == 1
        refused = run("session", "import", file, "--id", "moved", env=there, code=1)
        assert "SESSION_EXISTS" in refused.stderr
        file.write_bytes(file.read_bytes()[:-1])
        damaged = run("session", "import", file, env=there, code=1).stderr
        assert "DATA_CORRUPT" in damaged and str(file) in damaged
        assert "FILE_NOT_FOUND" in run("session", "import", tmp_path / "none", env=there,
                                       code=1).stderr
    assert "SESSION_NOT_FOUND" in run("session", "export", "nobody", "-o", tmp_path / "x",
                                      env=env, code=1).stderr
    assert not (tmp_path / "x").exists()
    run("session", "delete", "origin", env=env)


@needs_server
def test_data_survive_the_server_and_are_checked_and_copied_while_in_use(tmp_path):
    data, copy = tmp_path / "data", tmp_path / "copy"

    def maintain(*options):
        return subprocess.run([PLIANTD, *options], capture_output=True, text=True, check=False)

    with serving(tmp_path, "--data", data) as (address, process):
        run("session", "create", PLATE, *SIZE, "--id", "plate", "--server", address)
        run("session", "get", "plate", "-o", tmp_path / "before.mesh", "--server", address)
        assert maintain("--data", data, "--backup-data", copy).returncode == 0
        assert maintain("--data", data, "--check-data").returncode == 0
        process.kill()
    for folder in (data, copy):
        with serving(tmp_path, "--data", folder) as (address, _):
            run("session", "get", "plate", "-o", tmp_path / "after.mesh", "--server", address)
        assert (tmp_path / "after.mesh").read_bytes() == (tmp_path / "before.mesh").read_bytes()

    with open(copy / "pliant.sqlite", "r+b") as file:
        file.seek(3 * 4096)
        file.write(bytes(4096))
    damaged = maintain("--data", copy, "--check-data")
    assert damaged.returncode == 1 and (damaged.stdout or damaged.stderr)
    assert maintain("--check-data").returncode != 0


@needs_server
def test_the_life_of_a_job(server, tmp_path):
    env = {"PLIANT_SERVER": server}
    assert run("job", "list", env=env).stdout == ""
    assert run("remesh", PLATE, *SIZE, "--detach", "--job-id", "plate", "--priority", "2",
               "--keep-h", "1", env=env).stdout == "plate\n"
    assert "JOB_EXISTS" in run("remesh", PLATE, *SIZE, "--detach", "--job-id", "plate", env=env,
                               code=1).stderr
    assert "plate  done" in run("job", "wait", "plate", env=env).stdout
    shown = json.loads(run("job", "show", "plate", "--json", env=env).stdout)
    assert (shown["state"], shown["priority"], shown["stop"]) == ("done", 2, "converged")
    assert json.loads(run("job", "list", "--json", env=env).stdout) == [shown]

    run("job", "fetch", "plate", "-o", tmp_path / "got.vtu", env=env)
    run("remesh", PLATE, *SIZE, "-o", tmp_path / "made.vtu", "--local")
    assert (tmp_path / "got.vtu").read_bytes() == (tmp_path / "made.vtu").read_bytes()

    endless = run("remesh", PLATE, "--size", "0.0005", "--detach", env=env).stdout.strip()
    assert "DEADLINE_EXCEEDED" in run("job", "wait", endless, "--seconds-max", "0.2", env=env,
                                      code=1).stderr
    assert "JOB_NOT_DONE" in run("job", "fetch", endless, "-o", tmp_path / "m.mesh", env=env,
                                 code=1).stderr
    assert f"{endless}  cancelled" in run("job", "cancel", endless, env=env).stdout
    assert "JOB_NOT_DONE" in run("job", "wait", endless, env=env, code=1).stderr
    assert "plate  done" in run("job", "cancel", "plate", env=env).stdout, "it has ended"
    assert "JOB_NOT_FOUND" in run("job", "show", "nobody", env=env, code=1).stderr

    bad = run("remesh", DATA / "crossing.poly", *SIZE, "--detach", env=env).stdout.strip()
    assert "CROSSING_SEGMENTS" in run("job", "wait", bad, env=env, code=1).stderr


@needs_server
def test_ctrl_c_while_waiting_leaves_the_job(server):
    endless = run("remesh", PLATE, "--size", "0.0005", "--detach", "--server", server)
    job = endless.stdout.strip()
    begin = time.monotonic()
    code, text = interrupt_when(lambda: time.monotonic() > begin + 0.3, "job", "wait", job,
                                "--server", server)
    assert code == 130 and "goes on" in text
    assert "running" in run("job", "show", job, "--server", server).stdout
    run("job", "cancel", job, "--server", server)


def test_detach_leaves_nothing_to_write(tmp_path):
    run("remesh", PLATE, *SIZE, code=2)
    for extra in (["-o", tmp_path / "m.mesh"], ["--local"], ["--output-metric", "m.sol"]):
        run("remesh", PLATE, *SIZE, "--detach", *extra, code=2)
    run("remesh", PLATE, *SIZE, "--priority", "3", "-o", tmp_path / "m.mesh", code=2)


@needs_server
def test_the_servers_refusals_read_like_local_ones(server, tmp_path):
    for options in ([DATA / "crossing.poly", *SIZE], [PLATE, "--size", "0.1+"]):
        command = ["remesh", *options, "-o", tmp_path / "m.mesh"]
        here = run(*command, "--local", code=1).stderr
        assert run(*command, "--server", server, code=1).stderr == here


def interrupt_when(ready, *arguments):
    """Starts pliant, sends SIGINT once `ready`, returns its exit code and standard error."""
    with subprocess.Popen([PLIANT, *map(str, arguments)], stderr=subprocess.PIPE,
                          stdout=subprocess.DEVNULL, text=True) as process:
        while not ready():
            assert process.poll() is None, "it ended before it could be interrupted"
            time.sleep(0.01)
        process.send_signal(signal.SIGINT)
        return process.wait(timeout=60), process.stderr.read()


@needs_server
def test_ctrl_c_on_a_server_leaves_no_session_and_no_file(server, tmp_path):
    def running():
        listed = json.loads(run("session", "list", "--json", "--server", server).stdout)
        return any(session["state"] == "running" for session in listed)
    code, text = interrupt_when(running, "remesh", PLATE, "--size", "0.0005", "--server", server,
                                "-o", tmp_path / "m.mesh")
    assert code == 130 and "interrupted" in text
    assert list(tmp_path.iterdir()) == []
    assert run("session", "list", "--server", server).stdout == ""


def test_ctrl_c_here_leaves_no_file(tmp_path):
    begin = time.monotonic()
    code, text = interrupt_when(lambda: time.monotonic() > begin + 0.5, "remesh", PLATE, "--size",
                                "0.0003", "--local", "-o", tmp_path / "m.mesh")
    assert code == 130 and "interrupted" in text
    assert list(tmp_path.iterdir()) == []
