"""Models made for simulation: quadratic elements, grey values, materials, and what CalculiX makes of them."""
import json
import math
import re
import xml.etree.ElementTree as ElementTree

import numpy as np

import ccx
import harness
import images
import shapes

BONE = ["--threshold", "226", "--keep-largest", "1"]


def every_displacement(results, count):
    rows = results["displacements", "ALL"]
    displacements = np.zeros((count, 3))
    displacements[rows[:, 0].astype(int) - 1] = rows[:, 1:]
    return displacements


class PatchTest(harness.TestCase):
    """A linear displacement on the boundary of two nested balls gives it everywhere, and one stress."""

    GRADIENT = np.array([[2e-3, 5e-4, -3e-4], [1e-4, -1e-3, 7e-4], [4e-4, -2e-4, 1.5e-3]])

    def check(self, model, tolerance):
        deck = ccx.Deck(self.folder / model)
        boundary = np.unique(deck.faces("SURFACE_STRUCTURE_1"))
        self.assertEqual(sorted(deck.node_sets["NODES_INTERFACE_1_0"]), list(boundary))
        exact = deck.nodes @ self.GRADIENT.T
        lines = [*ccx.elastic("REGION_1"), *ccx.elastic("REGION_2", name="THE_SAME"), "*STEP", "*STATIC", "*BOUNDARY"]
        lines += [f"{n + 1}, {k + 1}, {k + 1}, {exact[n, k]:.15f}" for n in boundary for k in range(3)]
        lines += ["*NODE PRINT, NSET=ALL", "U", "*EL PRINT, ELSET=STRUCTURE_1", "S", "*END STEP"]
        results = ccx.solve(self.folder, deck, "patch", lines)
        inner = np.setdiff1d(np.arange(len(deck.nodes)), boundary)
        self.assertGreater(len(inner), 300)
        error = np.abs(every_displacement(results, len(deck.nodes)) - exact)[inner].max()
        self.assertLess(error, tolerance * np.abs(exact).max())
        strain = (self.GRADIENT + self.GRADIENT.T) / 2
        lame, shear = 1000 * 0.3 / (1.3 * 0.4), 1000 / 2.6
        stress = 2 * shear * strain + lame * np.trace(strain) * np.eye(3)
        wanted = np.array([stress[0, 0], stress[1, 1], stress[2, 2], stress[0, 1], stress[0, 2], stress[1, 2]])
        computed = results["stresses", "STRUCTURE_1"][:, 2:]
        self.assertLess(np.abs(computed - wanted).max(), 5 * tolerance * np.abs(wanted).max())

    def test_O02_linear_quadratic_and_bent_elements(self):
        ccx.program()
        outer, inner = shapes.sphere(10, 2.5), shapes.sphere(5, 2.5)
        drawn = shapes.Shape({1: "ball", 2: "core"}, 2.5)
        for (z, polygons), core in zip(outer.slices, [[]] * 2 + [p for _, p in inner.slices] + [[]] * 2):
            drawn.add_slice(z, polygons + [(2, points) for _, points in core])
        self.write("balls.json", drawn.document())
        self.run_program("model", "balls.json", "-o", "linear.inp")
        self.run_program("convert", "linear.inp", "--order", "2", "-o", "quadratic.inp")
        self.run_program("model", "balls.json", "-o", "bent.inp", "--order", "2")
        self.check("linear.inp", 1e-5)
        self.check("quadratic.inp", 1e-5)
        # Four integration points are not exact in bent elements.
        self.check("bent.inp", 2e-3)


