"""A hostile system: memory that ends, threads that cannot be made, calls that signals interrupt, odd rounding modes."""
import errno
import hashlib
import os
import pathlib
import random
import subprocess

import harness
import shapes

CALLS = pathlib.Path(__file__).resolve().parents[1] / "hostile/failing_calls.c"


class Process(harness.TestCase):
    def setUp(self):
        super().setUp()
        compiler = os.environ.get("CC", "cc")
        try:
            subprocess.run([compiler, "-shared", "-fPIC", "-O1", "-o", str(self.folder / "calls.so"), str(CALLS), "-ldl", "-lm"],
                           check=True, capture_output=True)
        except FileNotFoundError:
            self.skipTest("there is no C compiler")
        self.write("ball.json", shapes.sphere(8.0, 3.0).document())

    def model(self, threads=2, expect=0, **settings):
        """Exit code and error text, and the hash of the model if there is one."""
        for name in ("m.vtu", "m.report.json"):
            (self.folder / name).unlink(missing_ok=True)
        done = subprocess.run([harness.PROGRAM, "model", "ball.json", "-o", "m.vtu", "--threads", str(threads), "--quiet"], cwd=self.folder,
                              capture_output=True, text=True, timeout=300,
                              env={**os.environ, "LD_PRELOAD": str(self.folder / "calls.so"), **{k: str(v) for k, v in settings.items()}})
        model = self.folder / "m.vtu"
        whole = model.exists() and (self.folder / "m.report.json").exists()
        self.assertEqual(whole, done.returncode == 0, (settings, done.stderr))
        self.assertEqual(model.exists(), whole, settings)
        return done.returncode, done.stderr, hashlib.sha256(model.read_bytes()).hexdigest() if whole else None

    def test_M14_rounding_modes_of_others_change_no_byte(self):
        expected = self.model()
        self.assertEqual(expected[0], 0, expected[1])
        for rounding in ("up", "down", "zero"):
            for threads in (1, 2):
                self.assertEqual(self.model(threads, ROUNDING=rounding), expected, rounding)

    def test_F11_fewer_threads_give_the_same_bytes(self):
        expected = self.model(1)
        for at in (1, 2, 3):
            for more in ({}, {"FAIL_FROM_THEN_ON": 1}):
                self.assertEqual(self.model(2, FAIL_CALL="pthread_create", FAIL_AT=at, FAIL_ERRNO=errno.EAGAIN, **more), expected, at)

    def test_F02_F07_interrupted_calls_are_made_again(self):
        expected = self.model(1)
        for call in ("open", "read"):
            for at in range(1, 13):
                self.assertEqual(self.model(1, FAIL_CALL=call, FAIL_AT=at, FAIL_ERRNO=errno.EINTR), expected, (call, at))

    def test_F07_a_disk_that_cannot_be_read_is_told(self):
        codes = {self.model(1, FAIL_CALL="read", FAIL_AT=at, FAIL_FROM_THEN_ON=1, FAIL_ERRNO=errno.EIO)[0] for at in range(1, 8)}
        self.assertIn(6, codes)
        self.assertLessEqual(codes, {0, 6})

    def test_F10_a_folder_whose_names_cannot_be_exchanged_is_told(self):
        (self.folder / "m.vtu").write_text("what stood there")
        for number in (errno.EXDEV, errno.EPERM, errno.ENOSPC):
            done = subprocess.run([harness.PROGRAM, "model", "ball.json", "-o", "m.vtu", "--quiet"], cwd=self.folder, capture_output=True, text=True,
                                  env={**os.environ, "LD_PRELOAD": str(self.folder / "calls.so"), "FAIL_CALL": "rename", "FAIL_AT": "1",
                                       "FAIL_ERRNO": str(number)})
            self.assertEqual(done.returncode, 6, done.stderr)
            self.assertIn("E-FILE", done.stderr)
            self.assertEqual((self.folder / "m.vtu").read_text(), "what stood there")
            self.assertEqual(sorted(path.name for path in self.folder.iterdir()), ["ball.json", "calls.so", "m.vtu"])

    def test_F12_the_clock_changes_no_byte(self):
        expected = self.model()
        self.assertEqual(expected[0], 0, expected[1])
        for seconds in (0, 1, 2 ** 31, 2 ** 32 + 5, 253402300800):
            self.assertEqual(self.model(CLOCK=seconds), expected, seconds)

    def test_F06_the_end_of_memory_is_told_wherever_it_strikes(self):
        told = 0
        places = random.Random(3)
        for n in range(120):
            at = n + 1 if n < 60 else int(10 ** places.uniform(1.8, 4.6))
            more = {"FAIL_FROM_THEN_ON": 1} if n % 2 else {}
            code, text, _ = self.model(1, FAIL_CALL="malloc", FAIL_AT=at, **more)
            self.assertIn(code, (0, 5), (at, more, text))
            if code == 5:
                self.assertIn("E-", text, at)
                told += 1
        self.assertGreater(told, 60)


if __name__ == "__main__":
    harness.main(__name__)
