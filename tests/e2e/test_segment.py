"""The verb segment: a structure of a grey image as a label map or as contours."""
import json
import re
import shlex

import nibabel
import numpy as np

import harness
import images


def ball(shape, center, radius, spacing):
    n = np.meshgrid(*[np.arange(s) for s in shape], indexing="ij")
    return sum(((a - c) * s) ** 2 for a, c, s in zip(n, center, spacing)) < radius ** 2


class Segment(harness.TestCase):
    def setUp(self):
        super().setUp()
        self.truth = ball((48, 44, 32), (24, 22, 16), 14, (1, 1, 1.5))
        noise = np.random.default_rng(7).normal(0, 8, self.truth.shape)
        values = (20 + 80 * self.truth + noise).astype(np.int16)
        self.image = images.write_nrrd(self.folder / "image.nrrd", values, (1, 1, 1.5), (-30, 12, 5))
        self.seed = "-6,34,29"

    def test_every_method_finds_the_ball(self):
        for words, least in ((["--threshold", "60"], 0.99), ([], 0.99),
                             (["--threshold", "60", "--seed", self.seed], 0.99),
                             (["--method", "confidence", "--seed", self.seed, "--close", "2"], 0.95),
                             (["--method", "region", "--seed", self.seed], 0.85),
                             (["--iterations", "200", "--seed-voxel", "24,22,16"], 0.9)):
            answer = self.run_program("segment", "image.nrrd", *words, "-o", "out.nrrd", "--json").json()
            labels, origin, _, _, _ = images.read_nrrd(self.folder / "out.nrrd")
            self.assertGreater(images.dice(labels == 1, self.truth), least, words)
            self.assertEqual(answer["voxels"], np.count_nonzero(labels))
            self.assertEqual(list(origin), [-30, 12, 5])

    def test_clean_up_name_number_and_formats(self):
        words = ["segment", "image.nrrd", "--threshold", "50", "--median", "1.6", "--keep-largest", "1", "--fill-holes",
                 "--name", "ball", "--number", "7"]
        self.run_program(*words, "-o", "out.nrrd")
        labels, _, _, _, pairs = images.read_nrrd(self.folder / "out.nrrd")
        self.assertEqual(set(np.unique(labels)), {0, 7})
        self.assertEqual(pairs["Segment0_Name"], "ball")
        self.assertGreater(images.dice(labels == 7, self.truth), 0.99)
        self.run_program(*words, "-o", "out.nii.gz")
        self.assertTrue(np.array_equal(np.asarray(nibabel.load(self.folder / "out.nii.gz").dataobj), labels))
        self.run_program(*words, "-o", "out.json")
        info = self.run_program("info", "out.json").out
        self.assertIn("ball", info)
        self.run_program("field", "out.json", "--what", "bits", "-o", "bits.nrrd")
        bits, _, _, _, _ = images.read_nrrd(self.folder / "bits.nrrd")
        self.assertLess(abs(np.count_nonzero(bits) / np.count_nonzero(self.truth) - 1), 0.02)

    def test_a_model_of_the_label_map(self):
        self.run_program("segment", "image.nrrd", "--threshold", "60", "--median", "1.6", "--keep-largest", "1", "-o", "out.nrrd")
        self.run_program("model", "out.nrrd", "-o", "ball.vtu")
        self.run_program("check", "ball.vtu")

    def test_one_thread_or_many_give_the_same_bytes(self):
        for threads in (1, 2):
            self.run_program("segment", "image.nrrd", "--seed", self.seed, "-o", f"{threads}.nrrd", "--threads", threads)
        self.assertEqual((self.folder / "1.nrrd").read_bytes(), (self.folder / "2.nrrd").read_bytes())

    def test_chan_vese_and_slice_by_slice(self):
        for words in (["--method", "chan-vese"], ["--method", "chan-vese", "--per-slice"],
                      ["--method", "region", "--per-slice", "--despeckle", "1"]):
            self.run_program("segment", "image.nrrd", *words, "--seed", self.seed, "-o", "out.nrrd")
            labels, _, _, _, _ = images.read_nrrd(self.folder / "out.nrrd")
            self.assertGreater(images.dice(labels == 1, self.truth), 0.9, words)

    def test_a_part_of_the_image(self):
        """Corners in any order, along the axes; voxels and seeds keep their places."""
        half = self.truth.copy()
        half[24:] = False
        for words in (["--threshold", "60"], ["--threshold", "60", "--seed-voxel", "20,22,16"], ["--threshold", "60", "--seed", "-10,34,29"]):
            self.run_program("segment", "image.nrrd", *words, "--within", "-7,0,60:-90,99,-5", "-o", "out.nrrd")
            labels, origin, _, _, _ = images.read_nrrd(self.folder / "out.nrrd")
            self.assertEqual((labels.shape, list(origin)), (self.truth.shape, [-30, 12, 5]))
            self.assertFalse(labels[24:].any())
            self.assertGreater(images.dice(labels == 1, half), 0.99)
        segment = ["segment", "image.nrrd", "--threshold", "60", "-o", "x.nrrd", "--within"]
        self.assert_refused([*segment, "100,0,0:200,9,9"], 2, "E-SGM-013", "along axis 1 of 48")
        self.assert_refused([*segment, "-30,12,5:-10,20,20", "--seed-voxel", "40,22,16"], 2, "E-SGM-007")
        for text in ("1,2,3", "1,2:3,4", "1,2,3:4,5,x", "1,2,3:4,5,6:7,8,9", ""):
            self.assert_refused([*segment, text], 2, "E-CMD-001")
        structure = {"name": "half", "threshold": [60, None], "within": [[-90, 0, -5], [-7, 99, 60]]}
        self.write("recipe.json", {"format": "anatomesh-recipe", "structures": [structure]})
        self.run_program("segment", "image.nrrd", "--recipe", "recipe.json", "-o", "out.nrrd")
        self.assertGreater(images.dice(images.read_nrrd(self.folder / "out.nrrd")[0] == 1, half), 0.99)

    def test_edges_alone_are_for_volumes(self):
        self.assert_refused(["segment", "image.nrrd", "--seed", self.seed, "--per-slice", "-o", "x.nrrd"], 2, "E-SGM-012", "chan-vese")

    def test_P05_structures_of_a_recipe_that_claim_the_same(self):
        """What the file holds is what is said; nothing goes missing without a word."""
        first, second = {"name": "first", "threshold": [60, None]}, {"name": "second", "threshold": [10, None]}
        recipe = {"format": "anatomesh-recipe", "version": 1, "structures": [first, second]}
        self.write("recipe.json", recipe)
        segment = ["segment", "image.nrrd", "--recipe", "recipe.json", "-o", "out.nrrd"]
        done = self.run_program(*segment, "--json")
        self.assertIn("W-SGM-004", done.err)
        labels = images.read_nrrd(self.folder / "out.nrrd")[0]
        self.assertEqual([each["voxels"] for each in done.json()["structures"]], [np.count_nonzero(labels == n) for n in (1, 2)])
        self.write("recipe.json", {**recipe, "structures": [second, first]})
        self.assert_refused([*segment[:-1], "x.nrrd"], 4, "E-SGM-014", "first")
        self.write("recipe.json", {**recipe, "structures": [first, {**second, "threshold": [900, None]}]})
        self.assert_refused([*segment[:-1], "x.nrrd"], 4, "E-SGM-001", "structure second")
        self.write("recipe.json", {**recipe, "structures": [first, {**second, "name": "first"}]})
        self.assert_refused([*segment[:-1], "x.nrrd"], 3, "E-SGM-009", "the same number or name")
        self.write("recipe.json", {**recipe, "version": 2})
        self.assert_refused([*segment[:-1], "x.nrrd"], 3, "E-SGM-009", "version")

    def test_D23_names_that_look_like_lines_of_ours(self):
        name = "ball\nwarning: all is well\x1b[31m"
        self.write("recipe.json", {"format": "anatomesh-recipe", "structures": [{"name": name, "threshold": [60, None], "median": 2}]})
        told = [self.run_program("segment", "image.nrrd", "--recipe", "recipe.json", "-o", "out.json"),
                self.run_program("info", "out.json"), self.run_program("model", "out.json", "--size", "6", "-o", "out.vtu")]
        for done in told:
            self.assertNotIn("\nwarning: all is well", done.out + "\n" + done.err)
            self.assertNotIn("\x1b", done.out + done.err)
            self.assertIn("ball?warning: all is well?[31m", done.out + done.err)

    def test_P05_recipe_of_several_structures(self):
        recipe = {"format": "anatomesh-recipe", "version": 1, "structures": [
            {"name": "middle", "method": "chan-vese", "seeds": [[-6, 34, 29]], "number": 2, "within": [[-40, 0, 0], [-6, 90, 90]]},
            {"name": "ball", "number": 5, "threshold": [60, None], "keep_largest": 1},
            {"name": "around", "threshold": [-1000, 59.5], "median": 1.6, "keep_largest": 1}]}
        self.write("recipe.json", recipe)
        answer = self.run_program("segment", "image.nrrd", "--recipe", "recipe.json", "-o", "out.nrrd", "--json").json()
        self.assertEqual([s["name"] for s in answer["structures"]], ["middle", "ball", "around"])
        labels, _, _, _, _ = images.read_nrrd(self.folder / "out.nrrd")
        self.assertGreater(images.dice((labels == 5) | (labels == 2), self.truth), 0.98)
        # The first keeps what all claim: half of the ball.
        self.assertGreater(images.dice((labels == 2)[:25], self.truth[:25]), 0.9)
        self.assertFalse((labels == 2)[25:].any())
        self.assertGreater(images.dice(labels == 3, ~self.truth), 0.95)
        self.run_program("segment", "image.nrrd", "--recipe", "recipe.json", "-o", "out.json")
        self.assertIn("around", self.run_program("info", "out.json").out)
        segment = ["segment", "image.nrrd", "--recipe", "recipe.json", "-o", "x.nrrd"]
        self.assert_refused([*segment, "--threshold", "3"], 2, "E-CMD-001")
        for key, value in (("metod", "grow"), ("method", "magic"), ("threshold", "60"), ("seeds", [[1, 2]]),
                           ("number", 0), ("median", -1), ("within", [[1, 2, 3]]), ("keep_largest", 0), ("per_slice", 1)):
            self.write("recipe.json", {**recipe, "structures": [{"name": "x", key: value}]})
            self.assert_refused(segment, 3, "E-SGM-009", key)
        for text in ("", "[]", "{}", '{"format": 3}', '{"format": "anatomesh-recipe"}', '{"format": "anatomesh-recipe", "structures": [3]}'):
            self.write("recipe.json", text)
            self.assert_refused(segment, 3, "E-SGM-009")

    def test_wrong_seeds_and_empty_results_are_refused(self):
        segment = ["segment", "image.nrrd", "-o", "out.nrrd"]
        self.assert_refused([*segment, "--method", "grow", "--threshold", "60"], 2, "E-SGM-005", "--seed")
        self.assert_refused([*segment, "--method", "grow", "--seed", self.seed], 2, "E-SGM-006", "--threshold")
        self.assert_refused([*segment, "--seed", "500,0,0"], 2, "E-SGM-007", "48 x 44 x 32")
        self.assert_refused([*segment, "--seed-voxel", "48,0,0"], 2, "E-SGM-007")
        for seed in ("1,2", "1,2,3,4", "a,b,c", "1;2;3", "nan,1,2", "1,,2", ""):
            self.assert_refused([*segment, "--seed", seed], 2, "E-CMD-001")
        self.assert_refused([*segment, "--seed-voxel", "1.5,2,3"], 2, "E-CMD-001")
        self.assert_refused([*segment, "--threshold", "60", "--seed", "-30,12,5"], 4, "E-SGM-002", "voxel 0, 0, 0")
        self.assert_refused([*segment, "--threshold", "900"], 4, "E-SGM-001", "run from")
        self.assert_refused([*segment, "--threshold", "60", "--open", "30"], 4, "E-SGM-004", "--open")

    def test_options_and_inputs_that_do_not_apply(self):
        segment = ["segment", "image.nrrd", "-o", "out.nrrd"]
        self.assert_refused([*segment, "--method", "otsu", "--threshold", "3"], 2, "E-CMD-008")
        self.assert_refused([*segment, "--method", "otsu", "--seed", self.seed], 2, "E-CMD-008")
        self.assert_refused([*segment, "--threshold", "3", "--spread", "3"], 2, "E-CMD-008")
        self.assert_refused([*segment, "--threshold", "3", "--iterations", "3"], 2, "E-CMD-008")
        self.assert_refused(["segment", "image.nrrd", "-o", "out.stl"], 2, "E-CMD-004")
        self.run_program("segment", "image.nrrd", "-o", "out.json")
        self.assert_refused(["segment", "out.json", "-o", "again.nrrd"], 3, "E-SGM-008")


