"""Rows P-* and F-13 of the catalogue of bad input, and what every verb shares: help, versions, exit codes, completion."""
import os
import pty
import re
import shutil
import signal
import subprocess
import time
import unittest

import harness
import shapes

VERBS = ("info", "contours", "model", "check", "compare", "convert", "completion", "manual")


class Help(harness.TestCase):
    def test_help_names_every_verb_and_exit_code(self):
        text = self.run_program("--help").out
        for verb in VERBS:
            self.assertIn(verb, text)
        for code in "2345670":
            self.assertRegex(text, rf"\b{code}\b")

    def test_every_verb_has_help_with_an_example(self):
        for verb in VERBS:
            text = self.run_program(verb, "--help").out
            self.assertRegex(text, rf"Examples?:\n\s+anatomesh {verb}", verb)

    def test_version(self):
        self.assertRegex(self.run_program("--version").out, r"^anatomesh \d+\.\d+\.\d+\n$")

    def test_limits_are_listed_by_the_program_and_by_verbs(self):
        text = self.run_program("--limits").out
        for what in ("input file", "voxels", "tetrahedra", "coordinates"):
            self.assertIn(what, text)
        self.assertEqual(self.run_program("model", "--limits").out, text)

    def test_manual_has_every_option_and_is_valid_troff(self):
        manual = self.run_program("manual").out
        for verb in VERBS:
            for option in re.findall(r"(--[a-z-]+)", self.run_program(verb, "--help").out.split("Examples")[0]):
                self.assertIn(option.replace("-", r"\-"), manual)
        if shutil.which("man"):
            page = self.write("anatomesh.1", manual)
            shown = subprocess.run(["man", "--warnings", "-l", str(page)], capture_output=True, text=True)
            self.assertEqual(shown.stderr, "")


class Completion(harness.TestCase):
    def complete(self, *words):
        script = self.write("completion.bash", self.run_program("completion", "bash").out)
        line = " ".join(f"'{w}'" for w in words)
        command = (f"source {script}; COMP_WORDS=({line}); COMP_CWORD={len(words) - 1}; _anatomesh; "
                   'printf "%s\\n" "${COMPREPLY[@]}"')
        return subprocess.run(["bash", "-c", command], capture_output=True, text=True, check=True,
                              cwd=self.folder).stdout.split()

    def test_bash_completes_verbs_options_values_and_files(self):
        self.assertEqual(self.complete("anatomesh", "mo"), ["model"])
        self.assertEqual(self.complete("anatomesh", "model", "--thr"), ["--threshold", "--threads"])
        self.assertEqual(sorted(self.complete("anatomesh", "model", "--caps", "")), ["flat", "half"])
        self.assertEqual(self.complete("anatomesh", "completion", "z"), ["zsh"])
        self.write("liver.nii.gz", "")
        self.assertEqual(self.complete("anatomesh", "info", "liv"), ["liver.nii.gz"])

    def test_scripts_parse_in_their_shells(self):
        for shell, check in (("bash", ["bash", "-n"]), ("zsh", ["zsh", "-n"]), ("fish", ["fish", "-n"])):
            script = self.write(f"completion.{shell}", self.run_program("completion", shell).out)
            self.assertIn("--json" if shell != "fish" else "-l json", script.read_text())
            if shutil.which(shell):
                subprocess.run([*check, str(script)], check=True)


