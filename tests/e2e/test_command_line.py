"""Rows P-* and F-13 of the catalogue of bad input, and what every verb shares: help, versions, exit codes, completion."""
import json
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

VERBS = ("info", "segment", "contours", "field", "model", "check", "compare", "convert", "receive", "query", "fetch",
         "send", "where-next", "project", "completion", "manual")


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

    def test_help_fits_a_terminal_of_80_columns(self):
        for verb in ("", *VERBS):
            for flag in ("--help", "--help-all"):
                lines = self.run_program(*verb.split(), flag).out.split("Example")[0].splitlines()
                self.assertEqual([line for line in lines if len(line) > 80], [], (verb, flag))

    def test_help_of_model_lists_the_ten_options_used_most(self):
        text = self.run_program("model", "--help").out.split("Most used options:\n")[1].split("\n\n")[0]
        self.assertEqual(len(re.findall(r"^  -", text, re.M)), 10)
        self.assertLess(len(self.run_program("model", "--help").out.splitlines()), 60)

    def test_complete_help_has_every_option_in_a_group(self):
        groups = ["Input", "Slices and structures", "Contour repair", "Crossing planes", "Mesh", "Simulation", "Outputs", "Run"]
        complete = self.run_program("model", "--help-all").out
        self.assertEqual(re.findall(r"^(\S.*):$", complete.split("Examples")[0], re.M), groups)
        for verb in VERBS:
            completion = self.run_program("completion", "fish").out
            options = re.findall(rf"_from {verb}'.* -l ([a-z-]+)", completion)
            text = self.run_program(verb, "--help-all").out
            self.assertTrue(options, verb)
            for option in options:
                self.assertRegex(text, rf"(?m)^  (-\w, )?--{option}\b", verb)

    def test_version(self):
        self.assertRegex(self.run_program("--version").out, r"^anatomesh \d+\.\d+\.\d+\n$")

    def test_limits_are_listed_by_the_program_and_by_verbs(self):
        text = self.run_program("--limits").out
        for what in ("file-bytes", "voxels", "tetrahedra", "coordinate"):
            self.assertIn(what, text)
        self.assertEqual(self.run_program("model", "--limits").out, text)

    def test_manual_has_every_option_and_is_valid_troff(self):
        manual = self.run_program("manual").out
        for verb in VERBS:
            for option in re.findall(r"(--[a-z-]+)", self.run_program(verb, "--help-all").out.split("Examples")[0]):
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
        self.assertEqual(sorted(self.complete("anatomesh", "model", "--caps", "")), ["flat", "half", "rounded"])
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
        self.assert_refused([], 2, "command")
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

    def test_P03_slices_that_there_are_not_or_all_of_them(self):
        self.assert_refused(["model", "ball.json", "-o", "a.vtu", "--without", "z = 99"], 2, "E-CON-010", "the slices are: ")
        self.image("labels.nrrd", [0] * 21 + [1] * 22 + [0] * 21,
                   "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 4 4\nspace: LPS\nspace directions: (1,0,0) (0,1,0) "
                   "(0,0,1)\nspace origin: (0,0,0)\nencoding: raw\n\n")
        self.assert_refused(["contours", "labels.nrrd", "-o", "a.json", "--without", "k = 3"], 2, "E-CON-010", "the slices are: ")
        self.assert_refused(["contours", "labels.nrrd", "-o", "a.json", "--min-area", "0", "--without", "k = 1", "--without", "k=2"], 2, "E-CON-011")
        self.run_program("contours", "labels.nrrd", "-o", "a.json", "--min-area", "0", "--without", "k = 1", "--quiet")
        slices = json.loads((self.folder / "a.json").read_text())["slices"]
        self.assertEqual([s["name"] for s in slices], ["k = 2"])

    def test_P03_options_that_do_not_apply(self):
        for words in (["--threshold", "5"], ["--keep-largest", "1"], ["--min-area", "3"]):
            self.assert_refused(["model", "ball.json", "-o", "a.vtu", *words], 2, "E-CMD-008", words[0])

    def test_P03_options_of_dicom_tracking_and_other_slices_for_parallel_contours(self):
        matrix = "1,0,0,0,0,1,0,0,0,0,1,0"
        for words in (["--series", "x"], ["--allow-gaps"], ["--ignore-patient"], ["--ignore-frame-of-reference"],
                      ["--match-by-geometry"], ["--allow-outside"], ["--ultrasound-region", "1"], ["--frame-step", "1"],
                      ["--keep-patient-ids"], ["--image-to-probe", matrix], ["--pose-to", "Tracker"],
                      ["--slice-thickness", "7"], ["--align"], ["--reconcile", "0"], ["--max-disagreement", "5"]):
            self.assert_refused(["model", "ball.json", "-o", "a.vtu", *words], 2, "E-CMD-008", words[0])
        self.image("plain.nrrd", [0] * 21 + [1] * 22 + [0] * 21,
                   "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 4 4\nspace: LPS\nspace directions: (1,0,0) (0,1,0) "
                   "(0,0,1)\nspace origin: (0,0,0)\nencoding: raw\n\n")
        for words in (["--pose-to", "Tracker"], ["--image-to-probe", matrix], ["--series", "x"]):
            self.assert_refused(["contours", "plain.nrrd", "-o", "a.json", *words], 2, "E-CMD-008", words[0])

    def image(self, name, values, header):
        self.write(name, header.encode() + bytes(values))

    def test_P03_options_of_images_for_contours_and_of_nifti_for_others(self):
        self.image("labels.nrrd", [0] * 21 + [1] * 22 + [0] * 21,
                   "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 4 4\nspace: LPS\nspace directions: (1,0,0) (0,1,0) "
                   "(0,0,1)\nspace origin: (0,0,0)\nencoding: raw\n\n")
        for words in (["--use", "qform"], ["--assume-orientation", "RAS"], ["--volume", "0"]):
            self.assert_refused(["info", "ball.json", *words], 2, "E-CMD-008", words[0])
        for words in (["--use", "sform"], ["--assume-orientation", "RAS"], ["--holes", "filled"], ["--max-repair", "1"],
                      ["--closing-gap", "1"], ["--close-loops", "1"], ["--close-gaps", "1"], ["--close-slivers", "1"], ["--same-line", "0.01"], ["--plane-repair", "1"], ["--keyhole", "1"], ["--unite-repeated-planes"]):
            self.assert_refused(["contours", "labels.nrrd", "-o", "a.json", *words], 2, "E-CMD-008", words[0])
        for words in (["--frame", "RAS"], ["--holes", "filled"]):
            self.assert_refused(["check", "ball.json", *words], 2, "E-CMD-008", words[0], "--contours")
        self.assertIn("W-CMD-003", self.run_program("info", "labels.nrrd", "--frame", "RAS").err)
        self.assertIn("W-CMD-002", self.run_program("contours", "labels.nrrd", "-o", "a.csl", "--threshold", "1").err)
        self.assertNotIn("W-CMD", self.run_program("contours", "labels.nrrd", "-o", "a.csl").err)

    def test_a_unit_that_the_user_states_is_not_doubted(self):
        ring = "0 0 {z}\n{s} 0 {z}\n{s} {s} {z}\n0 {s} {z}\n4 1 0 1 2 3\n"
        for size in (0.01, 0.1):
            planes = "".join(f"{k + 1} 4 1 0 0 1 {-size * k / 4}\n" + ring.format(z=size * k / 4, s=size) for k in range(4))
            self.write("small.csl", "CSLC\n4 1\n" + planes)
            words = ["contours", "small.csl", "-o", "c.json", "--frame", "LPS"]
            self.assertIn("W-CON-023", self.run_program(*words).err)
            self.assertNotIn("W-CON-023", self.run_program(*words, "--unit", "mm").err)
            self.run_program(*words, "--unit", "m")
            points = json.loads((self.folder / "c.json").read_text())["slices"][0]["contours"][0]["points"]
            self.assertAlmostEqual(max(p[0] for p in points), 1000 * size)

    def test_values_of_options_are_validated(self):
        for words in (["--holes", "none"], ["--max-repair", "1.5"], ["--closing-gap", "-1"], ["--close-gaps", "11"], ["--close-slivers", "-1"], ["--same-line", "1"], ["--plane-repair", "11"], ["--keyhole", "11"],
                      ["--max-gap", "0.5"], ["--slice-thickness", "0"], ["--limit", "voxels"], ["--limit", "voxels=0"],
                      ["--limit", "pixels=5"], ["--limit", "voxels=+5"], ["--limit", "voxels=1e6"],
                      ["--limit", "points=99999999999"]):
            self.assert_refused(["model", "ball.json", "-o", "a.vtu", *words], 2, "E-CMD-001", words[0])
        for axes in ("RAX", "RR", "ras", "RASL", "RLS"):
            nifti = ["info", "ball.json", "--assume-orientation", axes]
            self.assert_refused(nifti, 2, "--assume-orientation")

    def test_P04_unknown_extension_lists_the_known(self):
        self.assert_refused(["model", "ball.json", "-o", "a.xyz"], 2, "E-CMD-004", ".vtu", ".msh", ".inp")
        self.assert_refused(["model", "ball.json", "-o", "a"], 2, ".vtu")
        self.assert_refused(["model", "ball.json", "-o", "a.vtu", "--surface", "a.vtu"], 2, ".stl", ".ply")
        self.assert_refused(["contours", "ball.json", "-o", "a.png"], 2, ".json", ".vtp", ".csl")

    def test_P04_structure_not_found_lists_the_names(self):
        self.write("pair.json", shapes.touching_balls().document())
        self.assert_refused(["model", "pair.json", "-o", "a.vtu", "--structure", "liver"], 2, "E-CMD-005", "left (1)",
                            "right (2)", "liver")

    def test_json_is_one_document_and_the_error_stands_on_standard_error_too(self):
        self.run_program("model", "ball.json", "-o", "ball.vtu", "--quiet")
        self.write("other.json", shapes.sphere(11).document())
        for words, code in ((["check", "ball.vtu", "--contours", "other.json"], 4), (["info", "nothing.json"], 6),
                            (["mdoel"], 2), (["info", "ball.json", "--use", "up"], 2), (["check", "ball.json"], 3),
                            (["contours", "ball.json", "-o", "a.csl", "--threshold", "5"], 2)):
            result = self.run_program(*words, "--json", expect=code)
            document = json.loads(result.out)
            self.assertRegex(result.err, r"anatomesh: E-[A-Z]{2,4}-\d{3}\b")
            if words[0] == "check" and code == 4:
                self.assertEqual(document["certificate"][0]["state"], "broken")
            else:
                self.assertEqual(document["error"]["exit_code"], code)

    def test_errors_are_json_when_json_is_asked(self):
        error = self.run_program("info", "nothing.json", "--json", expect=6).json()["error"]
        self.assertEqual(error["exit_code"], 6)
        self.assertRegex(error["code"], r"^E-[A-Z]+-\d{3}$")