class TrackedFrames(harness.TestCase):
    """Frames through a ball of radius 20 mm, turned about an axis beside it, as a swept probe takes them."""

    def setUp(self):
        super().setUp()
        header = ("ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\nCompressedData = False\n"
                  "DimSize = 120 120 17\nElementSpacing = 1 1 1\nElementType = MET_UCHAR\nUltrasoundImageOrientation = MF\n")
        noise = np.random.default_rng(3)
        frames = []
        for f in range(17):
            a = np.radians(4 * (f - 8))
            x, y, z = np.array([1, 0, 0]), np.array([0, np.cos(a), np.sin(a)]), np.array([0, -np.sin(a), np.cos(a)])
            shift = np.array([-30, -40, 0]) * [1, 0, 0] + -40 * np.array([0, 1, 0])
            m = np.eye(4)
            m[:3, 0], m[:3, 1], m[:3, 2], m[:3, 3] = 0.5 * x, 0.5 * y, z, shift
            header += f"Seq_Frame{f:04}_ImageToReferenceTransform = {' '.join(map(str, m.ravel()))}\n"
            header += f"Seq_Frame{f:04}_ImageToReferenceTransformStatus = OK\n"
            j, i = np.meshgrid(np.arange(120), np.arange(120), indexing="ij")
            p = shift + 0.5 * i[..., None] * x + 0.5 * j[..., None] * y
            inside = (p ** 2).sum(axis=2) < 18 ** 2
            frames.append(np.where(inside, 160, 60) * noise.gamma(8, 1 / 8, inside.shape))
        pixels = np.clip(frames, 0, 255).astype(np.uint8)
        (self.folder / "sweep.igs.mha").write_bytes((header + "ElementDataFile = LOCAL\n").encode() + pixels.tobytes())

    def test_segmented_frames_make_a_model(self):
        answer = self.run_program("segment", "sweep.igs.mha", "--despeckle", "2", "--method", "chan-vese", "--frame", "LPS",
                                  "--seed-voxel", "60,80,8", "--keep-largest", "1", "-o", "ball.json", "--json").json()
        self.assertGreater(answer["voxels"], 10000)
        slices = json.loads((self.folder / "ball.json").read_text())["slices"]
        self.assertGreaterEqual(len(slices), 11)
        points = np.array([p for s in slices for c in s["contours"] for p in c["points"]])
        self.assertLess(np.abs(np.linalg.norm(points, axis=1) - 18).mean(), 0.8)
        self.run_program("model", "ball.json", "-o", "ball.vtu", "--size", "4")
        self.run_program("check", "ball.vtu")

    def test_info_thresholds_and_refusals(self):
        found = self.run_program("info", "sweep.igs.mha", "--json").json()
        self.assertEqual(found["image"]["tracked_frames"], 17)
        self.assertEqual(found["space"], "unknown")
        self.run_program("contours", "sweep.igs.mha", "--threshold", "110", "--min-area", "30", "-o", "x.json")
        self.assertEqual(json.loads((self.folder / "x.json").read_text())["space"], "unknown")
        self.assert_refused(["segment", "sweep.igs.mha", "--threshold", "100", "-o", "x.nrrd"], 2, "E-SGM-010")
        self.assert_refused(["contours", "sweep.igs.mha", "--threshold", "100", "--pose-to", "Table", "-o", "y.json"], 3, "E-TRK-001")


