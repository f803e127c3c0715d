"""Prints what meshio sees in a mesh file: points, lines and triangles with tags; fields."""

import contextlib
import struct
import sys

import meshio
import numpy

TAG_NAMES = ("medit:ref", "gmsh:physical", "tag")

# Its reader of .msh prints an empty line.
with contextlib.redirect_stdout(sys.stderr):
    mesh = meshio.read(sys.argv[1])
for point in mesh.points:
    print("point", *(struct.pack(">d", c).hex() for c in point[:2]))
tag_arrays = [mesh.cell_data[name] for name in TAG_NAMES if name in mesh.cell_data]
for kind in ("line", "triangle"):
    for number, block in enumerate(mesh.cells):
        if block.type != kind:
            continue
        tags = tag_arrays[0][number] if tag_arrays else numpy.zeros(len(block.data), int)
        for corners, tag in zip(block.data, tags):
            print(kind, *(int(c) for c in corners), "tag", int(tag))
for name, values in mesh.point_data.items():
    if name not in TAG_NAMES + ("gmsh:dim_tags",):
        print("field", name, values.reshape(-1).tolist())
