#!/usr/bin/python3
"""netgen_mesher.py SURFACE.npz MODEL.mesh SIZE

Netgen, by its Python module, on interfaces that interfaces.py wrote: volume mesh and optimisation. Writes a Medit file whose references
are regions, and prints the seconds and CPU seconds of the mesher alone, reading and writing left out, as JSON.
"""
import json
import sys
import time

import netgen.meshing as ng
import numpy as np


def main():
    surface, model, size = sys.argv[1:4]
    faces = np.load(surface)
    mesh = ng.Mesh(dim=3)
    numbers = [mesh.Add(ng.MeshPoint(ng.Pnt(*p))) for p in faces["points"].tolist()]
    walls = {}
    for triangle, inner, outer in zip(faces["triangles"].tolist(), faces["inner"].tolist(), faces["outer"].tolist()):
        if (inner, outer) not in walls:
            wall = ng.FaceDescriptor(surfnr=len(walls) + 1, domin=inner, domout=outer, bc=len(walls) + 1)
            walls[inner, outer] = mesh.Add(wall)
        mesh.Add(ng.Element2D(walls[inner, outer], [numbers[v] for v in triangle]))
    start, cpu = time.monotonic(), time.process_time()
    mesh.GenerateVolumeMesh(ng.MeshingParameters(maxh=float(size)))
    seconds, cpu = time.monotonic() - start, time.process_time() - cpu
    cells = [[v.nr for v in element.points] + [element.index] for element in mesh.Elements3D()]
    if not cells:
        sys.exit("Netgen: no tetrahedra")
    with open(model, "w") as out:
        points = [tuple(p.p) for p in mesh.Points()]
        out.write(f"MeshVersionFormatted 2\nDimension 3\nVertices\n{len(points)}\n")
        out.writelines(f"{x!r} {y!r} {z!r} 0\n" for x, y, z in points)
        out.write(f"Tetrahedra\n{len(cells)}\n")
        out.writelines("%d %d %d %d %d\n" % tuple(cell) for cell in cells)
        out.write("End\n")
    print(json.dumps({"seconds": seconds, "cpu": cpu}))


if __name__ == "__main__":
    main()
