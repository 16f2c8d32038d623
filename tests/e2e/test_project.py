"""Project files: written here by the page on formats alone, read by the program, and damaged."""
import json
import math
import random
import struct
import unittest
import zlib

import harness


def line(record):
    text = json.dumps(record, ensure_ascii=False, separators=(",", ":")).encode()
    return b'{"crc32":"%08x","bytes":%d,"record":%s}\n' % (zlib.crc32(text), len(text), text)


def head(**others):
    return {"n": 0, "format": "anatomesh-project", "version": 1, "space": "LPS", "unit": "mm", "pixel_mm": 0.5,
            "slice_thickness_mm": 0, **others}


def ring(z, radius, count=24, turn=0.1):
    return [(radius * math.cos(turn + 2 * math.pi * i / count), radius * math.sin(turn + 2 * math.pi * i / count), z)
            for i in range(count)]


def as_text(points):
    return " ".join(repr(value) for point in points for value in point)


def plane(id, z, **others):
    to = {"origin": [0, 0, z], "u": [1, 0, 0], "v": [0, 1, 0], "normal": [0, 0, 1], "name": f"z = {z}", "thickness_mm": 3.0,
          "left_out": False, **others}
    return {"plane": id, "to": to}


def drawn(id, points, structure=1):
    return {"rings": [id, structure], "to": [{"tool": "stroke", "points": as_text(points)}]}


def bits(points):
    return [struct.pack("<3d", *point) for point in points]