class PressurisedSphere(harness.TestCase):
    """Lame's thick sphere under internal pressure: an octant with its three planes of symmetry."""

    INNER, OUTER, PRESSURE, YOUNG, POISSON = 15.0, 30.0, 10.0, 1000.0, 0.3

    def arc(self, radius, spacing):
        """A quarter of a polygon with the area of the circle."""
        angles = np.linspace(0, math.pi / 2, max(3, int(round(radius * math.pi / 2 / spacing)) + 1))
        reach = radius * math.sqrt(angles[1] / math.sin(angles[1]))
        points = reach * np.c_[np.cos(angles), np.sin(angles)]
        points[0, 1] = points[-1, 0] = 0
        return points

    def octant(self, spacing):
        """Quarter rings on planes from z = 0 up, one near the pole of each sphere."""
        shape = shapes.Shape({1: "sphere"}, spacing)
        heights = [spacing * i for i in range(int(round(self.OUTER / spacing)) + 1)]
        heights = [0.995 * z if z in (self.INNER, self.OUTER) else z for z in heights]
        for z in heights:
            outer = math.sqrt(self.OUTER ** 2 - z ** 2)
            outline = self.arc(outer, spacing)
            if z < self.INNER:
                hole = self.arc(math.sqrt(self.INNER ** 2 - z ** 2), spacing)[::-1]
                steps = max(2, int(round((outer - hole[0, 1]) / spacing)) + 1)
                left = np.c_[np.zeros(steps), np.linspace(outline[-1, 1], hole[0, 1], steps)][1:-1]
                bottom = np.c_[np.linspace(hole[-1, 0], outline[0, 0], steps), np.zeros(steps)][1:-1]
                outline = np.vstack([outline, left, hole, bottom])
            else:
                steps = max(2, int(round(outer / spacing)) + 1)
                left = np.c_[np.zeros(steps), np.linspace(outline[-1, 1], 0, steps)][1:]
                bottom = np.c_[np.linspace(0, outline[0, 0], steps), np.zeros(steps)][1:-1]
                outline = np.vstack([outline, left, bottom])
            shape.add_slice(z, [(1, outline)])
        return shape

    def radial_displacement(self, r):
        a, b, p, young, poisson = self.INNER, self.OUTER, self.PRESSURE, self.YOUNG, self.POISSON
        return p * a ** 3 / (young * (b ** 3 - a ** 3)) * ((1 - 2 * poisson) * r + (1 + poisson) * b ** 3 / (2 * r ** 2))

    def errors(self, model):
        deck = ccx.Deck(self.folder / model)
        corners = deck.nodes[deck.faces("INTERFACE_1_0")[:, :3]]
        middle = corners.mean(1)
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normal /= np.linalg.norm(normal, axis=1)[:, None]
        radius = np.linalg.norm(middle, axis=1)
        inside = (radius < 0.5 * (self.INNER + self.OUTER)) & (np.einsum("ij,ij->i", normal, middle) < -0.2 * radius)
        surface = [deck.surfaces["INTERFACE_1_0"][i] for i in np.flatnonzero(inside)]
        lines = [*ccx.elastic("STRUCTURE_1", self.YOUNG, self.POISSON), "*STEP", "*STATIC", "*BOUNDARY"]
        # The cut planes of the model are flat within hundredths of a millimetre.
        boundary = np.unique(deck.faces("INTERFACE_1_0"))
        for k in range(3):
            lines += [f"{n + 1}, {k + 1}, {k + 1}" for n in boundary[np.abs(deck.nodes[boundary, k]) < 0.4]]
        lines += ccx.pressure_lines(surface, self.PRESSURE)
        lines += ["*NODE PRINT, NSET=ALL", "U", "*END STEP"]
        results = ccx.solve(self.folder, deck, "sphere", lines)
        displacements = every_displacement(results, len(deck.nodes))
        r = np.linalg.norm(deck.nodes, axis=1)
        along = np.einsum("ij,ij->i", displacements, deck.nodes) / np.maximum(r, 1e-9)
        exact = self.radial_displacement(r)
        inner_nodes = np.unique(deck.faces("INTERFACE_1_0")[inside])
        return {"inner": (along[inner_nodes] / exact[inner_nodes]).mean() - 1,
                "all": np.sqrt(((along - exact) ** 2).mean() / (exact ** 2).mean()), "nodes": len(r)}

    def test_against_the_formula(self):
        ccx.program()
        self.write("octant.json", self.octant(2.0).document())
        common = ["model", "octant.json", "--caps", "flat"]
        self.run_program(*common, "-o", "linear.inp")
        self.run_program(*common, "-o", "bent.inp", "--order", "2")
        linear, bent = self.errors("linear.inp"), self.errors("bent.inp")
        self.assertLess(abs(linear["inner"]), 0.02)
        self.assertLess(abs(bent["inner"]), 0.006)
        self.assertLess(linear["all"], 0.02)
        self.assertLess(bent["all"], 0.009)


