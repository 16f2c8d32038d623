"""Tubes drawn on planes normal to their paths, as vessels are: arches, branches and two slices of a fan. Volumes are those of Pappus or counted."""
import json

import numpy as np
import vtk

import harness


def frame(along):
    along = np.asarray(along, float) / np.linalg.norm(along)
    u = np.cross(along, [0, 1, 0] if abs(along[1]) < 0.9 else [1, 0, 0])
    u /= np.linalg.norm(u)
    return along, u, np.cross(along, u)


def slice_of(at, along, radius, structure=1, count=40):
    """A slice of the JSON format; the points have eight digits, as files have."""
    along, u, v = frame(along)
    turn = 2 * np.pi * np.arange(count) / count
    ring = at + radius * (np.outer(np.cos(turn), u) + np.outer(np.sin(turn), v))
    return {"plane": {"origin": list(map(float, at)), "normal": along.tolist()},
            "contours": [{"structure": structure, "points": ring.round(8).tolist()}]}


def along_path(path, length, spacing, radius, structure=1):
    count = max(2, round(length / spacing))
    return [slice_of(*path((n + 0.5) * length / count), radius, structure) for n in range(count)]


def arch(first, last, bend=30.0):
    def path(s):
        if s < first:
            return np.array([-bend, 0, s]), np.array([0, 0, 1.0])
        a = min(s - first, np.pi * bend) / bend
        along = np.array([np.sin(a), 0, np.cos(a)])
        return np.array([-bend * np.cos(a), 0, first + bend * np.sin(a)]) + max(0.0, s - first - np.pi * bend) * along, along
    return path, first + np.pi * bend + last


def straight(start, along):
    along = frame(along)[0]
    return lambda s: (np.asarray(start, float) + s * along, along)


def set_by_eye(at, along, radius, random):
    """As slice_of() on a plane moved by 1 mm and turned by 6 degrees."""
    along, u, v = frame(along)
    turn, away = random.uniform(0, 2 * np.pi), random.normal(size=3)
    across = np.cos(turn) * u + np.sin(turn) * v
    return slice_of(at + away / np.linalg.norm(away), np.cos(np.radians(6)) * along + np.sin(np.radians(6)) * across, radius)


def area(radius, count=40):
    return 0.5 * count * np.sin(2 * np.pi / count) * radius ** 2


def united(tubes, low, high):
    """The volume of straight tubes (start, direction, length, radius) together, counted at random points."""
    points = np.random.default_rng(4).uniform(low, high, (2000000, 3))
    inside = np.zeros(len(points), bool)
    for start, along, length, radius in tubes:
        along = frame(along)[0]
        way = (points - start) @ along
        inside |= (way > 0) & (way < length) & (np.linalg.norm(points - start - np.outer(way, along), axis=1) < radius)
    return inside.mean() * np.prod(np.subtract(high, low))


