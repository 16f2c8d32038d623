"""What every end-to-end test shares: running the real program, a folder of its own, the data, and the ending.

Environment: ANATOMESH_PROGRAM, the program; ANATOMESH_DAMAGING, the one that damages its meshes; ANATOMESH_SOURCE, the root of the repository; ANATOMESH_DATA, a folder
of real data (absent: tests that need it are skipped).
"""
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

SOURCE = pathlib.Path(os.environ.get("ANATOMESH_SOURCE", pathlib.Path(__file__).resolve().parents[2]))
PROGRAM = os.environ.get("ANATOMESH_PROGRAM", str(SOURCE / "build/release/anatomesh"))
# The same, but it damages the mesh before it checks it (tests/damage).
DAMAGING = os.environ.get("ANATOMESH_DAMAGING", str(SOURCE / "build/release/tests/anatomesh_damaging"))
CRASHES = (134, 139, 136, 132, 135)


class Result:
    def __init__(self, code, out, err):
        self.code, self.out, self.err = code, out, err

    def json(self):
        return json.loads(self.out)


class TestCase(unittest.TestCase):
    """A test with an empty folder as `self.folder` and a runner of the program."""

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="anatomesh-test-"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)

    def run_program(self, *words, expect=0, timeout=600, **options):
        """Runs the program and checks its exit code; a death by signal is a failure whatever was expected."""
        result = run_program(*words, cwd=options.pop("cwd", self.folder), timeout=timeout, **options)
        self.assertGreaterEqual(result.code, 0, f"died by signal {-result.code}: {words}\n{result.err}")
        self.assertNotIn(result.code, CRASHES, result.err)
        if expect is not None:
            self.assertEqual(result.code, expect, f"{' '.join(map(str, words))}\n{result.out[-2000:]}\n{result.err[-4000:]}")
        return result

    def assert_refused(self, words, code, *texts, outputs=()):
        """Exit code `code`, every text in the message, no output file and no temporary file left."""
        before = sorted(os.listdir(self.folder))
        result = self.run_program(*words, expect=code)
        for text in texts:
            self.assertIn(text, result.err)
        self.assertEqual(sorted(os.listdir(self.folder)), before, "files appeared or vanished")
        for output in outputs:
            self.assertFalse((self.folder / output).exists(), f"{output} was written")
        return result

    def write(self, name, content):
        path = self.folder / name
        if isinstance(content, bytes):
            path.write_bytes(content)
        elif isinstance(content, str):
            path.write_text(content)
        else:
            path.write_text(json.dumps(content))
        return path


class JudgedTestCase(TestCase):
    """Models of real data, judged by the independent script beside them."""

    def judged(self, path, *options):
        """The judge's figures of the model of `path`, with what every model must keep asserted."""
        judge = acceptance("check_model.py")
        self.run_program("model", path, "-o", "model.vtu", "--contours", "contours.vtp", *options, timeout=900)
        done = subprocess.run(["/usr/bin/python3", str(judge), "model.vtu", "--contours", "contours.vtp"],
                              cwd=self.folder, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr[-2000:])
        figures = json.loads(done.stdout)
        for name in ("unused_points", "duplicate_points", "inverted", "duplicate_tets", "facets_in_more_than_two_tets",
                     "facets_with_both_tets_on_one_side"):
            self.assertEqual(figures[name], 0, name)
        for structure, state in figures["structures"].items():
            for name in ("open_edges", "nonmanifold_edges", "nonmanifold_vertices"):
                self.assertEqual(state[name], 0, f"structure {structure}: {name}")
        self.assertEqual(figures["contours"]["on_surface"], 1.0)
        self.assertLessEqual(figures["radius_edge"]["share_over_2"], 0.005)
        self.assertLessEqual(figures["radius_edge"]["mean"], 1.05)
        return figures


def run_program(*words, cwd=None, timeout=600, env=None, program=PROGRAM, **options):
    environment = dict(os.environ)
    for name, value in (env or {}).items():
        if value is None:
            environment.pop(name, None)
        else:
            environment[name] = value
    options.setdefault("stdin", subprocess.DEVNULL)
    done = subprocess.run([program, *map(str, words)], cwd=cwd, timeout=timeout, env=environment,
                          stdout=options.pop("stdout", subprocess.PIPE), stderr=options.pop("stderr", subprocess.PIPE),
                          **options)
    return Result(done.returncode, (done.stdout or b"").decode("utf-8", "replace"),
                  (done.stderr or b"").decode("utf-8", "replace"))


def data(*parts):
    """A file of the real data; skips the test when it is not there."""
    root = pathlib.Path(os.environ.get("ANATOMESH_DATA") or SOURCE.parent / "shared/data")
    path = root.joinpath(*parts)
    if not path.exists():
        raise unittest.SkipTest(f"no {'/'.join(parts)} (set ANATOMESH_DATA to a folder that has it)")
    return path


def acceptance(name):
    """A script of the independent judge beside the real data; skips the test when it is not there."""
    root = pathlib.Path(os.environ.get("ANATOMESH_DATA") or SOURCE.parent / "shared/data").parent
    path = root / "acceptance" / name
    if not path.exists():
        raise unittest.SkipTest(f"no {name} beside the real data")
    return path


def skull():
    """The CT skull of Debian's package invesalius-examples; skips the test when it cannot be had."""
    found = subprocess.run([str(SOURCE / "scripts/skull.sh")], stdout=subprocess.PIPE, text=True, cwd=SOURCE)
    path = found.stdout.strip()
    if found.returncode != 0 or not path:
        raise unittest.SkipTest("no Cranium.inv3: the package invesalius-examples is not installed")
    return pathlib.Path(SOURCE, path)


def main(module):
    """Runs the classes named on the command line (all without). Exit code 77 when every test was skipped."""
    names = sys.argv[1:]
    loader = unittest.TestLoader()
    suite = unittest.TestSuite()
    for name, each in vars(sys.modules[module]).items():
        if isinstance(each, type) and issubclass(each, unittest.TestCase) and each.__module__ == module:
            if not names or name in names:
                suite.addTests(loader.loadTestsFromTestCase(each))
    result = unittest.TextTestRunner(verbosity=2).run(suite)
    if result.testsRun + len(result.skipped) == 0:
        sys.exit("no test of that name")
    if not result.wasSuccessful():
        sys.exit(1)
    sys.exit(77 if result.skipped and len(result.skipped) >= result.testsRun else 0)
