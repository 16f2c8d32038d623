"""The scripts of the benchmarks at tiny sizes, and what they judge meshers by on solids whose figures are known."""
import json
import os
import shutil
import subprocess
import unittest

import numpy as np

import harness
import shapes

BENCH = harness.SOURCE / "bench"
PYTHON = "/usr/bin/python3"


def cube(corner, region):
    """Six tetrahedra: points (8, 3), cells from 0."""
    points = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], float) + corner
    cells = [(0, a, b, 7) for a, b in ((1, 3), (3, 2), (2, 6), (6, 4), (4, 5), (5, 1))]
    return points, cells, region


class Scripts(harness.TestCase):
    def script(self, name, *words, expect=0):
        done = subprocess.run([PYTHON, str(BENCH / name), *map(str, words)], cwd=self.folder, capture_output=True, text=True, timeout=300)
        self.assertEqual(done.returncode, expect, done.stdout + done.stderr)
        return done.stdout if expect == 0 else done.stderr

    def ball(self, path):
        self.write("ball.json", shapes.sphere(10.0, 2.0).document())
        path.parent.mkdir(parents=True, exist_ok=True)
        self.run_program("contours", "ball.json", "-o", path)

    def page(self, *names):
        page = self.folder / "page.md"
        page.write_text("before\n" + "".join(f"<!-- {name}: begin -->\nold\n<!-- {name}: end -->\n" for name in names) + "after\n")
        return page

    def test_every_mesher_is_a_row(self):
        """CGAL's peer is not built here, others may not be installed: their rows say so."""
        self.ball(self.folder / "data/contours/spleen_ct_3mm.csl")
        page = self.page("every mesher on every case", "seconds by stage")
        self.script("run.py", "--program", harness.PROGRAM, "--build", self.folder, "--data", self.folder / "data", "--case", "spleen",
                    "--runs", 1, "--update", page)
        text = page.read_text()
        self.assertTrue(text.startswith("before\n") and text.endswith("after\n"))
        self.assertNotIn("\nold\n", text)
        rows = [line.split(" | ") for line in text.splitlines() if line.startswith("| ")]
        meshers = {row[1]: row for row in rows}
        for name in ("anatomesh", "anatomesh, 2 threads"):
            self.assertIn("yes", meshers[name])
            self.assertIn("100.00 % |", meshers[name])
        self.assertEqual(sum("no model: " in row[2] and row[1].startswith("CGAL") for row in rows), 3)
        for name, command in (("TetGen", "tetgen"), ("Gmsh HXT", "gmsh")):
            row = next(row for row in rows if row[1].startswith(name))
            if shutil.which(command):
                self.assertIn("on ours", row[1])
                self.assertIn("yes", row)
                self.assertIn("0.0000 / 0.000", row)
            else:
                self.assertIn("no model: ", row[2])
        self.assertTrue(any(row[1].startswith("Netgen") for row in rows))

    def test_data_that_is_not_there_is_a_row(self):
        text = self.script("run.py", "--program", harness.PROGRAM, "--data", self.folder, "--case", "fetal")
        self.assertIn("left out: no contours/fetal_brain", text)

    def test_growth(self):
        self.ball(self.folder / "ball.csl")
        page = self.page("growth")
        words = ["--program", harness.PROGRAM, "--sizes", "3,1.5", "--update", page, "--", "ball.csl", "--frame", "LPS"]
        self.script("growth.py", *words)
        text = page.read_text()
        self.assertIn("| 3 mm | ", text)
        self.assertIn("| 1.5 mm | ", text)
        self.assertIn("The largest exponent is ", text)
        self.page("another")
        self.assertIn("must be there once each", self.script("growth.py", *words, expect=1))

    @unittest.skipUnless(shutil.which("gmsh"), "gmsh is not installed")
    def test_terraces(self):
        page = self.page("terraces")
        self.script("terraces.py", "--program", harness.PROGRAM, "--solids", 1, "--update", page)
        rows = [line.split(" | ") for line in page.read_text().splitlines() if line.startswith("| 32 x 24 x 18 | ")]
        self.assertEqual(len(rows), 1)
        length, ours, gmsh, icosahedron = (float(word) for word in rows[0][3:7])
        # Facets of edges so long on a ball of the mean radius.
        self.assertLess(abs(icosahedron / np.degrees(length / np.sqrt(3) / 24) - 1), 0.3)
        self.assertGreater(gmsh, icosahedron)
        self.assertLess(ours / gmsh, 1.2)


    def test_about_axis(self):
        page = self.page("about an axis")
        self.script("about_axis.py", "--program", harness.PROGRAM, "--sets", 1, "--update", page)
        rows = [line.split(" | ") for line in page.read_text().splitlines() if line.startswith("| 18 | ")]
        self.assertEqual(len(rows), 1)
        segments, missed = int(rows[0][3].replace(",", "")), int(rows[0][4].split(" ")[0])
        # Two sets of eighteen curves about as long as a circle of the mean radius, points 1 mm apart.
        self.assertLess(abs(segments / (2 * 18 * 2 * np.pi * 9.7) - 1), 0.1)
        self.assertLessEqual(missed, 0.001 * segments)

    def test_arrangements(self):
        page = self.page("arrangements")
        self.script("arrangements.py", "--program", harness.PROGRAM, "--solids", 1, "--arrangements", "beside,130,a fan", "--update", page)
        rows = [line.strip("| ").split(" | ") for line in page.read_text().splitlines() if line.startswith("| ")][1:]
        self.assertEqual([row[0] for row in rows], ["18, all 3 mm beside it", "24, all 5 mm beside it", "14 over 130 degrees", "a fan, apex 45 mm off"])
        for _, refused, volume, wrong, untold, seconds in rows:
            self.assertEqual((refused, wrong, untold), ("0", "0", "0"))
            self.assertLess(float(volume.split(",")[0]), 2)
            self.assertGreater(float(seconds), 0)
        self.assertIn("no such arrangement", self.script("arrangements.py", "--arrangements", "upside down", expect=2))

    def test_varied(self):
        self.write("ball.json", shapes.sphere(10.0, 2.0).document())
        page = self.page("varied")
        self.script("varied.py", "ball.json", "--program", harness.PROGRAM, "--update", page)
        rows = {line.split(":")[0].strip("| "): line.strip("| ").split(" | ") for line in page.read_text().splitlines() if line.startswith("| ")}
        self.assertEqual(len(rows), 7)
        for kind in ("turned", "mirrored", "jittered", "shifted", "thinned", "halved"):
            models, refused, segments, missed, cuts, broken = rows[kind][1:7]
            self.assertEqual((models, refused, missed, cuts.split()[0], broken), ("1", "0", "0", "0", "0"), rows[kind])
            self.assertGreater(int(segments.replace(",", "")), 100)
        whole = [int(rows[kind][3].replace(",", "")) for kind in ("turned", "mirrored", "shifted")]
        self.assertEqual(whole, [whole[0]] * 3)
        self.assertLess(int(rows["halved"][3].replace(",", "")), whole[0])
        self.assertIn("kinds are", self.script("varied.py", "ball.json", "--kinds", "upside", expect=2))


