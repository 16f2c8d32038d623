#!/usr/bin/python3
"""Solids by planes as probes are held: turned about an axis, beside it, part of a turn; fans, arcs, freehand, uneven stacks, long axes. Volume, pieces and handles.

    bench/arrangements.py --update docs/benchmarks.md
    bench/arrangements.py --program OTHER --beside build/release/anatomesh   # two programs, one after the other on each set
    bench/arrangements.py --arrangements "an arc,half held by hand" --solids 2

Contours are traced on a grid of 1 mm and have a vertex every 2.5 mm. What is wrong and not said by a warning is the worst.
"""
import argparse
import json
import math
import pathlib
import tempfile

import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy

from common import add_programs, columns, command, machine, modelled, note, programs_of, show, table

HALF, PIXEL, VERTICES = 50, 1, 2.5  # of what is looked at; of the grid; along contours. mm
LIMIT = 300                         # seconds a run may take
TELL = {"W-FLD-001", "W-FLD-002", "W-FLD-008", "W-PIP-004", "W-PIP-006", "W-PIP-007", "W-PIP-010"}


def scaled(p, half_axes):
    return np.linalg.norm(p / np.array(half_axes), axis=-1)


def bumpy(p):
    r = np.linalg.norm(p, axis=-1) + 1e-9
    across = np.arccos(np.clip(p[..., 2] / r, -1, 1))
    return r - 28 - 3 * np.sin(3 * np.arctan2(p[..., 1], p[..., 0])) * np.sin(across) ** 3 - 2.5 * np.cos(4 * across)


# A function that is negative inside; closed surfaces and handles.
SOLIDS = {"ellipsoid": (lambda p: (scaled(p, (30, 22, 40)) - 1) * 22, 1, 0), "bumpy ball": (bumpy, 1, 0),
          "shell": (lambda p: abs(scaled(p, (1, 0.9, 1.1)) - 28) - 4, 2, 0),
          "ring": (lambda p: np.hypot(np.hypot(p[..., 0], p[..., 1]) - 24, p[..., 2]) - 9, 1, 1),
          "two balls": (lambda p: np.minimum(scaled(p - [14, 0, 0], (1, 1, 1)) - 11, scaled(p - [-13, 2, 3], (1, 1, 1.6)) - 10), 2, 0)}


def about_z(angles, beside=0.0, lean=0.0):
    for angle in angles:
        normal = np.array([-math.sin(angle), math.cos(angle), lean])
        yield beside * normal, normal


def held(random, places, lean):
    for z in places:
        yield np.array([0, 0, z]), np.array([lean * random.normal(), lean * random.normal(), 1])


def apart(random, low, high, least, most):
    while low < high:
        yield low
        low += random.uniform(least, most)


ARRANGEMENTS = {
    "18 planes about an axis": lambda random: about_z(math.pi * np.arange(18) / 18),
    "18, all 3 mm beside it": lambda random: about_z(math.pi * np.arange(18) / 18, 3),
    "24, all 5 mm beside it": lambda random: about_z(math.pi * np.arange(24) / 24, 5),
    "18, all leaning by 7 degrees": lambda random: about_z(math.pi * np.arange(18) / 18, 0, 0.12),
    "14 at any angles": lambda random: about_z(np.sort(random.uniform(0, math.pi, 14))),
    "14 over 130 degrees": lambda random: about_z(np.radians(130) * np.arange(14) / 14),
    "a full turn, planes come twice": lambda random: about_z(2 * math.pi * np.arange(24) / 24 + 0.01 * random.normal(size=24)),
    "a fan, apex 45 mm off": lambda random: ((np.array([-45, 0, 0]), n) for _, n in about_z(np.radians(np.arange(-60, 61, 4)))),
    "an arc of 140 degrees": lambda random: ((np.array([0, 0, -20]), np.array([math.cos(a), 0, -math.sin(a)]))
                                             for a in np.radians(np.linspace(-70, 70, 30))),
    "freehand": lambda random: held(random, apart(random, -45, 45, 1.5, 5), 0.08),
    "freehand, dense": lambda random: held(random, apart(random, -45, 45, 0.3, 1.1), 0.02),
    "freehand, there and back": lambda random: [*held(random, np.arange(-45, 45, 4), 0.05), *held(random, np.arange(-44, 45, 4.3), 0.05)],
    "a sweep, and one across": lambda random: [*held(random, np.arange(-45, 45, 5), 0.03),
                                               *((o[[2, 0, 1]], n[[2, 0, 1]]) for o, n in held(random, np.arange(-45, 45, 5.5), 0.03))],
    "slices 1.5 to 6 mm apart": lambda random: held(random, apart(random, -45, 45, 1.5, 6), 0),
    "slices 8 mm apart, three across": lambda random: [*held(random, np.arange(-44, 45, 8), 0), *about_z([0.1, 1.1, 2.2])],
    "30 planes anywhere": lambda random: ((random.uniform(-20, 20) * n, n) for n in (v / np.linalg.norm(v) for v in random.normal(size=(30, 3)))),
}


