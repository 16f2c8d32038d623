"""Overlaps and how sure a surface is: --priority, --separate, --caps rounded, --uncertainty, where-next."""
import json
import math
import unittest

import numpy as np

import harness
import judge
import shapes


def radius(z):
    """Wavy: what lies between two slices is not foretold well by the others."""
    return 8 + 1.2 * math.sin(math.pi * z / 6)


def two_cylinders(missing=None):
    """Wavy cylinders that overlap, 3 mm apart."""
    shape = shapes.Shape({1: "left", 2: "right"}, 3)
    for z in range(0, 30, 3):
        if z != missing:
            shape.add_slice(float(z), [(n, shapes.circle(radius(z), 48, (x, 0.0))) for n, x in ((1, -4), (2, 4))])
    return shape


def areas(shape):
    """Of one cylinder and of what both have in common, summed over the slices, mm2."""
    whole = common = 0.0
    for z, _ in shape.slices:
        r = radius(z)
        whole += math.pi * r * r
        common += 2 * r * r * math.acos(4 / r) - 8 * math.sqrt(r * r - 16)
    return whole, common


class Overlaps(harness.TestCase):
    def test_priority_gives_the_overlap_to_the_structure_named(self):
        shape = two_cylinders()
        self.write("two.json", shape.document())
        result = self.run_program("model", "two.json", "-o", "two.vtu", "--priority", "right")
        self.assertIn("W-CMD-006", result.err)
        model = judge.Model(self.folder / "two.vtu")
        whole, common = areas(shape)
        self.assertAlmostEqual(model.volume(2) / (3 * whole), 1, delta=0.03)
        self.assertAlmostEqual(model.volume(1) / (3 * (whole - common)), 1, delta=0.03)
        self.assertEqual(set(np.unique(model.structure)), {1, 2})

    def test_a_thin_wall_round_a_chamber_is_whole_however_far_it_moves(self):
        shape = shapes.Shape({1: "chamber", 2: "wall"}, 4)
        for k in range(9):
            shape.add_slice(4.0 * k, [(1, shapes.circle(10, 40, (4.0 * k, 0.0))), (2, shapes.circle(12.5, 48, (4.0 * k, 0.0)))])
        self.write("pipe.json", shape.document())
        result = self.run_program("model", "pipe.json", "-o", "pipe.vtu", "--priority", "chamber", "--contours", "used.json")
        self.assertNotIn("W-PIP-004", result.err)
        report = json.loads((self.folder / "pipe.report.json").read_text())
        self.assertEqual([(s["components"], s["genus"]) for s in report["structures"]], [(1, 0), (1, 1)])
        self.assertEqual([clause["state"] for clause in report["certificate"]], ["kept"] * 6)
        # Between the slices the wall is what is between both outlines: of circles that shear, the same area.
        model = judge.Model(self.folder / "pipe.vtu")
        self.assertAlmostEqual(model.volume(1) / (math.pi * 100 * 36), 1, delta=0.02)
        self.assertAlmostEqual(model.volume(2) / (math.pi * (12.5**2 - 100) * 36), 1, delta=0.02)
        checked = self.run_program("check", "pipe.vtu", "--contours", "pipe.json", "--json").json()
        self.assertEqual([checked["certificate"][n]["state"] for n in (0, 1, 2, 3, 5)], ["kept"] * 5)
        # The contours that are left do not tell of it.
        checked = self.run_program("check", "pipe.vtu", "--contours", "used.json", "--json").json()
        self.assertEqual(checked["certificate"][0]["state"], "kept")
        self.assertIn("before overlaps were given", checked["certificate"][5]["evidence"])

    def test_priority_where_nothing_overlaps_is_told(self):
        shape = shapes.Shape({1: "left", 2: "right"}, 3)
        for z in range(0, 12, 3):
            shape.add_slice(float(z), [(n, shapes.circle(4, 24, (x, 0.0))) for n, x in ((1, -5), (2, 5))])
        self.write("apart.json", shape.document())
        result = self.run_program("model", "apart.json", "-o", "apart.vtu", "--priority", "right")
        self.assertIn("W-CMD-007", result.err)

    def test_a_structure_that_there_is_not_is_refused(self):
        self.write("two.json", two_cylinders().document())
        result = self.run_program("model", "two.json", "-o", "two.vtu", "--priority", "middle", expect=2)
        self.assertIn("E-CMD-005", result.err)

    def test_separate_makes_a_whole_model_of_each(self):
        shape = two_cylinders()
        self.write("two.json", shape.document())
        answer = self.run_program("model", "two.json", "-o", "two.vtu", "--surface", "two.stl", "--separate",
                                  "--contours", "kept.vtp", "--html", "page.html", "--dump", "cut=cut.vtu",
                                  "--uncertainty", "--json").json()
        self.assertEqual(len(answer["models"]), 2)
        whole, _ = areas(shape)
        for number in (1, 2):
            self.assertTrue((self.folder / f"two-{number}.stl").exists())
            for name in (f"kept-{number}.vtp", f"page-{number}.html", f"cut-{number}.vtu"):
                self.assertTrue((self.folder / name).exists(), name)
            report = json.loads((self.folder / f"two-{number}.report.json").read_text())
            self.assertEqual([s["number"] for s in report["structures"]], [number])
            self.assertEqual([c["clause"] for c in report["certificate"]], [1, 2, 3, 4, 5, 6])
            self.assertNotIn("broken", {c["state"] for c in report["certificate"]})
            model = judge.Model(self.folder / f"two-{number}.vtu")
            self.assertAlmostEqual(model.volume(number) / (3 * whole), 1, delta=0.02)
        self.assertFalse((self.folder / "two.vtu").exists())

    def test_rounded_caps_hold_less_than_half_caps(self):
        self.write("two.json", two_cylinders().document())
        volumes = {}
        for caps in ("half", "rounded", "flat"):
            self.run_program("model", "two.json", "--structure", "left", "-o", f"{caps}.vtu", "--caps", caps)
            volumes[caps] = judge.Model(self.folder / f"{caps}.vtu").volume(1)
        self.assertLess(volumes["flat"], volumes["rounded"])
        # A quarter circle of 1.5 mm along both rims takes 0.48 mm2 times their lengths.
        lost = (1 - math.pi / 4) * 1.5 ** 2 * 2 * math.pi * (radius(0) + radius(27) - 0.67)
        self.assertAlmostEqual(volumes["half"] - volumes["rounded"], lost, delta=0.25 * lost)