class Messages(harness.TestCase):
    """What is said names the file, what was found, and what to do next."""

    def setUp(self):
        super().setUp()
        self.write("ball.json", shapes.sphere(10).document())

    def test_every_error_of_an_odd_input_has_a_next_step(self):
        self.write("empty", "")
        self.write("text", "some notes\nof mine")
        self.write("bytes", bytes([0x89, 1, 2, 3]))
        self.write("page.csl", "CSLC 1 1")
        self.write("hexa.msh", "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n0 0 0 0\n$EndNodes\n$Elements\n1 1 1 1\n"
                               "3 1 5 1\n1 1 2 3 4 5 6 7 8\n$EndElements\n")
        self.write("quad.stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\n"
                               "vertex 0 1 0\nendloop\nendfacet\nendsolid a\n")
        self.write("hexa.mesh", "MeshVersionFormatted 2\nDimension 3\nVertices\n0\nHexahedra\n1\n1 2 3 4 5 6 7 8 1\nEnd\n")
        cases = [(verb, name, text) for verb in (["info"], ["convert", "-o", "x.vtu"], ["check"], ["compare", "ball.json"])
                 for name, text in ((".", "folder"), ("empty", "the file is empty"), ("text", "'some notes'"),
                                    ("bytes", "89 01 02 03"), ("none", "E-INP-001"))]
        cases += [(["convert", "-o", "x.vtu"], "hexa.msh", "E-MDL-006"), (["convert", "-o", "x.ply"], "quad.stl", "E-MDL"),
                  (["check"], "hexa.mesh", "E-MDL"), (["info"], "page.csl", "E-CSL")]
        for verb, name, text in cases:
            words = [*verb, name] if verb[0] != "compare" else ["compare", name, name]
            with self.subTest(words=words):
                code = 6 if name == "none" else 3
                message = self.assert_refused(words, code, text).err
                self.assertIn(f" {name}", message)
                self.assertIn("(next: ", message)

    def test_a_surface_has_no_tetrahedra_to_check_or_to_convert(self):
        self.run_program("model", "ball.json", "-o", "ball.vtu", "--surface", "ball.stl", "--quiet")
        self.assert_refused(["check", "ball.stl"], 3, "E-CMD-012", "surface", "next:")
        self.assert_refused(["convert", "ball.stl", "-o", "ball.msh"], 2, "E-CMD-008", "next:")

    def test_one_is_singular(self):
        self.write("two.json", shapes.touching_balls().document())
        one = self.run_program("info", "ball.json").out
        self.assertIn("  1 structure:\n", one)
        self.assertIn("  2 structures:\n", self.run_program("info", "two.json").out)
        text = self.run_program("model", "ball.json", "-o", "ball.vtu").out
        self.assertIn(" 1 shell, ", text)
        for line in (one + text).splitlines():
            self.assertNotRegex(line, r"\b1 (structures|shells|contours|slices|points|triangles|vertices)\b")
        other = shapes.sphere(10).document()
        other["slices"][4]["contours"][0]["points"][0][0] += 1e-4
        self.write("other.json", other)
        broken = self.run_program("check", "ball.vtu", "--contours", "other.json", expect=4).err
        self.assertIn("breaks 1 clause of the certificate", broken)

    def test_check_says_that_the_frame_is_missing(self):
        shape = shapes.sphere(10)
        self.write("off.json", shape.document(to_space=lambda p: (p[0] + 30, p[1] + 50, p[2])))
        self.run_program("contours", "off.json", "-o", "off.csl", "--quiet")
        self.run_program("model", "off.csl", "-o", "off.vtu", "--frame", "RAS", "--quiet")
        message = self.run_program("check", "off.vtu", "--contours", "off.csl", expect=4).err
        self.assertIn("--frame RAS", message)
        self.run_program("check", "off.vtu", "--contours", "off.csl", "--frame", "RAS")

    def test_compare_names_the_axes_of_each(self):
        self.run_program("contours", "ball.json", "-o", "ball.csl", "--quiet")
        self.run_program("model", "ball.csl", "-o", "unknown.vtu", "--quiet")
        self.run_program("model", "ball.json", "-o", "known.vtu", "--quiet")
        message = self.run_program("compare", "known.vtu", "unknown.vtu").err
        self.assertIn("the two files state different axes", message)
        self.assertIn("LPS of known.vtu, unknown of unknown.vtu", message)


