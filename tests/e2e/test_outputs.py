"""What every output says of itself, read by others."""
import hashlib
import json
import re
import shutil

import pydicom
from vtkmodules.vtkIOXML import vtkXMLPolyDataReader, vtkXMLUnstructuredGridReader

import harness
import network_peers as peers
import shapes


def texts_of_vtk(path):
    """The texts in the field data of a .vtu or .vtp file, as VTK reads them, and the file's own words."""
    reader = vtkXMLUnstructuredGridReader() if path.suffix == ".vtu" else vtkXMLPolyDataReader()
    reader.SetFileName(str(path))
    reader.Update()
    fields = reader.GetOutput().GetFieldData()
    lines = []
    for number in range(fields.GetNumberOfArrays()):
        array = fields.GetAbstractArray(number)
        name = array.GetName()
        if array.GetDataTypeAsString() == "string":
            lines += [f"{name}={array.GetValue(k)}" for k in range(array.GetNumberOfValues())]
    return "\n".join(lines)


class Provenance(harness.TestCase):
    """Every output states the program's version, its axes and unit, and what it was made with, as far as its format has room."""

    MODELS, SURFACES = ("vtu", "msh", "mesh", "inp", "feb"), ("vtp", "stl", "ply", "obj")

    def setUp(self):
        super().setUp()
        self.version = self.run_program("--version").out.split()[-1]

    def said(self, path):
        return texts_of_vtk(path) if path.suffix in (".vtu", ".vtp") else path.read_bytes().decode("latin-1")

    def test_O06_models_surfaces_and_reports(self):
        document = shapes.sphere(12).document()
        self.write("ball.json", document)
        sum_of_input = hashlib.sha256((self.folder / "ball.json").read_bytes()).hexdigest()
        for k, kind in enumerate(self.MODELS):
            surface = self.SURFACES[min(k, 3)]
            self.run_program("model", "ball.json", "-o", f"m.{kind}", "--size", "5", "--surface", f"{kind}.{surface}", "--report",
                             f"{kind}.json", "--html", f"{kind}.html", "--quiet")
            for name in (f"m.{kind}", f"{kind}.{surface}"):
                text = self.said(self.folder / name)
                parts = ["LPS", "mm"]
                if not name.endswith(".stl"):  # whose head has 80 bytes
                    parts += [self.version, "size_mm 5"]
                for part in parts:
                    self.assertIn(part, text, name)
            report = json.loads((self.folder / f"{kind}.json").read_text())
            self.assertEqual(report["versions"]["anatomesh"], self.version)
            self.assertEqual(report["inputs"][0]["sha256"], sum_of_input)
            self.assertEqual((report["space"], report["unit"], report["options"]["size_mm"]), ("LPS", "mm", "5"))
            self.assertIn("warnings", report)
            page = (self.folder / f"{kind}.html").read_text()
            for part in (self.version, sum_of_input, "LPS", "mm"):
                self.assertIn(part, page)
        # `check` measures the file again by what the file itself says.
        for kind in self.MODELS[:4]:
            self.run_program("check", f"m.{kind}", "--contours", "ball.json", "--quiet")

    def test_O06_dicom_objects(self):
        study, contours = peers.write_study(self.folder / "study")
        shutil.copy(contours, study / "rs.dcm")
        self.run_program("model", study, "-o", "m.vtu", "--size", "6", "--dicom-surface", "surface.dcm", "--dicom-obj", "obj.dcm",
                         "--dicom-segmentation", "seg.dcm", "--quiet")
        self.run_program("contours", study, "-o", "rs.dcm", "--quiet")
        for name in ("surface.dcm", "obj.dcm", "seg.dcm", "rs.dcm"):
            made = pydicom.dcmread(self.folder / name)
            self.assertEqual(made.SoftwareVersions, f"anatomesh {self.version}", name)
            self.assertEqual(made.Manufacturer, "anatomesh")
        for name in ("surface.dcm", "obj.dcm"):
            made = pydicom.dcmread(self.folder / name)
            self.assertEqual(made.MeasurementUnitsCodeSequence[0].CodeValue, "mm")
            self.assertTrue(re.search(rb"SPACE=LPS\s+(# )?UNIT=mm", made.EncapsulatedDocument), name)
            self.assertGreaterEqual(len(made.SourceInstanceSequence), 1)


if __name__ == "__main__":
    harness.main("__main__")
