#!/usr/bin/python3
"""interfaces.py MODEL.vtu STEM

The interfaces between the regions of a model, as the meshers that start from a surface take them: STEM.poly for TetGen, STEM.geo and
STEM.msh for Gmsh, STEM.npz for netgen_mesher.py, and STEM.json, which says the regions of the pieces and the structures of the regions.
A piece is what cells of one region make up that facets connect.
"""
import dataclasses
import json
import pathlib
import sys

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

import measuring
from measuring import judge


@dataclasses.dataclass
class Interfaces:
    points: np.ndarray     # (n, 3)
    triangles: np.ndarray  # (m, 3), seen from region `outer` counter-clockwise
    inner: np.ndarray      # (m,) region behind the triangle
    outer: np.ndarray      # (m,) region before it, 0: outside
    pieces: np.ndarray     # (m, 2) the piece of the inner and of the outer region, -1: outside
    shells: np.ndarray     # (m,) connected by edges that two triangles and no more share: the same two spaces lie beside them
    seeds: list            # [(point, region)] of every piece, in their order
    cavities: list         # points, one in every empty space that the model encloses


def _groups(pairs, count):
    """Group of each of `count` things of which `pairs` belong together."""
    return connected_components(coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(count, count)),
                                directed=False)[1]


def _neighbours(group):
    """Pairs of places that hold the same number, of numbers that occur at most twice: (k, 2); the others alone: (l,)."""
    order = np.argsort(group, kind="stable")
    same = np.nonzero(group[order][1:] == group[order][:-1])[0]
    pairs = np.c_[order[same], order[same + 1]]
    alone = np.ones(len(group), dtype=bool)
    alone[pairs.reshape(-1)] = False
    return pairs, np.nonzero(alone)[0]


