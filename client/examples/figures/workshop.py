"""Calls the programs `pliant` and `pliant_sheet`, and keeps what they made."""

import json
import pathlib
import subprocess
from dataclasses import dataclass, field
from typing import List, Optional

DATA = pathlib.Path(__file__).resolve().parent / "data"

# A figure fails if its node count is farther than this from the paper's.
COUNT_TOLERANCE = 0.15


class FigureError(Exception):
    """A program failed, or a figure is not what the paper shows."""


@dataclass
class Row:
    """One mesh: the numbers of its summary line."""

    figure: str
    what: str
    node_count: int
    paper_node_count: Optional[int]
    seconds: float
    q_mean: float
    share_125: float

    def line(self):
        paper = f" (paper {self.paper_node_count:,})" if self.paper_node_count else ""
        return (f"{self.figure:>5}  {self.what:28} {self.node_count:>9,} nodes{paper:14} "
                f"{self.seconds:7.3f} s  mean Q {self.q_mean:.3f}  "
                f"{100 * self.share_125:5.1f} % of edges in [0.8, 1.25]")


@dataclass
class Figure:
    """One figure: its title, what to see in it, its pictures (names without extension)."""

    title: str
    text: str
    pictures: List[str]
    rows: List[Row] = field(default_factory=list)


class Workshop:
    """Everything that a figure needs: a server at `address`, a folder `output`."""

    def __init__(self, address, output, picture_size, dpi):
        self.address = address
        self.output = pathlib.Path(output)
        self.picture_size = picture_size
        self._dpi = dpi
        for name in ("meshes", "pictures"):
            (self.output / name).mkdir(parents=True, exist_ok=True)

    def mesh(self, name, extension=".mesh"):
        """Path of a mesh."""
        return self.output / "meshes" / (name + extension)

    def remesh(self, name, source, *options):
        """Makes meshes/<name>.mesh of `source` on the server; returns the report."""
        return json.loads(self._run("pliant", "remesh", source, *options, "--server", self.address,
                                    "-o", self.mesh(name), "--json"))

    def remesh_as_vtu(self, name, source, *options):
        """Makes meshes/<name>.vtu as well: the same bits, with the metric, for ParaView."""
        self._run("pliant", "remesh", source, *options, "--server", self.address,
                  "-o", self.mesh(name, ".vtu"))

    def time(self, source, *options):
        """Makes a mesh that nobody keeps; returns the report."""
        report = self.remesh("timing", source, *options)
        self.mesh("timing").unlink()
        return report

    def download(self, name, session_id):
        """Fetches the mesh of a session as .mesh and .vtu."""
        for extension in (".mesh", ".vtu"):
            self._run("pliant", "session", "get", session_id, "--server", self.address,
                      "-o", self.mesh(name, extension))

    def plot(self, picture, name, *options):
        """Draws meshes/<name>.mesh as pictures/<picture>.svg and .png."""
        for path in self._picture_paths(picture):
            self._run("pliant", "plot", self.mesh(name), *options,
                      "--picture-size", self.picture_size, "--dpi", self._dpi, "-o", path)

    def sheet(self, picture, description):
        """Draws what `pliant_sheet` draws, several meshes or a chart."""
        path = self.output / "pictures" / (picture + ".json")
        path.write_text(json.dumps(description, indent=1, default=str))
        outputs = [part for file in self._picture_paths(picture) for part in ("-o", file)]
        self._run("pliant_sheet", path, "--dpi", self._dpi, *outputs)
        path.unlink()

    def _picture_paths(self, picture):
        return [self.output / "pictures" / (picture + extension) for extension in (".svg", ".png")]

    @staticmethod
    def _run(*command):
        command = [str(part) for part in command]
        try:
            done = subprocess.run(command, capture_output=True, text=True, check=False)
        except FileNotFoundError as error:
            raise FigureError(f"{command[0]} was not found; add its folder to PATH") from error
        if done.returncode != 0:
            raise FigureError(f"{' '.join(command)}\nended with status {done.returncode}: "
                              f"{done.stderr.strip()}")
        return done.stdout


def row_of(figure, what, report, paper_node_count=None):
    """The summary of a report of `pliant remesh --json`. Checks that the loop came to rest."""
    if report["stop"] != "converged":
        raise FigureError(f"figure {figure}, {what}: the loop ended with {report['stop']}")
    quality = report["quality"]
    return checked(Row(figure, what, report["vertex_count"], paper_node_count,
                       report["seconds"]["remesh"], quality["q_mean"],
                       quality["integrated"]["share_125"]))


def checked(row):
    """The row, if its node count is close enough to the paper's."""
    if row.paper_node_count is not None:
        error = row.node_count / row.paper_node_count - 1
        if abs(error) > COUNT_TOLERANCE:
            raise FigureError(f"figure {row.figure}: {row.node_count} nodes, the paper has "
                              f"{row.paper_node_count}: off by {100 * error:+.1f} %")
    print(row.line(), flush=True)
    return row
