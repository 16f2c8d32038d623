"""Landmarks at known places of a patient: a program that works in RAS finds them in every model, once the model is turned as
docs/conventions.md says."""
import itertools
import json

import meshio
import nibabel
import numpy as np
import vtk
from vtk.util import numpy_support

import harness

# By label: the place in the patient in mm, RAS as NIfTI has it, and the radius. No turn or mirroring that leaves the axes on each other
# puts all of them near each other's places.
LANDMARKS = {1: ((31.0, -12.0, 8.0), 9.0), 2: ((-14.0, 27.0, -19.0), 7.0), 3: ((6.0, 9.0, 41.0), 6.0), 4: ((-20.0, -31.0, 17.0), 5.0)}
PLACES = np.array([place for place, _ in LANDMARKS.values()])
# Voxels in mm, and where they run in the patient: axes (R+, A+, S+) in other sequences and against themselves, and two oblique ones.
SPACING = np.array([1.5, 2.0, 2.5])
TURNED = np.array([[0.8, -0.6, 0.0], [0.6, 0.8, 0.0], [0.0, 0.0, 1.0]])
TILTED = TURNED @ np.array([[1.0, 0.0, 0.0], [0.0, 0.96, -0.28], [0.0, 0.28, 0.96]])
ORIENTATIONS = {"RAS": np.eye(3), "LPS": np.diag([-1.0, -1.0, 1.0]), "LAS": np.diag([-1.0, 1.0, 1.0]), "RAI": np.diag([1.0, 1.0, -1.0]),
                "PIR": np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]), "turned": TURNED, "tilted": TILTED}
# Of LPS coordinates into RAS, as docs/conventions.md says: x and y negated.
TO_RAS = np.array([-1.0, -1.0, 1.0])


def label_map(axes):
    """The landmarks as voxels, by the centres of these, in a box around all of them."""
    steps = axes * SPACING
    low, high = PLACES.min(0) - 16, PLACES.max(0) + 16
    middle = (low + high) / 2
    reach = np.abs(axes).T @ ((high - low) / 2)
    count = np.ceil(2 * reach / SPACING).astype(int) + 1
    affine = np.eye(4)
    affine[:3, :3] = steps
    affine[:3, 3] = middle - steps @ ((count - 1) / 2)
    centres = np.moveaxis(np.indices(count), 0, -1) @ steps.T + affine[:3, 3]
    voxels = np.zeros(count, np.uint8)
    for label, (place, radius) in LANDMARKS.items():
        voxels[np.linalg.norm(centres - place, axis=-1) <= radius] = label
    image = nibabel.Nifti1Image(voxels, affine)
    image.header.set_xyzt_units("mm")
    return image


def centre_of_cells(points, cells):
    corners = points[cells]
    volumes = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1]))
    return np.average(corners.mean(1), axis=0, weights=volumes)


