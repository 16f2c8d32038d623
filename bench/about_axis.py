#!/usr/bin/python3
"""Ellipsoids cut by planes about an axis beside their middle: how many contour segments are no chains of edges, how
far contours were led for the others' sake, and what cells cost.

    bench/about_axis.py --update docs/benchmarks.md
    bench/about_axis.py --program OTHER --beside build/release/anatomesh   # two programs, one after the other on each set

Half axes R, 0.8 R, 1.1 R. The vertices are anywhere along the contours, which all meet at two poles and run beside each other there.
"""
import argparse
import json
import math
import pathlib
import tempfile

import numpy as np

from common import add_programs, columns, command, count, machine, programs_of, run, show, table

# Planes; R and distance of the vertices, mm; distance of the axis from the middle, shares of R; seeds.
SETS = [(18, 10, 1, 0, (1, 2)), (18, 20, 1, 0.3, (1, 2)), (24, 20, 3, 0.2, (1, 2)), (36, 20, 1, 0.2, (1, 2, 3, 4)),
        (36, 30, 2, 0.1, (1, 2)), (60, 40, 1, 0.3, (1, 2))]
LIMIT = 600  # seconds a run may take


def contour(half_axes, origin, u, v, spacing, random):
    """Points about `spacing` apart on the ellipsoid in the plane origin + s u + t v."""
    at, along_u, along_v = origin / half_axes, u / half_axes, v / half_axes
    form = np.array([[along_u @ along_u, along_u @ along_v], [along_u @ along_v, along_v @ along_v]])
    centre = -np.linalg.solve(form, [at @ along_u, at @ along_v])
    rest = 1 - at @ at + centre @ form @ centre
    values, vectors = np.linalg.eigh(form)
    half = vectors @ np.diag(np.sqrt(rest / values))
    angles = np.linspace(0, 2 * math.pi, 20001)
    curve = half @ np.array([np.cos(angles), np.sin(angles)])
    lengths = np.r_[0, np.cumsum(np.hypot(*np.diff(curve, axis=1)))]
    number = max(8, round(lengths[-1] / spacing))
    angles = np.interp((np.arange(number) + random.random()) * lengths[-1] / number, lengths, angles)
    flat = half @ np.array([np.cos(angles), np.sin(angles)]) + centre[:, None]
    return origin + np.outer(flat[0], u) + np.outer(flat[1], v)


def write_set(path, planes, radius, spacing, beside, seed):
    random = np.random.default_rng(seed)
    half_axes = radius * np.array([1, 0.8, 1.1])
    origin = radius * beside * np.array([1, 0.5, 0])
    slices = []
    for k in range(planes):
        u = np.array([math.cos(math.pi * k / planes), math.sin(math.pi * k / planes), 0])
        v = np.array([0.0, 0.0, 1.0])
        points = contour(half_axes, origin, u, v, spacing, random)
        slices.append({"plane": {"origin": origin.tolist(), "normal": np.cross(u, v).tolist()},
                       "contours": [{"structure": 1, "points": points.tolist()}]})
    path.write_text(json.dumps({"format": "anatomesh-contours", "version": 1, "space": "LPS", "unit": "mm",
                                "structures": [{"number": 1, "name": "ellipsoid"}], "slices": slices}))


def measured(program, folder, path):
    """(segments, missed, led, how far at most, seconds, cells with an angle below 10 degrees, their share above radius-edge ratio 2)."""
    seconds = run([program, "model", path, "-o", folder / "model.vtu", "--quiet", "--threads", "2"], LIMIT)["seconds"]
    report = json.loads((folder / "model.report.json").read_text())
    structure, quality = report["structures"][0], report["quality"]
    led = report["followed_contours"]
    return np.array([structure["contour_segments"], structure["contour_segments"] - structure["contour_segments_on_surface"],
                     sum(contour["segments"] for contour in led), max([contour["farthest_mm"] for contour in led], default=0), seconds,
                     quality["dihedral_deg"]["tetrahedra_below_10"], 100 * quality["radius_edge"]["share_over_2"]])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_programs(parser)
    parser.add_argument("--sets", type=int, default=len(SETS), help="so many of the rows")
    arguments = parser.parse_args()
    programs = programs_of(arguments)
    how, rows = f"{machine()}{command()}", []
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for planes, radius, spacing, beside, seeds in SETS[:arguments.sets]:
            found = []
            for seed in seeds:
                write_set(folder / "slices.json", planes, radius, spacing, beside, seed)
                found.append([measured(program, folder, folder / "slices.json") for program in programs])
            found = np.array(found)  # by seed, program and figure
            row = [str(planes), f"{radius:g}; {spacing:g}; {beside:g} R", str(len(seeds)), count(found[:, 0, 0].sum())]
            for own in found.transpose(1, 0, 2):
                row += [f"{count(own[:, 1].sum())} ({count(own[:, 1].max())})", f"{count(own[:, 2].sum())} ({own[:, 3].max():.3f})",
                        f"{np.median(own[:, 4]):.1f}", count(own[:, 5].sum()), f"{own[:, 6].mean():.2f}"]
            rows.append(row)
    head = ["planes", "R, mm; vertices, mm apart; axis from the middle", "sets", "segments"]
    head += columns(programs, "missed{}, the worst set", "led, mm at most", "s, median", "angles below 10", "above ratio 2, %")
    show(arguments, "about an axis", how, table(head, rows))


if __name__ == "__main__":
    main()
