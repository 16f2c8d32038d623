#!/usr/bin/python3
"""segment_dice.py --program PROGRAM --data FOLDER: structures of a CT by `anatomesh segment` beside labels.

FOLDER holds example_ct.nii.gz and example_seg_fast_force_split.nii.gz, labels that a trained network made (not a
truth: two such networks differ by a few points of Dice). Prints a table; exit code 1 when a run fails.
"""
import argparse
import json
import pathlib
import subprocess
import sys
import tempfile
import time

import nibabel
import numpy

# Name, labels, options. Seeds are single clicks, LPS mm.
RUNS = [
    ("spleen, active contour by edges", [1], ["--seed", "109,-107.3,406.3"]),
    ("spleen, Chan-Vese", [1], ["--method", "chan-vese", "--seed", "109,-107.3,406.3", "--seed-radius", "15"]),
    ("spleen, slice by slice", [1], ["--method", "region", "--per-slice", "--spread", "2", "--seed", "109,-107.3,406.3"]),
    ("right femur, threshold and growing", [76],
     ["--threshold", "150:1500", "--seed", "-94,-133,130", "--close", "6", "--fill-holes"]),
    ("vertebra L3, Chan-Vese", [29], ["--method", "chan-vese", "--seed", "3.7,-145,315", "--seed-radius", "12"]),
    ("all bone, threshold", list(range(25, 32)) + [75, 76, 77, 78] + list(range(92, 118)),
     ["--threshold", "150", "--keep-largest", "1", "--close", "6", "--fill-holes"]),
]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", required=True)
    parser.add_argument("--data", required=True, type=pathlib.Path)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    labels = numpy.asarray(nibabel.load(options.data / "example_seg_fast_force_split.nii.gz").dataobj)
    rows, failed = [], False
    with tempfile.TemporaryDirectory() as folder:
        for name, numbers, words in RUNS:
            output = pathlib.Path(folder) / "found.nii.gz"
            output.unlink(missing_ok=True)
            begin = time.monotonic()
            done = subprocess.run([options.program, "segment", str(options.data / "example_ct.nii.gz"), *words,
                                   "-o", str(output)], capture_output=True, text=True)
            seconds = time.monotonic() - begin
            if done.returncode:
                print(f"{name}: {done.stderr.strip()}", file=sys.stderr)
                failed = True
                continue
            found = numpy.asarray(nibabel.load(output).dataobj) > 0
            truth = numpy.isin(labels, numbers)
            dice = 2 * (found & truth).sum() / (found.sum() + truth.sum())
            rows.append({"what": name, "options": " ".join(words), "dice": round(float(dice), 3),
                         "seconds": round(seconds, 2)})
    if options.json:
        print(json.dumps(rows, indent=1))
    else:
        for row in rows:
            print(f"{row['what']:38} {row['dice']:.3f}  {row['seconds']:6.2f} s   {row['options']}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