class Accuracy(harness.TestCase):
    """The tables of bench/accuracy.py, of a ball whose surface is known."""

    def row(self, *words):
        program = os.environ.get("ANATOMESH_ACCURACY", str(harness.SOURCE / "build/release/bench/anatomesh_accuracy"))
        done = subprocess.run([program, *words, "--header"], cwd=self.folder, capture_output=True, text=True, timeout=300)
        self.assertEqual(done.returncode, 0, done.stderr)
        head, rule, row = done.stdout.strip().splitlines()
        self.assertEqual([line.count(" | ") for line in (row, head)], [rule.count("|") - 2] * 2)
        return row.strip("| ").split(" | ")

    def test_slices_left_out(self):
        self.write("ball.json", shapes.sphere(10.0, 2.0).document())
        figures = [float(word) for word in self.row("ball.json", "--every", "2")[4:]]
        (nearest, far), (between, off), (ours, near) = zip(figures[::2], figures[1::2])
        self.assertTrue(nearest < between < ours < 1, figures)
        self.assertTrue(far > off > near > 0, figures)

    def test_planes_in_any_position(self):
        self.write("ball.json", shapes.sphere(10.0, 1.0).document())
        for kind in ("axis", "stacks"):
            row = self.row("ball.json", "--cut", kind, "--planes", "18", "--points", "1")
            self.assertTrue(row[1].endswith(kind), row)
            nearest, _, between, _, field, _, to_model, _, to_truth, _ = (float(word) for word in row[3:13])
            self.assertTrue(nearest >= field > 0 and between >= field, row)
            self.assertTrue(0 < to_model < 0.5 and 0 < to_truth < 0.5, row)


