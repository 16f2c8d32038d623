#!/usr/bin/python3
"""surface_meshers.py gmsh|netgen SURFACE.poly MODEL SIZE

Meshers that start from a surface, on one that anatomesh_peers wrote. Writes MODEL (as Gmsh or Medit file, whatever its name)
and prints the seconds of the mesher alone, reading and writing left out, as JSON.
"""
import json
import pathlib
import subprocess
import sys
import time


def read_poly(path):
    """Points, triangles from 0, and the two regions of every triangle."""
    words = iter(pathlib.Path(path).read_text().split())
    take = lambda kind, count: [kind(next(words)) for _ in range(count)]
    n, *_ = take(int, 4)
    points = []
    for _ in range(n):
        next(words)
        points.append(take(float, 3))
    m, _ = take(int, 2)
    triangles, sides = [], []
    for _ in range(m):
        marker = take(int, 3)[2]
        sides.append((marker // 65536, marker % 65536))
        next(words)
        triangles.append([v - 1 for v in take(int, 3)])
    return points, triangles, sides


def write_medit(path, points, cells):
    with open(path, "w") as out:
        out.write(f"MeshVersionFormatted 2\nDimension 3\nVertices\n{len(points)}\n")
        out.writelines(f"{x!r} {y!r} {z!r} 0\n" for x, y, z in points)
        out.write(f"Tetrahedra\n{len(cells)}\n")
        out.writelines(f"{a} {b} {c} {d} 1\n" for a, b, c, d in cells)
        out.write("End\n")


def gmsh(surface, model, size):
    """HXT, the fastest of Gmsh's volume meshers, and Gmsh's own optimiser, which is on by default."""
    points, triangles, _ = read_poly(surface)
    folder = pathlib.Path(model).parent
    with open(folder / "surface.msh", "w") as out:
        out.write(f"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{len(points)}\n")
        out.writelines(f"{i + 1} {x!r} {y!r} {z!r}\n" for i, (x, y, z) in enumerate(points))
        out.write(f"$EndNodes\n$Elements\n{len(triangles)}\n")
        out.writelines(f"{i + 1} 2 2 1 1 {a + 1} {b + 1} {c + 1}\n" for i, (a, b, c) in enumerate(triangles))
        out.write("$EndElements\n")
    (folder / "volume.geo").write_text(
        f'Merge "surface.msh";\nSurface Loop(1) = {{1}};\nVolume(1) = {{1}};\nMesh.Algorithm3D = 10;\n'
        f"Mesh.MeshSizeExtendFromBoundary = 1;\nMesh.MeshSizeMax = {size};\nMesh.SaveAll = 1;\n")
    done = subprocess.run(["gmsh", "volume.geo", "-3", "-format", "msh41", "-bin", "-o", pathlib.Path(model).name, "-nt", "1", "-v", "4"],
                          cwd=folder, capture_output=True, text=True)
    text = done.stdout + done.stderr
    errors = [line for line in text.splitlines() if "Error" in line]
    if errors or done.returncode != 0:
        sys.exit(f"Gmsh: {errors[0].strip() if errors else text[-200:]}")
    wall = [line for line in text.splitlines() if "Done meshing 3D" in line]
    return float(wall[-1].split("Wall")[1].split("s")[0])


def netgen(surface, model, size):
    import netgen.meshing as ng
    points, triangles, sides = read_poly(surface)
    mesh = ng.Mesh(dim=3)
    numbers = [mesh.Add(ng.MeshPoint(ng.Pnt(*p))) for p in points]
    faces = {}
    for triangle, (inner, outer) in zip(triangles, sides):
        if (inner, outer) not in faces:
            face = ng.FaceDescriptor(surfnr=len(faces) + 1, domin=inner, domout=outer, bc=len(faces) + 1)
            faces[inner, outer] = mesh.Add(face)
        mesh.Add(ng.Element2D(faces[inner, outer], [numbers[v] for v in triangle]))
    start = time.monotonic()
    mesh.GenerateVolumeMesh(ng.MeshingParameters(maxh=size))
    seconds = time.monotonic() - start
    cells = [[v.nr for v in element.points] for element in mesh.Elements3D()]
    if not cells:
        sys.exit("Netgen: no tetrahedra")
    write_medit(model, [tuple(p.p) for p in mesh.Points()], cells)
    return seconds


if __name__ == "__main__":
    name, surface, model, size = sys.argv[1:5]
    seconds = {"gmsh": gmsh, "netgen": netgen}[name](surface, model, float(size))
    print(json.dumps({"seconds": seconds}))
