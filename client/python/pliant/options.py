"""Options of a session, limits of its metric, and how long an advance may run."""

from dataclasses import dataclass, fields
from typing import Mapping, Optional

from pliant.errors import InvalidInput
from pliant.v1 import edit_pb2, metric_pb2, options_pb2

# Names that users know from other remeshers.
_ALIASES = {"hmin": "h_min", "hmax": "h_max"}


def _names(enum, prefix):
    """The enum's names in Python, "paper" for VARIANT_PAPER, so that none is forgotten here."""
    return {name.removeprefix(prefix).lower(): number for name, number in enum.items() if number}


_VARIANTS = _names(options_pb2.Variant, "VARIANT_")
_DURABILITIES = _names(options_pb2.Durability, "DURABILITY_")
_SMOOTHINGS = _names(options_pb2.Smoothing, "SMOOTHING_")


@dataclass(frozen=True)
class Advance:
    """How long one run of the loop may take. Without limits it runs until converged.

    A run that hits its limit leaves a valid mesh, and another one goes on from there. It commits
    one revision, unless the time is over before all is staged that was sent with it
    (`Diff.stop_reason` "STAGING"): then the next one does.

    Attributes:
        visits_max: at most this many visits of vertices, > 0.
        time_ms_max: at most this long, in ms, > 0: from when the server has the advance, so that it
            is a deadline also for what the same call sends with it.
    """

    visits_max: Optional[int] = None
    time_ms_max: Optional[int] = None

    def to_wire(self):
        """The message."""
        return edit_pb2.Advance(budget_visits=self.visits_max, budget_ms=self.time_ms_max)


@dataclass(frozen=True)
class Limits:
    """Limits on the metric as stated; None keeps the present value, 0 switches a limit off.

    Attributes:
        h_min: least wanted edge length, domain units.
        h_max: greatest wanted edge length, domain units.
        anisotropy_max: greatest ratio of the wanted lengths along and across, >= 1.
        hgrad: greatest ratio of the wanted lengths of neighbouring edges, 1 to 10; 1.5 is usual.
        rotation: how much directions may turn within one edge, 0.1 to 10; 0.7 is usual, larger is
            looser.
        geometry: greatest wanted length at a given point relative to the shortest input segment
            there, 0.1 to 10; 1 is usual. Growth from there needs `hgrad`.
        gap_elements: how many elements shall fit across a gap between two boundaries, 0.5 to 100.
            Growth from there needs `hgrad`.
        tensor_smoothing: how many times each tensor is averaged with those of its neighbours, 0 to
            8; 1 or 2 for tensors with noise. May make the metric coarser too.
        automatic: where an update comes to rest and the metric is not met because it jumps, crosses
            or turns too much, hgrad 1.5 and rotation 0.7 hold from then on. True for a new session,
            until `hgrad` or `rotation` is given, also as 0.
    """

    h_min: Optional[float] = None
    h_max: Optional[float] = None
    anisotropy_max: Optional[float] = None
    hgrad: Optional[float] = None
    rotation: Optional[float] = None
    geometry: Optional[float] = None
    gap_elements: Optional[float] = None
    tensor_smoothing: Optional[int] = None
    automatic: Optional[bool] = None

    def to_wire(self):
        """The message; None if nothing is set."""
        if self == Limits():
            return None
        return metric_pb2.MetricLimits(size_min=self.h_min, size_max=self.h_max,
                                       anisotropy_max=self.anisotropy_max, gradation=self.hgrad,
                                       rotation=self.rotation, geometry=self.geometry,
                                       gap_element_count=self.gap_elements,
                                       smoothing_count=self.tensor_smoothing,
                                       automatic=self.automatic)


