"""CalculiX (Debian's calculix-ccx) on a model that the program wrote: decks, and their results as arrays."""
import os
import pathlib
import shutil
import subprocess
import unittest

import numpy as np

# Corners of face 1 to 4 of a C3D4 or C3D10, counter-clockwise from outside, and the mid-nodes between them.
FACES = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
MID_NODES = {(0, 1): 4, (1, 2): 5, (0, 2): 6, (0, 3): 7, (1, 3): 8, (2, 3): 9}


def program():
    """The solver; skips the test when it is not installed."""
    found = shutil.which("ccx")
    if not found:
        raise unittest.SkipTest("no ccx: the package calculix-ccx is not installed")
    return found


class Deck:
    """The nodes, elements and sets of an .inp file, by a parser of its own; numbers from 0."""

    def __init__(self, path):
        self.path = pathlib.Path(path)
        nodes, elements, self.sets, self.node_sets, self.surfaces = [], {}, {}, {}, {}
        target = None
        for line in self.path.read_text().splitlines():
            if line.startswith("**") or not line:
                continue
            if line.startswith("*"):
                keyword, *options = [part.strip() for part in line.split(",")]
                options = dict(option.split("=") for option in options if "=" in option)
                target = None
                if keyword == "*NODE":
                    target = lambda parts: nodes.append([float(x) for x in parts[1:4]])
                elif keyword == "*ELEMENT":
                    members = self.sets.setdefault(options["ELSET"], [])

                    def target(parts, members=members):
                        members.append(int(parts[0]) - 1)
                        elements[int(parts[0]) - 1] = [int(x) - 1 for x in parts[1:]]
                elif keyword == "*ELSET":
                    members = self.sets.setdefault(options["ELSET"], [])

                    def target(parts, members=members):
                        for part in parts:
                            members.extend([int(part) - 1] if part[0].isdigit() else self.sets[part])
                elif keyword == "*NSET":
                    members = self.node_sets.setdefault(options["NSET"], [])
                    target = lambda parts, members=members: members.extend(int(x) - 1 for x in parts)
                elif keyword == "*SURFACE":
                    members = self.surfaces.setdefault(options["NAME"], [])
                    target = lambda parts, members=members: members.append((int(parts[0]) - 1, int(parts[1][1:]) - 1))
                continue
            if target:
                target([part.strip() for part in line.split(",") if part.strip()])
        self.nodes = np.array(nodes)
        self.elements = np.array([elements[i] for i in range(len(elements))])

    def faces(self, name):
        """The nodes of the faces of a surface, (k, 3) or (k, 6): corners, then mid-nodes."""
        rows = []
        for element, face in self.surfaces[name]:
            corners = FACES[face]
            local = list(corners)
            if self.elements.shape[1] == 10:
                local += [MID_NODES[tuple(sorted((corners[i], corners[(i + 1) % 3])))] for i in range(3)]
            rows.append(self.elements[element][local])
        return np.array(rows)


def solve(folder, deck, name, lines, timeout=300):
    """Runs CalculiX on `lines` after the model. Returns its results by (what, set): arrays of node or element rows."""
    text = f"*INCLUDE, INPUT={deck.path.name}\n" + "\n".join(lines) + "\n"
    pathlib.Path(folder, name + ".inp").write_text(text)
    environment = dict(os.environ, OMP_NUM_THREADS="1", CCX_NPROC_EQUATION_SOLVER="1")
    done = subprocess.run([program(), "-i", name], cwd=folder, capture_output=True, text=True, timeout=timeout, env=environment)
    if done.returncode != 0 or "*ERROR" in done.stdout:
        raise AssertionError(f"ccx failed: {done.stdout[-2000:]}{done.stderr[-500:]}")
    return read_results(pathlib.Path(folder, name + ".dat"))


def read_results(path):
    results, rows = {}, None
    for line in path.read_text().splitlines():
        if " for set " in line:
            what, rest = line.strip().split(" for set ", 1)
            rows = results.setdefault((what.split("(")[0].strip(), rest.split()[0]), [])
        elif line.strip() and rows is not None:
            rows.append([float(x) for x in line.split()])
    return {key: np.array(rows) for key, rows in results.items()}


def elastic(elset, young=1000.0, poisson=0.3, name="ELASTIC_MATERIAL"):
    return [f"*MATERIAL, NAME={name}", "*ELASTIC", f"{young}, {poisson}", f"*SOLID SECTION, ELSET={elset}, MATERIAL={name}"]


def traction_forces(nodes, faces, traction):
    """Consistent nodal forces of a constant traction (a vector) on faces, by quadrature of degree 5."""
    a, b = (6 - np.sqrt(15)) / 21, (6 + np.sqrt(15)) / 21
    points = [(1 / 3, 1 / 3, 9 / 80)]
    for s, w in ((a, (155 - np.sqrt(15)) / 2400), (b, (155 + np.sqrt(15)) / 2400)):
        points += [(s, s, w), (1 - 2 * s, s, w), (s, 1 - 2 * s, w)]
    forces = np.zeros_like(nodes)
    for u, v, weight in points:
        l = 1 - u - v
        if faces.shape[1] == 3:
            shape = np.array([l, u, v])
            du, dv = np.array([-1.0, 1, 0]), np.array([-1.0, 0, 1])
        else:
            shape = np.array([l * (2 * l - 1), u * (2 * u - 1), v * (2 * v - 1), 4 * l * u, 4 * u * v, 4 * v * l])
            du = np.array([1 - 4 * l, 4 * u - 1, 0, 4 * (l - u), 4 * v, -4 * v])
            dv = np.array([1 - 4 * l, 0, 4 * v - 1, -4 * u, 4 * u, 4 * (l - v)])
        p = nodes[faces]
        area = np.linalg.norm(np.cross(np.einsum("fnk,n->fk", p, du), np.einsum("fnk,n->fk", p, dv)), axis=1)
        for n in range(faces.shape[1]):
            np.add.at(forces, faces[:, n], (weight * shape[n] * area)[:, None] * np.asarray(traction))
    return forces


def pressure_lines(surface, pressure):
    """The pressure on a surface of the model, by its own element faces."""
    return ["*DLOAD"] + [f"{element + 1}, P{face + 1}, {pressure}" for element, face in surface]


def load_lines(forces):
    lines = ["*CLOAD"]
    for node in np.flatnonzero(np.abs(forces).max(1) > 0):
        lines += [f"{node + 1}, {k + 1}, {forces[node, k]:.12e}" for k in range(3) if forces[node, k] != 0]
    return lines