def _shells(triangles):
    """Of every triangle its shell, and the shells that have a rim."""
    edges = np.vstack([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    owner = np.tile(np.arange(len(triangles)), 3)
    _, group, count = judge.distinct(edges)
    twice = np.nonzero(count[group] == 2)[0]
    pairs, _ = _neighbours(group[twice])
    shells = _groups(owner[twice[pairs]], len(triangles))
    return shells, np.unique(shells[owner[count[group] != 2]])


def _cavities(points, triangles, outer, shells, with_rim):
    """Before the largest triangle of every closed shell that turns its outside inwards, a hair off it. A cavity that touches something
    else has none; what a mesher puts into it is no part of its model."""
    a, b, c = (points[triangles[:, i]] for i in range(3))
    normal = np.cross(b - a, c - a)
    volume = np.einsum("ij,ij->i", a - points.mean(axis=0), normal)
    inwards = np.bincount(shells, weights=volume) < 0
    area = np.linalg.norm(normal, axis=1)
    found = []
    for shell in np.setdiff1d(shells[outer == 0], with_rim):
        if not inwards[shell]:
            continue
        largest = max(np.nonzero(shells == shell)[0], key=lambda triangle: area[triangle])
        hair = 1e-3 * np.sqrt(area[largest])
        found.append((a + b + c)[largest] / 3 + hair * normal[largest] / area[largest])
    return found


def of_model(model):
    facets = model.cells[:, judge.FACETS].reshape(-1, 3)
    cell = np.repeat(np.arange(len(model.cells)), 4)
    _, group, _ = judge.distinct(facets)
    pairs, alone = _neighbours(group)
    region = model.regions
    inside = region[cell[pairs[:, 0]]] == region[cell[pairs[:, 1]]]
    piece = _groups(cell[pairs[inside]], len(model.cells))
    between = pairs[~inside]
    kept = np.concatenate([alone, between[:, 0]])
    behind = cell[kept]
    before = np.concatenate([np.full(len(alone), -1), cell[between[:, 1]]])
    pieces = np.c_[piece[behind], np.where(before < 0, -1, piece[before])]
    used, triangles = np.unique(facets[kept], return_inverse=True)
    triangles = triangles.reshape(-1, 3)
    points = model.points[used]
    outer = np.where(before < 0, 0, region[before])
    # Of every piece the middle of its largest cell.
    volume = judge.volumes(model.points, model.cells)
    order = np.lexsort((-volume, piece))
    first = order[np.unique(piece[order], return_index=True)[1]]
    seeds = [(model.points[model.cells[at]].mean(axis=0), int(region[at])) for at in first]
    shells, with_rim = _shells(triangles)
    return Interfaces(points, triangles, region[behind], outer, pieces, shells, seeds,
                      _cavities(points, triangles, outer, shells, with_rim))


def write_poly(path, faces):
    """For TetGen: facets, a hole in every cavity, a region attribute for every piece."""
    with open(path, "w") as out:
        out.write(f"{len(faces.points)} 3 0 0\n")
        out.writelines(f"{i} {x!r} {y!r} {z!r}\n" for i, (x, y, z) in enumerate(faces.points.tolist(), 1))
        out.write(f"{len(faces.triangles)} 0\n")
        out.writelines(f"1\n3 {a + 1} {b + 1} {c + 1}\n" for a, b, c in faces.triangles.tolist())
        out.write(f"{len(faces.cavities)}\n")
        out.writelines(f"{i} {x!r} {y!r} {z!r}\n" for i, (x, y, z) in enumerate(map(tuple, np.asarray(faces.cavities).tolist()), 1))
        out.write(f"{len(faces.seeds)}\n")
        out.writelines(f"{i} {p[0]!r} {p[1]!r} {p[2]!r} {region}\n"
                       for i, (p, region) in enumerate(((list(map(float, p)), r) for p, r in faces.seeds), 1))


def write_gmsh(geometry, mesh, faces):
    """A surface for every shell, numbered from 1, and a volume for every piece: HXT tells them apart by their surfaces."""
    with open(mesh, "w") as out:
        out.write(f"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{len(faces.points)}\n")
        out.writelines(f"{i} {x!r} {y!r} {z!r}\n" for i, (x, y, z) in enumerate(faces.points.tolist(), 1))
        out.write(f"$EndNodes\n$Elements\n{len(faces.triangles)}\n")
        out.writelines(f"{i} 2 2 0 {shell + 1} {a + 1} {b + 1} {c + 1}\n" for i, (shell, (a, b, c))
                       in enumerate(zip(faces.shells.tolist(), faces.triangles.tolist()), 1))
        out.write("$EndElements\n")
    around = {}
    for column in (0, 1):
        for piece, shell in zip(faces.pieces[:, column].tolist(), faces.shells.tolist()):
            if piece >= 0:
                around.setdefault(piece, set()).add(shell + 1)
    with open(geometry, "w") as out:
        out.write(f'Merge "{mesh.name}";\nMesh.Algorithm3D = 10;\nMesh.MeshSizeExtendFromBoundary = 1;\nMesh.SaveAll = 1;\n')
        for piece, shells in sorted(around.items()):
            loop = ", ".join(map(str, sorted(shells)))
            out.write(f"Surface Loop({piece + 1}) = {{{loop}}};\nVolume({piece + 1}) = {{{piece + 1}}};\n")


def main():
    stem = pathlib.Path(sys.argv[2])
    model = measuring.read_vtu(sys.argv[1])
    faces = of_model(model)
    write_poly(stem.with_suffix(".poly"), faces)
    write_gmsh(stem.with_suffix(".geo"), stem.with_suffix(".msh"), faces)
    np.savez(stem.with_suffix(".npz"), points=faces.points, triangles=faces.triangles, inner=faces.inner, outer=faces.outer)
    stem.with_suffix(".json").write_text(json.dumps({
        "pieces": {piece + 1: region for piece, (_, region) in enumerate(faces.seeds)}, "structures": model.structures}))


if __name__ == "__main__":
    main()
