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

# Name, labels, options. Seeds are single clicks; boxes are the bounding boxes of the labels themselves; LPS mm.
RUNS = [
    ("right femur, threshold and growing in a box", [76],
     ["--threshold", "100:1500", "--seed", "-89,-143,118", "--within", "-59,-104,94:-152,-167,145", "--close", "9", "--fill-holes"]),
    ("left femur, threshold and growing in a box", [75],
     ["--threshold", "150:1500", "--seed", "97,-131,118", "--within", "145,-92,94:61,-167,148", "--close", "9", "--fill-holes"]),
    ("vertebrae T12 to S1 together, threshold and growing in a box", list(range(26, 33)),
     ["--threshold", "100:1500", "--seed", "4,-125,310", "--within", "49,-62,205:-50,-164,427", "--close", "3", "--fill-holes"]),
    ("one vertebra, threshold and growing in a box", [29],
     ["--threshold", "100:1500", "--seed", "4,-134,316", "--within", "49,-77,289:-50,-164,331", "--close", "3", "--fill-holes"]),
    ("spleen, active contour by edges, one click", [1], ["--seed", "109,-107.3,406.3"]),
    ("spleen, slice by slice, one click", [1], ["--method", "region", "--per-slice", "--spread", "2", "--seed", "109,-107.3,406.3"]),
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
        print("| structure | Dice | s | options |\n|---|---:|---:|---|")
        for row in rows:
            print(f"| {row['what']} | {row['dice']:.3f} | {row['seconds']:.2f} | `{row['options']}` |")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
