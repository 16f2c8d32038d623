"""Real label maps and contours against the independent judge that stands beside the real data (skipped without both)."""
import harness


class ContourLists(harness.JudgedTestCase):
    """The parallel contour lists."""

    def test_abdomen(self):
        self.judged(harness.data("contours", "abdomen_mr_20x3mm_spleen_liver_kidneys.csl"), "--frame", "RAS")

    def test_spleen(self):
        self.judged(harness.data("contours", "spleen_ct_3mm.csl"), "--frame", "RAS")

    def test_skull(self):
        self.judged(harness.data("contours", "skull_ct_54x3mm_simplified.csl"))


class Pelvis(harness.JudgedTestCase):
    def test_contour_list(self):
        self.judged(harness.data("contours", "pelvis_ct_labels_3mm.csl"), "--frame", "RAS")


class Spine(harness.JudgedTestCase):
    def test_contour_list(self):
        self.judged(harness.data("contours", "spine_ct_axial_1mm_simplified.csl"), "--frame", "RAS")

    def test_label_map(self):
        self.judged(harness.data("spine_ct_labels", "sub-verse004_seg-vert_msk.nii.gz"))


class BodyLabels(harness.JudgedTestCase):
    def test_abdomen_of_a_magnetic_resonance_image(self):
        self.judged(harness.data("body_ct_mr_labels", "example_seg_mr.nii.gz"))

    def test_body_of_a_computed_tomography(self):
        self.judged(harness.data("body_ct_mr_labels", "example_seg_fast_force_split.nii.gz"))


class Rtstruct(harness.JudgedTestCase):
    def test_abdomen(self):
        files = sorted(harness.data("abdomen_rtstruct").rglob("*.dcm"))
        self.assertTrue(files)
        self.judged(files[0])


if __name__ == "__main__":
    harness.main(__name__)