class WrongCommands(harness.TestCase):
    def setUp(self):
        super().setUp()
        self.write("ball.json", shapes.sphere(10).document())

    def test_P01_unknown_verb_and_option_with_a_suggestion(self):
        self.assert_refused(["mdoel", "ball.json"], 2, "E-CMD-002", "did you mean model?")
        self.assert_refused(["model", "ball.json", "-o", "a.vtu", "--sufrace", "a.stl"], 2, "did you mean --surface?")
        self.assert_refused(["info", "--josn", "ball.json"], 2, "did you mean --json?")
        self.assert_refused(["info", "ball.json", "--frobnicate"], 2, "E-CMD-002", "--help")
        self.assert_refused(["info", "ball.json", "-x"], 2, "-x")
        self.assert_refused(["info", "ball.json", "more.json"], 2, "more.json")
        self.assert_refused([], 2, "verb")
        self.assert_refused(["info"], 2, "INPUT")

    def test_P01_value_missing(self):
        self.assert_refused(["model", "ball.json", "-o", "a.vtu", "--size"], 2, "--size", "value")
        self.assert_refused(["model", "ball.json", "-o", "a.vtu", "--size", "--json"], 2, "--size", "value")
        self.assert_refused(["model", "ball.json", "-o"], 2, "output")
        self.assert_refused(["model", "ball.json"], 2, "output")

    def test_P01_given_twice(self):
        self.assert_refused(["model", "ball.json", "-o", "a.vtu", "--size", "2", "--size", "3"], 2, "--size")
        self.assert_refused(["model", "ball.json", "-o", "a.vtu", "-o", "b.vtu"], 2, "output")

    def test_P02_values_that_are_no_numbers(self):
        numbers = ("1,5", "1e-400", "0x10", " 5mm", "5 ", "9223372036854775808", "-0", "-0.0", "nan", "inf", "1e400",
                   "+3", "", "1.2.3", "\u0665")
        for text in numbers:
            for option in ("--size", "--epsilon", "--min-area"):
                self.assert_refused(["model", "ball.json", "-o", "a.vtu", f"{option}={text}"], 2, option)
            if text not in ("1e400",):
                self.assert_refused(["contours", "ball.json", "-o", "a.json", f"--threshold={text}"], 2, "--threshold")
        for text in ("1.0", "1,5", "0x1", " 5", "-0", "-1", "9223372036854775808", "4294967297", "+1", "1e3", ""):
            for option in ("--every", "--offset", "--keep-largest", "--threads"):
                self.assert_refused(["model", "ball.json", "-o", "a.vtu", f"{option}={text}"], 2, option)

    def test_P03_values_out_of_range_and_contradictions(self):
        for words in (["--threads", "0"], ["--threads", "1000000"], ["--size", "0"], ["--size", "1e9"],
                      ["--every", "0"], ["--epsilon", "-1"], ["--threshold", "300:200"], ["--keep-largest", "0"],
                      ["--every", "2", "--offset", "2"], ["--caps", "round"], ["--frame", "XYZ"],
                      ["--dump", "cul=a.vtu"], ["--dump", "cull"], ["--dump", "cull="]):
            self.assert_refused(["model", "ball.json", "-o", "a.vtu", *words], 2, words[-2] if words[-2] != "2" else "--offset")

    def test_P03_options_that_do_not_apply(self):
        for words in (["--threshold", "5"], ["--keep-largest", "1"], ["--min-area", "3"]):
            self.assert_refused(["model", "ball.json", "-o", "a.vtu", *words], 2, "E-CMD-008", words[0])

    def test_P04_unknown_extension_lists_the_known(self):
        self.assert_refused(["model", "ball.json", "-o", "a.xyz"], 2, "E-CMD-004", ".vtu", ".msh", ".inp")
        self.assert_refused(["model", "ball.json", "-o", "a"], 2, ".vtu")
        self.assert_refused(["model", "ball.json", "-o", "a.vtu", "--surface", "a.vtu"], 2, ".stl", ".ply")
        self.assert_refused(["contours", "ball.json", "-o", "a.dcm"], 2, ".json", ".vtp", ".csl")

    def test_P04_structure_not_found_lists_the_names(self):
        self.write("pair.json", shapes.touching_balls().document())
        self.assert_refused(["model", "pair.json", "-o", "a.vtu", "--structure", "liver"], 2, "E-CMD-005", "left (1)",
                            "right (2)", "liver")

    def test_errors_are_json_when_json_is_asked(self):
        error = self.run_program("info", "nothing.json", "--json", expect=6).json()["error"]
        self.assertEqual(error["exit_code"], 6)
        self.assertRegex(error["code"], r"^E-[A-Z]+-\d{3}$")


