"""Planes in any position through a head whose surface is known: the skin of the CT skull, cut by a fan and about an axis."""
import gzip
import pathlib
import tempfile
import unittest

import numpy as np
from scipy import ndimage
from scipy.spatial import cKDTree

import harness
import judge

SKIN = ["--threshold", "-300", "--open", "2", "--keep-largest", "1", "--close", "8", "--fill-holes"]
SPACING = np.array([0.9570312, 0.9570312, 1.5])


def read_mask(path):
    """The voxels of a gzipped NRRD label map as an array [x, y, z]; rows run from the front to the back in the file."""
    content = pathlib.Path(path).read_bytes()
    end = content.index(b"\n\n")
    sizes = next(line for line in content[:end].decode().splitlines() if line.startswith("sizes:"))
    sizes = [int(word) for word in sizes.split()[1:]]
    return np.frombuffer(gzip.decompress(content[end + 2:]), np.uint8).reshape(sizes[::-1]).transpose(2, 1, 0) != 0


class Truth:
    """The smoothed distance to a mask's boundary, about its centre; the truth is where it vanishes."""

    def __init__(self, mask):
        mask = np.pad(mask, 8)
        distance = (ndimage.distance_transform_edt(~mask, sampling=SPACING)
                    - ndimage.distance_transform_edt(mask, sampling=SPACING))
        self.field = ndimage.gaussian_filter(distance, [1.5, 1.5, 1.0])
        low, high = (np.argwhere(self.field < 0).min(axis=0), np.argwhere(self.field < 0).max(axis=0))
        self.centre = 0.5 * (low + high) * SPACING
        self.radius = 0.5 * np.linalg.norm((high - low) * SPACING)

    def value(self, points):
        return ndimage.map_coordinates(self.field, ((np.asarray(points) + self.centre) / SPACING).T, order=1, mode="nearest")

    def slope(self, points, h=0.3):
        steps = h * np.eye(3)
        return np.stack([(self.value(points + e) - self.value(points - e)) / (2 * h) for e in steps], axis=1)

    def onto(self, points):
        """The points moved along the slope onto the surface."""
        for _ in range(8):
            slope = self.slope(points)
            points = points - (self.value(points) / np.maximum((slope ** 2).sum(axis=1), 0.05))[:, None] * slope
        return points

    def surface(self, count):
        """Points spread over the surface."""
        box = self.radius * np.random.default_rng(1).uniform(-1, 1, (40 * count, 3))
        points = self.onto(box[np.abs(self.value(box)) < 1.5])
        return points[np.abs(self.value(points)) < 0.02][:count]

    def loops(self, origin, normal, spacing):
        """The polygons in which a plane cuts the surface, vertices on it."""
        import vtk
        from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy
        u = np.cross(normal, np.eye(3)[np.abs(normal).argmin()])
        u /= np.linalg.norm(u)
        v = np.cross(normal, u)
        origin = origin - (origin @ u) * u - (origin @ v) * v
        grid = np.arange(-self.radius, self.radius + 1, 1.0)
        x, y = np.meshgrid(grid, grid)
        image = vtk.vtkImageData()
        image.SetDimensions(len(grid), len(grid), 1)
        points = origin + x.ravel()[:, None] * u + y.ravel()[:, None] * v
        image.GetPointData().SetScalars(numpy_to_vtk(self.value(points), deep=True))
        contour, joined = vtk.vtkContourFilter(), vtk.vtkStripper()
        contour.SetInputData(image)
        contour.SetValue(0, 0.0)
        joined.SetInputConnection(contour.GetOutputPort())
        joined.JoinContiguousSegmentsOn()
        joined.SetMaximumLength(100_000)
        joined.Update()
        lines = joined.GetOutput()
        for k in range(lines.GetNumberOfCells()):
            ids = lines.GetCell(k).GetPointIds()
            at = vtk_to_numpy(lines.GetPoints().GetData())[[ids.GetId(i) for i in range(ids.GetNumberOfIds())], :2]
            at = at.astype(float) - self.radius
            if len(at) < 12 or np.linalg.norm(at[0] - at[-1]) > 1e-4:
                continue
            kept = [0]
            for i in range(1, len(at)):
                if min(np.linalg.norm(at[i] - at[kept[-1]]), np.linalg.norm(at[i] - at[0])) > spacing:
                    kept.append(i)
            yield origin + at[kept, :1] * u + at[kept, 1:] * v


