"""DICOM from the command line: folders, image series, segmentations, RTSTRUCT in both directions, privacy."""
import copy
import json
import math
import os
import re
import shutil
import subprocess
import unittest

import numpy
import pydicom
from pydicom.dataset import FileDataset, FileMetaDataset
from pydicom.uid import ExplicitVRLittleEndian

import harness

CT = "1.2.840.10008.5.1.4.1.1.2"
PLANTED = {"PatientName": "Zzplanted^Name", "PatientID": "ZZPLANTEDID", "PatientBirthDate": "19420228",
           "AccessionNumber": "ZZACC", "InstitutionName": "ZZPLANTED HOSPITAL", "ReferringPhysicianName": "Zzdoctor",
           "StudyDescription": "ZZSTUDY", "SeriesDescription": "ZZSERIES", "StudyDate": "19991231",
           "ProtocolName": "ZZPROTOCOL", "OperatorsName": "Zzoperator", "StationName": "ZZSTATION"}


def ball(count=20, size=32, spacing=2.0, radius=22.0):
    """Slices of a ball of 300 in -1000, off the middle."""
    axis = (numpy.arange(size) - (size - 1) / 2) * spacing
    heights = (numpy.arange(count) - (count - 1) / 2) * 3.0
    z, y, x = numpy.meshgrid(heights, axis, axis, indexing="ij")
    values = numpy.where((x - 4) ** 2 + y ** 2 + z ** 2 < radius ** 2, 300, -1000).astype("<i2")
    return values, heights, axis


def write_series(folder, names=None, series="1.2.826.0.1.3680043.8.498.1", shift=(0, 0, 0), spacing=3.0, **changes):
    values, heights, axis = ball()
    heights = heights * spacing / 3
    paths = []
    for k in range(len(heights)):
        meta = FileMetaDataset()
        meta.MediaStorageSOPClassUID = CT
        meta.MediaStorageSOPInstanceUID = f"{series}.{k + 1}"
        meta.TransferSyntaxUID = ExplicitVRLittleEndian
        path = folder / (names[k] if names else f"slice{k:03}")
        data = FileDataset(str(path), {}, file_meta=meta, preamble=b"\0" * 128)
        data.SOPClassUID, data.SOPInstanceUID, data.Modality = CT, f"{series}.{k + 1}", "CT"
        data.StudyInstanceUID, data.SeriesInstanceUID = "1.2.826.0.1.3680043.8.498.7", series
        data.FrameOfReferenceUID = "1.2.826.0.1.3680043.8.498.8"
        for keyword, value in PLANTED.items():
            setattr(data, keyword, value)
        data.add_new((0x0009, 0x0010), "LO", "ZZPRIVATE")
        data.add_new((0x0009, 0x1001), "LO", "ZZPRIVATEVALUE")
        data.InstanceNumber, data.SliceThickness = k + 1, 5
        data.ImagePositionPatient = [axis[0] + shift[0], axis[0] + shift[1], heights[k] + shift[2]]
        data.ImageOrientationPatient, data.PixelSpacing = [1, 0, 0, 0, 1, 0], [2, 2]
        data.Rows = data.Columns = len(axis)
        data.SamplesPerPixel, data.PhotometricInterpretation = 1, "MONOCHROME2"
        data.BitsAllocated = data.BitsStored = 16
        data.HighBit, data.PixelRepresentation = 15, 1
        data.RescaleSlope, data.RescaleIntercept = 1, 0
        data.PixelData = values[k].tobytes()
        for keyword, value in changes.items():
            setattr(data, keyword, value)
        data.is_little_endian, data.is_implicit_VR = True, False
        data.save_as(str(path), write_like_original=False)
        paths.append(path)
    return paths


def dciodvfy_errors(path):
    if not shutil.which("dciodvfy"):
        raise unittest.SkipTest("no dciodvfy (dicom3tools)")
    done = subprocess.run(["dciodvfy", str(path)], capture_output=True, text=True)
    return [line for line in (done.stdout + done.stderr).splitlines() if line.startswith("Error")]


