"""Files with many frames: every frame lies where the file says, or the file is refused for the true reason."""
import json

import numpy as np
from pydicom import dcmread
from pydicom.dataset import Dataset, FileDataset, FileMetaDataset
from pydicom.sequence import Sequence
from pydicom.uid import ExplicitVRLittleEndian, ImplicitVRLittleEndian

import harness
import images

ENHANCED_CT, CT = "1.2.840.10008.5.1.4.1.1.2.1", "1.2.840.10008.5.1.4.1.1.2"
ENHANCED_US, NUCLEAR = "1.2.840.10008.5.1.4.1.1.6.2", "1.2.840.10008.5.1.4.1.1.20"
SIZE = (9, 7, 8)  # columns, rows, frames
KINDS = ("patient", "volume", "step", "grid from 0", "grid of heights", "nuclear")


class Member:
    """A volume with frames anywhere in space, and the ways in which its file says so."""

    def __init__(self, random, kind):
        self.random, self.kind = random, kind
        turn = np.linalg.qr(random.normal(size=(3, 3)))[0]
        if kind == "grid of heights":
            turn = np.array([[1, 0, 0], [0, random.choice((1, -1)), 0], [0, 0, 1]], float)
        self.row, self.column = turn[0], turn[1]
        self.normal = np.cross(self.row, self.column)
        self.spacing = np.round(random.uniform(0.4, 2, 2), 3)  # between columns, between rows
        self.step = float(np.round(random.uniform(0.5, 3), 3)) * random.choice((1, -1))
        self.first = np.round(random.uniform(-80, 80, 3), 3)
        self.order = np.arange(SIZE[2])
        if kind in ("patient", "volume"):  # the file's order of frames: rising, falling, any
            self.order = [self.order, self.order[::-1], random.permutation(SIZE[2])][random.integers(3)]
        self.shared = random.integers(0, 2, 3).astype(bool)  # orientation, measures, values
        self.implicit = bool(random.integers(2))
        self.offsets = self.order * self.step

    def inside(self, points):
        """A corner of the volume, so that every mirrored one is another: by voxel, from the place in space."""
        middle = self.first + self.row * self.spacing[0] * 2.7 + self.column * self.spacing[1] * 2.2 + self.normal * self.step * 2.4
        return np.linalg.norm((points - middle) @ np.array([self.row / self.spacing[0], self.column / self.spacing[1],
                                                            self.normal / abs(self.step)]).T, axis=-1) < 2.6

    def pixels(self):
        j, i = np.meshgrid(np.arange(SIZE[1]), np.arange(SIZE[0]), indexing="ij")
        plane = i[..., None] * self.spacing[0] * self.row + j[..., None] * self.spacing[1] * self.column
        return np.array([self.inside(self.first + offset * self.normal + plane) for offset in self.offsets])

    def groups(self, data):
        positions = [self.first + offset * self.normal for offset in self.offsets]
        volume = self.kind == "volume"
        word = "Volume" if volume else "Patient"
        orientation, measures, values = Dataset(), Dataset(), Dataset()
        setattr(orientation, f"ImageOrientation{word}", decimals([*self.row, *self.column], volume))
        measures.PixelSpacing, measures.SliceThickness = decimals(self.spacing[::-1]), "1"
        values.RescaleSlope, values.RescaleIntercept, values.RescaleType = "2", "-7", "US"
        all_of = (f"PlaneOrientation{'Volume' if volume else ''}Sequence", orientation), \
            ("PixelMeasuresSequence", measures), ("PixelValueTransformationSequence", values)
        shared, frames = Dataset(), []
        for position in positions:
            frame, place = Dataset(), Dataset()
            setattr(place, f"ImagePosition{word}", decimals(position, volume))
            setattr(frame, f"PlanePosition{'Volume' if volume else ''}Sequence", Sequence([place]))
            for (name, item), is_shared in zip(all_of, self.shared):
                setattr(shared if is_shared else frame, name, Sequence([item]))
            frames.append(frame)
        data.SharedFunctionalGroupsSequence, data.PerFrameFunctionalGroupsSequence = Sequence([shared]), Sequence(frames)
        if volume:
            data.VolumeFrameOfReferenceUID, data.UltrasoundAcquisitionGeometry = "1.2.3.9", "APEX"

    def first_place(self, data):
        place = data
        if self.kind == "nuclear":
            place = Dataset()
            data.DetectorInformationSequence, data.SliceVector = Sequence([place]), list(range(1, SIZE[2] + 1))
            data.ImageType = ["ORIGINAL", "PRIMARY", "RECON TOMO", "EMISSION"]
        place.ImagePositionPatient = decimals(self.first)
        place.ImageOrientationPatient = decimals([*self.row, *self.column])
        data.PixelSpacing, data.RescaleSlope, data.RescaleIntercept = decimals(self.spacing[::-1]), "2", "-7"
        data.SpacingBetweenSlices = decimals([self.step if self.kind == "nuclear" else abs(self.step)])[0]
        if self.kind.startswith("grid"):
            data.FrameIncrementPointer = 0x3004000C
            heights = self.first[2] + self.offsets * self.normal[2]
            data.GridFrameOffsetVector = decimals(self.offsets if self.kind == "grid from 0" else heights)

    def write(self, path, change=None):
        meta = FileMetaDataset()
        meta.MediaStorageSOPClassUID = {"patient": ENHANCED_CT, "volume": ENHANCED_US, "nuclear": NUCLEAR}.get(self.kind, CT)
        meta.MediaStorageSOPInstanceUID = "1.2.3.4"
        meta.TransferSyntaxUID = ImplicitVRLittleEndian if self.implicit else ExplicitVRLittleEndian
        data = FileDataset(str(path), {}, file_meta=meta, preamble=b"\0" * 128)
        data.SOPClassUID, data.SOPInstanceUID = meta.MediaStorageSOPClassUID, "1.2.3.4"
        data.Modality, data.StudyInstanceUID, data.SeriesInstanceUID = "OT", "1.2.3.5", "1.2.3.6"
        data.PatientName, data.PatientID, data.FrameOfReferenceUID = "Nobody", "0", "1.2.3.7"
        data.ImageType = ["ORIGINAL", "PRIMARY"]
        data.NumberOfFrames, (data.Columns, data.Rows) = SIZE[2], SIZE[:2]
        data.SamplesPerPixel, data.PhotometricInterpretation = 1, "MONOCHROME2"
        data.BitsAllocated = data.BitsStored = 16
        data.HighBit, data.PixelRepresentation = 15, 0
        data.PixelData = (self.pixels() * 100).astype("<u2").tobytes()
        (self.groups if self.kind in ("patient", "volume") else self.first_place)(data)
        if change:
            change(data)
        data.is_little_endian, data.is_implicit_VR = True, self.implicit
        data.save_as(str(path), write_like_original=False)

    def options(self):
        return {"step": [f"--frame-step={self.step}"], "volume": ["--frame", "LPS"]}.get(self.kind, [])


