#!/usr/bin/python3
"""The contours that the program writes as JSON obey schemas/contours.schema.json.

Usage: contours_json_test.py PROGRAM TMPDIR
"""
import json
import pathlib
import subprocess
import sys

import jsonschema

SCHEMA = pathlib.Path(__file__).resolve().parents[2] / "schemas" / "contours.schema.json"

CSL = """CSLC
2 2

1 7 2 0 0 1 -5

0 0 5
10 0 5
10.25 10.1 5
0 10 5
2 2 5
2 8 5
8 2 5

4 3 0 1 2 3
3h0 3 4 5 6

2 3 1 0 0 1 -8
0 0 8
9 0 8
0 9 8
3 3 0 1 2
"""


def main(program, folder):
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "in.csl").write_text(CSL)
    written = folder / "contours.json"
    subprocess.run([program, "contours", folder / "in.csl", "--frame", "LPS", "-o", written], check=True)

    schema = json.loads(SCHEMA.read_text())
    jsonschema.Draft202012Validator.check_schema(schema)
    validator = jsonschema.Draft202012Validator(schema)
    contours = json.loads(written.read_text(encoding="utf-8"))
    validator.validate(contours)
    assert contours["space"] == "LPS"
    points = [p for s in contours["slices"] for c in s["contours"] for p in c["points"]]
    assert sorted(map(tuple, points)) == sorted(
        [(0, 0, 5), (10, 0, 5), (10.25, 10.1, 5), (0, 10, 5), (2, 2, 5), (2, 8, 5), (8, 2, 5),
         (0, 0, 8), (9, 0, 8), (0, 9, 8)])
    assert [s["number"] for s in contours["structures"]] == [3]

    # The schema refuses what the program refuses.
    for path, value in [(("unit",), "cm"), (("version",), 2), (("structures", 0, "number"), 1.5),
                        (("slices", 0, "contours", 0, "points", 1), [0, 1]),
                        (("slices", 0, "contours", 0, "points", 1), [0, 1, 1e30]),
                        (("slices", 0, "contours", 0, "kind"), "CLOSED")]:
        broken = json.loads(written.read_text(encoding="utf-8"))
        target = broken
        for key in path[:-1]:
            target = target[key]
        target[path[-1]] = value
        assert not validator.is_valid(broken), path
        (folder / "broken.json").write_text(json.dumps(broken))
        run = subprocess.run([program, "contours", folder / "broken.json", "-o", folder / "never.json"],
                             capture_output=True)
        assert run.returncode == 3, (path, run.returncode, run.stderr)
        assert not (folder / "never.json").exists()


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2])