class Sureness(harness.TestCase):
    def test_surface_and_model_have_the_arrays(self):
        shape = two_cylinders()
        self.write("two.json", shape.document())
        self.run_program("model", "two.json", "-o", "two.vtu", "--surface", "two.vtp", "--uncertainty")
        for name, reader in (("two.vtu", "vtkXMLUnstructuredGridReader"), ("two.vtp", "vtkXMLPolyDataReader")):
            points, arrays = self.point_arrays(name, reader)
            on_slices = np.abs(points[:, 2] / 3 - np.round(points[:, 2] / 3)) < 1e-9
            evidence = arrays["evidence_distance"]
            self.assertLess(evidence[on_slices & (evidence > 0)].max(initial=0), 20)
            self.assertTrue((arrays["uncertainty"] <= arrays["left_out_error"] * (1 + 1e-5)).all())
            vertices = {tuple(p) for p in shape.vertices()}
            mine = np.array([tuple(p) in vertices for p in points])
            self.assertEqual(mine.sum(), len(vertices))
            self.assertEqual(arrays["uncertainty"][mine].max(), 0)

    def point_arrays(self, name, reader):
        import vtk
        from vtk.util.numpy_support import vtk_to_numpy
        read = getattr(vtk, reader)()
        read.SetFileName(str(self.folder / name))
        read.Update()
        data = read.GetOutput().GetPointData()
        arrays = {data.GetArrayName(i): vtk_to_numpy(data.GetArray(i)) for i in range(data.GetNumberOfArrays())}
        return vtk_to_numpy(read.GetOutput().GetPoints().GetData()), arrays

    def test_arrays_come_back_and_other_formats_say_that_they_leave_them_out(self):
        self.write("two.json", two_cylinders().document())
        self.run_program("model", "two.json", "-o", "two.vtu", "--uncertainty")
        self.run_program("convert", "two.vtu", "-o", "again.vtu")
        self.assertEqual((self.folder / "again.vtu").read_bytes(), (self.folder / "two.vtu").read_bytes())
        self.assertIn("W-MDL-008", self.run_program("convert", "two.vtu", "-o", "two.msh").err)

    def test_where_next_goes_by_the_rules_of_the_model(self):
        # A gap of three spacings: where it is not joined, its middle has no surface that a contour could hold.
        shape = shapes.Shape({1: "tube"}, 3)
        for z in (0, 3, 6, 9, 18, 21, 24, 27):
            shape.add_slice(float(z), [(1, shapes.circle(8, 48, (0.0, 0.0)))])
        self.write("gap.json", shape.document())
        errors = [self.run_program("where-next", "gap.json", "--count", "1", "--json", *more).json()["expected_error_mm3"]
                  for more in ((), ("--max-gap", "4"))]
        self.assertNotEqual(*errors)

    def test_where_next_names_the_middle_of_a_gap_that_is_not_joined(self):
        for missing in (2, 3, 5):
            shape = shapes.Shape({1: "tube"}, 3)
            for k in range(14):
                if not 5 <= k < 5 + missing:
                    shape.add_slice(3.0 * k, [(1, shapes.circle(8 + math.sin(k), 48, (0.0, 0.0)))])
            self.write("gap.json", shape.document())
            answer = self.run_program("where-next", "gap.json", "--count", "2", "--json").json()
            first = answer["planes"][0]
            self.assertAlmostEqual(first["origin_mm"][2], 3 * (5 + 0.5 * (missing - 1)), delta=1e-6)
            self.assertIn("where slices are missing", first["place"])
            self.assertGreater(first["gap_mm3"], 0)
            self.assertLessEqual(first["gap_mm3"], answer["expected_in_gaps_mm3"] * (1 + 1e-9))
            joined = self.run_program("where-next", "gap.json", "--max-gap", "9", "--json").json()
            self.assertEqual(joined["expected_in_gaps_mm3"], 0)

    def test_where_next_names_the_missing_slice(self):
        self.write("gap.json", two_cylinders(missing=15).document())
        answer = self.run_program("where-next", "gap.json", "--count", "2", "--json").json()
        self.assertEqual(len(answer["planes"]), 2)
        first = answer["planes"][0]
        self.assertAlmostEqual(first["origin_mm"][2], 15, delta=0.01)
        self.assertGreater(first["gain_mm3"], answer["planes"][1]["gain_mm3"])
        self.assertEqual(len(answer["left_out_slices"]), 9)
        table = self.run_program("where-next", "gap.json", "--count", "2").out
        self.assertIn("between", table)


if __name__ == "__main__":
    harness.main(__name__)