def decimals(numbers, as_doubles=False):
    return [float(n) for n in numbers] if as_doubles else [f"{n:.10g}" for n in numbers]


def members(count, seed):
    random = np.random.default_rng(seed)
    for n in range(count):
        yield Member(random, KINDS[n % len(KINDS)])


class PlacesOfFrames(harness.TestCase):
    def segmented(self, *options):
        self.run_program("segment", "frames.dcm", "--threshold", "100", *options, "-o", "found.nrrd", "--quiet")
        return images.read_nrrd(self.folder / "found.nrrd")[:3]

    def test_every_frame_lies_where_the_file_says(self):
        for n, member in enumerate(members(66, 1)):
            with self.subTest(n=n, kind=member.kind, implicit=member.implicit, shared=member.shared):
                member.write(self.folder / "frames.dcm")
                found, origin, steps = self.segmented(*member.options())
                points = images.positions(found.shape, origin, steps)
                self.assertEqual(sorted(found.shape), sorted(SIZE))
                self.assertTrue(np.array_equal(found > 0, member.inside(points)))
                self.assertGreater(np.count_nonzero(found), 20)
                told = self.run_program("info", "frames.dcm", *(member.options() if member.kind == "step" else []), "--json")
                self.assertEqual(told.json()["space"], "unknown" if member.kind == "volume" else "LPS")
                self.assertEqual("W-DCM-026" in told.err, member.kind == "volume")

    def test_axes_that_are_not_the_patients_stay_unknown_until_the_user_names_them(self):
        for member in members(12, 2):
            if member.kind != "volume":
                continue
            member.write(self.folder / "frames.dcm")
            self.run_program("model", "frames.dcm", "--threshold", "100", "--min-area", "0", "-o", "m.vtu", "--quiet")
            self.assertEqual(json.loads((self.folder / "m.report.json").read_text())["space"], "unknown")
            self.run_program("contours", "frames.dcm", "--threshold", "100", "--min-area", "0", "-o", "c.json", "--quiet")
            self.assertEqual(json.loads((self.folder / "c.json").read_text())["space"], "unknown")
            for words in (["segment", "frames.dcm", "--threshold", "100", "-o", "x.nrrd"],
                          ["contours", "frames.dcm", "--threshold", "100", "-o", "x.dcm"]):
                self.assert_refused(words, 2, "E-CMD-018")
            lps, ras = (self.segmented("--frame", frame)[1:] for frame in ("LPS", "RAS"))
            np.testing.assert_allclose(lps[0] * [-1, -1, 1], ras[0], atol=1e-9)
            np.testing.assert_allclose(lps[1] * [-1, -1, 1], ras[1], atol=1e-9)

    def test_contours_and_volumes_in_axes_of_their_own_are_not_put_together(self):
        member = next(m for m in members(12, 8) if m.kind == "volume")
        study = self.folder / "study"
        study.mkdir()
        member.write(study / "us.dcm")
        words = ["--threshold", "100", "--min-area", "0", "--quiet"]
        uids = set()
        for frame in ("LPS", "RAS"):
            self.run_program("contours", "study/us.dcm", "--frame", frame, *words, "--keep-patient-ids", "-o", "rs.dcm")
            uids.add(str(dcmread(self.folder / "rs.dcm").FrameOfReferenceUID))
        # What lies elsewhere has another frame of reference, and neither is that of the volume.
        self.assertEqual(len(uids | {"1.2.3.9", "1.2.3.7"}), 4)
        made = dcmread(self.folder / "rs.dcm")
        image = Dataset()
        image.ReferencedSOPClassUID, image.ReferencedSOPInstanceUID, image.ReferencedFrameNumber = ENHANCED_US, "1.2.3.4", "1"
        series, of_study = Dataset(), Dataset()
        series.SeriesInstanceUID, series.ContourImageSequence = "1.2.3.6", Sequence([image])
        of_study.ReferencedSOPClassUID, of_study.ReferencedSOPInstanceUID = "1.2.840.10008.3.1.2.3.1", "1.2.3.5"
        of_study.RTReferencedSeriesSequence = Sequence([series])
        made.ReferencedFrameOfReferenceSequence[0].RTReferencedStudySequence = Sequence([of_study])
        for roi in made.ROIContourSequence:
            for contour in roi.ContourSequence:
                contour.ContourImageSequence = Sequence([image])
        made.save_as(str(study / "rs.dcm"), write_like_original=False)
        self.assert_refused(["model", "study", "-o", "m.vtu"], 3, "E-DCM-032")
        said = self.run_program("model", "study", "--ignore-frame-of-reference", "-o", "m.vtu").err
        self.assertIn("W-DCM-022", said)
        self.assertNotIn("W-DCM-024", said)

    def assert_each_refused(self, count, seed, kinds, change, *texts, options=True):
        seen = 0
        for member in members(count, seed):
            if member.kind not in kinds:
                continue
            seen += 1
            said = []
            member.write(self.folder / "frames.dcm", lambda data: said.append(change(member, data) or ""))
            with self.subTest(n=seen, kind=member.kind):
                self.assert_refused(["info", "frames.dcm", *(member.options() if options else [])], 3, *texts, *said)
        self.assertGreaterEqual(seen, 10)

    def test_a_frame_without_its_place_is_named(self):
        def lose_one(member, data):
            lost = int(member.random.integers(1, SIZE[2]))
            volume = "Volume" if member.kind == "volume" else ""
            kept = data.PerFrameFunctionalGroupsSequence[0][f"PlanePosition{volume}Sequence"].value
            delattr(data.PerFrameFunctionalGroupsSequence[lost], f"PlanePosition{volume}Sequence")
            # A place for all frames, or for the file, is no place for this one.
            if member.random.integers(2):
                setattr(data.SharedFunctionalGroupsSequence[0], f"PlanePosition{volume}Sequence", kept)
            elif not volume:
                data.ImagePositionPatient = kept[0].ImagePositionPatient
            return f"frame {lost + 1}:"
        self.assert_each_refused(60, 3, ("patient", "volume"), lose_one, "E-DCM-004")

    def test_uneven_frames_are_refused(self):
        def move_one(member, data):
            moved = int(member.random.integers(1, SIZE[2] - 1))
            away = 0.3 * member.step
            if member.kind == "nuclear":
                vector = list(range(1, SIZE[2] + 1))
                vector[-1] += 2
                data.SliceVector = vector
            elif member.kind.startswith("grid"):
                offsets = [float(o) for o in data.GridFrameOffsetVector]
                offsets[moved] += away * (1 if member.kind == "grid from 0" else member.normal[2])
                data.GridFrameOffsetVector = decimals(offsets)
            else:
                word, name = ("Volume", "Volume") if member.kind == "volume" else ("", "Patient")
                moved = int(np.flatnonzero(member.order == moved)[0])
                place = data.PerFrameFunctionalGroupsSequence[moved][f"PlanePosition{word}Sequence"].value[0]
                position = np.array([float(p) for p in getattr(place, f"ImagePosition{name}")]) + away * member.normal
                setattr(place, f"ImagePosition{name}", decimals(position, bool(word)))
        self.assert_each_refused(60, 4, ("patient", "volume", "grid from 0", "grid of heights", "nuclear"), move_one, "E-DCM-014")

    def test_frames_far_outside_are_refused(self):
        def go_far(member, data):
            if member.kind == "nuclear":
                data.SpacingBetweenSlices = "1e300"
            else:
                data.GridFrameOffsetVector = [*data.GridFrameOffsetVector[:-1], "1e300"]
        self.assert_each_refused(30, 9, ("nuclear", "grid from 0"), go_far, "E-DCM-008")

    def test_the_place_of_the_first_frame_alone_is_not_enough(self):
        self.assert_each_refused(60, 5, ("step",), lambda member, data: None, "E-DCM-040", "--frame-step", options=False)

        def forget(member, data):
            if member.kind == "nuclear":
                del data.SpacingBetweenSlices
            else:
                del data.GridFrameOffsetVector
        self.assert_each_refused(30, 6, ("nuclear", "grid from 0"), forget, "E-DCM-040", "--frame-step")

    def test_a_wrong_or_unused_step_is_told(self):
        for member in members(12, 7):
            member.write(self.folder / "frames.dcm")
            said = self.run_program("info", "frames.dcm", f"--frame-step={2 * member.step}").err
            self.assertEqual("W-CMD-003" in said, member.kind != "step")
            self.assertEqual("W-DCM-010" in said, member.kind == "step")

    def test_a_step_of_nothing_is_refused(self):
        for step in ("0", "1e-4", "-1e-4", "1e5", "x"):
            self.assert_refused(["info", "frames.dcm", f"--frame-step={step}"], 2, "--frame-step")


if __name__ == "__main__":
    harness.main(__name__)