def write_csl(path, slices):
    lines = [f"CSLC\n{len(slices)} 1\n"]
    for number, (origin, normal, loops) in enumerate(slices, 1):
        plane = " ".join(repr(float(x)) for x in (*normal, -origin @ normal))
        lines.append(f"{number} {sum(map(len, loops))} {len(loops)} {plane}\n")
        lines += [" ".join(repr(float(x)) for x in p) for loop in loops for p in loop]
        lines.append("")
        first = 0
        for loop in loops:
            lines.append(" ".join(map(str, [len(loop), 1, *range(first, first + len(loop))])))
            first += len(loop)
        lines.append("")
    pathlib.Path(path).write_text("\n".join(lines))


def fan(count):
    for angle in np.radians(np.linspace(-45, 45, count)):
        yield np.array([0.0, 0.0, -120.0]), np.array([np.cos(angle), 0.0, -np.sin(angle)])


def about_an_axis(count):
    for angle in np.pi * np.arange(count) / count:
        yield np.zeros(3), np.array([np.cos(angle), np.sin(angle), 0.0])


def within_the_fan(points):
    return np.abs(np.arctan2(points[:, 0], points[:, 2] + 120)) <= np.pi / 4


class Head(harness.TestCase):
    """36 planes: every contour vertex on a closed surface; from the truth 0.5 mm in the mean, 1.5 mm at 95 %, both ways."""

    @classmethod
    def setUpClass(cls):
        path = harness.skull()
        with tempfile.TemporaryDirectory(prefix="anatomesh-skin-") as folder:
            mask = pathlib.Path(folder, "skin.nrrd")
            made = harness.run_program("segment", path, *SKIN, "-o", mask, "--quiet")
            assert made.code == 0, made.err
            cls.truth = Truth(read_mask(mask))

    def kept_vertices(self):
        import vtk
        from vtk.util.numpy_support import vtk_to_numpy
        reader = vtk.vtkXMLPolyDataReader()
        reader.SetFileName(str(self.folder / "kept.vtp"))
        reader.Update()
        return vtk_to_numpy(reader.GetOutput().GetPoints().GetData()).astype(float)

    def check(self, planes, within):
        slices = []
        for origin, normal in planes:
            loops = list(self.truth.loops(origin, normal, 1.5))
            if loops:
                slices.append((origin, normal, loops))
        write_csl(self.folder / "cuts.csl", slices)
        self.run_program("model", "cuts.csl", "-o", "model.vtu", "--contours", "kept.vtp", "--frame", "LPS", "--threads", "2")
        model = judge.Model(self.folder / "model.vtu")
        triangles = model.surface()
        state = judge.topology(triangles)
        self.assertEqual([state[name] for name in ("open_edges", "nonmanifold_edges", "nonmanifold_vertices")], [0, 0, 0])

        kept = self.kept_vertices()
        self.assertEqual(judge.share_on_surface(model, triangles, kept), 1)
        drawn = np.concatenate([loop for _, _, loops in slices for loop in loops])
        self.assertLess(cKDTree(kept).query(drawn)[0].max(), 0.2, "the planes agree but for the linear interpolation")

        corners = model.points[triangles]
        bary = np.random.default_rng(2).dirichlet([1, 1, 1], (8, len(corners)))
        samples = np.einsum("ktc,tcx->ktx", bary, corners).reshape(-1, 3)
        truth = self.truth.surface(10_000)
        truth = truth[within(truth)]
        to_model = cKDTree(samples).query(truth)[0]
        areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
        chosen = np.random.default_rng(3).choice(len(corners), 10_000, p=areas / areas.sum())
        spots = np.einsum("tc,tcx->tx", bary[0][chosen], corners[chosen])
        spots = spots[within(spots)]
        to_truth = np.linalg.norm(self.truth.onto(spots) - spots, axis=1)
        for name, errors in (("truth to model", to_model), ("model to truth", to_truth)):
            print(f"{name}: mean {errors.mean():.2f} mm, 95 % {np.percentile(errors, 95):.2f} mm")
            self.assertLessEqual(errors.mean(), 0.5, name)
            self.assertLessEqual(np.percentile(errors, 95), 1.5, name)

    def test_fan(self):
        self.check(fan(36), within_the_fan)

    def test_about_an_axis(self):
        self.check(about_an_axis(36), lambda points: np.ones(len(points), bool))


if __name__ == "__main__":
    harness.main(__name__)
