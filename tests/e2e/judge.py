"""Figures of a tetrahedral model recomputed from its file by VTK and numpy alone: no code of the program."""
import numpy as np
import vtk
from vtk.util.numpy_support import vtk_to_numpy

FACETS = np.array([[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]])  # outward for positive cells
EDGES = np.array([[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]])
FACET_PAIRS = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)]  # which meet in an edge each


def distinct(rows):
    """As numpy.unique of rows of vertex numbers, any order within a row: first index, group of each row, sizes."""
    rows = np.sort(rows, axis=1).astype(np.int64)
    span = int(rows.max()) + 1 if len(rows) else 1
    key = rows[:, 0]
    for column in range(1, rows.shape[1]):
        if int(key.max(initial=0)) + 1 > (2 ** 63 - 1) // span:
            key = np.unique(key, return_inverse=True)[1].astype(np.int64)
        key = key * span + rows[:, column]
    _, index, group, count = np.unique(key, return_index=True, return_inverse=True, return_counts=True)
    return index, group, count


def volumes(points, cells):
    a, b, c, d = (points[cells[:, i]] for i in range(4))
    return np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) / 6


def boundary(cells):
    """Facets with one of these positive cells on them, outward: (k, 3)."""
    facets = cells[:, FACETS].reshape(-1, 3)
    index, _, count = distinct(facets)
    assert count.max(initial=0) <= 2, "a facet in more than two cells"
    return facets[index[count == 1]]


def radius_edge(points, cells):
    a, b, c, d = (points[cells[:, i]] for i in range(4))
    b, c, d = b - a, c - a, d - a
    top = ((b ** 2).sum(1)[:, None] * np.cross(c, d) + (c ** 2).sum(1)[:, None] * np.cross(d, b)
           + (d ** 2).sum(1)[:, None] * np.cross(b, c))
    with np.errstate(divide="ignore", invalid="ignore"):
        radius = np.linalg.norm(top, axis=1) / (2 * np.abs(np.einsum("ij,ij->i", b, np.cross(c, d))))
    ends = points[cells[:, EDGES]]
    return radius / np.linalg.norm(ends[:, :, 0] - ends[:, :, 1], axis=2).min(1)


def smallest_dihedral(points, cells):
    """Of every cell, degrees."""
    corners = points[cells]
    normals = []
    for facet in FACETS:
        a, b, c = (corners[:, v] for v in facet)
        normal = np.cross(b - a, c - a)
        normals.append(normal / np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None])
    cosines = [-np.einsum("ij,ij->i", normals[i], normals[j]) for i, j in FACET_PAIRS]
    return np.degrees(np.arccos(np.clip(np.max(cosines, axis=0), -1, 1)))


class Model:
    """points (n, 3), cells (m, 4), structure (m,) of a .vtu file."""

    def __init__(self, path):
        reader = vtk.vtkXMLUnstructuredGridReader()
        reader.SetFileName(str(path))
        reader.Update()
        grid = reader.GetOutput()
        assert grid.GetNumberOfCells() > 0, f"{path}: no cells"
        assert (vtk_to_numpy(grid.GetCellTypesArray()) == vtk.VTK_TETRA).all()
        self.points = vtk_to_numpy(grid.GetPoints().GetData()).astype(float)
        self.cells = vtk_to_numpy(grid.GetCells().GetConnectivityArray()).astype(np.int64).reshape(-1, 4)
        self.structure = vtk_to_numpy(grid.GetCellData().GetArray("structure")).astype(np.int64)

    def volumes(self):
        return volumes(self.points, self.cells)

    def volume(self, number):
        return float(self.volumes()[self.structure == number].sum())

    def surface(self, chosen=None):
        """Outward facets with one chosen cell on them (all cells when None): (k, 3)."""
        return boundary(self.cells if chosen is None else self.cells[chosen])

    def radius_edge(self):
        return radius_edge(self.points, self.cells)


def description(path):
    """The lines that describe a .vtu file's model: structures, regions, notes."""
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(path))
    reader.Update()
    lines = reader.GetOutput().GetFieldData().GetAbstractArray("DESCRIPTION")
    return [lines.GetValue(n) for n in range(lines.GetNumberOfTuples())]


def topology(triangles):
    """Of a closed oriented surface: open and non-manifold edges and vertices, shells, genus."""
    edges = np.vstack([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    owner = np.tile(np.arange(len(triangles)), 3)
    key = np.sort(edges, axis=1)
    _, inverse, count = distinct(edges)
    figures = {"open_edges": int((count == 1).sum()), "nonmanifold_edges": int((count > 2).sum())}
    order = np.argsort(inverse, kind="stable")
    pairs = order[np.searchsorted(inverse[order], np.nonzero(count == 2)[0])[:, None] + [0, 1]]
    one, other = owner[pairs[:, 0]], owner[pairs[:, 1]]
    # The triangles round a vertex form one fan when the corners at it are joined across shared edges.
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components
    m = len(triangles)
    rows, cols = [], []
    for end in (0, 1):
        vertex = key[pairs[:, 0], end]
        first = (triangles[one] == vertex[:, None]).argmax(1) * m + one
        second = (triangles[other] == vertex[:, None]).argmax(1) * m + other
        rows.append(first)
        cols.append(second)
    rows, cols = np.concatenate(rows), np.concatenate(cols)
    _, fan = connected_components(coo_matrix((np.ones(len(rows)), (rows, cols)), shape=(3 * m, 3 * m)), directed=False)
    vertex_of_corner = triangles.T.reshape(-1)
    fans = np.unique(vertex_of_corner.astype(np.int64) * 3 * m + fan)
    _, fan_count = np.unique(fans // (3 * m), return_counts=True)
    figures["nonmanifold_vertices"] = int((fan_count > 1).sum())
    shells, _ = connected_components(coo_matrix((np.ones(len(one)), (one, other)), shape=(m, m)), directed=False)
    euler = len(np.unique(triangles)) - len(count) + m
    figures["shells"] = int(shells)
    figures["genus"] = int(shells - euler // 2)
    return figures


def share_on_surface(model, triangles, vertices):
    """Share of `vertices` that are vertices of the surface, coordinate for coordinate."""
    surface = {tuple(p) for p in model.points[np.unique(triangles)].tolist()}
    return sum(tuple(v) in surface for v in vertices.tolist()) / len(vertices)


def missing_segments(points, triangles, starts, ends):
    """How many of the segments are not chains of edges of the surface."""
    from scipy.spatial import cKDTree
    edges = np.sort(np.vstack([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1).astype(np.int64)
    known = set((edges[:, 0] << 32 | edges[:, 1]).tolist())
    used = np.unique(triangles)
    tree = cKDTree(points[used])
    missing = 0
    for start, end in zip(starts, ends):
        span = np.linalg.norm(end - start)
        along = (end - start) / span
        near = used[tree.query_ball_point((start + end) / 2, 0.5 * span * (1 + 1e-9))]
        offset = points[near] - start
        place = offset @ along
        on = np.linalg.norm(offset - place[:, None] * along, axis=1) < 1e-6 * span
        chain = near[on][np.argsort(place[on])].astype(np.int64)
        low, high = np.minimum(chain[:-1], chain[1:]), np.maximum(chain[:-1], chain[1:])
        whole = len(chain) > 1 and (points[chain[0]] == start).all() and (points[chain[-1]] == end).all()
        missing += not whole or not all(edge in known for edge in (low << 32 | high).tolist())
    return missing