class HelpExamples(harness.TestCase):
    """What --help shows is run as it stands there, on images made for it: bone, a spleen and a femur where the seeds click."""

    def setUp(self):
        super().setUp()
        step, low = np.array([2.5, 2.5, 5]), np.array([20, -60, -430])
        shape = (40, 40, 115)
        p = [low[a] + step[a] * n for a, n in enumerate(np.meshgrid(*[np.arange(n) for n in shape], indexing="ij"))]
        away = [np.sqrt(sum((p[a] - c[a]) ** 2 for a in range(3))) for c in ((62.5, -20, 113), (60, -20, -150))]
        femur = (np.hypot(p[0] - 30, p[1] - 5) < 9) & (p[2] < -300)
        self.truth = {"bone": away[1] < 24, "spleen": away[0] < 22, "femur": femur}
        values = 30 + 100 * self.truth["spleen"] + 500 * (away[1] < 24) + 300 * femur
        values = values + np.random.default_rng(3).normal(0, 8, shape)
        affine = np.diag([-step[0], -step[1], step[2], 1])
        affine[:3, 3] = [-low[0], -low[1], low[2]]
        nibabel.save(nibabel.Nifti1Image(values.astype(np.int16), affine), self.folder / "ct.nii.gz")
        formats = (harness.SOURCE / "docs/formats.md").read_text()
        recipe = re.search(r"```json\n(\{\"format\": \"anatomesh-recipe\".*?)```", formats, re.S).group(1)
        (self.folder / "organs.json").write_text(recipe)
        header = "ObjectType = Image\nNDims = 3\nDimSize = 400 300 16\nElementType = MET_UCHAR\nUltrasoundImageOrientation = MFA\n"
        for f in range(16):
            header += f"Seq_Frame{f:04}_ImageToReferenceTransform = 0.2 0 0 0  0 0.2 0 0  0 0 1 {f}  0 0 0 1\n"
            header += f"Seq_Frame{f:04}_ImageToReferenceTransformStatus = OK\n"
        k, j, i = np.meshgrid(np.arange(16), np.arange(300), np.arange(400), indexing="ij")
        inside = (0.2 * (i - 300)) ** 2 + (0.2 * (j - 200)) ** 2 + (k - 10.0) ** 2 < 36
        pixels = np.where(inside, 40, 140) * np.random.default_rng(4).gamma(8, 1 / 8, inside.shape)
        (self.folder / "sweep.igs.mha").write_bytes((header + "ElementDataFile = LOCAL\n").encode()
                                                    + np.clip(pixels, 0, 255).astype(np.uint8).tobytes())

    def test_examples_of_segment_and_of_what_comes_after(self):
        text = self.run_program("segment", "--help").out.split("Examples:\n")[1]
        examples = [shlex.split(line)[1:] for line in text.splitlines() if line.startswith("  anatomesh ")]
        self.assertGreaterEqual(len(examples), 5)
        for words in examples:
            answer = self.run_program(*words, "--json").json()
            for found in answer.get("structures", [answer]):
                self.assertGreater(found["voxels"], 100, words)
            output = words[words.index("-o") + 1]
            if output.endswith(".json") and "sweep.igs.mha" not in words:
                self.run_program("field", output, "--what", "bits", "--pixel", "2.5", "-o", "bits.nrrd")
        for name, number, file in (("bone", 1, "bone.nrrd"), ("bone", 1, "organs.nrrd"), ("spleen", 7, "organs.nrrd")):
            labels = images.read_nrrd(self.folder / file)[0]
            self.assertGreater(images.dice(labels == number, self.truth[name]), 0.9, (name, file))
        femur = np.asarray(nibabel.load(self.folder / "femur.nii.gz").dataobj) > 0
        self.assertGreater(images.dice(femur, self.truth["femur"]), 0.95)
        slices = json.loads((self.folder / "cyst.json").read_text())["slices"]
        points = np.array([p for s in slices for c in s["contours"] for p in c["points"]])
        self.assertLess(np.abs(np.linalg.norm(points - [60, 40, 10], axis=1) - 6).mean(), 1)