def traced(solid, origin, u, v):
    """The closed lines where the solid is 0 on a plane, as points of it."""
    at = np.arange(-HALF, HALF + PIXEL, PIXEL)
    grid = origin + at[None, :, None] * u + at[:, None, None] * v
    image = vtk.vtkImageData()
    image.SetDimensions(len(at), len(at), 1)
    image.SetOrigin(-HALF, -HALF, 0)
    image.SetSpacing(PIXEL, PIXEL, 1)
    image.GetPointData().SetScalars(numpy_to_vtk(np.ascontiguousarray(solid(grid).ravel()), deep=True))
    lines, joined = vtk.vtkMarchingSquares(), vtk.vtkStripper()
    lines.SetInputData(image)
    lines.SetValue(0, 0)
    joined.SetInputConnection(lines.GetOutputPort())
    joined.JoinContiguousSegmentsOn()
    joined.SetMaximumLength(100000)
    joined.Update()
    found = joined.GetOutput()
    for k in range(found.GetNumberOfCells()):
        ids = found.GetCell(k).GetPointIds()
        line = vtk_to_numpy(found.GetPoints().GetData())[[ids.GetId(n) for n in range(ids.GetNumberOfIds())], :2].astype(float)
        along = np.r_[0, np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))]
        if along[-1] < 4 * PIXEL or np.linalg.norm(line[0] - line[-1]) > 1e-3:
            continue
        wanted = np.arange(max(4, int(along[-1] / VERTICES))) / max(4, int(along[-1] / VERTICES)) * along[-1]
        yield (origin + np.interp(wanted, along, line[:, 0])[:, None] * u + np.interp(wanted, along, line[:, 1])[:, None] * v).tolist()


def write_set(path, solid, planes):
    slices = []
    for number, (origin, normal) in enumerate(planes):
        normal = normal / np.linalg.norm(normal)
        v = np.eye(3)[2 if abs(normal[2]) < 0.8 else 1]
        v = (v - v @ normal * normal) / np.linalg.norm(v - v @ normal * normal)
        foot = origin @ normal * normal
        slices.append({"name": f"s{number}", "plane": {"origin": foot.tolist(), "normal": normal.tolist()},
                       "contours": [{"structure": 1, "points": points} for points in traced(solid, foot, np.cross(v, normal), v)]})
    path.write_text(json.dumps({"format": "anatomesh-contours", "version": 1, "space": "LPS", "unit": "mm",
                                "structures": [{"number": 1, "name": "solid"}], "slices": slices}))


def volume_of(solid):
    at = np.arange(-HALF, HALF, 0.5) + 0.25
    return 0.125 * np.count_nonzero(solid(np.stack(np.meshgrid(at, at, at, indexing="ij"), -1)) < 0)


def built(program, folder, path, truth):
    """Volume off in percent, whether pieces and handles are the solid's, whether a warning tells of gaps or joints, seconds; None: refused."""
    volume, surfaces, handles = truth
    made = modelled(program, path, folder, LIMIT)
    if not made:
        return None
    report, seconds = made
    structure = report["structures"][0]
    told = any(warning["code"] in TELL for warning in report["warnings"])
    return [100 * (structure["volume_mesh_mm3"] / volume - 1), (structure["components"], structure["genus"]) == (surfaces, handles), told, seconds]


def figures(found):
    """The cells of a row for one program."""
    models = [each for each in found if each]
    if not models:
        return [str(len(found)), "-", "-", "-", "-"]
    off = np.array([each[0] for each in models])
    wrong = [each for each in models if not each[1] or abs(each[0]) > 5]
    return [str(len(found) - len(models)), f"{abs(off).mean():.1f}, {off[np.argmax(abs(off))]:+.1f}", str(sum(not each[1] for each in models)),
            str(sum(not each[2] for each in wrong)), f"{sum(each[3] for each in models):.1f}"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_programs(parser)
    parser.add_argument("--arrangements", default=",".join(name.replace(",", ";") for name in ARRANGEMENTS),
                        help="of " + "; ".join(ARRANGEMENTS) + "; by words of their names, with commas between them")
    parser.add_argument("--solids", type=int, default=len(SOLIDS), help="the first so many of " + ", ".join(SOLIDS))
    arguments = parser.parse_args()
    asked = [word.strip().replace(";", ",") for word in arguments.arrangements.split(",")]
    names = [name for name in ARRANGEMENTS if any(word in name for word in asked)]
    if not names:
        parser.error("there is no such arrangement")
    programs = programs_of(arguments)
    solids = dict(list(SOLIDS.items())[:arguments.solids])
    truths = {name: (volume_of(solid), surfaces, handles) for name, (solid, surfaces, handles) in solids.items()}
    how, rows = f"{machine()}{command()}", []
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        for name in names:
            found = [[] for _ in programs]
            for seed, (solid, (distance, _, _)) in enumerate(solids.items()):
                write_set(folder / "slices.json", distance, ARRANGEMENTS[name](np.random.default_rng(100 + seed)))
                for own, program in zip(found, programs):
                    own.append(built(program, folder, folder / "slices.json", truths[solid]))
                note(f"{name}, {solid}: {[own[-1] for own in found]}")
            rows.append([name, *(cell for own in found for cell in figures(own))])
    head = ["planes", *columns(programs, "refused{}", "volume off, %: mean, worst", "pieces or handles wrong", "wrong and not told", "s")]
    show(arguments, "arrangements", how, table(head, rows))


if __name__ == "__main__":
    main()
