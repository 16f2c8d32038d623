#!/usr/bin/python3
"""Contours of patients turned, mirrored, jittered, shifted, and with slices left out: as other patients' files would have them.

    bench/varied.py --update docs/benchmarks.md
    bench/varied.py --program OTHER --beside build/release/anatomesh   # two programs, one after the other on each
    bench/varied.py rtss.dcm organs.nii.gz --kinds turned,jittered

Without FILE: the CT skull, and what the folder of data (ANATOMESH_DATA, ../shared/data) has of contour files, label maps and structure sets.
A model must not get worse because a patient lies askew. Contours are taken as the program writes them (`anatomesh contours`).
"""
import argparse
import json
import pathlib
import subprocess
import tempfile

import numpy as np

from common import DATA, SKULL_OPTIONS, add_programs, columns, command, count, machine, modelled, note, programs_of, show, skull, table

KINDS = {"turned": "by any angles, and moved by up to 0.6 m", "mirrored": "and 0.7 times as large",
         "jittered": "every second point, moved by 0.12 mm (standard deviation) in its plane",
         "shifted": "each slice by 0.7 mm in its plane", "thinned": "a quarter of the slices left out", "halved": "half of the slices left out"}
PATTERNS = ["contours/*.csl", "spine_ct_labels/*.nii.gz", "body_ct_mr_labels/example_seg_*.nii.gz", "head_masks/*.nrrd", "eclipse_contours/*.seg",
            "abdomen_rtstruct/**/*.dcm", "breast_ct_rtstruct/rtss.dcm", "thigh_mr/**/*.dcm", "sarcoma_ct_mr/**/*.dcm", "dicom_seg/*.nrrd"]
LIMIT = 900  # seconds a run may take


def turn(random):
    """A rotation, each as likely as any other."""
    matrix, _ = np.linalg.qr(random.normal(size=(3, 3)))
    return matrix if np.linalg.det(matrix) > 0 else -matrix


def varied(document, kind, random):
    matrix, by = np.eye(3), np.zeros(3)
    if kind == "turned":
        matrix, by = turn(random), random.uniform(-600, 600, 3)
    if kind == "mirrored":
        matrix = np.diag([-0.7, 0.7, 0.7])
    share = {"thinned": 0.25, "halved": 0.5}.get(kind, 0)
    slices = [each for each in document["slices"] if random.random() >= share]
    for each in slices:
        normal = np.array(each["plane"]["normal"], float)
        u = np.cross(normal, np.eye(3)[np.argmin(abs(normal))])
        in_plane = np.array([u, np.cross(normal, u)]) / np.linalg.norm(u)
        shift = random.normal(0, 0.7, 2) @ in_plane if kind == "shifted" else 0
        each["plane"] = {"origin": (matrix @ each["plane"]["origin"] + by).tolist(),
                         "normal": (matrix @ normal / np.linalg.norm(matrix @ normal)).tolist()}
        for contour in each["contours"]:
            points = np.array(contour["points"], float)
            if kind == "jittered" and len(points) > 3:
                points = points[::2] if len(points) > 11 else points
                points = points + random.normal(0, 0.12, (len(points), 2)) @ in_plane
            contour["points"] = ((points + shift) @ matrix.T + by).tolist()
    return {**document, "slices": slices}


def contours_of(program, folder, words):
    """The document of contours that the program makes of a file, or None, and why is said."""
    path = folder / "contours.json"
    done = subprocess.run([str(word) for word in [program, "contours", *words, "-o", path, "--quiet"]], capture_output=True, text=True)
    if done.returncode:
        note(f"{words[0]}: {done.stderr.strip().splitlines()[-1]}")
        return None
    return json.loads(path.read_text())


def inputs(files, program, folder):
    """Name and document of each input."""
    wanted = [[file] for file in files]
    if not files:
        wanted = [[skull(), *SKULL_OPTIONS, "--every", "2"]] if skull() else []
        wanted += [[path] for pattern in PATTERNS for path in sorted(DATA.glob(pattern))]
    for words in wanted:
        document = contours_of(program, folder, words)
        if document and all("plane" in each for each in document["slices"]):
            yield str(words[0]), document


def built(program, folder, path):
    """Segments, missed, cuts, those off by more than 0.1 %, clauses broken, 1 where clauses 2 and 4 are kept, seconds; None: refused."""
    made = modelled(program, path, folder, LIMIT)
    if not made:
        return None
    report, seconds = made
    segments = sum(each["contour_segments"] for each in report["structures"])
    missed = segments - sum(each["contour_segments_on_surface"] for each in report["structures"])
    state = {each["clause"]: each["state"] for each in report["certificate"]}
    cuts = [cut for cut in report["cuts"] if cut["drawn_mm2"] > 0]
    off = [cut for cut in cuts if cut["difference_mm2"] > 0.001 * cut["drawn_mm2"]]
    return [segments, missed, len(cuts), len(off), list(state.values()).count("broken"),
            state[2] in ("kept", "moved"), state[4] == "kept", seconds]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="*", metavar="FILE", type=pathlib.Path)
    add_programs(parser)
    parser.add_argument("--kinds", default=",".join(KINDS), help="of " + ", ".join(KINDS))
    arguments = parser.parse_args()
    kinds = arguments.kinds.split(",")
    if not set(kinds) <= set(KINDS):
        parser.error(f"kinds are {', '.join(KINDS)}")
    programs = programs_of(arguments)
    how, found = f"{machine()}{command()}", {kind: [] for kind in kinds}
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for number, (source, document) in enumerate(inputs(arguments.files, programs[0], folder)):
            for kind in kinds:
                path = folder / "varied.json"
                path.write_text(json.dumps(varied(json.loads(json.dumps(document)), kind, np.random.default_rng(1000 + number))))
                figures = [built(program, folder, path) for program in programs]
                note(f"{kind} {source}: {figures}")
                found[kind].append(figures)
    head = ["contours", "models", "refused", "segments",
            *columns(programs, "missed{}", "cuts off by over 0.1 %", "clauses broken", "clause 2 kept", "clause 4 kept", "s")]
    rows = []
    for kind in kinds:
        both = np.array([figures for figures in found[kind] if None not in figures], float)  # by input, program and figure
        row = [f"{kind}: {KINDS[kind]}", str(len(both)), str(len(found[kind]) - len(both))]
        sums = both.sum(axis=0) if len(both) else np.zeros((len(programs), 8))
        row.append(count(sums[0][0]))
        for own in sums:
            row += [count(own[1]), f"{count(own[3])} of {count(own[2])}", count(own[4]), count(own[5]), count(own[6]), f"{own[7]:.0f}"]
        rows.append(row)
    show(arguments, "varied", how, table(head, rows))


if __name__ == "__main__":
    main()
