#!/usr/bin/python3
"""Is a model of slices as smooth as the solid meshed directly? Leaning ellipsoids, and the mean angle between neighbouring facets.

    bench/terraces.py --update docs/benchmarks.md

Of every ellipsoid: the program on its slices, at two positions of the slices; Gmsh on the solid itself, at the same mean
edge length; and an icosahedron cut finer and put onto it, which is convex at every edge, as no mesher's surface is.
"""
import argparse
import json
import math
import pathlib
import tempfile

import numpy as np
import vtk
from vtk.util.numpy_support import vtk_to_numpy

import measuring
from common import SOURCE, command, keep, machine, run, table

SOLIDS = [  # half axes, the direction of the first one, spacing of the slices and of the points on them, mm
    ((32, 24, 18), (1, 0.4, 0.6), 3, 2.5), ((32, 24, 18), (1, 0.3, 0.26), 3, 2.5), ((32, 24, 18), (1, 0.2, 0.1), 2, 2),
    ((32, 24, 18), (1, 0, 0), 3, 2.5), ((50, 35, 25), (1, 0.5, 0.35), 3, 2), ((30, 30, 15), (1, 0, 0.58), 3, 2.5),
    ((40, 20, 20), (1, 0.1, 1), 3, 2.5), ((32, 24, 18), (1, 0.3, 1.7), 2, 2.5), ((50, 35, 25), (1, 0.4, 0.4), 5, 4),
    ((45, 30, 22), (1, 0.4, 0.2), 3, 2), ((32, 24, 18), (1, 1, 1), 4, 3),
]
POSITIONS = 2
SAME_LENGTH = 0.02  # of the mean edge
BOUND = 1.2         # asked
LIMIT = 300         # seconds a run may take


def turn(along):
    """Columns: where the axes of the ellipsoid point."""
    x = np.array(along, float) / np.linalg.norm(along)
    y = np.cross([0.0, 0.0, 1.0], x)
    y /= np.linalg.norm(y)
    return np.column_stack([x, y, np.cross(x, y)])


def section(form, z, spacing):
    """Points about `spacing` apart on the curve x^T form x = 1 at this height; none where it is tiny."""
    across, beside = form[:2, :2], form[:2, 2]
    centre = -np.linalg.solve(across, beside) * z
    rest = 1 - form[2, 2] * z * z + centre @ across @ centre
    if rest <= 0.02:
        return None
    half = np.linalg.cholesky(np.linalg.inv(across)) * math.sqrt(rest)
    count = max(8, int(2 * math.pi * math.sqrt(abs(np.linalg.det(half))) / spacing))
    angles = 2 * math.pi * np.arange(count) / count
    return centre + np.column_stack([np.cos(angles), np.sin(angles)]) @ half.T