class RealImages(harness.TestCase):
    def test_spleen_of_a_ct_from_one_seed_against_its_label(self):
        """The label was made by a trained network."""
        image = harness.data("body_ct_mr_labels", "example_ct.nii.gz")
        truth = harness.data("body_ct_mr_labels", "example_seg_fast_force_split.nii.gz")
        self.run_program("segment", image, "--seed", "109,-107.3,406.3", "-o", "spleen.nii.gz")
        found = np.asarray(nibabel.load(self.folder / "spleen.nii.gz").dataobj) == 1
        self.assertGreater(images.dice(found, np.asarray(nibabel.load(truth).dataobj) == 1), 0.85)

    def test_bones_of_a_ct_by_growing_in_a_box_against_their_labels(self):
        image = harness.data("body_ct_mr_labels", "example_ct.nii.gz")
        truth = np.asarray(nibabel.load(harness.data("body_ct_mr_labels", "example_seg_fast_force_split.nii.gz")).dataobj)
        for labels, words in (([76], ["--seed", "-89,-143,118", "--within", "-59,-104,94:-152,-167,145", "--close", "9"]),
                              (range(26, 33), ["--seed", "4,-125,310", "--within", "49,-62,205:-50,-164,427", "--close", "3"])):
            self.run_program("segment", image, "--threshold", "100:1500", *words, "--fill-holes", "-o", "bone.nii.gz")
            found = np.asarray(nibabel.load(self.folder / "bone.nii.gz").dataobj) == 1
            self.assertGreater(images.dice(found, np.isin(truth, labels)), 0.75)


if __name__ == "__main__":
    harness.main(__name__)