class Outputs(harness.TestCase):
    def setUp(self):
        super().setUp()
        self.ball = self.write("ball.json", shapes.sphere(10).document())
        self.before = self.ball.read_bytes()

    def refused_and_intact(self, *words, code=6):
        result = self.assert_refused(words, code)
        self.assertEqual(self.ball.read_bytes(), self.before)
        return result

    def test_P06_output_is_the_input_also_by_a_link(self):
        self.refused_and_intact("contours", "ball.json", "-o", "ball.json")
        self.refused_and_intact("contours", "ball.json", "-o", "./ball.json")
        os.link(self.ball, self.folder / "hard.json")
        self.refused_and_intact("contours", "ball.json", "-o", "hard.json")
        os.symlink("ball.json", self.folder / "soft.json")
        self.refused_and_intact("contours", "ball.json", "-o", "soft.json")
        self.refused_and_intact("model", "ball.json", "-o", "a.vtu", "--report", "soft.json")

    def test_P06_two_outputs_are_one(self):
        self.refused_and_intact("model", "ball.json", "-o", "a.vtu", "--surface", "b.stl", "--surface", "./b.stl")

    def test_F03_outputs_that_cannot_be_written(self):
        (self.folder / "folder.vtu").mkdir()
        self.refused_and_intact("model", "ball.json", "-o", "none/a.vtu")
        self.refused_and_intact("model", "ball.json", "-o", "folder.vtu")
        self.refused_and_intact("model", "ball.json", "-o", "x" * 5000 + ".vtu")
        if os.geteuid() != 0:
            locked = self.folder / "locked"
            locked.mkdir(mode=0o500)
            self.refused_and_intact("model", "ball.json", "-o", "locked/a.vtu")

    def test_F03_is_found_before_the_work(self):
        """An input that would take long is not even opened when an output cannot be written."""
        os.mkfifo(self.folder / "input.json")
        self.run_program("model", "input.json", "-o", "none/a.vtu", expect=6, timeout=10)

    def test_F01_disk_full_leaves_the_old_file(self):
        self.run_program("contours", "ball.json", "-o", "out.json")
        old = (self.folder / "out.json").read_bytes()
        for limit in (0, 1, 100, 1000, len(old) - 1):
            limited = (["bash", "-c", f'trap "" XFSZ; ulimit -f 0; exec "$@"', "bash"] if limit < 1024 else None)
            if limited is None:
                continue
            done = subprocess.run([*limited, harness.PROGRAM, "contours", "ball.json", "-o", "out.json"],
                                  cwd=self.folder, capture_output=True, text=True)
            self.assertEqual(done.returncode, 6, done.stderr)
            self.assertEqual((self.folder / "out.json").read_bytes(), old)
            self.assertEqual(sorted(os.listdir(self.folder)), ["ball.json", "out.json"])