class Folders(harness.TestCase):
    def setUp(self):
        super().setUp()
        self.study = self.folder / "study"
        self.study.mkdir()

    def test_info_lists_what_is_there(self):
        write_series(self.study)
        (self.study / "notes.txt").write_text("no DICOM")
        found = self.run_program("info", "study", "--json").json()
        self.assertEqual(found["kind"], "DICOM folder")
        self.assertEqual(found["folder"]["skipped"], 1)
        self.assertEqual(len(found["folder"]["series"]), 1)
        series = found["folder"]["series"][0]
        self.assertEqual(series["objects"], 20)
        image = self.run_program("info", "study", "--series", series["series"], "--json").json()["image"]
        self.assertEqual(image["size"], [32, 32, 20])
        self.assertEqual(image["spacing_mm"], [2, 2, 3])

    def test_a_folder_without_dicom(self):
        (self.study / "notes.txt").write_text("no DICOM")
        self.assert_refused(["model", "study", "-o", "x.vtu"], 3, "E-DCM-031")

    def test_model_of_images_is_that_of_the_same_nifti_volume(self):
        write_series(self.study)
        self.run_program("contours", "study", "--threshold", "0", "-o", "a.json")
        shutil.rmtree(self.study)
        self.study.mkdir()
        # G01: other names, another order.
        write_series(self.study, names=[f"x{(7 * k) % 20:02}" for k in range(20)])
        self.run_program("contours", "study", "--threshold", "0", "-o", "b.json")
        self.assertEqual((self.folder / "a.json").read_bytes(), (self.folder / "b.json").read_bytes())
        points = numpy.array([p for s in json.loads((self.folder / "a.json").read_text())["slices"]
                              for c in s["contours"] for p in c["points"]])
        # O07: left is +x; the ball lies 4 mm to the left.
        self.assertAlmostEqual((points[:, 0].min() + points[:, 0].max()) / 2, 4, delta=1.1)

    def test_contours_as_rtstruct_and_back(self):
        write_series(self.study)
        self.run_program("contours", "study", "--threshold", "0", "-o", "a.json")
        self.run_program("contours", "study", "--threshold", "0", "--keep-patient-ids", "-o", "rs.dcm")
        made = pydicom.dcmread(self.folder / "rs.dcm")
        self.assertEqual(made.Modality, "RTSTRUCT")
        self.assertEqual(made.PatientID, "ZZPLANTEDID")
        self.assertEqual(made.FrameOfReferenceUID, "1.2.826.0.1.3680043.8.498.8")
        contours = made.ROIContourSequence[0].ContourSequence
        for contour in contours:
            self.assertEqual(len(contour.ContourData), 3 * contour.NumberOfContourPoints)
            self.assertTrue(contour.ContourImageSequence[0].ReferencedSOPInstanceUID.startswith("1.2.826"))
        self.assertEqual(dciodvfy_errors(self.folder / "rs.dcm"), [])
        if shutil.which("drtdump"):
            done = subprocess.run(["drtdump", str(self.folder / "rs.dcm")], capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stderr)
        # RS-21: alone it is not compared with its images, and that is said; beside them it is.
        alone = self.run_program("contours", "rs.dcm", "-o", "alone.json").err
        self.assertEqual(alone.count("W-DCM-018"), 1, alone)
        self.assertIn("without comparing it with them", alone)
        # Beside its images it is what the folder's model is made of.
        shutil.copy(self.folder / "rs.dcm", self.study / "rs")
        beside = self.run_program("contours", "study", "-o", "b.json").err
        self.assertNotIn("W-DCM-018", beside)
        a, b = (json.loads((self.folder / name).read_text()) for name in ("a.json", "b.json"))
        self.assertEqual(sum(len(s["contours"]) for s in a["slices"]), sum(len(s["contours"]) for s in b["slices"]))
        points = [numpy.array([p for s in each["slices"] for c in s["contours"] for p in c["points"]]) for each in (a, b)]
        self.assertEqual(len(points[0]), len(points[1]))
        self.assertLess(numpy.abs(points[0].mean(axis=0) - points[1].mean(axis=0)).max(), 1e-9)

    def test_G34_contours_under_other_uids_are_matched_by_where_they_lie(self):
        write_series(self.study)
        # Without the patient's identity the contours refer to images under UIDs that are nowhere.
        self.run_program("contours", "study", "--threshold", "0", "-o", "rs.dcm")
        shutil.copy(self.folder / "rs.dcm", self.study / "rs")
        self.assert_refused(["contours", "study", "-o", "x.json"], 3, "E-DCM-035", "--match-by-geometry")
        self.run_program("contours", "study", "--match-by-geometry", "-o", "x.json")
        shutil.rmtree(self.study)
        self.study.mkdir()
        write_series(self.study, ImageOrientationPatient=[0, 1, 0, 0, 0, 1])
        shutil.copy(self.folder / "rs.dcm", self.study / "rs")
        self.assert_refused(["contours", "study", "--match-by-geometry", "-o", "y.json"], 3, "E-DCM-036")

    def test_RS22_RS23_RS31_contradictions_need_an_option(self):
        write_series(self.study)
        self.run_program("contours", "study", "--threshold", "0", "--keep-patient-ids", "-o", "rs.dcm")
        contours = pydicom.dcmread(self.folder / "rs.dcm")
        moved = pydicom.dcmread(self.folder / "rs.dcm")
        for item in moved.ROIContourSequence[0].ContourSequence:
            item.ContourData = [float(v) + (4000 if i % 3 == 0 else 0) for i, v in enumerate(item.ContourData)]
        other_frame, other_patient = pydicom.dcmread(self.folder / "rs.dcm"), pydicom.dcmread(self.folder / "rs.dcm")
        other_frame.FrameOfReferenceUID = "1.2.3.9"
        other_patient.PatientID = "SOMEBODY"
        for made, code, option in ((other_frame, "E-DCM-032", "--ignore-frame-of-reference"),
                                   (other_patient, "E-DCM-033", "--ignore-patient"), (moved, "E-DCM-037", "--allow-outside")):
            made.save_as(str(self.study / "rs"), write_like_original=True)
            self.assert_refused(["contours", "study", "-o", "x.json"], 3, code, option)
            self.run_program("contours", "study", option, "-o", "x.json")
            (self.folder / "x.json").unlink()
        contours.save_as(str(self.study / "rs"), write_like_original=True)
        self.run_program("contours", "study", "-o", "x.json")

    def test_the_unit_of_contours_is_what_images_say_it_is(self):
        """In metres: refused alone, beside images in mm and beside images elsewhere; accepted beside their own, or with --unit."""
        def scaled(value):
            return [f"{float(v) / 1000:.9g}"[:16] for v in value]

        write_series(self.study)
        self.run_program("contours", "study", "--threshold", "0", "--keep-patient-ids", "-o", "rs.dcm")
        metres = pydicom.dcmread(self.folder / "rs.dcm")
        for roi in metres.ROIContourSequence:
            for contour in roi.ContourSequence:
                contour.ContourData = scaled(contour.ContourData)
        metres.save_as(self.folder / "metres.dcm")
        self.assert_refused(["model", "metres.dcm", "-o", "x.vtu"], 3, "E-RTS-011", "--unit")
        for name, code in (("in_mm", "E-DCM-038"), ("elsewhere", "E-RTS-011"), ("own", None)):
            folder = self.folder / name
            folder.mkdir()
            for path in self.study.iterdir():
                image = pydicom.dcmread(path)
                if name == "elsewhere":
                    image.ImagePositionPatient[2] += 0.777
                if name == "own":
                    image.ImagePositionPatient = scaled(image.ImagePositionPatient)
                    image.PixelSpacing, image.SliceThickness = scaled(image.PixelSpacing), 0.001
                image.save_as(folder / path.name)
            metres.save_as(folder / "rs.dcm")
            if code:
                self.assert_refused(["model", name, "-o", "x.vtu", "--allow-outside"], 3, code)
            else:
                self.run_program("contours", name, "-o", "own.json", "--quiet")
        self.run_program("model", "in_mm", "--unit", "m", "-o", "m.vtu", "--quiet")
        self.run_program("model", "rs.dcm", "-o", "mm.vtu", "--quiet")
        volume = [json.loads((self.folder / f"{name}.report.json").read_text())["structures"][0]["volume_mesh_mm3"]
                  for name in ("m", "mm")]
        self.assertAlmostEqual(volume[0] / volume[1], 1, delta=1e-3)

    def test_contours_on_frames_of_one_image(self):
        """Frames with places are held against the contours that name them; without places nothing says where these lie."""
        write_series(self.study)
        self.run_program("contours", "study", "--threshold", "0", "--keep-patient-ids", "-o", "rs.dcm")
        slices = sorted((pydicom.dcmread(path) for path in self.study.iterdir()),
                        key=lambda ds: float(ds.ImagePositionPatient[2]))
        uid = "1.2.826.0.1.3680043.8.498.77"

        def image(with_places):
            frames = pydicom.Dataset()
            frames.update(slices[0])
            frames.file_meta = slices[0].file_meta
            frames.SOPInstanceUID = frames.file_meta.MediaStorageSOPInstanceUID = uid
            frames.NumberOfFrames = len(slices)
            frames.PixelData = b"".join(ds.PixelData for ds in slices)
            shared, measures, orientation = pydicom.Dataset(), pydicom.Dataset(), pydicom.Dataset()
            measures.PixelSpacing, measures.SliceThickness = slices[0].PixelSpacing, 2
            orientation.ImageOrientationPatient = slices[0].ImageOrientationPatient
            shared.PixelMeasuresSequence, shared.PlaneOrientationSequence = [measures], [orientation]
            frames.SharedFunctionalGroupsSequence = [shared]
            frames.PerFrameFunctionalGroupsSequence = []
            for ds in slices if with_places else []:
                place, group = pydicom.Dataset(), pydicom.Dataset()
                place.ImagePositionPatient = ds.ImagePositionPatient
                group.PlanePositionSequence = [place]
                frames.PerFrameFunctionalGroupsSequence.append(group)
            for name in ("ImagePositionPatient", "ImageOrientationPatient"):
                del frames[name]
            return frames

        def study(folder, with_places, frame_of):
            contours = pydicom.dcmread(self.folder / "rs.dcm")
            for roi in contours.ROIContourSequence:
                for contour in roi.ContourSequence:
                    k = min(range(len(slices)), key=lambda n: abs(float(slices[n].ImagePositionPatient[2])
                                                                  - float(contour.ContourData[2])))
                    contour.ContourImageSequence[0].ReferencedSOPInstanceUID = uid
                    contour.ContourImageSequence[0].ReferencedFrameNumber = frame_of(k + 1)
            for study in contours.ReferencedFrameOfReferenceSequence[0].RTReferencedStudySequence:
                for series in study.RTReferencedSeriesSequence:
                    del series.ContourImageSequence[1:]
                    series.ContourImageSequence[0].ReferencedSOPInstanceUID = uid
            (self.folder / folder).mkdir()
            contours.save_as(self.folder / folder / "rs.dcm")
            image(with_places).save_as(self.folder / folder / "frames.dcm", write_like_original=False)

        def codes():
            return {w["code"] for w in json.loads((self.folder / "m.report.json").read_text())["warnings"]}

        for name, frame_of, expected in (("right", lambda k: k, set()), ("mirrored", lambda k: len(slices) + 1 - k, {"W-DCM-024"}),
                                         ("shifted", lambda k: max(1, k - 2), {"W-DCM-024"}),
                                         ("absent", lambda k: k + 500, {"W-DCM-025"})):
            study(name, True, frame_of)
            self.run_program("model", name, "-o", "m.vtu", "--quiet")
            self.assertEqual(codes() & {"W-DCM-024", "W-DCM-025"}, expected, name)
        study("noplace", False, lambda k: k)
        self.assert_refused(["model", "noplace", "-o", "x.vtu"], 3, "E-DCM-039", "does not say where its frames lie")

    def test_RS22_structures_of_two_frames_of_reference(self):
        write_series(self.study)
        self.run_program("contours", "study", "--threshold", "0", "--keep-patient-ids", "-o", "rs.dcm")
        both = pydicom.dcmread(self.folder / "rs.dcm")
        for sequence, number in (("StructureSetROISequence", "ROINumber"), ("ROIContourSequence", "ReferencedROINumber")):
            other = copy.deepcopy(getattr(both, sequence)[0])
            setattr(other, number, 77)
            getattr(both, sequence).append(other)
        both.StructureSetROISequence[1].ROIName = "elsewhere"
        both.StructureSetROISequence[1].ReferencedFrameOfReferenceUID = "1.2.3.9"
        both.save_as(str(self.folder / "both.dcm"), write_like_original=True)
        for verb, output in (("contours", "x.json"), ("model", "x.vtu")):
            self.assert_refused([verb, "both.dcm", "-o", output], 3, "E-RTS-010", "--structure")
        self.assertNotIn("RTS-0", self.run_program("contours", "both.dcm", "--structure", "elsewhere", "-o", "x.json").err)
        told = self.run_program("contours", "both.dcm", "--ignore-frame-of-reference", "-o", "x.json").err
        self.assertIn("W-RTS-007", told)

    def test_G31_a_patient_far_from_the_origin(self):
        """The model is that of the centred twin, moved: by amounts that are exact in floating point."""
        def model(shift):
            shutil.rmtree(self.study)
            self.study.mkdir()
            write_series(self.study, shift=shift)
            # Half way between the two values there are: points in the middle between pixels.
            self.run_program("model", "study", "--threshold", "-350", "--size", "6", "-o", "m.mesh")
            words = (self.folder / "m.mesh").read_text().split()
            at, cells = words.index("Vertices") + 1, words.index("Tetrahedra") + 1
            points = numpy.array(words[at + 1:at + 1 + 4 * int(words[at])], float).reshape(-1, 4)[:, :3]
            return points, words[cells:cells + 1 + 5 * int(words[cells])]
        points, cells = model((0, 0, 0))
        for shift in ((2 ** 14, -2 ** 14, 2 ** 14), (-2 ** 20, 2 ** 17, 2 ** 20), (2 ** 23, 2 ** 23, -2 ** 23)):
            moved, same = model(shift)
            self.assertEqual(same, cells, shift)
            self.assertLess(abs(moved - points - shift).max(), 4 * numpy.spacing(float(max(map(abs, shift)))))

    def test_RS20_one_contour_in_total(self):
        write_series(self.study)
        self.run_program("contours", "study", "--threshold", "0", "--keep-patient-ids", "-o", "rs.dcm")
        made = pydicom.dcmread(self.folder / "rs.dcm")
        sequence = made.ROIContourSequence[0].ContourSequence
        middle = sequence[len(sequence) // 2]
        made.ROIContourSequence[0].ContourSequence = [middle]
        made.save_as(str(self.folder / "one.dcm"), write_like_original=True)
        self.assertIn("W-FLD-013", self.run_program("model", "one.dcm", "-o", "x.vtu").err)
        # Other programs state no thickness.
        del middle[0x3006, 0x0044]
        made.save_as(str(self.folder / "one.dcm"), write_like_original=True)
        refused = self.run_program("model", "one.dcm", "-o", "x.vtu", expect=None)
        self.assertIn(refused.code, (3, 4), refused.err)
        self.assertIn("--slice-thickness", refused.err)
        self.run_program("model", "one.dcm", "--slice-thickness", "3", "-o", "x.vtu")

    def drawn(self, rings):
        """An RTSTRUCT of circles [(ROI, centre, radius)], in a folder beside the images of `study`."""
        (self.study / "drawn.dcm").unlink(missing_ok=True)
        self.run_program("contours", "study", "--threshold", "0", "--keep-patient-ids", "-o", "rs.dcm")
        made = pydicom.dcmread(self.folder / "rs.dcm")
        rois = sorted({roi for roi, _, _ in rings})
        declared = made.StructureSetROISequence[0]
        made.StructureSetROISequence, made.ROIContourSequence = [], []
        for roi in rois:
            one = copy.deepcopy(declared)
            one.ROINumber, one.ROIName = roi, f"roi {roi}"
            made.StructureSetROISequence.append(one)
            contours = []
            for _, centre, radius in (ring for ring in rings if ring[0] == roi):
                turn = 2 * numpy.pi * numpy.arange(64) / 64
                points = numpy.array(centre) + radius * numpy.stack([numpy.cos(turn), numpy.sin(turn), 0 * turn], -1)
                contour = pydicom.Dataset()
                contour.ContourGeometricType, contour.NumberOfContourPoints = "CLOSED_PLANAR", 64
                contour.ContourData = [f"{value:.4f}" for value in points.ravel()]
                contours.append(contour)
            item = pydicom.Dataset()
            item.ReferencedROINumber, item.ContourSequence = roi, contours
            made.ROIContourSequence.append(item)
        made.save_as(str(self.study / "drawn.dcm"), write_like_original=True)

    def volumes(self, *words):
        self.run_program("model", *words, "-o", "m.vtu", "--report", "r.json", "--quiet")
        report = json.loads((self.folder / "r.json").read_text())
        return ({s["number"]: (s["volume_mesh_mm3"], s["components"]) for s in report["structures"]},
                {w["code"] for w in report["warnings"]})

    def test_structures_on_one_or_two_slices_are_as_thick_as_the_images_say(self):
        """Several lesions on a slice each, a lesion beside a slice that was skipped, and two slices far apart, by any file."""
        random, seen = numpy.random.default_rng(3), 0
        for spacing in (2.0, 3.0):
            write_series(self.study, spacing=spacing)
            first = float(pydicom.dcmread(self.study / "slice000").ImagePositionPatient[2])
            area = 64 / 2 * math.sin(2 * math.pi / 64)
            for n in range(7):
                at = lambda k, x: (x, float(random.uniform(-3, 3)), first + spacing * k)
                radii = random.uniform(4, 9, 5)
                alone = sorted(random.choice(20, 3, replace=False))
                apart = int(random.integers(4, 9))
                rings = [(n + 1, at(k, -12), radii[n]) for n, k in enumerate(alone)]
                right = {n + 1: (area * radii[n] ** 2 * spacing, 1) for n in range(3)}
                rings += [(4, at(2 + apart * n, 12), radii[3]) for n in range(2)]
                right[4] = (2 * area * radii[3] ** 2 * spacing, 2)
                self.drawn(rings)
                found, told = self.volumes("study")
                self.assertIn("W-FLD-021", told)
                self.assertTrue({"W-FLD-001", "W-FLD-003"} & told)
                self.assertNotIn("W-PIP-004", told)
                for number, (volume, parts) in right.items():
                    self.assertAlmostEqual(found[number][0] / volume, 1, delta=0.02, msg=f"{rings} {number}")
                    self.assertEqual(found[number][1], parts)
                    seen += 1
                asked, _ = self.volumes("study", "--slice-thickness", str(spacing / 2))
                self.assertAlmostEqual(asked[1][0] / right[1][0], 0.5, delta=0.02)
                for ending in (".json", ".vtp", ".dcm") if n % 3 == 0 else ():
                    self.run_program("contours", "study", "--keep-patient-ids", "-o", "again" + ending, "--quiet")
                    again, _ = self.volumes("again" + ending)
                    for number in right:
                        self.assertAlmostEqual(again[number][0] / found[number][0], 1, delta=1e-3, msg=ending)
        self.assertGreaterEqual(seen, 50)

    def test_a_lesion_beside_a_slice_that_was_skipped_is_one_slice_thick(self):
        write_series(self.study)
        first = float(pydicom.dcmread(self.study / "slice000").ImagePositionPatient[2])
        organ = [(1, (0, 0, first + 3 * k), 20) for k in range(2, 18) if k != 10]
        for k in (6, 9, 11):
            self.drawn(organ + [(2, (30, 0, first + 3 * k), 5)])
            found, told = self.volumes("study")
            self.assertAlmostEqual(found[2][0] / (64 / 2 * math.sin(2 * math.pi / 64) * 25 * 3), 1, delta=0.02)
            self.assertIn("W-FLD-021", told)
            self.run_program("model", "study", "--structure", "1", "--slice-thickness", "2", "-o", "x.vtu", expect=2)

    def test_images_of_the_drawn_slices_alone_are_no_series_and_state_the_thickness(self):
        """An archive that exports the images with contours alone: their distances say nothing of how thick a slice is."""
        area = 64 / 2 * math.sin(2 * math.pi / 64) * 36
        for drawn in ((2, 7, 15), (3, 6), (1, 4, 9, 18)):
            shutil.rmtree(self.study)
            self.study.mkdir()
            paths = write_series(self.study, SliceThickness=2.5)
            first = float(pydicom.dcmread(paths[0]).ImagePositionPatient[2])
            self.drawn([(n + 1, (0, 0, first + 3 * k), 6) for n, k in enumerate(drawn)])
            for k, path in enumerate(paths):
                if k not in drawn:
                    path.unlink()
            found, told = self.volumes("study")
            self.assertIn("W-FLD-021", told)
            for number, (volume, _) in found.items():
                self.assertAlmostEqual(volume / (area * 2.5), 1, delta=0.02, msg=f"{drawn} {number}")

    def test_a_structure_on_none_of_every_nth_slice_is_told(self):
        write_series(self.study)
        first = float(pydicom.dcmread(self.study / "slice000").ImagePositionPatient[2])
        self.drawn([(1, (0, 0, first + 3 * k), 20) for k in range(2, 18)] + [(2, (30, 0, first + 3 * 7), 5)])
        found, told = self.volumes("study", "--every", "2")
        self.assertIn("W-CON-001", told)
        self.assertEqual(list(found), [1])

    def test_several_series(self):
        write_series(self.study)
        (self.study / "more").mkdir()
        write_series(self.study / "more", series="1.2.826.0.1.3680043.8.498.2")
        self.assert_refused(["contours", "study", "--threshold", "0", "-o", "x.json"], 3, "E-DCM-029", "20 images")
        self.run_program("contours", "study", "--threshold", "0", "--series", "1.2.826.0.1.3680043.8.498.2", "-o", "x.json")

    def test_G03_a_missing_slice(self):
        paths = write_series(self.study)
        os.remove(paths[9])
        self.assert_refused(["contours", "study", "--threshold", "0", "-o", "x.json"], 3, "E-DCM-014", "--allow-gaps")
        self.run_program("contours", "study", "--threshold", "0", "--allow-gaps", "-o", "x.json")


class ModelObjects(harness.TestCase):
    def test_surface_and_segmentation_of_the_study(self):
        study = self.folder / "study"
        study.mkdir()
        write_series(study)
        self.run_program("model", "study", "--threshold", "0", "--size", "6", "-o", "m.vtu", "--keep-patient-ids",
                         "--dicom-surface", "stl.dcm", "--dicom-obj", "obj.dcm", "--dicom-segmentation", "seg.dcm",
                         "--surface", "m.obj")
        surface, text, voxels = (pydicom.dcmread(self.folder / name) for name in ("stl.dcm", "obj.dcm", "seg.dcm"))
        for made in (surface, text, voxels):
            self.assertEqual(made.StudyInstanceUID, "1.2.826.0.1.3680043.8.498.7")
            self.assertEqual(made.FrameOfReferenceUID, "1.2.826.0.1.3680043.8.498.8")
        self.assertEqual(surface.MIMETypeOfEncapsulatedDocument, "model/stl")
        stl = surface.EncapsulatedDocument[:surface.EncapsulatedDocumentLength]
        triangles = int.from_bytes(stl[80:84], "little")
        self.assertEqual(len(stl), 84 + 50 * triangles)
        self.assertEqual((text.SOPClassUID, text.MIMETypeOfEncapsulatedDocument),
                         ("1.2.840.10008.5.1.4.1.1.104.4", "model/obj"))
        obj = text.EncapsulatedDocument[:text.EncapsulatedDocumentLength].decode().splitlines()
        written = (self.folder / "m.obj").read_text().splitlines()
        for kind in ("v ", "f "):
            self.assertEqual([line for line in obj if line.startswith(kind)],
                             [line for line in written if line.startswith(kind)])
        self.assertEqual(sum(line.startswith("f ") for line in obj), triangles)
        # The voxels of the segmentation are those of the ball, by pydicom's own unpacking.
        pixels = voxels.pixel_array
        wanted, heights, _ = ball()
        wanted = wanted > 0
        read = numpy.zeros_like(wanted)
        for frame, item in zip(pixels, voxels.PerFrameFunctionalGroupsSequence):
            z = float(item.PlanePositionSequence[0].ImagePositionPatient[2])
            read[numpy.argmin(abs(heights - z))] |= frame > 0
        self.assertGreater(2 * (read & wanted).sum() / (read.sum() + wanted.sum()), 0.97)
        # Debian 12's dciodvfy knows no Encapsulated OBJ. Its modules are those of Encapsulated STL (PS3.3, A.85.1.3 and A.85.2.3):
        # the same bytes under the name of an STL have to pass.
        unnamed = (self.folder / "obj.dcm").read_bytes()
        for said, instead in ((b"1.2.840.10008.5.1.4.1.1.104.4", b"1.2.840.10008.5.1.4.1.1.104.3"), (b"model/obj", b"model/stl")):
            self.assertIn(said, unnamed)
            unnamed = unnamed.replace(said, instead)
        (self.folder / "obj-as-stl.dcm").write_bytes(unnamed)
        self.assertLessEqual(set(dciodvfy_errors(self.folder / "obj.dcm")), {"Error - Information Object Not found"})
        for name in ("stl.dcm", "obj-as-stl.dcm", "seg.dcm"):
            self.assertEqual(dciodvfy_errors(self.folder / name), [], name)
        # Our own reader takes the segmentation for what it is.
        found = self.run_program("info", "seg.dcm", "--json").json()["image"]
        self.assertEqual(found["structures"][0]["voxels"], int(read.sum()))


# What the modules of Encapsulated OBJ and STL (PS3.3, A.85) demand: with a value (type 1), or at least there (type 2).
WITH_VALUE = ["StudyInstanceUID", "Modality", "SeriesInstanceUID", "SeriesNumber", "FrameOfReferenceUID", "Manufacturer",
              "ManufacturerModelName", "DeviceSerialNumber", "SoftwareVersions", "InstanceNumber", "BurnedInAnnotation",
              "EncapsulatedDocument", "MIMETypeOfEncapsulatedDocument", "MeasurementUnitsCodeSequence", "SOPClassUID",
              "SOPInstanceUID", "SourceInstanceSequence"]
THERE = ["PatientName", "PatientID", "PatientBirthDate", "PatientSex", "StudyDate", "StudyTime", "ReferringPhysicianName",
         "StudyID", "AccessionNumber", "PositionReferenceIndicator", "ContentDate", "ContentTime", "AcquisitionDateTime",
         "DocumentTitle", "ConceptNameCodeSequence"]


class EncapsulatedObj(harness.TestCase):
    """No checker in Debian 12 knows Encapsulated OBJ: it is held against the standard's tables and against DCMTK's stl2dcm."""

    def setUp(self):
        super().setUp()
        study = self.folder / "study"
        study.mkdir()
        write_series(study)
        self.run_program("contours", "study", "--threshold", "0", "--keep-patient-ids", "-o", "rs.dcm")
        shutil.copy(self.folder / "rs.dcm", study / "rs")
        self.run_program("model", "study", "--size", "6", "-o", "m.vtu", "--keep-patient-ids", "--dicom-surface", "stl.dcm",
                         "--dicom-obj", "obj.dcm", "--surface", "m.stl")

    def read(self, name):
        return pydicom.dcmread(self.folder / name)

    def test_what_the_standard_demands_is_there(self):
        for made in (self.read("obj.dcm"), self.read("stl.dcm")):
            for keyword in WITH_VALUE:
                self.assertTrue(keyword in made and made[keyword].value not in (None, "", b"", []), keyword)
            for keyword in THERE:
                self.assertIn(keyword, made)
            self.assertEqual(made.Modality, "M3D")
            self.assertEqual(len(made.EncapsulatedDocument) % 2, 0)
            unit = made.MeasurementUnitsCodeSequence[0]
            self.assertEqual((unit.CodeValue, unit.CodingSchemeDesignator), ("mm", "UCUM"))

    def test_it_says_what_it_was_made_from(self):
        contours, made = self.read("rs.dcm"), self.read("obj.dcm")
        images = {f"1.2.826.0.1.3680043.8.498.1.{k + 1}" for k in range(20)}
        self.assertEqual({item.ReferencedSOPInstanceUID for item in made.SourceInstanceSequence},
                         images | {contours.SOPInstanceUID})
        series = {item.SeriesInstanceUID: {each.ReferencedSOPInstanceUID for each in item.ReferencedInstanceSequence}
                  for item in made.ReferencedSeriesSequence}
        self.assertEqual(series, {"1.2.826.0.1.3680043.8.498.1": images, contours.SeriesInstanceUID: {contours.SOPInstanceUID}})

    def test_beside_what_dcmtk_makes_of_the_same_surface(self):
        if not shutil.which("stl2dcm"):
            self.skipTest("no stl2dcm (dcmtk)")
        done = subprocess.run(["stl2dcm", "--study-from", "study/slice000", "+mu", "UCUM", "mm", "mm", "-an", "+t", "model surface",
                               "m.stl", "peer.dcm"], cwd=self.folder, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        peer, ours, text = self.read("peer.dcm"), self.read("stl.dcm"), self.read("obj.dcm")
        kinds = [{element.keyword: element.VR for element in each} for each in (peer, ours, text)]
        # Both ways: what the peer alone says is optional (SOP Common), what we alone say is references and the model's state.
        self.assertEqual(set(kinds[0]) - set(kinds[1]), {"InstanceCreationDate", "InstanceCreationTime"})
        self.assertEqual(set(kinds[1]) - set(kinds[0]), {"SeriesDescription", "ModelModification", "ModelMirroring",
                                                         "SourceInstanceSequence", "ReferencedSeriesSequence"})
        for keyword in set(kinds[0]) & set(kinds[1]):
            self.assertEqual(kinds[0][keyword], kinds[1][keyword], keyword)
        for keyword in ("SOPClassUID", "Modality", "StudyInstanceUID", "FrameOfReferenceUID", "PatientName", "PatientID",
                        "MIMETypeOfEncapsulatedDocument", "DocumentTitle", "BurnedInAnnotation", "EncapsulatedDocument",
                        "EncapsulatedDocumentLength", "MeasurementUnitsCodeSequence"):
            self.assertEqual(peer[keyword].value, ours[keyword].value, keyword)
        # And the text differs from the binary in what it is, and in nothing else.
        self.assertEqual(kinds[2], kinds[1])
        differ = {keyword for keyword in kinds[1] if text[keyword].value != ours[keyword].value}
        self.assertEqual(differ, {"SOPClassUID", "SOPInstanceUID", "SeriesInstanceUID", "EncapsulatedDocument",
                                  "EncapsulatedDocumentLength", "MIMETypeOfEncapsulatedDocument"})

    def test_dcmtk_reads_every_element_of_it(self):
        if not shutil.which("dcmconv"):
            self.skipTest("no dcmconv (dcmtk)")
        for words in (["dcmdump", "+E", "obj.dcm"], ["dcm2xml", "obj.dcm", "obj.xml"], ["dcmconv", "+ti", "obj.dcm", "implicit.dcm"]):
            done = subprocess.run(words, cwd=self.folder, capture_output=True, text=True)
            self.assertEqual((done.returncode, done.stderr), (0, ""), words)
        self.assertEqual(self.read("implicit.dcm").to_json(), self.read("obj.dcm").to_json())


class Privacy(harness.TestCase):
    def test_O05_nothing_planted_gets_out(self):
        study = self.folder / "study"
        study.mkdir()
        paths = write_series(study, names=[f"Zzplanted_Name_{k:02}.dcm" for k in range(20)])
        (study / "ZZPLANTED damaged.dcm").write_bytes(paths[0].read_bytes()[:900])
        texts = []
        for words in (["info", "study"], ["info", "study", "--json"],
                      ["model", "study", "--threshold", "0", "-o", "m.vtu", "--html", "m.html", "--size", "6",
                       "--contours", "m.json", "--dicom-surface", "m1.dcm", "--dicom-obj", "m2.dcm",
                       "--dicom-segmentation", "m3.dcm"],
                      ["contours", "study", "--threshold", "0", "-o", "m.dcm"],
                      ["segment", "study", "--threshold", "0", "-o", "m.nrrd", "--json"],
                      ["field", "study", "--threshold", "0", "-o", "m.nii", "--json"],
                      ["info", "study", "--series", "SERIES"]):
            if words[0] != "info" or "SERIES" in words:
                (study / "ZZPLANTED damaged.dcm").unlink(missing_ok=True)
            if "SERIES" in words:
                named = self.run_program("info", "study", "--json").json()["folder"]["series"][0]["series"]
                words = words[:-1] + [named]
            done = self.run_program(*words)
            texts += [done.out.encode(), done.err.encode()]
        refused = self.run_program("contours", "study", "--threshold", "0", "--volume", "7", "-o", "n.dcm", expect=3)
        texts.append(refused.err.encode())
        for output in self.folder.glob("m*"):
            texts.append(output.read_bytes())
        for text in texts:
            found = re.search(rb"zz(planted|acc|doctor|study|series|protocol|operator|station|private)|19991231|19420228|1\.2\.826\.0\.1\.3680043\.8\.498", text, re.I)
            self.assertIsNone(found, found and text[max(0, found.start() - 60):found.end() + 60])
        report = json.loads((self.folder / "m.report.json").read_text())
        self.assertEqual(len(report["inputs"][0]["sha256"]), 64)

    def test_O05_folders_called_after_the_patient(self):
        """What is written says neither how the folder is called nor the series' UID, also where the command line has them."""
        study = self.folder / "ZZPLANTED Doe^John"
        study.mkdir()
        paths = write_series(study)
        os.remove(paths[9])
        uid, out = "1.2.826.0.1.3680043.8.498.1", self.folder / "ZZPLANTED out"
        out.mkdir()
        for folder, file in (("ZZPLANTED Doe^John/", "m1"), (study, "m2")):
            words = ["model", folder, "--threshold", "0", "--size", "6", "--allow-gaps", "--series", uid, "--grey", folder,
                     "-o", f"ZZPLANTED out/{file}.vtu", f"--html={self.folder}/ZZPLANTED out/{file}.html"]
            self.run_program(*words)
            report = json.loads((out / f"{file}.report.json").read_text())
            self.assertIn("anatomesh model 'DICOM input' --threshold 0", report["timing"]["command"])
            self.assertIn("W-DCM", json.dumps(report["warnings"]))
            self.run_program(*words, "--keep-patient-ids")
            self.assertIn("ZZPLANTED", (out / f"{file}.report.json").read_text())
            self.run_program(*words)
        self.run_program("contours", study, "--threshold", "0", "--allow-gaps", "--keep-patient-ids", "-o", "ZZPLANTED rs.dcm")
        self.run_program("model", "ZZPLANTED rs.dcm", "-o", "m3.vtu", "--size", "6", "--html", "m3.html")
        for output in [*self.folder.glob("m*"), *out.iterdir()]:
            found = re.search(rb"zzplanted|doe\^|1\.2\.826\.0\.1\.3680043\.8\.498", output.read_bytes(), re.I)
            self.assertIsNone(found, found and output.read_bytes()[max(0, found.start() - 300):found.end() + 60])

    def test_asked_for_it_is_kept(self):
        study = self.folder / "study"
        study.mkdir()
        write_series(study)
        self.run_program("contours", "study", "--threshold", "0", "--keep-patient-ids", "-o", "m.dcm")
        made = pydicom.dcmread(self.folder / "m.dcm")
        self.assertEqual(str(made.PatientName), PLANTED["PatientName"])
        self.assertEqual(made.StudyInstanceUID, "1.2.826.0.1.3680043.8.498.7")


class RealFolders(harness.TestCase):
    def test_contours_with_their_series(self):
        for study in ("thigh_mr/STS_001", "sarcoma_ct_mr/STS_002"):
            folder = harness.data(*study.split("/"))
            found = self.run_program("info", folder, "--json").json()["folder"]
            kinds = [series["kind"] for series in found["series"]]
            self.assertIn("RTSTRUCT", kinds)
            self.assertIn("images", kinds)

    def test_compressed_series_equal_the_values_of_pydicom(self):
        folder = harness.data("body_ct_mr_labels", "example_ct_dicom")
        image = self.run_program("info", folder, "--series",
                                 self.run_program("info", folder, "--json").json()["folder"]["series"][0]["series"],
                                 "--json").json()["image"]
        files = [pydicom.dcmread(path) for path in folder.iterdir()]
        self.assertEqual(image["size"], [files[0].Columns, files[0].Rows, len(files)])
        heights = sorted(float(f.ImagePositionPatient[2]) for f in files)
        self.assertAlmostEqual(image["spacing_mm"][2], heights[1] - heights[0], places=6)

    def test_segmentation(self):
        path = harness.data("dicom_seg", "liver.dcm")
        found = self.run_program("info", path, "--json").json()["image"]
        self.assertEqual(found["voxel_type"], "BINARY")
        self.run_program("contours", path, "-o", "liver.json")
        overlaps = harness.data("dicom_seg", "partial_overlaps.dcm")
        self.run_program("contours", overlaps, "-o", "overlaps.json")


if __name__ == "__main__":
    harness.main("__main__")