class SkullUnderLoad(harness.TestCase):
    """A force on the crown of the CT skull that stands on its base, with linear and quadratic elements of three sizes."""

    FORCE = 100.0
    YOUNG = 12000.0

    def energy(self, size, order="1"):
        """Strain energy and number of elements; reactions balance the force, and energies agree."""
        self.run_program("model", harness.skull(), *BONE, "--every", "6", "--epsilon", "1", "--size", size,
                         "--order", order, "-o", "skull.inp")
        deck = ccx.Deck(self.folder / "skull.inp")
        z = deck.nodes[:, 2]
        low, high = z.min(), z.max()
        faces = deck.faces("INTERFACE_1_0")
        top = faces[(deck.nodes[faces[:, :3], 2].mean(1) > high - 0.1 * (high - low))]
        forces = ccx.traction_forces(deck.nodes, top, [0, 0, -1.0])
        forces *= self.FORCE / -forces[:, 2].sum()
        fixed = np.flatnonzero(z < low + 0.05 * (high - low))
        lines = ["*NSET, NSET=FIXED", *(f"{n + 1}," for n in fixed), *ccx.elastic("STRUCTURE_1", self.YOUNG), "*STEP", "*STATIC",
                 "*BOUNDARY", "FIXED, 1, 3", *ccx.load_lines(forces), "*NODE PRINT, NSET=ALL", "U",
                 "*NODE PRINT, NSET=FIXED, TOTALS=ONLY", "RF", "*EL PRINT, ELSET=STRUCTURE_1, TOTALS=ONLY", "ELSE", "*END STEP"]
        results = ccx.solve(self.folder, deck, "load", lines)
        displacements = every_displacement(results, len(deck.nodes))
        work = 0.5 * (forces * displacements).sum()
        reaction = results["total force", "FIXED"][0]
        self.assertLess(np.abs(reaction - [0, 0, self.FORCE]).max(), 1e-6 * self.FORCE)
        self.assertAlmostEqual(results["total internal energy", "STRUCTURE_1"][0, 0] / work, 1, delta=1e-6)
        return work, len(deck.elements)

    def test_reactions_balance_and_energy_converges(self):
        ccx.program()
        harness.skull()
        (coarse, n0), (middle, n1), (fine, n2) = (self.energy(size) for size in ("12", "8", "6"))
        self.assertTrue(n0 < n1 < n2, (n0, n1, n2))
        # Elements of finite size are too stiff: the work of the force grows towards its limit. In thin bone linear ones are
        # far from it; quadratic ones have converged: those of three sizes agree, beyond the linear ones.
        self.assertLess(coarse, middle)
        self.assertLess(middle, fine)
        bent, counts = zip(*(self.energy(size, "2") for size in ("12", "10", "8")))
        self.assertTrue(counts[0] < counts[1] < counts[2], counts)
        self.assertLess(fine, min(bent))
        self.assertLess(max(bent), 1.03 * min(bent))


VTK_EDGES = [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)]


def read_grid(path):
    """Points, cells, and cell arrays of a .vtu of linear or quadratic tetrahedra, by VTK."""
    import vtk
    from vtk.util.numpy_support import vtk_to_numpy
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(path))
    reader.Update()
    grid = reader.GetOutput()
    types = set(vtk_to_numpy(grid.GetCellTypesArray()).tolist())
    cells = vtk_to_numpy(grid.GetCells().GetConnectivityArray()).reshape(-1, 4 if types == {10} else 10)
    data = grid.GetCellData()
    arrays = {data.GetArrayName(i): vtk_to_numpy(data.GetArray(i)) for i in range(data.GetNumberOfArrays())}
    return vtk_to_numpy(grid.GetPoints().GetData()), cells, arrays


def jacobians(points, cells, barycentric):
    """The Jacobian determinant of every quadratic element at one place, over that of the straight element."""
    l = np.asarray(barycentric)
    gradient = np.zeros((10, 3))  # of the shape functions, by the last three coordinates
    for i in range(4):
        step = np.eye(4)[i, 1:] - (i == 0)
        gradient[i] = (4 * l[i] - 1) * step
    for n, (a, b) in enumerate(VTK_EDGES):
        gradient[4 + n] = 4 * (l[b] * (np.eye(4)[a, 1:] - (a == 0)) + l[a] * (np.eye(4)[b, 1:] - (b == 0)))
    bent = np.linalg.det(np.einsum("cnx,nk->cxk", points[cells], gradient))
    corners = points[cells[:, :4]]
    return bent / np.linalg.det(np.stack([corners[:, k] - corners[:, 0] for k in (1, 2, 3)], 2))