class Surroundings(harness.TestCase):
    """P-07: locale, time zone, HOME, closed streams, argv[0]: the same bytes."""

    def setUp(self):
        super().setUp()
        self.write("ball.json", shapes.sphere(10).document())
        self.run_program("contours", "ball.json", "-o", "plain.json")
        self.plain = (self.folder / "plain.json").read_bytes()

    def same(self, **options):
        self.run_program("contours", "ball.json", "-o", "again.json", **options)
        self.assertEqual((self.folder / "again.json").read_bytes(), self.plain)

    def test_P07_time_zone_and_home(self):
        self.same(env={"TZ": "Pacific/Kiritimati"})
        self.same(env={"TZ": ":/nothing", "HOME": None, "PATH": None})

    def test_P07_locales(self):
        if not shutil.which("localedef"):
            raise unittest.SkipTest("no localedef to make a locale with (package locales)")
        for name in ("de_DE", "tr_TR"):
            made = subprocess.run(["localedef", "-i", name, "-f", "UTF-8", str(self.folder / f"{name}.UTF-8")],
                                  capture_output=True, text=True)
            if not (self.folder / f"{name}.UTF-8" / "LC_NUMERIC").exists():
                raise unittest.SkipTest(f"localedef made no {name}: {made.stderr}")
            self.same(env={"LC_ALL": f"{name}.UTF-8", "LOCPATH": str(self.folder)})

    def test_P07_closed_streams(self):
        for closing in ("<&-", ">&-", "2>&-", "<&- >&- 2>&-"):
            target = self.folder / "closed.json"
            command = f'exec "$0" contours ball.json -o closed.json {closing}'
            done = subprocess.run(["bash", "-c", command, harness.PROGRAM], cwd=self.folder)
            self.assertEqual(done.returncode, 0, closing)
            self.assertEqual(target.read_bytes(), self.plain, closing)
            target.unlink()

    def test_P07_empty_name_of_the_program(self):
        for name in ("", "anatomesh\n"):
            done = subprocess.run([name, "contours", "ball.json", "-o", "again.json"], executable=harness.PROGRAM,
                                  cwd=self.folder)
            self.assertEqual(done.returncode, 0)
        self.assertEqual((self.folder / "again.json").read_bytes(), self.plain)

    def test_F13_closed_pipe_ends_quietly(self):
        done = subprocess.run(["bash", "-c", 'set -o pipefail; "$0" manual | head -1; echo ${PIPESTATUS[0]}',
                               harness.PROGRAM], capture_output=True, text=True)
        self.assertEqual(done.stderr, "")
        self.assertEqual(done.stdout.splitlines()[-1], "0")

    def test_full_standard_output_is_an_error(self):
        with open("/dev/full", "w") as full:
            self.run_program("--help", stdout=full, expect=6)

    def test_names_cannot_drive_the_terminal(self):
        document = shapes.sphere(10).document()
        document["structures"][0]["name"] = "liver\x1b[2J\u009b2J"
        self.write("evil.json", document)
        text = self.run_program("info", "evil.json").out
        self.assertIn("liver", text)
        self.assertNotIn("\x1b", text)
        self.assertNotIn("\u009b", text)


class LongWork(harness.TestCase):
    """Progress and cancelling, on work that takes seconds."""

    def setUp(self):
        super().setUp()
        self.skull = harness.skull()
        self.words = [harness.PROGRAM, "model", str(self.skull), "--threshold", "226", "--keep-largest", "1",
                      "-o", "skull.vtu", "--surface", "skull.stl"]

    def test_interrupt_cancels_with_130_and_no_file(self):
        for delay in (0.3, 1.5, 3.0):
            process = subprocess.Popen(self.words, cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
            time.sleep(delay)
            process.send_signal(signal.SIGINT)
            out, err = process.communicate(timeout=60)
            self.assertEqual(process.returncode, 130, err.decode())
            self.assertIn("cancelled", err.decode())
            self.assertEqual(os.listdir(self.folder), [])

    def test_F04_kill_leaves_nothing_but_a_temporary_file(self):
        process = subprocess.Popen(self.words, cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        time.sleep(2)
        process.kill()
        process.communicate()
        for name in os.listdir(self.folder):
            self.assertTrue(name.startswith(".anatomesh-"), name)

    def test_progress_is_shown_on_a_terminal_only(self):
        leader, follower = pty.openpty()
        process = subprocess.Popen(self.words, cwd=self.folder, stdout=subprocess.DEVNULL, stderr=follower)
        os.close(follower)
        shown = b""
        while True:
            try:
                piece = os.read(leader, 4096)
            except OSError:
                break
            if not piece:
                break
            shown += piece
        self.assertEqual(process.wait(), 0)
        self.assertIn(b"%", shown)
        self.assertIn(b" left", shown)
        self.assertIn(b"[", shown)
        piped = subprocess.run(self.words, cwd=self.folder, capture_output=True)
        self.assertNotIn(b"\x1b", piped.stderr)
        self.assertNotIn(b" left", piped.stderr)


if __name__ == "__main__":
    harness.main(__name__)