class Paths(harness.TestCase):
    def built(self, slices, names=("vessel",), options=()):
        self.write("tubes.json", {"format": "anatomesh-contours", "version": 1, "space": "LPS", "unit": "mm",
                                  "structures": [{"number": n, "name": name} for n, name in enumerate(names, 1)], "slices": slices})
        return self.run_program("model", "tubes.json", "-o", "tubes.vtu", "--report", "report.json", "--contours", "kept.vtp", *options)

    def model(self, slices, names=("vessel",), options=()):
        said = self.built(slices, names, options)
        report = json.loads((self.folder / "report.json").read_text())
        self.assertIn("clauses 1, 2, 3, 4, 5, 6 kept", said.out + said.err)
        return report["structures"], said.err

    def assert_one_part(self, structure, volume, share=0.02):
        self.assertAlmostEqual(structure["volume_mesh_mm3"], volume, delta=share * volume)
        self.assertEqual((structure["pieces"], structure["voids"], structure["genus"]), (1, 0, 0))

    def test_arches_end_half_a_spacing_beyond_their_last_contours(self):
        for first, last, spacing in ((60, 100, 4), (60, 100, 8), (60, 60, 5), (0, 80, 10), (20, 100, 5)):
            with self.subTest(first=first, last=last, spacing=spacing):
                path, length = arch(first, last)
                structures, _ = self.model(along_path(path, length, spacing, 12))
                self.assert_one_part(structures[0], area(12) * length, 0.01)
                reader = vtk.vtkXMLUnstructuredGridReader()
                reader.SetFileName(str(self.folder / "tubes.vtu"))
                reader.Update()
                points = np.array([reader.GetOutput().GetPoint(n) for n in range(reader.GetOutput().GetNumberOfPoints())])
                for leg, end in ((points[:, 0] < -15, 0.0), (points[:, 0] > 15, first - last)):
                    self.assertAlmostEqual(points[leg, 2].min(), end, delta=0.5 * spacing)

    def test_a_branch_of_the_structure_is_united_with_its_parent(self):
        for degrees in (45, 90):
            with self.subTest(degrees=degrees):
                a = np.radians(degrees)
                along = np.array([np.sin(a), 0, np.cos(a)])
                slices = along_path(straight([0, 0, 0], [0, 0, 1]), 100, 4, 12) + along_path(straight([0, 0, 50], along), 60, 3, 6)
                structures, said = self.model(slices)
                right = united([(np.zeros(3), [0, 0, 1], 100, 12), (np.array([0, 0, 50.0]), along, 60, 6)], [-13, -13, 0], [62, 13, 105])
                self.assert_one_part(structures[0], right)
                self.assertIn("W-FLD-016", said)

    def test_a_branch_of_its_own_changes_nothing_of_its_parent(self):
        path, length = arch(60, 100)
        for degrees in (0, 35):
            with self.subTest(degrees=degrees):
                a = np.radians(degrees)
                branch = along_path(straight([0, 0, 90], [np.sin(a), 0, np.cos(a)]), 40, 4, 5, 2)
                structures, _ = self.model(along_path(path, length, 4, 12) + branch, ("aorta", "subclavian"))
                self.assert_one_part(structures[0], area(12) * length, 0.01)
                self.assert_one_part(structures[1], area(5) * 40, 0.01)

    def test_legs_at_nearly_one_height_stay_two_slices_in_a_file_without_planes(self):
        for spacing, off in ((4, 0.2), (6, 0.1)):
            # Slices of the two legs lie `off` apart along their normal.
            path, length = arch(10 * spacing, 6 * spacing + off)
            self.built(along_path(path, length, spacing, 9))
            self.run_program("contours", "tubes.json", "-o", "tubes.dcm")
            said = self.run_program("model", "tubes.dcm", "-o", "tubes.vtu", "--report", "report.json")
            self.assertNotRegex(said.err, "W-CON-009|W-CON-010|W-FLD-001|W-FLD-017")
            [structure] = json.loads((self.folder / "report.json").read_text())["structures"]
            self.assert_one_part(structure, area(9) * length)

    def test_priority_of_tubes_that_overlap_between_slices_is_refused(self):
        path, length = arch(60, 100)
        for tilt in (0, 20):
            at, along = path(60 + np.pi * 15)
            branch = straight(at, [np.sin(np.radians(tilt)), 0, np.cos(np.radians(tilt))])
            self.write("tubes.json", {"format": "anatomesh-contours", "version": 1, "space": "LPS", "unit": "mm",
                                      "structures": [{"number": 1, "name": "aorta"}, {"number": 2, "name": "branch"}],
                                      "slices": along_path(path, length, 8, 12) + along_path(branch, 48, 8, 5, 2)})
            self.assert_refused(["model", "tubes.json", "--priority", "aorta", "-o", "m.vtu"], 4, "E-PRI-002", "--separate")

    def test_a_slice_along_a_tube_is_told_and_without_it_the_tube_is_right(self):
        path, length = arch(60, 100)
        check = {"name": "check", "plane": {"origin": [30, 0, 0], "normal": [0, 1, 0]},
                 "contours": [{"structure": 1, "points": [[18, 0, -30], [42, 0, -30], [42, 0, 30], [18, 0, 30]]}]}
        slices = along_path(path, length, 4, 12) + [check]
        told = next(line for line in self.built(slices).err.splitlines() if "W-FLD-018" in line)
        self.assertIn("--without 'check'", told)
        structures, said = self.model(slices, options=("--without", "check"))
        self.assertNotIn("W-FLD-018", said)
        self.assert_one_part(structures[0], area(12) * length, 0.01)

    def test_a_structure_on_planes_that_cross_is_told_beside_an_arch(self):
        path, length = arch(60, 100)
        heart = [slice_of(np.array([0.0, -80, z]), [0, 0, 1], np.sqrt(625 - (z - 40) ** 2), 2) for z in range(20, 61, 5)]
        heart += [slice_of(np.array([0.0, -80, 40]), along, 25, 2) for along in ([1, 0, 0], [0, 1, 0])]
        slices = along_path(path, length, 4, 12) + heart
        told = next(line for line in self.built(slices, ("aorta", "heart")).err.splitlines() if "W-FLD-018" in line)
        self.assertIn("all slices of heart", told)
        self.assertIn("--structure 'aorta'", told)
        structures, said = self.model(slices, ("aorta", "heart"), ("--structure", "aorta"))
        self.assertNotIn("W-FLD-018", said)
        self.assert_one_part(structures[0], area(12) * length, 0.01)

    def test_planes_set_by_eye_keep_the_volume_and_the_slices_that_cross_are_named(self):
        path, length = arch(60, 100)
        for spacing, radius, skips in ((4, 14, True), (8, 12, False)):
            with self.subTest(spacing=spacing):
                random, count = np.random.default_rng(3), round(length / spacing)
                slices = [set_by_eye(*path((n + 0.5) * length / count), radius, random) for n in range(count)]
                structures, said = self.model(slices)
                self.assert_one_part(structures[0], area(radius) * length)
                self.assertEqual("W-FLD-019" in said, skips)

    def test_two_slices_of_a_fan_give_what_their_outline_sweeps(self):
        for degrees in (20, 60, 90):
            with self.subTest(degrees=degrees):
                slices = []
                for a in (0.0, np.radians(degrees)):
                    slices.append(slice_of(60 * np.array([np.cos(a), np.sin(a), 0]), [-np.sin(a), np.cos(a), 0], 20))
                structures, said = self.model(slices)
                self.assert_one_part(structures[0], area(20) * 60 * 2 * np.radians(degrees))
                self.assertEqual("W-FLD-008" in said, degrees > 20)


if __name__ == "__main__":
    harness.main(__name__)