class Options(harness.TestCase):
    """Options that messages advise, and what they do."""

    def setUp(self):
        super().setUp()
        self.write("ball.json", shapes.sphere(10).document())

    def disc(self, radius, z, points=48):
        import math
        return [[radius * math.cos(2 * math.pi * i / points), radius * math.sin(2 * math.pi * i / points), z]
                for i in range(points)]

    def drawn(self, slices):
        return {"format": "anatomesh-contours", "version": 1, "space": "LPS", "unit": "mm",
                "structures": [{"number": 1, "name": "disc"}],
                "slices": [{"contours": [{"structure": 1, "points": points} for points in contours]}
                           for contours in slices]}

    def test_every_limit_can_be_set_and_is_named(self):
        text = self.run_program("--limits").out
        names = re.findall(r"^([a-z-]+) +\d", text, re.M)
        self.assertGreaterEqual(len(names), 12)
        for name in names:
            self.run_program("info", "ball.json", "--limit", f"{name}=10000000")
        for name, value in (("file-bytes", 100), ("contours", 2), ("points", 50), ("contour-points", 10), ("coordinate", 5)):
            result = self.run_program("info", "ball.json", "--limit", f"{name}={value}", expect=None)
            self.assertIn(result.code, (3, 5), name)

    def test_slice_thickness_makes_one_slice_a_solid(self):
        self.write("one.json", self.drawn([[self.disc(10, 0)]]))
        self.assert_refused(["model", "one.json", "-o", "one.vtu"], 4, "E-FLD-003", "--slice-thickness")
        self.run_program("model", "one.json", "-o", "one.vtu", "--slice-thickness", "4")
        report = json.loads((self.folder / "one.report.json").read_text())
        volume = report["structures"][0]["volume_mesh_mm3"]
        self.assertAlmostEqual(volume / (3.1326 * 100 * 4), 1, delta=0.02)

    def test_max_gap_joins_what_is_far_apart(self):
        self.write("gap.json", self.drawn([[self.disc(10, z)] for z in (0, 2, 4, 6, 16, 18, 20, 22)]))
        apart = self.run_program("model", "gap.json", "-o", "apart.vtu")
        self.assertIn("--max-gap", apart.err)
        self.assertIn(" 2 shells", apart.out)
        self.assertIn(" 1 shell,", self.run_program("model", "gap.json", "-o", "joined.vtu", "--max-gap", "6").out)

    def test_holes_filled(self):
        self.write("ring.json", self.drawn([[self.disc(10, z), self.disc(5, z)] for z in (0, 2, 4)]))
        area = []
        for rule in ("even-odd", "filled"):
            self.run_program("contours", "ring.json", "-o", "out.json", "--holes", rule, "--report", "report.json", "--quiet")
            kept = json.loads((self.folder / "out.json").read_text())
            area.append(sum(len(s["contours"]) for s in kept["slices"]))
            report = json.loads((self.folder / "report.json").read_text())
            self.assertEqual(report["options"]["holes"], rule)
            self.assertEqual(len(report["contour_log"]), 6)
        self.assertEqual(area, [6, 3])

    def test_contours_report_has_inputs_options_log_and_warnings(self):
        self.run_program("contours", "ball.json", "-o", "out.csl", "--report", "out.report.json")
        report = json.loads((self.folder / "out.report.json").read_text())
        self.assertEqual(report["inputs"][0]["file"], "ball.json")
        self.assertEqual(report["warnings"][0]["code"], "W-CIO-006")
        self.assertEqual(report["contour_log"][0]["rule"], "outer")

    def test_M09_M12_tiny_size_is_refused_before_the_work(self):
        start = time.time()
        result = self.assert_refused(["model", "ball.json", "-o", "a.vtu", "--size", "0.01"], 5, "E-CMD-014", "--size",
                                     "--limit")
        self.assertLess(time.time() - start, 5)
        self.assertIn("tetrahedra", result.err)
        self.assert_refused(["model", "ball.json", "-o", "a.vtu", "--size", "1", "--limit", "tetrahedra=1000"], 5,
                            "E-CMD-014")
        self.assert_refused(["model", "ball.json", "-o", "a.vtu", "--size", "1", "--limit", "memory-bytes=1000000"], 5,
                            "E-CMD-014")

    def test_a_flat_disc_of_close_slices_asks_for_a_size(self):
        disc = shapes.Shape({1: "disc"}, 0.01)
        for k in range(5):
            disc.add_slice(0.01 * k, [(1, shapes.circle(10, 24))])
        self.write("disc.json", disc.document())
        start = time.time()
        result = self.assert_refused(["model", "disc.json", "-o", "a.vtu"], 5, "E-CMD-014", "--size")
        self.assertLess(time.time() - start, 5)
        self.assertIn("0.01 mm apart", result.err)

    def two_plates(self, gap):
        def slab(low, high):
            return [(0, low), (20, low), (20, high), (0, high)]

        plates = shapes.Shape({1: "plates"}, 3)
        for z in range(0, 15, 3):
            plates.add_slice(z, [(1, slab(0, 3)), (1, slab(3 + gap, 6))])
        self.write("plates.json", plates.document())

    def model_of(self, name, *options):
        self.run_program("model", name, "-o", "a.vtu", "--quiet", *options)
        return json.loads((self.folder / "a.report.json").read_text())

    def test_a_narrow_gap_that_a_coarse_mesh_bridges_is_warned_of(self):
        """By bridges and cavities, or altogether: one solid without a handle."""
        bridged = 0
        for gap in (0.02, 0.03):
            self.two_plates(gap)
            report = self.model_of("plates.json", "--size", "3")
            if (report["structures"][0]["components"], report["structures"][0]["genus"]) != (2, 0):
                self.assertIn("W-PIP-004", [w["code"] for w in report["warnings"]], gap)
                bridged += 1
        self.assertGreater(bridged, 0, "no gap was bridged: nothing is shown")
        self.two_plates(1)
        report = self.model_of("plates.json", "--size", "1")
        self.assertEqual((report["structures"][0]["components"], report["structures"][0]["genus"]), (2, 0))
        self.assertNotIn("W-PIP-004", [w["code"] for w in report["warnings"]])

    def test_tubes_and_hollow_parts_are_not_taken_for_torn(self):
        rings = shapes.Shape({1: "rings"}, 3)
        for z in range(0, 30, 3):
            rings.add_slice(z, [(1, shapes.circle(r, 4 * r)) for r in (20, 16, 12, 8, 4)])
        self.write("rings.json", rings.document())
        report = self.model_of("rings.json")
        self.assertEqual((report["structures"][0]["components"], report["structures"][0]["genus"]), (3, 2))
        self.assertEqual(report["warnings"], [])

    def test_M09_M12_a_size_larger_than_the_object_makes_a_model_and_warns(self):
        for size in ("60", "1000"):
            self.run_program("model", "ball.json", "-o", "a.vtu", "--size", size, "--quiet")
            codes = [w["code"] for w in json.loads((self.folder / "a.report.json").read_text())["warnings"]]
            self.assertIn("W-PIP-002", codes)

    def test_the_estimate_is_near_the_truth(self):
        self.write("egg.json", shapes.ellipsoid((30, 20, 15)).document())
        for size in ("1.5", "3"):
            self.run_program("model", "egg.json", "-o", "egg.vtu", "--size", size, "--quiet")
            made = json.loads((self.folder / "egg.report.json").read_text())["counts"]["tetrahedra"]
            refused = self.run_program("model", "egg.json", "-o", "no.vtu", "--size", size, "--limit", "tetrahedra=10",
                                       expect=5).err
            estimate = float(re.search(r"about (\S+) tetrahedra", refused).group(1))
            self.assertLess(max(made / estimate, estimate / made), 4, (size, made, estimate))

    def test_advice_names_only_options_there_are(self):
        """Every --option in messages, in the sources and in the documentation is one that the program has."""
        known = set()
        for verb in ("", *VERBS):
            known |= set(re.findall(r"--[a-z][a-z-]*", self.run_program(*verb.split(), "--help-all").out))
        quoted = re.compile(r'"(?:[^"\\\n]|\\.)*"')
        for root, suffixes in (("src", (".cpp", ".h")), ("apps", (".cpp", ".h"))):
            for source in sorted((harness.SOURCE / root).rglob("*")):
                if source.suffix not in suffixes or "_test" in source.name or "viewer_script" in source.name:
                    continue
                text = re.sub(r"^\s*//.*$", "", source.read_text(), flags=re.M)
                for literal in quoted.findall(text):
                    for option in re.findall(r"(?<![-\w(])--[a-z][a-z-]*", literal):
                        self.assertIn(option, known, f"{source}: {literal}")
        docs = harness.SOURCE / "docs"
        documents = [*sorted(docs.glob("*.md")), *sorted((docs / "stages").glob("*.md")), harness.SOURCE / "README.md"]
        for document in documents:
            for line in document.read_text().splitlines():
                if "bench/" in line or "ctest" in line or "cmake" in line or "bench" in document.name:
                    continue
                for option in re.findall(r"(?<![-\w])--[a-z]+(?:-[a-z]+)*(?![-\w])", line):  # not a line that is drawn: --x--
                    self.assertIn(option, known, f"{document.name}: {line}")


