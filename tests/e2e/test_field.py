"""The verb field: bit volumes and distance maps of contours as images."""
import hashlib
import json

import nibabel
import numpy as np

import harness
import images
import shapes


class Field(harness.TestCase):
    def setUp(self):
        super().setUp()
        self.ball = shapes.sphere(20)
        self.write("ball.json", self.ball.document())

    def test_distance_to_the_circles_of_a_ball(self):
        answer = self.run_program("field", "ball.json", "-o", "d.nrrd", "--pixel", "0.5", "--json").json()
        values, origin, steps, fields, _ = images.read_nrrd(self.folder / "d.nrrd")
        self.assertEqual((fields["type"], list(values.shape)), ("float", answer["size"]))
        at = images.positions(values.shape, origin, steps)
        radius = np.sqrt(np.maximum(0, 400 - at[..., 2] ** 2))
        wanted = np.hypot(at[..., 0], at[..., 1]) - radius
        # Polygons with vertices 1.4 mm apart at most lie within 0.1 mm of their circles.
        self.assertLess(np.abs(values - wanted).max(), 0.1)

    def test_bits_are_the_sign_of_the_distance_and_nifti_is_the_same_image(self):
        for name in ("d.nrrd", "d.nii.gz"):
            self.run_program("field", "ball.json", "-o", name)
        self.run_program("field", "ball.json", "-o", "b.nrrd", "--what", "bits")
        distance, origin, steps, _, _ = images.read_nrrd(self.folder / "d.nrrd")
        bits, _, _, _, pairs = images.read_nrrd(self.folder / "b.nrrd")
        self.assertTrue(((bits == 1) == (distance < 0))[distance != 0].all())
        self.assertEqual(pairs["Segment0_Name"], list(self.ball.structures.values())[0])
        nifti = nibabel.load(self.folder / "d.nii.gz")
        self.assertTrue(np.array_equal(nifti.get_fdata(dtype=np.float32), distance))
        corner = nifti.affine @ [1, 2, 3, 1]
        self.assertLess(np.abs(corner[:3] * [-1, -1, 1] - (origin + [1, 2, 3] @ steps)).max(), 1e-4)

    def test_the_bits_of_traced_contours_are_the_label_map(self):
        n = np.arange(40)
        ball = np.hypot(np.hypot(n[:, None, None] - 20, n[None, :, None] - 19), 1.5 * (n[None, None, :24] - 12)) < 14
        labels = images.write_nrrd(self.folder / "labels.nrrd", (3 * ball).astype(np.uint8), (1, 1, 1.5), (5, -6, 7))
        self.run_program("field", labels, "--what", "bits", "--epsilon", "exact", "--min-area", "0", "-o", "bits.nrrd")
        bits, origin, steps, _, _ = images.read_nrrd(self.folder / "bits.nrrd")
        first = np.rint((origin - [5, -6, 7]) / [1, 1, 1.5]).astype(int)
        self.assertLess(np.abs(origin - ([5, -6, 7] + first * [1, 1, 1.5])).max(), 1e-9)
        whole = np.zeros_like(ball)
        whole[tuple(slice(f, f + s) for f, s in zip(first, bits.shape))] = bits == 3
        self.assertTrue(np.array_equal(whole, ball))

    def test_one_slice_is_as_thick_as_the_source_or_the_user_says(self):
        disc = np.zeros((12, 12, 5), np.uint8)
        disc[3:9, 4:10, 2] = 1
        for thickness in (1.5, 2, 5):
            images.write_nrrd(self.folder / "map.nrrd", disc, (1, 1, thickness))
            self.run_program("contours", "map.nrrd", "-o", "c.json", "--quiet")
            for source in ("map.nrrd", "c.json"):
                said = self.run_program("field", source, "-o", "d.nrrd").err
                self.assertIn("W-FLD-013", said)
                self.assertAlmostEqual(images.read_nrrd(self.folder / "d.nrrd")[2][2][2], thickness, delta=1e-9)
                said = self.run_program("field", source, "-o", "d.nrrd", "--slice-thickness", "3.5").err
                self.assertNotIn("W-FLD", said)
                self.assertAlmostEqual(images.read_nrrd(self.folder / "d.nrrd")[2][2][2], 3.5, delta=1e-9)
        file = json.loads((self.folder / "c.json").read_text())
        del file["slice_thickness_mm"]
        self.write("c.json", file)
        self.assertIn("W-FLD-015", self.run_program("field", "c.json", "-o", "d.nrrd").err)
        self.assertNotIn("W-FLD", self.run_program("field", "c.json", "-o", "d.nrrd", "--slice-thickness", "2").err)
        self.assert_refused(["field", "ball.json", "-o", "x.nrrd", "--slice-thickness", "2"], 2, "E-CMD-008", "--slice-thickness")

    def test_O06_every_output_says_how_it_was_made(self):
        self.run_program("model", "ball.json", "-o", "ball.vtu", "--size", "6")
        report = json.loads((self.folder / "ball.report.json").read_text())
        self.assertRegex(report["versions"]["anatomesh"], r"\d+\.\d+")
        self.assertEqual(report["inputs"][0]["sha256"], hashlib.sha256((self.folder / "ball.json").read_bytes()).hexdigest())
        self.assertEqual((report["space"], report["unit"]), ("LPS", "mm"))
        self.assertEqual(report["options"]["size_mm"], "6")
        self.assertIn("warnings", report)
        self.run_program("convert", "ball.vtu", "-o", "ball.msh")
        text = (self.folder / "ball.msh").read_bytes()
        for part in (b"SPACE=LPS", b"UNIT=mm", b"NOTE version=", b"NOTE option=size_mm 6"):
            self.assertIn(part, text)
        for words in (["--what", "bits"], []):
            self.run_program("field", "ball.json", *words, "-o", "x.nrrd")
            header = (self.folder / "x.nrrd").read_bytes()[:2000]
            for part in (b"anatomesh:=version ", b"left-posterior-superior", b'"mm"'):
                self.assertIn(part, header)
            self.run_program("field", "ball.json", *words, "-o", "x.nii")
            self.assertIn(b"version ", (self.folder / "x.nii").read_bytes()[148:228])
            answer = self.run_program("field", "ball.json", *words, "-o", "x.nii", "--json").json()
            self.assertEqual(len(answer["inputs"][0]["sha256"]), 64)

    def test_one_thread_or_many_give_the_same_bytes(self):
        for threads in (1, 2):
            self.run_program("field", "ball.json", "-o", f"{threads}.nrrd", "--threads", threads)
        self.assertEqual((self.folder / "1.nrrd").read_bytes(), (self.folder / "2.nrrd").read_bytes())

    def test_what_makes_no_image_is_refused(self):
        self.assert_refused(["field", "ball.json", "-o", "d.mha"], 2, "E-IMG-016", ".nrrd")
        self.assert_refused(["field", "ball.json", "-o", ".nrrd"], 2, "E-CMD-004")
        self.assert_refused(["field", "ball.json", "-o", "d.nrrd", "--pixel", "0"], 2, "E-CMD-001")
        self.assert_refused(["field", "ball.json", "-o", "d.nrrd", "--pixel", "0.001"], 5, "E-FLD-006", "--pixel")
        document = self.ball.document()
        document["structures"].append({"number": 9, "name": "twin"})
        for entry in document["slices"]:
            entry["contours"] += [dict(c, structure=9) for c in entry["contours"]]
        self.write("two.json", document)
        self.assert_refused(["field", "two.json", "-o", "d.nrrd"], 2, "E-CMD-019", "--structure")
        self.assertIn("W-CMD-004", self.run_program("field", "two.json", "-o", "b.nrrd", "--what", "bits").err)
        self.run_program("field", "two.json", "-o", "d.nrrd", "--structure", "twin")
        del document["slices"][3]
        document["slices"][5]["plane"]["origin"][2] += 0.3
        for contour in document["slices"][5]["contours"]:
            for point in contour["points"]:
                point[2] += 0.3
        self.write("uneven.json", document)
        self.assert_refused(["field", "uneven.json", "--structure", "9", "-o", "u.nrrd"], 4, "E-FLD-005", "--every")


if __name__ == "__main__":
    harness.main(__name__)
