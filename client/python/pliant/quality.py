"""How well a mesh follows its metric."""

from dataclasses import dataclass

import numpy as np

from pliant.v1 import quality_pb2


@dataclass(frozen=True, eq=False)
class Histogram:
    """Equal bins from `low` to `high`; values outside are in the first or last bin.

    Attributes:
        low: left end of the first bin.
        high: right end of the last bin.
        counts: (bins,) int64.
    """

    low: float
    high: float
    counts: np.ndarray

    @property
    def edges(self) -> np.ndarray:
        """(bins + 1,) float64: the ends of the bins."""
        return np.linspace(self.low, self.high, len(self.counts) + 1)


@dataclass(frozen=True, eq=False)
class LengthStatistics:
    """Metric lengths of all edges; 1 is exactly as wanted.

    Attributes:
        min, mean, max: shortest, mean, longest.
        share_sqrt2: share of edges in [1/sqrt 2, sqrt 2], 0 to 1.
        share_125: share of edges in [0.8, 1.25], 0 to 1.
        histogram: of the lengths; None where the server made none.
    """

    min: float
    mean: float
    max: float
    share_sqrt2: float
    share_125: float
    histogram: "Histogram | None"


@dataclass(frozen=True, eq=False)
class Quality:
    """Quality of one revision.

    Attributes:
        revision: which.
        basis: measured against the metric that the mesh follows ("limited") or the one that was
            sent ("raw").
        vertex_count, triangle_count, edge_count: elements; `edge_count` counts all edges.
        q_min, q_mean, q_percentile_1: triangle quality, 4 sqrt(3) A_M / sum of squared metric
            lengths: 1 is equilateral in the metric.
        averaged: lengths with the metric averaged over both ends.
        integrated: lengths with the metric integrated along the edge (5 Gauss points).
        angle_deg: histogram of the normalized angles in degrees; 60 is wanted.
        complexity: integral of sqrt(det M) over the domain; an ideal mesh has about 2 / sqrt(3)
            times as many vertices.
        active_count: vertices that are still active in the loop; 0 if converged.
    """

    revision: int
    vertex_count: int
    triangle_count: int
    edge_count: int
    q_min: float
    q_mean: float
    q_percentile_1: float
    averaged: LengthStatistics
    integrated: LengthStatistics
    angle_deg: "Histogram | None"
    complexity: float
    active_count: int
    basis: str


def basis_to_wire(basis: str) -> int:
    """The enum value of "limited" or "raw"."""
    bases = {"limited": quality_pb2.METRIC_BASIS_LIMITED, "raw": quality_pb2.METRIC_BASIS_RAW}
    if basis not in bases:
        raise ValueError(f"basis is {basis!r}; expected 'limited' or 'raw'")
    return bases[basis]


def from_wire(report) -> Quality:
    """The dataclass for a `QualityReport` message."""
    return Quality(
        revision=report.revision, vertex_count=report.counts.vertex_count,
        triangle_count=report.counts.triangle_count, edge_count=report.edge_count,
        q_min=report.q_min, q_mean=report.q_mean, q_percentile_1=report.q_percentile_1,
        averaged=_lengths(report.averaged), integrated=_lengths(report.integrated),
        angle_deg=_histogram(report, "angle_deg"), complexity=report.complexity,
        active_count=report.active_count,
        basis="raw" if report.basis == quality_pb2.METRIC_BASIS_RAW else "limited")


def _lengths(message):
    return LengthStatistics(min=message.min, mean=message.mean, max=message.max,
                            share_sqrt2=message.share_sqrt2, share_125=message.share_125,
                            histogram=_histogram(message, "histogram"))


def _histogram(message, name):
    if not message.HasField(name):
        return None
    histogram = getattr(message, name)
    counts = np.array(histogram.counts, np.int64)
    counts.flags.writeable = False
    return Histogram(low=histogram.low, high=histogram.high, counts=counts)