class Outputs(harness.TestCase):
    def setUp(self):
        super().setUp()
        self.ball = self.write("ball.json", shapes.sphere(10).document())
        self.before = self.ball.read_bytes()

    def refused_and_intact(self, *words, code=2):
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
        self.refused_and_intact("model", "ball.json", "-o", "a.vtu", "--dump", f"cull={self.folder}/a.vtu")
        self.refused_and_intact("model", "ball.json", "-o", "a.vtu", "--report", "c.json", "--contours", "c.json")
        self.refused_and_intact("contours", "ball.json", "-o", "c.json", "--report", "../" + self.folder.name + "/c.json")
        os.symlink("b.stl", self.folder / "soft.stl")  # to a file that is not there yet
        self.refused_and_intact("model", "ball.json", "-o", "a.vtu", "--surface", "b.stl", "--surface", "soft.stl")
        self.write("one.stl", "")
        os.link(self.folder / "one.stl", self.folder / "two.stl")
        self.refused_and_intact("model", "ball.json", "-o", "a.vtu", "--surface", "one.stl", "--surface", "two.stl")

    def test_P06_is_found_before_any_work(self):
        os.mkfifo(self.folder / "pipe.json")
        self.run_program("model", "pipe.json", "-o", "a.vtu", "--surface", "b.stl", "--surface", "b.stl", expect=2,
                         timeout=10)
        self.run_program("contours", "pipe.json", "-o", "pipe.json", expect=2, timeout=10)

    def test_P06_output_is_the_data_file_of_the_input(self):
        self.write("image.mhd", "ObjectType = Image\nNDims = 3\nDimSize = 4 4 4\nElementSpacing = 1 1 1\nElementType = MET_UCHAR\n"
                                "ElementDataFile = values.json\n")
        values = self.write("values.json", bytes([0] * 21 + [1] * 22 + [0] * 21))
        before = values.read_bytes()
        self.assert_refused(["model", "image.mhd", "-o", "a.vtu", "--report", "values.json"], 2, "E-CMD-006")
        self.assert_refused(["contours", "image.mhd", "-o", "values.json"], 2, "E-CMD-006")
        self.assertEqual(values.read_bytes(), before)

    def test_P04_names_that_are_only_an_extension_and_other_extensions(self):
        for words in (["model", "ball.json", "-o", ".vtu"], ["model", "ball.json", "-o", "./.vtu"],
                      ["contours", "ball.json", "-o", ".json"],
                      ["model", "ball.json", "-o", "a.vtu", "--surface", ".stl"],
                      ["model", "ball.json", "-o", "a.vtu", "--html", "page.txt"],
                      ["model", "ball.json", "-o", "a.vtu", "--html", "page"],
                      ["model", "ball.json", "-o", "a.vtu", "--report", "report.txt"],
                      ["contours", "ball.json", "-o", "a.csl", "--report", "report"]):
            result = self.refused_and_intact(*words)
            self.assertIn("E-CMD-004", result.err)

    def test_an_answer_that_cannot_be_printed_leaves_no_file(self):
        self.write("old.csl", "old")
        before = sorted(os.listdir(self.folder))
        for words in (["contours", "ball.json", "-o", "old.csl"], ["contours", "ball.json", "-o", "new.csl", "--json"],
                      ["model", "ball.json", "-o", "a.vtu"], ["model", "ball.json", "-o", "a.vtu", "--json"]):
            with open("/dev/full", "w") as full:
                self.run_program(*words, stdout=full, expect=6)
            self.assertEqual(sorted(os.listdir(self.folder)), before, words)
        self.assertEqual((self.folder / "old.csl").read_text(), "old")
        self.run_program("model", "ball.json", "-o", "a.vtu")
        with open("/dev/full", "w") as full:
            self.run_program("convert", "a.vtu", "-o", "b.msh", stdout=full, expect=6)
            self.run_program("convert", "a.vtu", "-o", "b.msh", "--quiet", stdout=full)
        self.assertTrue((self.folder / "b.msh").exists())

    def test_F03_outputs_that_cannot_be_written(self):
        (self.folder / "folder.vtu").mkdir()
        self.refused_and_intact("model", "ball.json", "-o", "none/a.vtu", code=6)
        self.refused_and_intact("model", "ball.json", "-o", "folder.vtu", code=6)
        self.refused_and_intact("model", "ball.json", "-o", "x" * 5000 + ".vtu", code=6)
        if os.geteuid() != 0:
            locked = self.folder / "locked"
            locked.mkdir(mode=0o500)
            self.refused_and_intact("model", "ball.json", "-o", "locked/a.vtu", code=6)

    def test_F03_is_found_before_the_work(self):
        """An input that would take long is not even opened when an output cannot be written."""
        os.mkfifo(self.folder / "input.json")
        self.run_program("model", "input.json", "-o", "none/a.vtu", expect=6, timeout=10)

    def test_F01_a_limit_on_files_is_an_error_and_no_signal(self):
        for script in ('ulimit -f 0; exec "$@"', 'ulimit -f 0; exec "$@" 2>err.txt'):
            done = subprocess.run(["bash", "-c", script, "bash", harness.PROGRAM, "contours", "ball.json", "-o", "b.json"],
                                  cwd=self.folder, capture_output=True, text=True)
            self.assertEqual(done.returncode, 6, script)
            self.assertFalse((self.folder / "b.json").exists())

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

    def test_P07_an_answer_needs_standard_output(self):
        for words in ("info ball.json", "info ball.json --quiet", "manual", "--help", "--limits",
                      "contours ball.json -o closed.json --json"):
            done = subprocess.run(["bash", "-c", f'exec "$0" {words} >&-', harness.PROGRAM], cwd=self.folder,
                                  stderr=subprocess.PIPE, text=True)
            self.assertEqual(done.returncode, 6, words)
            self.assertIn("E-CMD-009", done.stderr)
        self.assertFalse((self.folder / "closed.json").exists())

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

    def test_M15_interrupt_cancels_with_130_and_no_file(self):
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
        time_left = re.compile(rb", (\d+ min )?\d+ s left")
        self.assertRegex(shown, time_left)
        self.assertIn(b"[", shown)
        piped = subprocess.run(self.words, cwd=self.folder, capture_output=True)
        self.assertNotIn(b"\x1b", piped.stderr)
        self.assertNotRegex(piped.stderr, time_left)


if __name__ == "__main__":
    harness.main(__name__)
