"""Damage done to a sound model, and to what it is made of: `check` and `model` must say so."""
import json

import numpy as np

import harness
import judge
import shapes


class DamagedModels(harness.TestCase):
    """A ball with a ball in it as .mesh: its points and cells as arrays, written back with what was done to them."""

    def setUp(self):
        super().setUp()
        self.write("contours.json", self.contours())
        self.run_program("model", "contours.json", "-o", "sound.mesh")
        self.head, self.points, self.cells = self.read("sound.mesh")
        self.regions = self.cells[:, 4]
        facets = np.sort(np.concatenate([self.cells[:, list(f)] for f in ((1, 2, 3), (0, 2, 3), (0, 1, 3), (0, 1, 2))]), 1)
        of = np.tile(np.arange(len(self.cells)), 4)
        order = np.lexsort(facets.T[::-1])
        facets, of = facets[order], of[order]
        twin = (facets[1:] == facets[:-1]).all(1)
        wall = np.ones(len(facets), bool)
        inside = twin & (self.regions[of[1:]] == self.regions[of[:-1]])
        wall[1:][inside] = wall[:-1][inside] = False
        self.on_surface = np.zeros(len(self.points), bool)
        self.on_surface[facets[wall].ravel()] = True
        vertices = {tuple(p) for each in self.contours()["slices"] for c in each["contours"] for p in c["points"]}
        self.of_contour = np.array([tuple(p) in vertices for p in self.points])
        centres = self.points[self.cells[:, :4]].mean(1)
        deep = np.nonzero(~self.on_surface[self.cells[:, :4]].any(1) & (self.regions == self.regions.min()))[0]
        self.deep = deep[np.argsort(np.linalg.norm(centres[deep] - centres[deep[0]], axis=1))]

    @staticmethod
    def contours():
        """Two balls, the smaller one in the larger one."""
        both, inner = shapes.sphere(16, 2), shapes.sphere(6, 2)
        both.structures = {1: "outer", 2: "inner"}
        for z, polygons in inner.slices:
            next(p for at, p in both.slices if at == z).extend((2, points) for _, points in polygons)
        return both.document()

    def read(self, name):
        lines = (self.folder / name).read_text().splitlines()
        v, t = lines.index("Vertices"), lines.index("Tetrahedra")
        points = np.array([[float(x) for x in line.split()[:3]] for line in lines[v + 2:v + 2 + int(lines[v + 1])]])
        cells = np.array([[int(x) for x in line.split()] for line in lines[t + 2:t + 2 + int(lines[t + 1])]])
        cells[:, :4] -= 1
        return lines[:v], points, cells

    def damaged(self, points=None, cells=None, head=None):
        points = self.points if points is None else points
        cells = self.cells if cells is None else cells
        used = np.unique(cells[:, :4])
        number = np.full(len(points), -1)
        number[used] = np.arange(len(used))
        lines = list(self.head if head is None else head)
        lines += ["Vertices", str(len(used))] + [" ".join(repr(float(x)) for x in points[v]) + " 0" for v in used]
        lines += ["Tetrahedra", str(len(cells))]
        lines += [" ".join(str(number[v] + 1) for v in c[:4]) + f" {c[4]}" for c in cells]
        self.write("damaged.mesh", "\n".join(lines) + "\nEnd\n")

    def checked(self, name="damaged.mesh", contours="contours.json", expect=0):
        """States of the clauses, codes of the warnings, the report."""
        words = ("check", name, "--json", *(("--contours", contours) if contours else ()))
        report = self.run_program(*words, expect=expect).json()
        return ({c["clause"]: c["state"] for c in report["certificate"]}, [w["code"] for w in report["warnings"]], report)

    def test_a_sound_model_keeps_clause_6_too_and_nothing_is_warned_of(self):
        states, codes, report = self.checked(name="sound.mesh")
        self.assertNotIn("broken", states.values())
        self.assertEqual([states[n] for n in (1, 3, 4, 6)], ["kept"] * 4)
        self.assertEqual([c for c in codes if c.startswith("W-PIP")], [])
        self.assertIn("as the model's file says", report["certificate"][5]["evidence"])
        self.assertLess(report["field_distance"]["max_mm"], 1)

    def test_writing_it_back_unchanged_changes_nothing(self):
        self.damaged()
        states, codes, _ = self.checked()
        self.assertEqual(states[6], "kept")
        self.assertEqual([c for c in codes if c.startswith("W-PIP")], [])

    def test_one_cell_removed_from_the_inside(self):
        self.damaged(cells=np.delete(self.cells, self.deep[0], 0))
        states, codes, report = self.checked()
        self.assertIn("W-PIP-006", codes)
        outer = report["structures"][0]
        self.assertEqual((outer["voids"], outer["shells_without_contour"]), (1, 1))
        self.assertGreater(outer["shells_without_contour_mm3"], 0)
        _, _, alone = self.checked(contours=None)
        self.assertEqual(alone["structures"][0]["voids"], 1)
        text = self.run_program("check", "damaged.mesh").out
        self.assertIn("2 shells (1 void, smallest", text)

    def test_a_third_of_the_inside_removed(self):
        self.damaged(cells=np.delete(self.cells, self.deep[:len(self.deep) // 3], 0))
        states, codes, report = self.checked(expect=4)
        self.assertEqual((states[2], states[6]), ("broken", "broken"))
        self.assertLessEqual({"W-PIP-003", "W-PIP-006"}, set(codes))
        self.assertIn("of the drawn area of outer are wrong", report["certificate"][1]["evidence"])

    def test_one_cell_in_the_other_region(self):
        cells = self.cells.copy()
        cells[self.deep[0], 4] = self.regions.max()
        self.damaged(cells=cells)
        _, codes, report = self.checked()
        self.assertIn("W-PIP-006", codes)
        self.assertEqual([s["shells_without_contour"] for s in report["structures"]], [0, 1])

    def test_a_hole_through_a_wall_onto_what_is_inside(self):
        """Thinner than the size, so that no point of it is far from some surface."""
        both, inner = shapes.sphere(16, 2), shapes.sphere(14, 2)
        both.structures = {1: "outer", 2: "inner"}
        for z, polygons in inner.slices:
            next(p for at, p in both.slices if at == z).extend((2, points) for _, points in polygons)
        self.write("walls.json", both.document())
        self.run_program("model", "walls.json", "-o", "sound.mesh", "--size", "3")
        head, points, cells = self.read("sound.mesh")
        self.assertNotIn("W-PIP-009", self.checked("sound.mesh", "walls.json")[1])
        centres = points[cells[:, :4]].mean(1)
        wall = cells[:, 4] == cells[:, 4].min()
        near = np.linalg.norm(centres - np.array([16, 0, 1]), axis=1) < 5
        self.damaged(points, cells[~(wall & near)], head)
        _, codes, report = self.checked(contours="walls.json", expect=None)
        self.assertIn("W-PIP-009", codes)
        self.assertEqual(report["field_distance"]["joined_structure"], "outer")
        self.assertGreater(report["field_distance"]["joined_mm"], 1)

    def test_a_piece_of_a_thin_wall_that_is_not_there(self):
        """No vertex is far from the field, for the wall has surfaces on both sides of what is gone."""
        wall = shapes.shell(16, 14.5, 2)
        self.write("wall.json", wall.document())
        self.run_program("model", "wall.json", "-o", "sound.mesh", "--size", "2")
        self.assertNotIn("W-PIP-010", self.checked("sound.mesh", "wall.json")[1])
        head, points, cells = self.read("sound.mesh")
        centres = points[cells[:, :4]].mean(1)
        near = np.linalg.norm(centres - np.array([15, 0, 1]), axis=1) < 4
        self.damaged(points, cells[~near], head)
        _, codes, report = self.checked(contours="wall.json", expect=None)
        self.assertIn("W-PIP-010", codes)
        self.assertTrue(report["field_difference"]["missing"])
        self.assertLess(np.linalg.norm(np.array(report["field_difference"]["at_mm"]) - np.array([15, 0, 1])), 4)

    def test_a_structure_array_that_says_otherwise_than_the_regions(self):
        self.run_program("convert", "sound.mesh", "-o", "model.vtu")
        import vtk
        from vtk.util import numpy_support
        reader = vtk.vtkXMLUnstructuredGridReader()
        reader.SetFileName(str(self.folder / "model.vtu"))
        reader.Update()
        grid = reader.GetOutput()
        shown = numpy_support.vtk_to_numpy(grid.GetCellData().GetArray("structure"))
        shown[:] = np.where(shown == 1, shown.max(), 1)
        writer = vtk.vtkXMLUnstructuredGridWriter()
        writer.SetFileName(str(self.folder / "swapped.vtu"))
        writer.SetInputData(grid)
        writer.Write()
        for words in (("check", "swapped.vtu"), ("convert", "swapped.vtu", "-o", "x.msh")):
            self.assertIn("E-MDL-016", self.run_program(*words, expect=3).err)

    def test_a_model_in_metres(self):
        self.damaged(head=[line.replace("UNIT=mm", "UNIT=m") for line in self.head])
        for words in (("check", "damaged.mesh"), ("convert", "damaged.mesh", "-o", "x.vtu")):
            self.assertIn("E-MDL-017", self.run_program(*words, expect=3).err)

    def test_a_free_vertex_of_the_surface_pulled_out(self):
        free = np.nonzero(self.on_surface & ~self.of_contour & (np.linalg.norm(self.points, axis=1) > 14))[0]
        points = self.points.copy()
        size = float(next(line for line in self.head if "size_mm" in line).split()[-1])
        points[free[0]] *= 1 + 1.1 * size / np.linalg.norm(points[free[0]])
        self.damaged(points=points)
        _, codes, report = self.checked(expect=None)
        self.assertIn("W-PIP-008", codes)
        self.assertAlmostEqual(np.linalg.norm(np.array(report["field_distance"]["at_mm"]) - points[free[0]]), 0, delta=1e-6)

    def test_ends_that_the_file_does_not_tell_are_found(self):
        for caps in ("half", "flat", "rounded"):
            self.run_program("model", "contours.json", "-o", "sound.mesh", "--caps", caps)
            head, points, cells = self.read("sound.mesh")
            for kept, words in ((head, "as the model's file says"), ([line for line in head if "NOTE" not in line], "assumed")):
                self.damaged(points, cells, kept)
                states, _, report = self.checked()
                self.assertEqual(states[6], "kept", report["certificate"][5])
                self.assertIn(f"with ends '{caps}'", report["certificate"][5]["evidence"])
                self.assertIn(words, report["certificate"][5]["evidence"])

    def test_contours_of_one_of_the_structures_say_nothing_of_volumes(self):
        document = self.contours()
        document["structures"] = document["structures"][:1]
        for each in document["slices"]:
            each["contours"] = [c for c in each["contours"] if c["structure"] == 1]
        self.write("one.json", document)
        states, codes, report = self.checked("sound.mesh", "one.json")
        self.assertIn("W-CMD-010", codes)
        self.assertNotIn("W-PIP-008", codes)
        self.assertEqual(states[6], "not promised yet")
        self.assertIn("the structures differ", report["certificate"][5]["evidence"])

    def test_structures_exchanged_in_the_contours(self):
        document = self.contours()
        names = [each["name"] for each in document["structures"]]
        for each, name in zip(document["structures"], names[::-1]):
            each["name"] = name
        self.write("exchanged.json", document)
        _, codes, report = self.checked("sound.mesh", "exchanged.json")
        self.assertIn("W-CMD-008", codes)
        told = next(w for w in report["warnings"] if w["code"] == "W-CMD-008")
        self.assertIn("inner (1) of the contours is outer (1) of the model", json.dumps(told))

    def test_axes_that_contradict_each_other(self):
        self.damaged(head=[line.replace("SPACE=LPS", "SPACE=RAS") for line in self.head])
        self.assertIn("W-CMD-001", self.checked()[1])

    def test_contours_that_are_elsewhere(self):
        document = self.contours()
        for each in document["slices"]:
            for contour in each["contours"]:
                contour["points"] = [[-x, y, z + 0.25] for x, y, z in contour["points"]]
            each["plane"]["origin"][2] += 0.25
        self.write("moved.json", document)
        told = self.run_program("check", "sound.mesh", "--contours", "moved.json", expect=4).err
        self.assertIn("mm from the model's surface in the mean", told)


class SoundModels(harness.TestCase):
    """Models checked against the contours that the user drew, which are not always those they are made of."""

    def codes(self, model, contours, *words, expect=0):
        report = self.run_program("check", model, "--contours", contours, "--json", *words, expect=expect).json()
        self.report = report
        return [w["code"] for w in report["warnings"]]

    def overlapping(self):
        balls = shapes.touching_balls()
        document = balls.document()
        for each in document["slices"]:
            for contour in each["contours"]:
                shift = 3.0 if contour["structure"] == 1 else -3.0
                contour["points"] = [[x + shift, y, z] for x, y, z in contour["points"]]
        return document

    def test_priority(self):
        self.write("drawn.json", self.overlapping())
        self.run_program("model", "drawn.json", "-o", "m.vtu", "--priority", "2", "--contours", "used.json")
        self.assertNotIn("W-CMD-011", self.codes("m.vtu", "used.json"))
        self.assertEqual(self.report["certificate"][5]["state"], "kept")
        self.assertIn("W-CMD-011", self.codes("m.vtu", "drawn.json"))
        self.assertEqual([self.report["certificate"][n]["state"] for n in (0, 5)], ["kept"] * 2)

    def test_every_other_slice(self):
        self.write("drawn.json", shapes.torus().document())
        for words in ((), ("--offset", "1")):
            self.run_program("model", "drawn.json", "-o", "m.vtu", "--every", "2", *words, "--contours", "used.json")
            self.assertNotIn("W-CMD-011", self.codes("m.vtu", "used.json"))
            counts = self.report["counts"]
            self.assertIn("W-CMD-011", self.codes("m.vtu", "drawn.json"))
            self.assertEqual(self.report["counts"], counts)
            self.assertEqual([self.report["certificate"][n]["state"] for n in (0, 1, 5)], ["kept"] * 3)
        # One that was made of all is not taken for another.
        self.run_program("model", "drawn.json", "-o", "all.vtu")
        self.assertNotIn("W-CMD-011", self.codes("all.vtu", "drawn.json"))

    def test_separate_models_against_all_contours(self):
        self.write("drawn.json", self.overlapping())
        self.run_program("model", "drawn.json", "-o", "m.vtu", "--separate")
        for number in (1, 2):
            self.assertIn("W-CMD-009", self.codes(f"m-{number}.vtu", "drawn.json"))
            self.assertEqual([self.report["certificate"][n]["state"] for n in (0, 5)], ["kept"] * 2)
            self.assertNotIn("W-CMD-009", self.codes(f"m-{number}.vtu", "drawn.json", "--structure", str(number)))
        self.assert_refused(("check", "m-1.vtu", "--structure", "1"), 2, "E-CMD-008")

    def test_slices_that_cross(self):
        """A ball by planes in three directions, each contour a little too large or too small."""
        document = {"format": "anatomesh-contours", "version": 1, "space": "LPS", "unit": "mm",
                    "structures": [{"number": 1, "name": "ball"}], "slices": []}
        turn = np.arange(60) * 2 * np.pi / 60
        for axis in range(3):
            for n, at in enumerate(range(-12, 13, 6)):
                radius = np.sqrt(256 - at * at) * (1.01 if (axis + n) % 2 else 0.99)
                points = np.roll(np.stack([radius * np.cos(turn), radius * np.sin(turn), np.full(60, at)], 1), axis + 1, 1)
                plane = {"origin": np.roll([0.0, 0.0, at], axis + 1).tolist(), "normal": np.roll([0.0, 0.0, 1.0], axis + 1).tolist()}
                document["slices"].append({"plane": plane, "contours": [{"structure": 1, "points": points.tolist()}]})
        self.write("drawn.json", document)
        self.run_program("model", "drawn.json", "-o", "m.vtu", "--contours", "used.json")
        self.assertNotIn("W-CMD-011", self.codes("m.vtu", "used.json"))
        self.assertIn("W-CMD-011", self.codes("m.vtu", "drawn.json"))
        self.assertEqual(self.report["certificate"][0]["state"], "kept")
        self.run_program("model", "drawn.json", "-o", "m.vtu", "--reconcile", "0")
        self.assertNotIn("W-CMD-011", self.codes("m.vtu", "drawn.json", expect=None))

    def test_joints_that_model_tells_of_are_told_again(self):
        """Two plates with a gap far narrower than the edges."""
        def slab(low, high):
            return [(0, low), (20, low), (20, high), (0, high)]

        plates = shapes.Shape({1: "plates"}, 3)
        for z in range(0, 15, 3):
            plates.add_slice(z, [(1, slab(0, 3)), (1, slab(3.02, 6))])
        self.write("plates.json", plates.document())
        self.run_program("model", "plates.json", "-o", "m.vtu", "--size", "3")
        told = [w["code"] for w in json.loads((self.folder / "m.report.json").read_text())["warnings"]]
        self.assertEqual("W-PIP-004" in self.codes("m.vtu", "plates.json"), "W-PIP-004" in told)
        self.assertIn("W-PIP-004", told)


class DamagedRuns(harness.TestCase):
    """The program with the mesh of every run damaged between its last stage and the certificate (tests/damage)."""

    # By kind of damage, the clause that the error names.
    BROKEN = {"turned_cell": 3, "repeated_cell": 3, "nested_cell": 3, "flat_cell": 3, "parted_corner": 3, "cell_in_other_region": 3,
              "inner_vertex_through_facet": 3, "surface_vertex_through_model": 3, "point_not_finite": 3, "index_beyond": 3,
              "missing_cell_at_vertex": 3, "missing_cell_at_edge": 3, "hollow": 3, "contour_vertices_exchanged": 3, "contour_vertex_off": 1}
    OUTPUTS = ("m.vtu", "m.report.json", "m.stl", "m.html", "m.json")

    def setUp(self):
        super().setUp()
        self.write("contours.json", DamagedModels.contours())

    def model(self, damage, *words, expect, program=harness.DAMAGING):
        vtu, report, stl, html, contours = self.OUTPUTS
        return self.run_program("model", "contours.json", "-o", vtu, "--report", report, "--surface", stl, "--html", html, "--contours",
                                contours, *words, expect=expect, program=program, env={"ANATOMESH_DAMAGE": damage})

    def files(self):
        return {path.name: path.read_bytes() for path in self.folder.iterdir()}

    def test_M16_without_damage_it_is_the_program(self):
        self.model(None, "--size", "3", expect=0, program=harness.PROGRAM)
        of_program = self.files()
        self.model(None, "--size", "3", expect=0)
        for name in ("m.vtu", "m.stl", "m.json"):
            self.assertEqual((self.folder / name).read_bytes(), of_program[name], name)

    def test_M16_a_damaged_mesh_ends_with_7_and_no_file_changes(self):
        for damage, clause in self.BROKEN.items():
            for were_there in (self.OUTPUTS, self.OUTPUTS[1::2], ()):
                for name in self.OUTPUTS:
                    (self.folder / name).unlink(missing_ok=True)
                for name in were_there:
                    self.write(name, f"what stood there as {name}")
                before = self.files()
                with self.subTest(damage=damage, were_there=were_there):
                    done = self.model(damage, "--size", "3", expect=7)
                    self.assertIn(f"E-PIP-002: clause {clause} of the certificate is broken", done.err)
                    self.assertIn("nothing was written", done.err)
                    self.assertEqual(done.out, "")
                    self.assertEqual(self.files(), before)

    def test_M16_no_further_run_hides_the_damage(self):
        """Of a default size, finer runs follow; each is damaged as well."""
        self.write("m.stl", "what stood there")
        before = self.files()
        for damage in ("turned_cell", "contour_vertex_off"):
            self.assertIn("E-PIP-002", self.model(damage, expect=7).err)
            self.assertEqual(self.files(), before)

    def test_M16_one_of_several_models_is_damaged(self):
        before = self.files()
        self.model("turned_cell", "--separate", "--size", "3", expect=7)
        self.assertEqual(self.files(), before)

    def test_M16_what_breaks_no_clause_is_told(self):
        """Without a cell of its inside, or one at its surface, a model is still a manifold: the field tells that it is another one."""
        for damage, codes in (("missing_cell_inside", {"W-PIP-006", "W-PIP-008"}), ("missing_cell_at_facet", {"W-PIP-008"})):
            done = self.model(damage, "--size", "2", expect=0)
            report = json.loads((self.folder / "m.report.json").read_text())
            self.assertLessEqual(codes, {warning["code"] for warning in report["warnings"]}, damage)
            for code in codes:
                self.assertIn(code, done.err)


if __name__ == "__main__":
    harness.main(__name__)
