#!/usr/bin/python3
"""The tables of accuracy in one run: nearest slice, shape-based interpolation, and ours.

    bench/accuracy.py [--build build/release] [--data FOLDER]

1. Slices left out of parallel ones. 2. Planes in any position through a head whose surface is known. 3. Planes left out
of drawn contours that contradict each other. Without a folder of data (ANATOMESH_DATA, ../shared/data) only the CT skull.
"""
import argparse
import os
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[1]
SKIN = ["--threshold", "-300", "--open", "2", "--keep-largest", "1", "--close", "8", "--fill-holes"]
BONE = ["--threshold", "226", "--keep-largest", "1"]
CROSSING = ["fetal_brain_mr_3orient_aligned.csl", "fetal_brain_mr_3orient_runs1_3_5.csl"]
WAYS = [["--reconcile", "0"], [], ["--align"]]
BOUND = ["--max-disagreement", "25"]


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--build", type=pathlib.Path, default=ROOT / "build/release")
    options.add_argument("--data", type=pathlib.Path, default=os.environ.get("ANATOMESH_DATA") or ROOT.parent / "shared/data")
    given = options.parse_args()
    skull = subprocess.run([ROOT / "scripts/skull.sh"], stdout=subprocess.PIPE, text=True, check=True, cwd=ROOT).stdout.strip()

    def row(*words):
        print(subprocess.run([given.build / "bench/anatomesh_accuracy", *map(str, words)], stdout=subprocess.PIPE, text=True,
                             check=True, cwd=ROOT).stdout.rstrip(), flush=True)

    print("## Slices left out\n")
    for every in (2, 4):
        row(skull, *BONE, "--every", every, *(["--header"] if every == 2 else []))

    print("\n## Planes through a head\n")
    with tempfile.TemporaryDirectory() as folder:
        skin = pathlib.Path(folder, "skin.nrrd")
        subprocess.run([given.build / "anatomesh", "segment", skull, *SKIN, "-o", skin, "--quiet"], check=True, cwd=ROOT)
        about_axis = [("axis", planes) for planes in (3, 6, 12, 18, 36, 60)]
        for kind, planes in (("fan", 36), *about_axis, ("stacks", 60), ("freehand", 60)):
            row(skin, "--cut", kind, "--planes", planes, *(["--header"] if kind == "fan" else []))

    present = [given.data / "contours" / name for name in CROSSING if (given.data / "contours" / name).exists()]
    if not present:
        sys.exit("no contours on crossing planes: give --data")
    print("\n## Planes left out of contours that contradict each other\n")
    for path in present:
        for way in WAYS:
            bound = BOUND if way[:1] != ["--reconcile"] else []
            head = ["--header"] if (path, way) == (present[0], WAYS[0]) else []
            row(path, "--leave-out", 5, *way, *bound, *head)


if __name__ == "__main__":
    main()
