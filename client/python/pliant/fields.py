"""Values that follow the mesh: fields on the server, and transfer rows for a client's own."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from pliant import arrays
from pliant.errors import FailedPrecondition, InvalidInput
from pliant.v1 import mesh_pb2, motion_pb2

_LOCATIONS = {"vertex": mesh_pb2.FIELD_LOCATION_VERTEX,
              "triangle": mesh_pb2.FIELD_LOCATION_TRIANGLE}
_TRANSFERS = {"linear": motion_pb2.TRANSFER_LINEAR, "bounded": motion_pb2.TRANSFER_BOUNDED,
              "conservative": motion_pb2.TRANSFER_CONSERVATIVE}


@dataclass(frozen=True, eq=False)
class FieldRows:
    """New values of one field, part of a `Diff`.

    Attributes:
        name: of the field.
        location: "vertex" or "triangle".
        ids: (k,) int32 slots.
        values: (k,), (k, 2) or (k, 3) float64.
    """

    name: str
    location: str
    ids: np.ndarray
    values: np.ndarray


@dataclass(frozen=True, eq=False)
class TransferRows:
    """A sparse matrix from nodal values of one revision to those of the next, part of a `Diff`.

    value_new[vertex_ids[i]] = sum_j weights[i, j] * value_old[sources[i, j]]; vertices without a
    row keep their value. Weights are >= 0 and add up to exactly 1.

    Attributes:
        vertex_ids: (k,) int32 slots of new and moved vertices.
        sources: (k, 3) int32 old slots; -1 for an unused entry.
        weights: (k, 3) float64; 0 for an unused entry.
    """

    vertex_ids: np.ndarray
    sources: np.ndarray
    weights: np.ndarray

    def carry(self, values: Any, old, new) -> np.ndarray:
        """Nodal values for the mesh `new` from those for `old`, bit for bit as the server's own
        linear transfer.

        Args:
            values: (n,) or (n, c), row i at `old.points[i]`.
            old, new: `session.mesh` before and after the diff that this is part of.
        """
        values = np.asarray(values, float)
        if len(values) != len(old.points):
            raise InvalidInput("ARRAY_LENGTH", f"values has {len(values)} rows; expected "
                               f"{len(old.points)}, one for each point of the old mesh",
                               field="values")
        kept = old.rows_of(new.vertex_ids)
        result = values[np.maximum(kept, 0)]
        # An unused entry takes the first source: its difference is 0.
        used = np.where(self.sources >= 0, self.sources, self.sources[:, :1])
        first, second, third = (values[old.rows_of(used[:, j])] for j in range(3))
        weights = self.weights.reshape(self.weights.shape + (1,) * (values.ndim - 1))
        result[new.rows_of(self.vertex_ids)] = first + (
            weights[:, 1] * (second - first) + weights[:, 2] * (third - first))
        return result


def rows_from_wire(message, blobs):
    """The TransferRows of a `MeshDiff` message; None where it has none."""
    if not message.HasField("transfer"):
        return None
    rows = message.transfer
    return TransferRows(blobs.array(rows.vertex_ids, "transfer.vertex_ids", "<i4"),
                        blobs.array(rows.sources, "transfer.sources", "<i4", 3),
                        blobs.array(rows.weights, "transfer.weights", "<f8", 3))


def fields_from_wire(message, blobs):
    """The FieldRows of a `MeshDiff` or `MeshSnapshot` message, and the names of dropped fields."""
    fields, dropped_names = [], []
    for field in message.fields:
        if field.location == mesh_pb2.FIELD_LOCATION_UNSPECIFIED:
            dropped_names.append(field.name)
            continue
        column_count = field.values.shape[1] if len(field.values.shape) == 2 else None
        location = "vertex" if field.location == mesh_pb2.FIELD_LOCATION_VERTEX else "triangle"
        fields.append(FieldRows(
            field.name, location, blobs.array(field.ids, "fields.ids", "<i4"),
            blobs.array(field.values, "fields.values", "<f8", column_count)))
    return fields, dropped_names


def field_values(name, values, ids, location, sender):
    """The message for values of one field, checked as far as a client can."""
    field = f"fields.{name}"
    if location not in _LOCATIONS:
        raise InvalidInput("OUT_OF_RANGE", f"location is {location!r}; expected 'vertex' or "
                           "'triangle'", field="location")
    given = np.asarray(values)
    if given.ndim == 1:
        given = arrays.as_floats(field, given.reshape(-1, 1), 1).reshape(-1)
    else:
        if given.ndim != 2 or not 1 <= given.shape[1] <= 3:
            raise InvalidInput("ARRAY_LENGTH", f"{field} has the shape {given.shape}; expected "
                               "(n,) for a scalar, (n, 2) for a vector or (n, 3) for a symmetric "
                               f"tensor, one row for each {location}", field=field)
        given = arrays.as_floats(field, given, given.shape[1])
    return mesh_pb2.FieldValues(
        name=name, location=_LOCATIONS[location], values=sender.array(given),
        ids=None if ids is None else sender.array(arrays.as_integers("fields.ids", ids)))


def command(revision, counts, name, values, ids, location, transfer):
    """Name and maker of the command that sets a field of a mesh with these counts."""
    kind = transfer_kind(transfer)
    if ids is None and location in ("vertex", "triangle"):
        arrays.check_rows(f"fields.{name}", np.atleast_1d(values),
                          counts.vertices if location == "vertex" else counts.triangles,
                          f"{location} of the mesh")

    def make(sender):
        return motion_pb2.FieldUpdate(values=[field_values(name, values, ids, location, sender)],
                                      revision=revision, transfer=kind)

    return "fields", make


def transfer_kind(transfer):
    """The wire's name for a kind of transfer; None stays None."""
    if transfer is not None and transfer not in _TRANSFERS:
        raise InvalidInput("OUT_OF_RANGE", f"transfer is {transfer!r}; expected 'linear', "
                           "'bounded' or 'conservative'", field="transfer")
    return None if transfer is None else _TRANSFERS[transfer]


class FieldTable:
    """The fields of a replica: values by slot."""

    def __init__(self):
        self._fields = {}

    def write(self, rows, dropped_names):
        """Takes over what a change says."""
        for name in dropped_names:
            self._fields.pop(name, None)
        for field in rows:
            location, values = self._fields.get(field.name, (None, None))
            tail = field.values.shape[1:]
            if location != field.location or values.shape[1:] != tail:
                values = np.zeros((0,) + tail)
            slot_count = int(field.ids[-1]) + 1 if len(field.ids) else 0
            if slot_count > len(values):
                grown = np.zeros((max(slot_count, len(values) * 3 // 2),) + tail)
                grown[:len(values)] = values
                values = grown
            values[field.ids] = field.values
            self._fields[field.name] = (field.location, values)

    def values(self, name, view):
        """The values of a field for a `MeshView`."""
        if name not in self._fields:
            known = ", ".join(sorted(self._fields)) or "none"
            raise FailedPrecondition("OUT_OF_RANGE", f"the session has no field {name!r}; there "
                                     f"are: {known}")
        location, values = self._fields[name]
        return values[view.vertex_ids if location == "vertex" else view.triangle_ids]

    def names(self):
        """Ascending."""
        return sorted(self._fields)
