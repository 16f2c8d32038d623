"""Sound small inputs of every format, which hostile ones are made of: written by the program, and by pydicom."""
import json
import pathlib
import subprocess
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "e2e"))
import images  # noqa: E402
import shapes  # noqa: E402
import test_dicom  # noqa: E402

REPORTED = ("m.vtu", "m.report.json")


class Seed:
    """The file to damage (`name`, `content`), files that stay beside it, and a command that reads it and writes `outputs`."""

    def __init__(self, kind, path, words, outputs, beside=()):
        self.kind, self.name, self.content, self.words, self.outputs = kind, path.name, path.read_bytes(), words, outputs
        self.beside = {other.name: other.read_bytes() for other in beside}

    def lay(self, folder, content=None):
        """Writes the input, damaged or not, and what lies beside it, into `folder`."""
        (folder / "in").mkdir()
        (folder / "in" / self.name).write_bytes(self.content if content is None else content)
        for name, bytes_ in self.beside.items():
            (folder / "in" / name).write_bytes(bytes_)


def tilted(p):
    return (p[0], 0.8 * p[1] - 0.6 * p[2], 0.6 * p[1] + 0.8 * p[2])


def organ_and_lesion():
    """A lesion on two slices of an organ, and on two a little off its slices, as files round them."""
    organ = shapes.sphere(8.0, 2.5)
    organ.structures[2] = "lesion"
    for z in (0.0, 0.04, 2.5, 2.46):
        organ.add_slice(z, [(2, shapes.circle(2.0, 24, (3.0 if z in (0.0, 2.5) else -3.0, 0.0)))])
    return organ.document()


def made(program, folder):
    """All seeds, made in `folder`."""
    folder = pathlib.Path(folder)

    def run(*words):
        done = subprocess.run([program, *map(str, words)], cwd=folder, capture_output=True, text=True)
        if done.returncode != 0:
            raise SystemExit(f"a seed cannot be made: {words}\n{done.stderr}")

    def of_model(kind, name, *words, beside=()):
        return Seed(kind, folder / name, ["model", f"in/{pathlib.Path(name).name}", "-o", "m.vtu", "--threads", "1", *words], REPORTED, beside)

    ball = shapes.sphere(8.0, 2.5)
    crossing = ball.document()
    crossing["slices"] += ball.document(to_space=lambda p: (p[1], p[2], p[0]))["slices"]
    for name, document in (("stack.json", ball.document()), ("oblique.json", ball.document(to_space=tilted)), ("crossing.json", crossing)):
        (folder / name).write_text(json.dumps(document))
    for ending in ("vtp", "csl", "dcm"):
        run("contours", "oblique.json", "-o", f"contours.{ending}")
    (folder / "two.json").write_text(json.dumps(organ_and_lesion()))
    run("contours", "two.json", "-o", "two.dcm")
    axis = np.arange(14) - 6.5
    x, y, z = np.meshgrid(axis, axis, axis, indexing="ij")
    inside = x ** 2 + y ** 2 + z ** 2
    images.write_nrrd(folder / "labels.nrrd", ((inside < 30) + 1 * (inside < 9)).astype(np.uint8), (1, 1, 1.5))
    for ending in ("nii", "nii.gz", "nrrd"):
        run("field", "stack.json", "-o", f"bits.{ending}", "--what", "bits")
    (folder / "study").mkdir()
    slices = test_dicom.write_series(folder / "study")
    run("model", "study", "--threshold", "0", "-o", "model.vtu", "--size", "12", "--threads", "1", "--dicom-segmentation", "seg.dcm")
    run("model", "stack.json", "-o", "small.vtu", "--threads", "1")
    for ending in ("msh", "inp", "mesh"):
        run("convert", "small.vtu", "-o", f"small.{ending}")
    kinds = {"stack.json": "JSON contours", "oblique.json": "JSON contours", "crossing.json": "JSON contours that cross", "contours.vtp": "VTP contours",
             "contours.dcm": "RTSTRUCT", "two.dcm": "RTSTRUCT of two structures", "labels.nrrd": "NRRD label map", "bits.nii": "NIfTI label map", "bits.nii.gz": "NIfTI label map, compressed",
             "seg.dcm": "DICOM segmentation"}
    found = [of_model(kind, name) for name, kind in kinds.items()]
    found.append(of_model("CSL contours", "contours.csl", "--frame", "LPS"))
    series = Seed("DICOM series", slices[7], ["model", "in", "--threshold", "0", "--size", "12", "-o", "m.vtu", "--threads", "1"], REPORTED,
                  [path for path in slices if path != slices[7]])
    found.append(series)
    for name in ("small.vtu", "small.msh", "small.inp", "small.mesh"):
        kind = name.split(".")[1].upper() + " model"
        found.append(Seed(kind, folder / name, ["convert", f"in/{name}", "-o", "again.vtu"], ("again.vtu",)))
        found.append(Seed(kind, folder / name, ["check", f"in/{name}"], ()))
    return found
