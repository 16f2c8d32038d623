"""What the tests of power failures share: runs whose calls on files are recorded, and what the log must hold."""
import os
import pathlib
import subprocess
import sys

import harness

HOSTILE = pathlib.Path(__file__).resolve().parents[1] / "hostile"
sys.path.insert(0, str(HOSTILE))
import disk  # noqa: E402

KILLED = 9  # the exit code of a run that recorded_calls.c ends


class TestCase(harness.TestCase):
    """A test with a folder `place`, whose files are recorded, and a log of the calls."""

    def setUp(self):
        super().setUp()
        self.folder = self.folder.resolve()
        compiler = os.environ.get("CC", "cc")
        try:
            subprocess.run([compiler, "-shared", "-fPIC", "-O1", "-o", str(self.folder / "calls.so"), str(HOSTILE / "recorded_calls.c"), "-ldl"],
                           check=True, capture_output=True)
        except FileNotFoundError:
            self.skipTest("there is no C compiler")
        self.log = self.folder / "log"
        self.place = self.folder / "place"  # whose files are recorded
        self.place.mkdir()

    def recording(self, last=0):
        return {"LD_PRELOAD": str(self.folder / "calls.so"), "CALLS_LOG": str(self.log), "CALLS_UNDER": str(self.place), "CALLS_LAST": str(last)}

    def found(self):
        """Paths in the place and contents, None for a folder."""
        return {str(path.relative_to(self.place)): path.read_bytes() if path.is_file() else None for path in self.place.rglob("*")}

    def assert_complete(self, played):
        """No call escaped the log: played to the end it gives what is there."""
        kept = {path: content for path, (_, content) in played.left(({}, "kept")).items() if path}
        self.assertEqual(kept, self.found())