@dataclass(frozen=True)
class SessionOptions:
    """How the loop works. None means the default, which serves nearly everybody.

    Attributes:
        seed: seed of every random choice; same input, options and seed: same mesh, bit for bit.
        variant: "nested" (default: the first mesh of a domain from coarse to fine), "cooled" or
            "paper" (the paper's loop to the letter).
        smoothing: "pliant" (default), "laplacian", "lennard_jones" or "bubble".
        no_insert: no vertex is inserted or deleted.
        no_swap: no edge is swapped.
        no_move: no vertex is moved.
        no_surf: constrained edges and the vertices on them are left alone.
        step: step length of the smoothing, in (0, 1].
        speed_threshold: a vertex sleeps once its step is shorter, in metric length, in (0, 1).
        metric_tolerance: relative change of its metric below which a vertex sleeps on, 0 to 1.
        boundary_tolerance: how far an advance may move the boundary, in domain units, to get rid of
            corners that are closer together than the metric asks for; for solvers that move its
            nodes. 0 (default): given points and corners that moving made stay for ever.
        hops_max: an update wakes vertices at most this many edges away from its changes, 1 to 250.
        vertices_max: the mesh never has more vertices, 3 to 100,000,000.
    """

    seed: Optional[int] = None
    variant: Optional[str] = None
    smoothing: Optional[str] = None
    no_insert: bool = False
    no_swap: bool = False
    no_move: bool = False
    no_surf: bool = False
    step: Optional[float] = None
    speed_threshold: Optional[float] = None
    metric_tolerance: Optional[float] = None
    boundary_tolerance: Optional[float] = None
    hops_max: Optional[int] = None
    vertices_max: Optional[int] = None

    def to_wire(self):
        """The message."""
        restrictions = [wire for is_wanted, wire in (
            (self.no_insert, options_pb2.RESTRICTION_NO_INSERT),
            (self.no_swap, options_pb2.RESTRICTION_NO_SWAP),
            (self.no_move, options_pb2.RESTRICTION_NO_MOVE),
            (self.no_surf, options_pb2.RESTRICTION_NO_SURFACE)) if is_wanted]
        return options_pb2.SessionOptions(
            seed=self.seed, variant=_choice("variant", self.variant, _VARIANTS),
            smoothing=_choice("smoothing", self.smoothing, _SMOOTHINGS), step=self.step,
            speed_threshold=self.speed_threshold, metric_tolerance=self.metric_tolerance,
            boundary_tolerance=self.boundary_tolerance,
            hops_max=self.hops_max, vertices_max=self.vertices_max, restrictions=restrictions)


def durability_to_wire(durability: str):
    """The enum value. Raises InvalidInput for an unknown name."""
    return _choice("durability", durability, _DURABILITIES)


def split(options: Mapping[str, object]):
    """Keyword arguments as (Limits, SessionOptions). Raises TypeError for an unknown name."""
    known = {cls: {field.name for field in fields(cls)} for cls in (Limits, SessionOptions)}
    sorted_out = {Limits: {}, SessionOptions: {}}
    for name, value in options.items():
        canonical = _ALIASES.get(name, name)
        cls = next((cls for cls, names in known.items() if canonical in names), None)
        if cls is None:
            every = sorted(known[Limits] | known[SessionOptions] | set(_ALIASES))
            raise TypeError(f"unknown option {name!r}; the options are {', '.join(every)}")
        if canonical in sorted_out[cls]:
            raise TypeError(f"option {canonical!r} is given twice")
        sorted_out[cls][canonical] = value
    return Limits(**sorted_out[Limits]), SessionOptions(**sorted_out[SessionOptions])


def make_limits(options: Mapping[str, object]) -> Limits:
    """Keyword arguments as Limits. Raises TypeError for an unknown name."""
    limits, others = split(options)
    if others != SessionOptions():
        raise TypeError(f"only limits can change later; got {', '.join(options)}")
    return limits


def _choice(name, value, choices):
    if value is None:
        return None
    if value not in choices:
        raise InvalidInput("OUT_OF_RANGE", f"{name} must be one of {', '.join(choices)}; "
                           f"got {value!r}", field=f"options.{name}")
    return choices[value]
