"""The same outlines by any format give the same model: label maps, and the contours that the program writes of them."""
import json

import numpy as np

import harness
import images

SIZE = (16, 15, 14)
TOUCHING = (11, 10, 9)


def ball(radius, center=(7.6, 7.2, 6.4), spacing=(1, 1, 1)):
    n = np.meshgrid(*[np.arange(s) for s in SIZE], indexing="ij")
    return sum(((a - c) * s) ** 2 for a, c, s in zip(n, center, spacing)) < radius ** 2


def on_slices(mask, axis, slices):
    painted = np.zeros_like(mask)
    index = [slice(None)] * 3
    index[axis] = list(slices)
    painted[tuple(index)] = mask[tuple(index)]
    return painted


def maps():
    """(name, label map, spacing, options) of every kind: whole, on every nth slice along any axis, uneven, plates, one slice."""
    for spacing in ((1, 1, 1.5), (0.7, 0.7, 3)):
        whole = ball(5.5)
        yield "whole", whole.astype(np.uint8), spacing, []
        yield "one slice", on_slices(whole, 2, [6]).astype(np.uint8), spacing, ["--axis", "z"]
        yield "one empty slice within", on_slices(whole, 2, [n for n in range(14) if n != 7]).astype(np.uint8), spacing, ["--axis", "z"]
        yield "two structures", (whole + 1 * (whole & (np.arange(SIZE[0]) > 7)[:, None, None])).astype(np.uint8), spacing, []
        for axis in range(3):
            for step in ((2, 3) if axis == 2 else (3,)):
                every = on_slices(whole, axis, range(axis % step, SIZE[axis], step)).astype(np.uint8)
                yield f"every {step} along {axis}", every, spacing, ["--axis", "xyz"[axis]]
        uneven = on_slices(whole, 2, (2, 4, 7, 9, 11)).astype(np.uint8)
        yield "uneven", uneven, spacing, ["--axis", "z"]


