"""What a session must leave alone, as messages."""

from pliant import arrays
from pliant.v1 import motion_pb2, options_pb2


def command(revision, vertex_ids, edge_ids, regions, restrictions):
    """The `constraints` command of the edit stream, as (name, function that makes the message).

    Args:
        revision: whose ids are given.
        restrictions: {name of a Restriction: whether it holds}.
    """
    forbidden = [options_pb2.Restriction.Value(f"RESTRICTION_{name}")
                 for name, holds in restrictions.items() if holds]
    tags = [] if regions is None else arrays.as_integers("constraints.frozen_regions", regions)

    def ids(name, given, sender):
        return None if given is None else sender.array(
            arrays.as_integers(f"constraints.{name}", given))

    def make(sender):
        return motion_pb2.ConstraintUpdate(
            frozen_vertices=ids("frozen_vertices", vertex_ids, sender),
            frozen_edges=ids("frozen_edges", edge_ids, sender),
            frozen_regions=tags, restrictions=forbidden, revision=revision)

    return "constraints", make