def centres_of_parts(surface):
    """The centre of each connected surface, by its triangles; formats keep points of triangles apart or join them."""
    clean = vtk.vtkCleanPolyData()
    clean.SetInputData(surface)
    parts = vtk.vtkPolyDataConnectivityFilter()
    parts.SetInputConnection(clean.GetOutputPort())
    parts.SetExtractionModeToAllRegions()
    parts.ColorRegionsOn()
    parts.Update()
    found = parts.GetOutput()
    region = numpy_support.vtk_to_numpy(found.GetPointData().GetArray("RegionId"))
    points = numpy_support.vtk_to_numpy(found.GetPoints().GetData()).astype(float)
    triangles = numpy_support.vtk_to_numpy(found.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    centres = []
    for number in range(parts.GetNumberOfExtractedRegions()):
        corners = points[triangles[region[triangles[:, 0]] == number]]
        areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
        centres.append(np.average(corners.mean(1), axis=0, weights=areas))
    return np.array(centres)


class Landmarks(harness.TestCase):
    def read(self, reader, name):
        reader.SetFileName(str(self.folder / name))
        reader.Update()
        return reader.GetOutput()

    def states_lps(self, name, of_fields=None):
        """What the file says of its axes, in the way of its format."""
        if of_fields is not None:
            self.assertEqual([of_fields.GetAbstractArray(key).GetValue(0) for key in ("SPACE", "UNIT")], ["LPS", "mm"], name)
        else:
            head = (self.folder / name).read_bytes()[:4096]
            self.assertIn(b"SPACE=LPS", head, name)

    def structures_of_vtu(self):
        grid = self.read(vtk.vtkXMLUnstructuredGridReader(), "m.vtu")
        self.states_lps("m.vtu", grid.GetFieldData())
        points = numpy_support.vtk_to_numpy(grid.GetPoints().GetData())
        cells = numpy_support.vtk_to_numpy(grid.GetCells().GetConnectivityArray()).reshape(-1, 4)
        structure = numpy_support.vtk_to_numpy(grid.GetCellData().GetArray("structure"))
        return np.array([centre_of_cells(points, cells[structure == label]) for label in LANDMARKS])

    def structures_of_mesh(self):
        self.states_lps("m.mesh")
        mesh = meshio.read(self.folder / "m.mesh")
        cells, reference = mesh.cells_dict["tetra"], mesh.cell_data_dict["medit:ref"]["tetra"]
        return np.array([centre_of_cells(mesh.points, cells[reference == label]) for label in LANDMARKS])

    def structures_of_msh(self):
        self.states_lps("m.msh")
        mesh = meshio.read(self.folder / "m.msh")
        cells, group = mesh.cells_dict["tetra"], mesh.cell_data_dict["gmsh:physical"]["tetra"]
        return np.array([centre_of_cells(mesh.points, cells[group == label]) for label in LANDMARKS])

    def centres(self):
        """By file, the centres of the landmarks in its own coordinates; surfaces say them in any sequence."""
        yield "m.vtu", self.structures_of_vtu()
        yield "m.mesh", self.structures_of_mesh()
        yield "m.msh", self.structures_of_msh()
        for name, reader in (("m.stl", vtk.vtkSTLReader()), ("m.ply", vtk.vtkPLYReader()), ("m.obj", vtk.vtkOBJReader()),
                             ("m.vtp", vtk.vtkXMLPolyDataReader())):
            surface = self.read(reader, name)
            self.states_lps(name, surface.GetFieldData() if name == "m.vtp" else None)
            centres = centres_of_parts(surface)
            self.assertEqual(len(centres), len(LANDMARKS), name)
            yield name, centres

    def farthest(self, centres):
        """How far the landmarks of a model are from those of the patient at most: each from its own, or of a surface from the nearest."""
        return np.linalg.norm(centres[:, None] - PLACES[None], axis=2).min(0).max()

    def test_O07_landmarks_are_where_they_were_in_ras(self):
        for name, axes in ORIENTATIONS.items():
            nibabel.save(label_map(axes), self.folder / "landmarks.nii.gz")
            self.run_program("model", "landmarks.nii.gz", "-o", "m.vtu", *sum((["--surface", f"m.{kind}"] for kind in ("stl", "ply", "obj", "vtp")), []))
            for kind in ("mesh", "msh"):
                self.run_program("convert", "m.vtu", "-o", f"m.{kind}")
            for file, centres in self.centres():
                with self.subTest(orientation=name, file=file):
                    turned = centres * TO_RAS
                    if file in ("m.vtu", "m.mesh", "m.msh"):  # they name the landmarks
                        self.assertLess(np.linalg.norm(turned - PLACES, axis=1).max(), SPACING.min())
                    self.assertLess(self.farthest(turned), SPACING.min())
                    # Turned in any other way they are elsewhere.
                    for signs in itertools.product((1, -1), repeat=3):
                        for order in itertools.permutations(range(3)):
                            if signs != (-1, -1, 1) or order != (0, 1, 2):
                                self.assertGreater(self.farthest(centres[:, order] * signs), 3 * SPACING.max(), (signs, order))

    def test_O07_contours_of_a_program_that_works_in_ras(self):
        """What such a program writes, and states or is said to be RAS, is modelled at the same places."""
        nibabel.save(label_map(ORIENTATIONS["tilted"]), self.folder / "landmarks.nii.gz")
        self.run_program("contours", "landmarks.nii.gz", "-o", "lps.json")
        document = json.loads((self.folder / "lps.json").read_text())
        self.assertEqual(document["space"], "LPS")

        def turned(point):
            return [float(x) for x in np.array(point) * TO_RAS]
        for each in document["slices"]:
            each["plane"] = {**each["plane"], "origin": turned(each["plane"]["origin"]), "normal": turned(each["plane"]["normal"])}
            for contour in each["contours"]:
                contour["points"] = [turned(point) for point in contour["points"]]
        for space, words in (("RAS", ()), ("unknown", ("--frame", "RAS"))):
            self.write("other.json", {**document, "space": space})
            self.run_program("model", "other.json", "-o", "m.vtu", *words)
            centres = self.structures_of_vtu() * TO_RAS
            self.assertLess(np.linalg.norm(centres - PLACES, axis=1).max(), SPACING.min(), space)


if __name__ == "__main__":
    harness.main(__name__)
