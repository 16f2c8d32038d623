#!/usr/bin/python3
"""segment_dice.py --program PROGRAM --data FOLDER: structures of a CT by `anatomesh segment` beside labels.

FOLDER holds example_ct.nii.gz and example_seg_fast_force_split.nii.gz, labels that a trained network made (not a
truth: two such networks differ by a few points of Dice). Prints a table; exit code 1 when a run fails.
"""
import argparse
import json
import pathlib
import re
import subprocess
import sys
import tempfile
import time

import nibabel
import numpy

# Name, the labels' names in the file's own table (patterns), options. Seeds are single clicks; boxes are the bounding
# boxes of the labels themselves; LPS mm.
RUNS = [
    ("right femur, threshold and growing in a box", ["femur_right"],
     ["--threshold", "100:1500", "--seed", "-89,-143,118", "--within", "-59,-104,94:-152,-167,145", "--close", "9", "--fill-holes"]),
    ("left femur, threshold and growing in a box", ["femur_left"],
     ["--threshold", "150:1500", "--seed", "97,-131,118", "--within", "145,-92,94:61,-167,148", "--close", "9", "--fill-holes"]),
    ("vertebrae T12 to S1 together, threshold and growing in a box", ["vertebrae_T12", "vertebrae_L[1-5]", "vertebrae_S1"],
     ["--threshold", "100:1500", "--seed", "4,-125,310", "--within", "49,-62,205:-50,-164,427", "--close", "3", "--fill-holes"]),
    ("vertebra L3, threshold and growing in a box", ["vertebrae_L3"],
     ["--threshold", "100:1500", "--seed", "4,-134,316", "--within", "49,-77,289:-50,-164,331", "--close", "3", "--fill-holes"]),
    ("spleen, active contour by edges, one click", ["spleen"], ["--seed", "109,-107.3,406.3"]),
    ("spleen, slice by slice, one click", ["spleen"],
     ["--method", "region", "--per-slice", "--spread", "2", "--seed", "109,-107.3,406.3"]),
    ("all bone, threshold", ["sacrum", "vertebrae_.*", "femur_.*", "hip_.*", "rib_.*"],
     ["--threshold", "150", "--keep-largest", "1", "--close", "6", "--fill-holes"]),
]


def label_table(image):
    """Name -> number, of the table that the file carries in its header."""
    text = b"".join(extension.get_content() for extension in image.header.extensions).decode()
    return {name: int(key) for key, name in re.findall(r'<Label Key="(\d+)"[^>]*><!\[CDATA\[([^\]]+)\]\]>', text)}


def numbers_of(table, patterns):
    named = [[number for name, number in table.items() if re.fullmatch(pattern, name)] for pattern in patterns]
    for pattern, numbers in zip(patterns, named):
        if not numbers:
            raise SystemExit(f"no label in the file is named {pattern}")
    return sorted(set(sum(named, [])))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", required=True)
    parser.add_argument("--data", required=True, type=pathlib.Path)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    image = nibabel.load(options.data / "example_seg_fast_force_split.nii.gz")
    labels, table = numpy.asarray(image.dataobj), label_table(image)
    rows, failed = [], False
    with tempfile.TemporaryDirectory() as folder:
        for name, patterns, words in RUNS:
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
            numbers = numbers_of(table, patterns)
            truth = numpy.isin(labels, numbers)
            dice = 2 * (found & truth).sum() / (found.sum() + truth.sum())
            rows.append({"what": name, "labels": numbers, "options": " ".join(words), "dice": round(float(dice), 3),
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