class Judging(harness.TestCase):
    def medit(self, *parts):
        points, cells = np.vstack([part[0] for part in parts]), []
        for i, (_, mine, region) in enumerate(parts):
            cells += [(*(v + 1 + sum(len(part[0]) for part in parts[:i]) for v in cell), region) for cell in mine]
        text = f"MeshVersionFormatted 2\nDimension 3\nVertices\n{len(points)}\n" + "".join(f"{x} {y} {z} 0\n" for x, y, z in points)
        return self.write("model.mesh", text + f"Tetrahedra\n{len(cells)}\n" + "".join(" ".join(map(str, c)) + "\n" for c in cells) + "End\n")

    def figures(self, model, outline, z=0.0):
        """Of a model whose references are regions 1 and 2, beside one polygon of structure 1."""
        self.write("drawn.json", {"format": "anatomesh-contours", "version": 1, "space": "LPS", "unit": "mm",
                                  "structures": [{"number": 1, "name": "one"}],
                                  "slices": [{"plane": {"origin": [0, 0, z], "normal": [0, 0, 1]},
                                              "contours": [{"structure": 1, "points": [[x, y, z] for x, y in outline]}]}]})
        self.run_program("contours", "drawn.json", "-o", "drawn.vtp")
        surface = self.write("surface.json", {"pieces": {"7": 1, "8": 2}, "structures": {"1": [1], "2": [1]}})
        done = subprocess.run([PYTHON, str(BENCH / "measuring.py"), str(model), "drawn.vtp", str(surface), "regions"], cwd=self.folder,
                              capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(done.stdout)

    def test_regular_tetrahedron(self):
        points = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]], float)
        for cell in ((0, 1, 2, 3), (1, 0, 2, 3)):  # whatever a mesher calls positive
            found = self.figures(self.medit((points, [cell], 1)), [(-1, -1), (1, -1), (1, 1), (-1, 1)], z=3.0)
            self.assertAlmostEqual(found["radius_edge"]["mean"], np.sqrt(3 / 8))
            self.assertAlmostEqual(found["dihedral"]["min"], np.degrees(np.arccos(1 / 3)))
            self.assertEqual((found["bad_edges"], found["bad_vertices"], found["on_surface"]), (0, 0, 0))
            self.assertAlmostEqual(found["contour_distance"]["max"], np.sqrt(6))  # (1, -1, 3) from (0, 0, 1)

    def test_cubes(self):
        unit = [(0, 0), (1, 0), (1, 1), (0, 1)]
        found = self.figures(self.medit(cube([0, 0, 0], 1)), unit)
        self.assertEqual((found["tetrahedra"], found["contour_vertices"], found["on_surface"]), (6, 4, 4))
        self.assertAlmostEqual(found["dihedral"]["min"], 45)
        self.assertAlmostEqual(found["contour_distance"]["max"], 0)
        off = self.figures(self.medit(cube([0, 0, 0.25], 1)), unit)
        self.assertEqual(off["on_surface"], 0)
        self.assertAlmostEqual(off["contour_distance"]["mean"], 0.25)
        unknown = self.figures(self.medit(cube([0, 0, 0], 1), cube([5, 0, 0], 3)), unit)
        self.assertEqual(unknown["tetrahedra"], 6, "cells in no region are outside")

    def test_cubes_that_share_an_edge_are_not_manifold(self):
        one, other = cube([0, 0, 0], 1), cube([1, 1, 0], 2)
        places = {tuple(p): i for i, p in enumerate(one[0].tolist())}
        numbers = [places.setdefault(tuple(p), len(places)) for p in other[0].tolist()]
        points = np.array(list(places))
        cells = [tuple(numbers[v] for v in cell) for cell in other[1]]
        outline = [(0, 0), (1, 0), (1, 1)]
        for mine, expected in ((one[1], (0, 0)), (cells, (0, 0)), (one[1] + cells, (1, 2))):
            found = self.figures(self.medit((points, mine, 1)), outline)
            self.assertEqual((found["bad_edges"], found["bad_vertices"]), expected)

    def test_interfaces_of_a_hollow_ball_and_its_core(self):
        """A shell between 6 and 10 mm, and in its void a ball of 3 mm of another structure: one cavity, two pieces."""
        shape = shapes.Shape({1: "shell", 2: "core"}, 1.0)
        for z in np.arange(-9.5, 10):
            rings = [(1, shapes.circle(np.sqrt(100 - z * z), 48))]
            rings += [(1, shapes.circle(np.sqrt(36 - z * z), 32))] if abs(z) < 6 else []
            rings += [(2, shapes.circle(np.sqrt(9 - z * z), 24))] if abs(z) < 3 else []
            shape.add_slice(z, rings)
        self.write("hollow.json", shape.document())
        self.run_program("model", "hollow.json", "-o", "hollow.vtu")
        done = subprocess.run([PYTHON, str(BENCH / "interfaces.py"), "hollow.vtu", "hollow"], cwd=self.folder, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        described = json.loads((self.folder / "hollow.json").read_text())
        self.assertEqual(sorted(described["pieces"].values()), [1, 2])
        lines = (self.folder / "hollow.poly").read_text().splitlines()
        at = 1 + int(lines[0].split()[0])
        at += 1 + 2 * int(lines[at].split()[0])
        self.assertEqual(lines[at], "1", "cavities")
        radius = np.linalg.norm(list(map(float, lines[at + 1].split()[1:4])))
        self.assertTrue(3 < radius < 6.1, radius)
        seeds = [line.split() for line in lines[at + 3:at + 5]]
        radii = {int(seed[4]): np.linalg.norm(list(map(float, seed[1:4]))) for seed in seeds}
        self.assertTrue(5.9 < radii[1] < 10 and radii[2] < 3, radii)
        self.assertEqual((self.folder / "hollow.geo").read_text().count("\nVolume("), 2)


if __name__ == "__main__":
    harness.main(__name__)