class Elements(harness.TestCase):
    def test_quadratic_elements(self):
        shape = shapes.sphere(15, 3)
        self.write("ball.json", shape.document())
        self.run_program("model", "ball.json", "-o", "ball.vtu", "--order", "2")
        self.run_program("model", "ball.json", "-o", "linear.vtu")
        points, cells, _ = read_grid(self.folder / "ball.vtu")
        straight, corners, _ = read_grid(self.folder / "linear.vtu")
        self.assertEqual(cells.shape[1], 10)
        self.assertTrue((cells[:, :4] == corners).all() and (points[:len(straight)] == straight).all())
        random = np.random.default_rng(1)
        for barycentric in [*np.eye(4), *random.dirichlet(np.ones(4), 60)]:
            self.assertGreater(jacobians(points, cells, barycentric).min(), 0.199)
        # Nodes of the surface that left their middles are nearer to the ball than those were (but for its flat caps).
        middles = np.stack([points[cells[:, [a, b]]].mean(1) for a, b in VTK_EDGES], 1).reshape(-1, 3)
        nodes = points[cells[:, 4:]].reshape(-1, 3)
        moved = np.linalg.norm(nodes - middles, axis=1) > 1e-9
        self.assertGreater(moved.sum(), 1000)
        off = lambda p: np.median(np.abs(np.linalg.norm(p[moved], axis=1) - 15))
        self.assertLess(off(nodes), 0.8 * off(middles))
        report = json.loads((self.folder / "ball.report.json").read_text())
        stage, = [stage for stage in report["stages"] if stage["name"] == "element"]
        self.assertEqual(stage["figures"]["mid_nodes"], len(points) - len(straight))
        self.assertGreaterEqual(stage["figures"]["least_jacobian"], 0.2)
        self.assertEqual(report["options"]["order"], "2")
        self.run_program("check", "ball.vtu")

    def test_convert_between_orders_and_formats(self):
        self.write("ball.json", shapes.sphere(10, 2.5).document())
        self.run_program("model", "ball.json", "-o", "ball.vtu", "--order", "2")
        for name in ("ball.msh", "ball.inp"):
            self.run_program("convert", "ball.vtu", "-o", name)
            self.run_program("convert", name, "-o", "back.vtu")
            self.assertEqual((self.folder / "back.vtu").read_bytes(), (self.folder / "ball.vtu").read_bytes(), name)
        self.run_program("convert", "ball.vtu", "-o", "ball.feb", "--quiet")
        self.assertEqual(ElementTree.parse(self.folder / "ball.feb").getroot().find("Mesh/Elements").get("type"), "tet10")
        self.run_program("convert", "ball.vtu", "-o", "linear.vtu", "--order", "1")
        self.run_program("convert", "linear.vtu", "-o", "straight.vtu", "--order", "2")
        points, cells, _ = read_grid(self.folder / "straight.vtu")
        middles = np.stack([points[cells[:, [a, b]]].mean(1) for a, b in VTK_EDGES], 1)
        self.assertTrue(np.allclose(points[cells[:, 4:]], middles, rtol=0, atol=1e-12))
        self.assert_refused(["convert", "ball.vtu", "-o", "ball.mesh"], 2, "E-MDL-014")
        self.assert_refused(["convert", "linear.vtu", "-o", "x.mesh", "--order", "2"], 2, "E-MDL-014")
        self.assert_refused(["convert", "ball.vtu", "-o", "x.stl", "--order", "2"], 2, "E-CMD-008")
        self.assert_refused(["model", "ball.json", "-o", "x.mesh", "--order", "2"], 2, "E-MDL-014")
        self.assert_refused(["model", "ball.json", "-o", "x.vtu", "--order", "3"], 2, "--order")

    def image(self):
        """A ball of 12 mm in a grey image whose values rise along x in it."""
        grid = np.stack(np.meshgrid(*[np.arange(40) - 19.5] * 3, indexing="ij"), -1)
        inside = np.linalg.norm(grid, axis=-1) < 12
        values = np.where(inside, 500 + 10 * grid[..., 0], -1000).astype(np.int16)
        images.write_nrrd(self.folder / "ct.nrrd", values, (1, 1, 1), (-19.5, -19.5, -19.5))

    def test_a_law_applies_to_the_structure_that_name_gives(self):
        """The law file of the page: without --name it names nothing, and the model would be of 1 MPa."""
        self.image()
        laws = [{"structure": "bone", "table": [[-100, 50], [1000, 900]]}, {"young_mpa": 1}]
        self.write("bone.json", {"format": "anatomesh-material", "version": 1, "laws": laws})
        model = ["model", "ct.nrrd", "--threshold", "200", "-o", "ball.vtu", "--material", "bone.json"]
        self.assert_refused(model, 3, "E-MAT-004", "threshold 200", "--name", outputs=["ball.vtu"])
        # Before the mesh is made: nothing is said of cells.
        self.assert_refused([*model[:-1], "ct.nrrd", "--size", "0.01"], 3, "E-MAT-001")
        for table, wanted in (([[5, -1]], "moduli are above 0"), ([[5, 1], [4, 1]], "grey values rise")):
            self.write("wrong.json", {"format": "anatomesh-material", "version": 1, "laws": [{"table": table}]})
            self.assert_refused([*model[:-1], "wrong.json", "--size", "0.01"], 3, "E-MAT-002", wanted)
        result = self.run_program(*model, "--name", "bone")
        self.assertRegex(result.out, r"material of bone: \d+ materials?, [\d.]+ mm3, E [\d.]+ to [\d.]+ MPa")
        low, high = map(float, re.search(r"E ([\d.]+) to ([\d.]+) MPa", result.out).groups())
        self.assertGreater(low, 50)
        self.assertLess(high, 900)
        report = json.loads((self.folder / "ball.report.json").read_text())
        self.assertEqual([s["name"] for s in report["structures"]], ["bone"])

    def test_grey_values_and_materials(self):
        self.image()
        law = {"table": [[0, 100], [1000, 1100]], "bins": 8, "density_g_cm3": 1.5}
        self.write("law.json", {"format": "anatomesh-material", "version": 1, "laws": [law]})
        self.run_program("model", "ct.nrrd", "--threshold", "200", "-o", "ball.vtu", "--material", "law.json")
        points, cells, arrays = read_grid(self.folder / "ball.vtu")
        centroids = points[cells].mean(1)
        deep = np.linalg.norm(points[cells], axis=2).max(1) < 10
        self.assertGreater(deep.sum(), 100)
        self.assertTrue(np.allclose(arrays["grey"][deep], 500 + 10 * centroids[deep, 0], rtol=0, atol=1e-3))
        self.assertLessEqual(arrays["material"].max(), 8)
        young = 100 + np.clip(arrays["grey"], 0, 1000)
        width = (young.max() - young.min()) / 8
        self.assertLess(np.abs(arrays["young_mpa"] - young).max(), 1.001 * width)
        report = json.loads((self.folder / "ball.report.json").read_text())
        self.assertEqual([stage["name"] for stage in report["stages"]][-2:], ["grey", "material"])
        self.assertIn("law.json", [entry["file"] for entry in report["inputs"]])
        # The same by `convert`, and in a deck.
        self.run_program("model", "ct.nrrd", "--threshold", "200", "-o", "plain.vtu")
        self.run_program("convert", "plain.vtu", "-o", "again.vtu", "--grey", "ct.nrrd", "--material", "law.json")
        again = read_grid(self.folder / "again.vtu")[2]
        self.assertTrue((again["grey"] == arrays["grey"]).all() and (again["material"] == arrays["material"]).all())
        self.run_program("convert", "again.vtu", "-o", "ball.inp")
        deck = ccx.Deck(self.folder / "ball.inp")
        for number in set(arrays["material"].tolist()):
            self.assertEqual(sorted(deck.sets[f"MATERIAL_{number}"]), list(np.flatnonzero(arrays["material"] == number)))
        text = (self.folder / "ball.inp").read_text()
        self.assertEqual(text.count("*SOLID SECTION"), len(set(arrays["material"].tolist())))
        self.assertEqual(text.count("*DENSITY\n1.5"), text.count("*MATERIAL"))

    def test_what_is_missing_is_said(self):
        self.image()
        self.write("ball.json", shapes.sphere(10, 2.5).document())
        self.write("law.json", {"format": "anatomesh-material", "version": 1, "laws": [{"table": [[0, 1], [9, 5]]}]})
        self.write("other.json", {"format": "anatomesh-material", "version": 1, "laws": [{"structure": 99, "young_mpa": 1}]})
        model = ["model", "ball.json", "-o", "x.vtu"]
        self.assert_refused([*model, "--material", "law.json"], 2, "E-CMD-008", "--grey")
        self.assert_refused([*model, "--material", "ball.json"], 3, "E-MAT-001")
        self.assert_refused([*model, "--material", "other.json"], 3, "E-MAT-004")
        self.assert_refused([*model, "--grey", "ball.json"], 3, "E-CMD-012")
        self.assert_refused([*model, "--grey", "none.nrrd"], 6, "none.nrrd")
        far = shapes.sphere(10, 2.5).document(lambda p: (p[0] + 500, p[1], p[2]))
        self.write("far.json", far)
        self.assert_refused(["model", "far.json", "-o", "x.vtu", "--grey", "ct.nrrd"], 4, "E-ELM-001")


if __name__ == "__main__":
    harness.main(__name__)