class SameModel(harness.TestCase):
    def figures(self, *words):
        self.run_program("model", *words, "-o", "model.vtu", "--quiet")
        report = json.loads((self.folder / "model.report.json").read_text())
        return ([(s["volume_mesh_mm3"], s["components"], s["genus"]) for s in report["structures"]],
                {w["code"] for w in report["warnings"]})

    def test_contours_of_a_label_map_give_its_model_by_any_file(self):
        seen = 0
        for name, labels, spacing, options in maps():
            images.write_nrrd(self.folder / "map.nrrd", labels, spacing, (-30, 12, 5))
            for between in ("nothing", "interpolated"):
                if between == "interpolated" and ("whole" == name or "structures" in name):
                    continue
                words = [*options, "--between-sparse", between]
                direct, warned = self.figures("map.nrrd", *words)
                sparse = any(word in name for word in ("every", "uneven"))
                self.assertEqual("W-TRC-007" in warned, sparse, f"{name} {spacing}")
                self.assertEqual("W-FLD-013" in warned, name == "one slice", f"{name} {spacing}")
                for ending in (".vtp", ".json"):
                    self.run_program("contours", "map.nrrd", *words, "-o", "contours" + ending, "--quiet")
                    by_file, _ = self.figures("contours" + ending)
                    with self.subTest(map=name, spacing=spacing, between=between, ending=ending):
                        self.assertEqual(len(by_file), len(direct))
                        for (volume, *counts), (same, *same_counts) in zip(by_file, direct):
                            self.assertAlmostEqual(volume / same, 1, delta=1e-3)
                            self.assertEqual(counts, same_counts)
                    seen += 1
        self.assertGreaterEqual(seen, 50)

    def touching(self, random):
        """Two to four structures that touch, cells about random points in a ball; some are painted on every nth slice."""
        count = int(random.integers(2, 5))
        n = np.stack(np.meshgrid(*[np.arange(s) for s in TOUCHING], indexing="ij"), -1)
        middles = random.uniform([3, 3, 2], np.array(TOUCHING) - [3, 3, 2], size=(count, 3))
        labels = np.linalg.norm(n[..., None, :] - middles, axis=-1).argmin(-1) + 1
        middle = (np.array(TOUCHING) - 1) / 2
        labels = np.where(np.linalg.norm((n - middle) / (middle - 0.7), axis=-1) < 1, labels, 0).astype(np.uint8)
        is_sparse = random.random(count) < 0.5
        for structure in np.flatnonzero(is_sparse) + 1:
            step = int(random.integers(2, 4))
            kept = on_slices(labels == structure, 2, range(int(random.integers(step)), TOUCHING[2], step))
            labels[(labels == structure) & ~kept] = 0
        return labels, (1, 1, float(random.choice((1, 1.5, 3)))), is_sparse.any()

    def test_structures_that_touch_and_are_sparse_are_the_same_by_any_file(self):
        random = np.random.default_rng(7)
        sparse = others = 0
        for n in range(50):
            labels, spacing, is_sparse = self.touching(random)
            sparse += is_sparse
            images.write_nrrd(self.folder / "map.nrrd", labels, spacing, (-30, 12, 5))
            words = ["--axis", "z"]
            direct, warned = self.figures("map.nrrd", *words)
            ending = (".json", ".vtp")[n % 2]
            self.run_program("contours", "map.nrrd", *words, "-o", "contours" + ending, "--quiet")
            with self.subTest(n=n, spacing=spacing, ending=ending):
                by_file, told = self.figures("contours" + ending)
                # A structure of which no island is left stands in no file of contours.
                self.assertEqual(by_file, [figures for figures in direct if figures[0] > 0])
                # Tracing tells of pixels and of structures on some slices alone; of a file slices without them are told.
                of_source = {w for w in warned ^ told if w.startswith("W-TRC") or w in ("W-CON-024", "W-FLD-003")}
                self.assertEqual(warned ^ told, of_source)
                if "W-TRC-007" in warned:
                    self.assertIn("W-FLD-003", told)
            if ending == ".json" and is_sparse and others == 0:
                # Without the word, the same contours end otherwise.
                file = json.loads((self.folder / "contours.json").read_text())
                self.assertTrue(file.pop("exclusive"))
                self.write("contours.json", file)
                without, _ = self.figures("contours.json")
                others += any(abs(a[0] / b[0] - 1) > 5e-3 for a, b in zip(without, direct))
        self.assertGreater(sparse, 20)
        self.assertEqual(others, 1)

    def test_a_file_that_calls_overlapping_structures_exclusive_is_told(self):
        def ring(x, y, r, z):
            return [[x - r, y - r, z], [x + r, y - r, z], [x + r, y + r, z], [x - r, y + r, z]]
        for name, second, text in (("crossing", (4, 3, 5), "overlap"), ("within", (1, 0, 2), "overlap"),
                                   ("beside, other vertices", (10.5, 0.5, 5.5), "different vertices"), ("beside", (10, 0, 5), "")):
            file = {"format": "anatomesh-contours", "version": 1, "space": "LPS", "unit": "mm", "coverage": "complete",
                    "exclusive": True, "structures": [{"number": n, "name": "ab"[n - 1]} for n in (1, 2)],
                    "slices": [{"contours": [{"structure": 1, "points": ring(0, 0, 5, z)},
                                             {"structure": 2, "points": ring(*second, z)}]} for z in (0, 2, 4)]}
            self.write("c.json", file)
            said = self.run_program("contours", "c.json", "-o", "again.json").err
            self.assertEqual("W-CON-034" in said, bool(text), name)
            self.assertIn(text, said)
            self.assertEqual(json.loads((self.folder / "again.json").read_text()).get("exclusive", False), not text, name)
            file["coverage"] = "drawn"
            self.write("c.json", file)
            self.assertIn("not that its slices are complete", self.run_program("contours", "c.json", "-o", "again.json").err)
            file["exclusive"] = "yes"
            self.write("c.json", file)
            self.assert_refused(["contours", "c.json", "-o", "x.json"], 3, "E-JSN-003", "true or false")

    def test_what_lies_between_sparse_slices_is_a_ball_when_asked_for(self):
        for axis in range(3):
            for step in (3,):
                labels = on_slices(ball(5.5), axis, range(1, SIZE[axis], step)).astype(np.uint8)
                images.write_nrrd(self.folder / "map.nrrd", labels)
                words = ["map.nrrd", "--axis", "xyz"[axis], "--min-area", "0"]
                [(volume, parts, _)], _ = self.figures(*words, "--between-sparse", "interpolated")
                self.assertEqual(parts, 1)
                self.assertAlmostEqual(volume / np.count_nonzero(ball(5.5)), 1, delta=0.06, msg=f"{axis} {step}")
                [(plates, parts, _)], _ = self.figures(*words)
                self.assertEqual(parts, len(np.unique(np.nonzero(labels)[axis])))
                self.assertAlmostEqual(plates / np.count_nonzero(labels), 1, delta=0.1)

    def test_one_slice_is_as_thick_as_stated(self):
        for thickness in (0.8, 2, 5):
            labels = on_slices(ball(5.5), 2, [6]).astype(np.uint8)
            images.write_nrrd(self.folder / "map.nrrd", labels, (1, 1, thickness))
            [(volume, _, _)], warned = self.figures("map.nrrd", "--axis", "z")
            self.assertAlmostEqual(volume / (np.count_nonzero(labels) * thickness), 1, delta=0.02)
            self.assertIn("W-FLD-013", warned)
            [(volume, _, _)], warned = self.figures("map.nrrd", "--axis", "z", "--slice-thickness", "3")
            self.assertAlmostEqual(volume / (np.count_nonzero(labels) * 3), 1, delta=0.02)
            self.assertNotIn("W-FLD-013", warned)


if __name__ == "__main__":
    harness.main(__name__)
