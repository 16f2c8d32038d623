"""The examples as a new user runs them."""
import json
import os
import subprocess

import harness

EXAMPLES = harness.SOURCE / "examples"


class Examples(harness.TestCase):
    def test_every_verb(self):
        """Twice: results that are there already are replaced."""
        for _ in range(2):
            done = subprocess.run([str(EXAMPLES / "every_verb.sh"), "out put"], cwd=self.folder, capture_output=True,
                                  text=True, env={**os.environ, "ANATOMESH": harness.PROGRAM})
            self.assertEqual(done.returncode, 0, done.stderr)
            warnings = done.stderr.splitlines()
            self.assertEqual(len(warnings), 1, done.stderr)
            self.assertIn("W-PIP-015", warnings[0])  # they overlap
        names = {"both.vtu", "both.report.json", "both.stl", "both.contours.json", "both.html", "tumour.inp",
                 "tumour.report.json", "contours.vtp", "contours.report.json", "both.msh"}
        self.assertEqual(set(os.listdir(self.folder / "out put")), names)
        report = json.loads((self.folder / "out put/both.report.json").read_text())
        volumes = {each["name"]: each["volume_mesh_mm3"] for each in report["structures"]}
        self.assertAlmostEqual(volumes["organ"] / 14137, 1, delta=0.04)   # balls of 15 and 6 mm
        self.assertAlmostEqual(volumes["tumour"] / 905, 1, delta=0.1)

    def test_the_script_uses_every_verb(self):
        script = (EXAMPLES / "every_verb.sh").read_text()
        for verb in ("info", "contours", "model", "check", "compare", "convert"):
            self.assertIn(f'"$program" {verb} ', script)


if __name__ == "__main__":
    harness.main(__name__)