def smoothness(points, triangles, counts=None):
    """(mean angle between neighbouring facets in degrees, mean edge in mm), of edges between vertices that count."""
    corners = points[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    edges = np.sort(np.vstack([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    order = np.lexsort(edges.T)
    edges, facets = edges[order], (order % len(triangles))
    pairs = np.flatnonzero((edges[1:] == edges[:-1]).all(axis=1))
    if 2 * len(pairs) != len(edges):
        raise ValueError("the surface is not closed")
    ends = edges[pairs]
    if counts is not None:
        kept = counts[ends].all(axis=1)
        pairs, ends = pairs[kept], ends[kept]
    a, b = normals[facets[pairs]], normals[facets[pairs + 1]]
    angles = np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), (a * b).sum(axis=1)))
    return float(angles.mean()), float(np.linalg.norm(points[ends[:, 0]] - points[ends[:, 1]], axis=1).mean())


def of_slices(program, folder, solid, position):
    axes, along, gap, spacing = solid
    turned = turn(along)
    form = turned @ np.diag(1 / np.square(axes, dtype=float)) @ turned.T
    most = math.ceil(max(axes) / gap)
    slices = []
    for k in range(-most, most + 1):
        z = (k + position) * gap
        polygon = section(form, z, spacing)
        if polygon is not None:
            slices.append({"plane": {"origin": [0, 0, z], "normal": [0, 0, 1]},
                           "contours": [{"structure": 1, "points": [[x, y, z] for x, y in polygon.tolist()]}]})
    path, model = folder / "slices.json", folder / "model.vtu"
    path.write_text(json.dumps({"format": "anatomesh-contours", "version": 1, "space": "LPS", "unit": "mm",
                                "structures": [{"number": 1, "name": "ellipsoid"}], "slices": slices}))
    run([program, "model", path, "-o", model, "--quiet"], LIMIT)
    read = measuring.read_vtu(model)
    low, high = (slices[n]["plane"]["origin"][2] for n in (0, -1))
    # What lies beyond the first and the last slice is the business of the caps.
    between = (read.points[:, 2] > low + 0.01) & (read.points[:, 2] < high - 0.01)
    return smoothness(read.points, measuring.judge.boundary(read.cells_of(1)), between)


def by_icosahedron(axes, pieces):
    """Every facet in pieces^2, its vertices put onto the solid."""
    g = 0.5 * (1 + math.sqrt(5))
    corners = np.array([(-1, g, 0), (1, g, 0), (-1, -g, 0), (1, -g, 0), (0, -1, g), (0, 1, g), (0, -1, -g), (0, 1, -g), (g, 0, -1),
                        (g, 0, 1), (-g, 0, -1), (-g, 0, 1)])
    lengths = np.linalg.norm(corners[:, None] - corners[None], axis=2)
    near = lengths < 2.1
    facets = [(a, b, c) for a in range(12) for b in range(a) for c in range(b) if near[a, b] and near[b, c] and near[a, c]]
    numbers, points, triangles = {}, [], []

    def vertex(facet, i, j):
        at = corners[facet[0]] * (pieces - i - j) + corners[facet[1]] * i + corners[facet[2]] * j
        key = tuple(np.round(at, 6) + 0.0)
        if key not in numbers:
            numbers[key] = len(points)
            points.append(at / np.linalg.norm(at) * axes)
        return numbers[key]

    for a, b, c in facets:
        facet = (a, b, c) if np.linalg.det(corners[[a, b, c]]) > 0 else (a, c, b)
        for i in range(pieces):
            for j in range(pieces - i):
                triangles.append((vertex(facet, i, j), vertex(facet, i + 1, j), vertex(facet, i, j + 1)))
                if i + j + 2 <= pieces:
                    triangles.append((vertex(facet, i + 1, j), vertex(facet, i + 1, j + 1), vertex(facet, i, j + 1)))
    return smoothness(np.array(points), np.array(triangles))


def by_gmsh(folder, axes, size):
    geometry, surface = folder / "ellipsoid.geo", folder / "ellipsoid.stl"
    a, b, c = axes
    geometry.write_text('SetFactory("OpenCASCADE");\nSphere(1) = {0, 0, 0, 1};\n'
                        f"Affine{{{a}, 0, 0, 0, 0, {b}, 0, 0, 0, 0, {c}, 0}} {{ Volume{{1}}; }}\n"
                        f"Mesh.MeshSizeMin = {size!r};\nMesh.MeshSizeMax = {size!r};\n")
    run(["gmsh", geometry, "-2", "-format", "stl", "-o", surface], LIMIT)
    reader = vtk.vtkSTLReader()
    reader.SetFileName(str(surface))
    reader.Update()  # with the vertices that facets share
    poly = reader.GetOutput()
    points = vtk_to_numpy(poly.GetPoints().GetData()).astype(float)
    # Numbers of a text file: back onto the solid.
    points /= np.linalg.norm(points / axes, axis=1)[:, None]
    return smoothness(points, vtk_to_numpy(poly.GetPolys().GetConnectivityArray()).reshape(-1, 3))


def at_length(mesher, start, length):
    """The mean angle of the mesher's surface whose mean edge is so long; `start` is what it is asked for first."""
    size = start
    for _ in range(8):
        angle, edge = mesher(size)
        if abs(edge / length - 1) <= SAME_LENGTH:
            break
        size *= length / edge
    return angle * length / edge


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", type=pathlib.Path, default=SOURCE / "build/release/anatomesh")
    parser.add_argument("--solids", type=int, default=len(SOLIDS), help="so many of the ellipsoids")
    parser.add_argument("--update", type=pathlib.Path, metavar="PAGE", help="put the table between its markers in PAGE")
    arguments = parser.parse_args()
    how, rows, ratios = f"{machine()}{command()}", [], []
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for solid in SOLIDS[:arguments.solids]:
            axes, along, gap, spacing = solid
            ours = [of_slices(arguments.program.resolve(), folder, solid, (n + 0.3) / POSITIONS) for n in range(POSITIONS)]
            angle, length = np.mean(ours, axis=0)
            gmsh = at_length(lambda size: by_gmsh(folder, np.array(axes, float), size), length, length)
            _, edge = by_icosahedron(np.array(axes, float), 12)
            icosahedron, edge = by_icosahedron(np.array(axes, float), round(12 * edge / length))
            icosahedron *= length / edge
            ratios.append((angle / gmsh, angle / icosahedron))
            rows.append([" x ".join(map(str, axes)), " ".join(f"{v:g}" for v in along), f"{gap:g}", f"{length:.2f}", f"{angle:.2f}",
                         f"{gmsh:.2f}", f"{icosahedron:.2f}", f"{ratios[-1][0]:.2f}", f"{ratios[-1][1]:.2f}"])
    head = ["half axes, mm", "first axis", "slices, mm apart", "mean edge, mm", "ours, degrees", "Gmsh on the solid", "icosahedron",
            f"ours / Gmsh (asked: {BOUND:g})", "ours / icosahedron"]
    mean, most = np.mean(ratios, axis=0), np.max(ratios, axis=0)
    text = (f"{table(head, rows, 2)}\nBeside Gmsh's {mean[0]:.2f} times the angles in the mean, at most {most[0]:.2f}; beside the "
            f"icosahedron's {mean[1]:.2f}, at most {most[1]:.2f}.\n")
    print(text)
    if arguments.update:
        keep(arguments.update, "terraces", f"{how}\n{text}")


if __name__ == "__main__":
    main()
