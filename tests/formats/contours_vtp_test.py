#!/usr/bin/python3
"""VTK and the program agree on contours as polydata, in both directions.

Usage: contours_vtp_test.py PROGRAM TMPDIR
"""
import json
import math
import pathlib
import subprocess
import sys

import vtk
from vtk.util.numpy_support import vtk_to_numpy


def rings():
    """Rings of two structures on three tilted planes: [(structure, slice, points)], and the planes' normals."""
    result = []
    for k in range(3):
        for structure, shift in ((2, 0.0), (9, 40.0)):
            ring = []
            for i in range(12):
                angle = i * math.pi / 6
                x, y = shift + 10 * math.cos(angle), (8 + k) * math.sin(angle)
                ring.append((x, y, 3.0 * k + 0.1 * y))
            result.append((structure, k, ring))
    return result


def write_json(path, contours):
    slices = []
    for k in range(3):
        slices.append({
            "name": f"slice {k}",
            "plane": {"origin": [0, 0, 3.0 * k], "normal": [0, -0.1, 1]},
            "contours": [{"structure": s, "points": p} for s, at, p in contours if at == k],
        })
    structures = [{"number": 2, "name": "L\u00f6we \"a\"", "color": [255, 0, 1]}, {"number": 9, "name": "<b>&"}]
    path.write_text(json.dumps({"format": "anatomesh-contours", "version": 1, "space": "LPS", "unit": "mm",
                                "structures": structures, "slices": slices}), encoding="utf-8")


def read_vtp(path):
    reader = vtk.vtkXMLPolyDataReader()
    errors = []
    reader.AddObserver("ErrorEvent", lambda *_: errors.append(1))
    reader.SetFileName(str(path))
    reader.Update()
    assert not errors and reader.GetErrorCode() == 0, path
    return reader.GetOutput()


def lines_of(data):
    ids = vtk.vtkIdList()
    lines = data.GetLines()
    lines.InitTraversal()
    while lines.GetNextCell(ids):
        yield [data.GetPoint(ids.GetId(i)) for i in range(ids.GetNumberOfIds())]


def turned_to_start(ring):
    """A closed ring from its smallest point on, in the direction of its smaller neighbour."""
    start = ring.index(min(ring))
    ring = ring[start:] + ring[:start]
    return min(tuple(ring), tuple(ring[:1] + ring[:0:-1]))


def check_written(program, folder):
    contours = rings()
    write_json(folder / "in.json", contours)
    subprocess.run([program, "contours", folder / "in.json", "-o", folder / "out.vtp", "--epsilon", "exact"], check=True)
    data = read_vtp(folder / "out.vtp")
    assert data.GetNumberOfLines() == len(contours) and data.GetNumberOfPolys() == 0
    assert data.GetNumberOfPoints() == sum(len(ring) for _, _, ring in contours)
    fields = data.GetFieldData()
    assert fields.GetAbstractArray("SPACE").GetValue(0) == "LPS"
    assert fields.GetAbstractArray("unit").GetValue(0) == "mm"
    names = fields.GetAbstractArray("structure_name")
    assert [names.GetValue(i) for i in range(2)] == ["L\u00f6we \"a\"", "<b>&"]
    assert list(vtk_to_numpy(fields.GetArray("structure_number"))) == [2, 9]
    assert fields.GetArray("structure_color").GetTuple3(0) == (255, 0, 1)
    assert fields.GetArray("slice_normal").GetNumberOfTuples() == 3
    structures = vtk_to_numpy(data.GetCellData().GetArray("structure"))
    slices = vtk_to_numpy(data.GetCellData().GetArray("slice"))
    found = []
    for structure, at, line in zip(structures, slices, lines_of(data)):
        assert line[0] == line[-1]
        found.append((int(structure), int(at), turned_to_start(line[:-1])))
    wanted = [(s, k, turned_to_start(ring)) for s, k, ring in contours]
    assert sorted(found) == sorted(wanted)  # to the last bit


def write_vtp(path, contours, mode, compressed):
    points, cells = vtk.vtkPoints(), vtk.vtkCellArray()
    points.SetDataTypeToDouble()
    structures = vtk.vtkIntArray()
    structures.SetName("structure")
    for structure, _, ring in contours:
        ids = [points.InsertNextPoint(p) for p in ring]
        cells.InsertNextCell(len(ids) + 1)
        for i in ids + ids[:1]:
            cells.InsertCellPoint(i)
        structures.InsertNextValue(structure)
    data = vtk.vtkPolyData()
    data.SetPoints(points)
    data.SetLines(cells)
    data.GetCellData().AddArray(structures)
    space = vtk.vtkStringArray()
    space.SetName("SPACE")
    space.InsertNextValue("LPS")
    data.GetFieldData().AddArray(space)
    writer = vtk.vtkXMLPolyDataWriter()
    writer.SetFileName(str(path))
    writer.SetInputData(data)
    getattr(writer, "SetDataModeTo" + mode)()
    if not compressed:
        writer.SetCompressorTypeToNone()
    writer.Write()


def check_read(program, folder):
    contours = rings()
    wanted = sorted((s, turned_to_start([tuple(p) for p in ring])) for s, _, ring in contours)
    for mode in ("Ascii", "Binary", "Appended"):
        for compressed in (True, False):
            path = folder / f"vtk_{mode}_{compressed}.vtp"
            write_vtp(path, contours, mode, compressed)
            out = folder / "back.json"
            subprocess.run([program, "contours", path, "-o", out, "--epsilon", "exact"], check=True)
            back = json.loads(out.read_text(encoding="utf-8"))
            assert back["space"] == "LPS"
            found = [(c["structure"], [tuple(p) for p in c["points"]]) for s in back["slices"] for c in s["contours"]]
            assert len(found) == len(wanted), path
            for (a_structure, a), (b_structure, b) in zip(
                    sorted((s, turned_to_start(ring)) for s, ring in found), wanted):
                assert a_structure == b_structure
                # VTK's ascii has fewer digits.
                tolerance = 1e-4 if mode == "Ascii" else 0
                assert all(abs(x - y) <= tolerance for p, q in zip(a, b) for x, y in zip(p, q)), path


def main(program, folder):
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    check_written(program, folder)
    check_read(program, folder)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2])
