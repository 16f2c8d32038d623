#!/usr/bin/python3
"""measuring.py MODEL CONTOURS.vtp [SURFACE.json pieces|regions]

Figures of anybody's tetrahedral model as JSON, from its points, cells and regions alone: by VTK, numpy and scipy, with no code of the
program. What the end-to-end tests judge the program with (tests/e2e/judge.py) judges every mesher here. MODEL is a .vtu of the
program or of its bench; or a .mesh of a mesher that started from the surface which interfaces.py described in SURFACE.json, whose
references are its pieces or its regions.
"""
import json
import pathlib
import re
import sys

import numpy as np
import vtk
from scipy.spatial import cKDTree
from vtk.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray, vtk_to_numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "tests/e2e"))
import judge  # noqa: E402

SAME_POINT = 1e-6  # mm: rounding of meshers that write text


class Model:
    """points (n, 3); cells (m, 4), positive; regions (m,); structures: region -> numbers of the structures that it is part of."""

    def __init__(self, points, cells, regions, structures):
        known = np.isin(regions, list(structures))  # others are outside: cavities that a mesher filled
        self.points, self.cells, self.regions = points, cells[known].astype(np.int64), regions[known].astype(np.int64)
        self.structures = structures
        if len(self.cells) == 0:
            raise ValueError("no tetrahedra in any region")
        turned = judge.volumes(points, self.cells) < 0  # meshers differ in what they call positive
        self.cells[turned] = self.cells[turned][:, [1, 0, 2, 3]]

    def cells_of(self, number):
        return self.cells[np.isin(self.regions, [region for region, numbers in self.structures.items() if number in numbers])]


def read_vtu(path):
    """As the program and its bench write it: cell array `region`, and lines `REGION row = structures` in DESCRIPTION."""
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(path))
    reader.Update()
    grid = reader.GetOutput()
    lines = grid.GetFieldData().GetAbstractArray("DESCRIPTION")
    words = [lines.GetValue(i).split() for i in range(lines.GetNumberOfValues())]
    structures = {int(line[1]): [int(word) for word in line[3:]] for line in words if line[0] == "REGION"}
    return Model(vtk_to_numpy(grid.GetPoints().GetData()).astype(float),
                 vtk_to_numpy(grid.GetCells().GetConnectivityArray()).reshape(-1, 4),
                 vtk_to_numpy(grid.GetCellData().GetArray("region")), structures)


def read_medit(path, surface, references):
    text = "\n".join(line for line in path.read_text().splitlines() if not line.startswith("#"))

    def section(name, columns):
        found = re.search(rf"^\s*{name}\s+(\d+)\s", text, re.MULTILINE)
        if not found:
            raise ValueError(f"no {name} in {path.name}")
        return np.fromstring(text[found.end():], sep=" ", count=columns * int(found[1])).reshape(-1, columns)

    points, cells = section("Vertices", 4)[:, :3], section("Tetrahedra", 5).astype(np.int64)
    described = json.loads(surface.read_text())
    regions = cells[:, 4]
    if references == "pieces":
        region_of = {int(piece): region for piece, region in described["pieces"].items()}
        regions = np.array([region_of.get(piece, 0) for piece in regions.tolist()])
    return Model(points, cells[:, :4] - 1, regions, {int(region): numbers for region, numbers in described["structures"].items()})


def read_contours(path):
    """[(number of the structure, points (k, 3) without the first one again)] of a .vtp file."""
    reader = vtk.vtkXMLPolyDataReader()
    reader.SetFileName(str(path))
    reader.Update()
    poly = reader.GetOutput()
    points = vtk_to_numpy(poly.GetPoints().GetData()).astype(float)
    lines = poly.GetLines()
    numbers, starts = (vtk_to_numpy(array) for array in (lines.GetConnectivityArray(), lines.GetOffsetsArray()))
    structure = vtk_to_numpy(poly.GetCellData().GetArray("structure"))
    return [(int(number), points[numbers[start:end - 1]]) for number, start, end in zip(structure, starts[:-1], starts[1:])]


def distances(points, triangles, queries):
    """Of every query to the nearest point of the triangles."""
    poly = vtk.vtkPolyData()
    corners = vtk.vtkPoints()
    corners.SetData(numpy_to_vtk(points, deep=True))
    poly.SetPoints(corners)
    cells = vtk.vtkCellArray()
    flat = np.ascontiguousarray(triangles.reshape(-1), dtype=np.int64)
    cells.SetData(numpy_to_vtkIdTypeArray(np.arange(0, len(flat) + 1, 3, dtype=np.int64), deep=True),
                  numpy_to_vtkIdTypeArray(flat, deep=True))
    poly.SetPolys(cells)
    locator = vtk.vtkStaticCellLocator()
    locator.SetDataSet(poly)
    locator.BuildLocator()
    nearest, cell, part, squared = [0.0] * 3, vtk.reference(0), vtk.reference(0), vtk.reference(0.0)
    result = np.empty(len(queries))
    for i, query in enumerate(queries.tolist()):
        locator.FindClosestPoint(query, nearest, cell, part, squared)
        result[i] = squared.get()
    return np.sqrt(result)


def surface_figures(model, contours):
    """Summed over the structures: edges and vertices that are not manifold, contour vertices, and their distances."""
    bad_edges = bad_vertices = vertices = on_surface = 0
    from_contours = []
    for number in sorted({number for number, _ in contours}):
        drawn = [points for structure, points in contours if structure == number]
        ends = np.vstack(drawn)
        vertices += len(ends)
        cells = model.cells_of(number)
        if len(cells) == 0:  # lost: infinitely far
            from_contours.append(np.full(2 * len(ends), np.inf))
            continue
        surface = judge.boundary(cells)
        state = judge.topology(surface)
        bad_edges += state["open_edges"] + state["nonmanifold_edges"]
        bad_vertices += state["nonmanifold_vertices"]
        middles = np.vstack([0.5 * (points + np.roll(points, -1, axis=0)) for points in drawn])
        on_surface += int((cKDTree(model.points[np.unique(surface)]).query(ends)[0] <= SAME_POINT).sum())
        from_contours.append(distances(model.points, surface, np.vstack([ends, middles])))
    apart = np.concatenate(from_contours)
    return {"bad_edges": bad_edges, "bad_vertices": bad_vertices, "contour_vertices": vertices, "on_surface": on_surface,
            "contour_distance": {"mean": float(apart.mean()), "max": float(apart.max())}}


def figures(model, contours):
    """Everything that the tables show of a model. The share of the dihedral angles is of the smallest one of every cell."""
    ratio = judge.radius_edge(model.points, model.cells)
    angle = judge.smallest_dihedral(model.points, model.cells)
    return {"tetrahedra": len(model.cells),
            "radius_edge": {"mean": float(ratio.mean()), "max": float(ratio.max()), "share_over_2": float((ratio > 2).mean())},
            "dihedral": dict(zip(("min", "p001", "median"), np.percentile(angle, [0, 0.1, 50]).tolist())),
            **surface_figures(model, contours)}


def main():
    path, contours = map(pathlib.Path, sys.argv[1:3])
    try:
        model = read_vtu(path) if path.suffix == ".vtu" else read_medit(path, pathlib.Path(sys.argv[3]), sys.argv[4])
        print(json.dumps(figures(model, read_contours(contours))))
    except (AssertionError, ValueError) as error:
        sys.exit(f"cannot be judged: {error}")


if __name__ == "__main__":
    main()