class Project(harness.TestCase):
    """A ball drawn on seven slices, step by step."""

    HEIGHTS = (-9, -6, -3, 0, 3, 6, 9)

    def setUp(self):
        super().setUp()
        self.rings = {i + 1: ring(z, math.sqrt(144 - z * z)) for i, z in enumerate(self.HEIGHTS)}
        self.records = [head(), self.step("Add liver", {"structure": 1, "to": {"name": "Leber, \"links\"\n\u00e4", "color": [200, 80, 60], "locked": False}},
                                          {"order": True, "to": [1]}, n=1)]
        for id, z in enumerate(self.HEIGHTS, 1):
            self.add(self.step(f"Draw liver on z = {z}", plane(id, z), drawn(id, self.rings[id])))
        self.add({"do": "undo", "name": "Draw liver on z = 9"})
        self.add({"do": "redo", "name": "Draw liver on z = 9"})

    def step(self, name, *changes, n=None):
        return {"n": len(self.records) if n is None else n, "do": "apply", "name": name, "changes": list(changes)}

    def add(self, record):
        self.records.append({"n": len(self.records), **record} if "n" not in record else record)

    def save(self, name="liver.project", change=lambda content: content):
        return self.write(name, change(b"".join(map(line, self.records))))

    def test_says_what_is_there_and_writes_the_contours_bit_for_bit(self):
        self.add(self.step("Leave out z = 3", plane(5, 3, left_out=True)))
        self.add(self.step("Delete z = 9", {"rings": [7, 1], "to": None}))
        self.add({"do": "undo", "name": "Delete z = 9"})
        self.save()
        answer = self.run_program("project", "liver.project", "--json").json()
        self.assertEqual(answer["records"], len(self.records))
        self.assertEqual(answer["structures"], [{"number": 1, "name": "Leber, \"links\"\n\u00e4", "color": [200, 80, 60], "locked": False,
                                                 "planes": 7, "contours": 7, "points": 168, "proposals": 0}])
        self.assertEqual(answer["left_out"], ["z = 3"])
        self.assertEqual(answer["undo"][:2], ["Leave out z = 3", "Draw liver on z = 9"])
        self.assertEqual(answer["redo"], ["Delete z = 9"])
        self.assertIn("7 contours on 7 planes", self.run_program("project", "liver.project").out)
        self.run_program("project", "liver.project", "--contours", "c.json")
        contours = json.loads((self.folder / "c.json").read_text())
        self.assertEqual(contours["pixel_mm"], 0.5)
        self.assertEqual([each["name"] for each in contours["slices"]], [f"z = {z}" for z in self.HEIGHTS])
        for id, each in enumerate(contours["slices"], 1):
            self.assertEqual(bits(each["contours"][0]["points"]), bits(self.rings[id]))
        self.run_program("model", "c.json", "--without", "z = 3", "--size", "4", "-o", "m.vtu")
        volume = json.loads((self.folder / "m.report.json").read_text())["structures"][0]["volume_mesh_mm3"]
        self.assertGreater(volume, 0.9 * sum(math.pi * (144 - z * z) * 3 for z in self.HEIGHTS))

    def test_the_example_of_the_page_on_formats_is_a_project(self):
        page = (harness.SOURCE / "docs/formats.md").read_text().splitlines()
        self.write("page.project", "".join(each + "\n" for each in page if each.startswith('{"crc32"')))
        self.assertEqual(self.run_program("project", "page.project", "--json").json()["structures"][0]["name"], "liver")

    def test_common_points_of_a_ring_are_not_written_again(self):
        moved = list(self.rings[2])
        moved[5] = (moved[5][0] + 0.25, *moved[5][1:])
        self.add(self.step("Move a vertex", {"rings": [2, 1], "to": [{"tool": "stroke", "from": 0, "head": 5, "tail": 18,
                                                                      "points": as_text(moved[5:6])}]}))
        self.save()
        self.run_program("project", "liver.project", "--contours", "c.json")
        contours = json.loads((self.folder / "c.json").read_text())
        self.assertEqual(bits(contours["slices"][1]["contours"][0]["points"]), bits(moved))

    def test_a_torn_last_record_is_told_and_left_out(self):
        whole = self.save().read_bytes()
        start = len(whole) - len(line(self.records[-1]))
        for cut in (start + 1, start + 40, len(whole) - 1):
            for tail in (b"", bytes(len(whole) - cut)):
                self.write("torn.project", whole[:cut] + tail)
                result = self.run_program("project", "torn.project", "--json")
                self.assertIn("W-PRJ-001", result.err)
                self.assertEqual(result.json()["records"], len(self.records) - 1)
                self.assertEqual(result.json()["redo"], ["Draw liver on z = 9"])

    def test_a_damaged_record_is_refused_and_what_is_before_it_is_saved(self):
        def damage(content):
            at = content.index(b"Draw liver on z = -3")
            return content[:at] + b"d" + content[at + 1:]
        self.save(change=damage)
        self.assert_refused(["project", "liver.project"], 3, "E-PRJ-003", "record 4", "--recover")
        self.assert_refused(["project", "liver.project", "--contours", "c.json"], 3, "E-PRJ-003", outputs=["c.json"])
        self.assert_refused(["project", "liver.project", "--recover", "liver.project"], 2, "E-CMD-006")
        result = self.run_program("project", "liver.project", "--recover", "saved.project")
        self.assertIn("W-PRJ-002", result.err)
        answer = self.run_program("project", "saved.project", "--json").json()
        self.assertEqual(answer["records"], 4)
        self.assertEqual(answer["undo"][0], "Draw liver on z = -6")

    def test_what_cannot_be_is_refused(self):
        for record, words in (
                (self.step("Draw", drawn(99, self.rings[1])), ["E-PRJ-004", "E-EDT-003"]),
                (self.step("Draw", drawn(1, self.rings[1], structure=9)), ["E-PRJ-004", "E-EDT-002"]),
                (self.step("Draw", drawn(1, self.rings[2])), ["E-PRJ-004", "E-EDT-005"]),
                (self.step("Draw", drawn(1, self.rings[1][:2])), ["E-PRJ-004", "E-EDT-007"]),
                (self.step("Draw", {"rings": [1, 1], "to": [{"tool": "pen", "points": ""}]}), ["E-PRJ-004", "unknown word"]),
                (self.step("Draw", {"rings": [1, 1], "to": [{"tool": "stroke", "points": "0 0 -9 1"}]}), ["E-PRJ-004", "three numbers"]),
                (self.step("Draw", {"rings": [1, 1], "to": [{"tool": "stroke", "points": "0 0 nan"}]}), ["E-PRJ-004", "a number"]),
                (self.step("Draw", {"rings": [1, 1], "to": [{"tool": "stroke", "from": 0, "head": 20, "tail": 5, "points": ""}]}),
                 ["E-PRJ-004", "more points"]),
                (self.step("Add", plane(9, 3)), ["E-PRJ-004", "E-EDT-004"]),
                ({"n": len(self.records), "do": "redo", "name": "Draw"}, ["E-PRJ-004", "nothing to redo"]),
                ({"n": len(self.records) + 1, "do": "undo", "name": "Draw liver on z = 9"}, ["E-PRJ-004", "missing"])):
            before = list(self.records)
            self.add(record)
            self.save()
            self.assert_refused(["project", "liver.project"], 3, f"record {len(before)}", *words)
            self.records = before

    def test_other_files_and_newer_versions_are_refused(self):
        self.write("contours.json", {"format": "anatomesh-contours"})
        self.assert_refused(["project", "contours.json"], 3, "E-PRJ-001")
        self.write("newer.project", line(head(version=2)) + line({"n": 1, "do": "dance"}))
        for words in ([], ["--recover", "out.project"]):
            self.assert_refused(["project", "newer.project", *words], 3, "E-PRJ-002", "version 2")
        self.write("empty.project", line(head()))
        self.assertEqual(self.run_program("project", "empty.project", "--json").json()["structures"], [])
        self.assert_refused(["project", "empty.project", "--contours", "c.json"], 3, "E-CIO-006", outputs=["c.json"])
        self.assert_refused(["project", "empty.project", "--contours", "c.vtp"], 2, "E-CMD-004")
        self.assert_refused(["project", "empty.project", "--contours", "c.json", "--recover", "p"], 2, "E-CMD-008")

    def test_points_beyond_a_limit_are_refused(self):
        self.save()
        self.assert_refused(["project", "liver.project", "--limit", "project-points=100"], 5, "E-PRJ-011", "project-points")

    def test_damage_anywhere_gives_an_error_or_a_warning_and_no_crash(self):
        dice, whole = random.Random(1), self.save().read_bytes()
        for _ in range(60):
            content = bytearray(whole)
            for _ in range(dice.randint(1, 4)):
                at = dice.randrange(len(content))
                content[at:at + dice.randint(0, 30)] = dice.randbytes(dice.randint(0, 30))
            self.write("damaged.project", bytes(content))
            result = self.run_program("project", "damaged.project", "--json", expect=None)
            self.assertIn(result.code, (0, 3))
            if result.code == 0 and bytes(content) != whole:
                self.assertIn("W-PRJ-001", result.err)


if __name__ == "__main__":
    harness.main(__name__)
