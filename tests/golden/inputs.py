"""The inputs of the golden runs: small solids, drawn on every kind of arrangement of slices that the program tells apart.

Contours are found on rays, by halving, and rounded to 0.0001 mm, so that every machine writes the same files.
`CASES` gives for each name the options of `anatomesh model` and a function that writes the input into a folder.
"""
import functools
import gzip
import json
import math
import random

ROUND = 4      # decimals of coordinates, mm
HALVINGS = 34  # of a ray: far below what is rounded away


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def add(a, b, factor=1.0):
    return tuple(x + factor * y for x, y in zip(a, b))


def unit(a):
    length = math.sqrt(dot(a, a))
    return tuple(x / length for x in a)


class Part:
    """A piece of a structure: a function that is negative inside, seen from any point of `centres` in every section."""

    def __init__(self, inside, centre, reach):
        self.inside, self.centre, self.reach = inside, centre, reach


def ellipsoid(centre, half_axes, lumps=0.0):
    def inside(p):
        q = [(p[i] - centre[i]) / half_axes[i] for i in range(3)]
        r = math.sqrt(dot(q, q)) + 1e-12
        return r - 1 - lumps * math.sin(3 * math.atan2(q[1], q[0])) * (q[0] ** 2 + q[1] ** 2) / r ** 2 - lumps * q[2] / r
    return Part(inside, centre, 1.6 * max(half_axes))


def frame(normal):
    """Two directions in a plane, at right angles."""
    up = (0.0, 0.0, 1.0) if abs(normal[2]) < 0.8 else (0.0, 1.0, 0.0)
    u = unit(cross(up, normal))
    return u, cross(normal, u)


def section(part, origin, normal, spacing, turn=0.1):
    """The outline of a part in a plane, points about `spacing` apart; None where the plane misses it."""
    u, v = frame(normal)
    middle = add(part.centre, normal, dot(add(origin, part.centre, -1), normal))
    if part.inside(middle) >= 0:
        return None

    def at(angle):
        direction = add(tuple(math.cos(angle) * x for x in u), v, math.sin(angle))
        low, high = 0.0, part.reach
        for _ in range(HALVINGS):
            half = 0.5 * (low + high)
            low, high = (half, high) if part.inside(add(middle, direction, half)) < 0 else (low, half)
        return add(middle, direction, low)

    rough = [at(2 * math.pi * k / 24) for k in range(24)]
    length = sum(math.dist(rough[k], rough[k - 1]) for k in range(24))
    if length < 4 * spacing:
        return None
    count = max(8, round(length / spacing))
    return [at(turn + 2 * math.pi * k / count) for k in range(count)]


def rounded(point):
    return [round(x, ROUND) + 0.0 for x in point]


def contour_file(planes, structures, spacing=2.0, skip=lambda number, slice_number: False):
    """`planes`: (origin, normal); `structures`: {name: [rings of Part: outlines and holes]}."""
    slices = []
    for k, (origin, normal) in enumerate(planes):
        normal = unit(normal)
        contours = []
        for number, parts in enumerate(structures.values(), 1):
            if skip(number, k):
                continue
            for turn, part in enumerate(parts):
                points = section(part, origin, normal, spacing, 0.1 + 0.07 * turn + 0.013 * k)
                if points:
                    contours.append({"structure": number, "points": [rounded(p) for p in points]})
        if contours:
            slices.append({"plane": {"origin": rounded(origin), "normal": [round(x, 9) for x in normal]}, "contours": contours})
    return json.dumps({"format": "anatomesh-contours", "version": 1, "space": "LPS", "unit": "mm",
                       "structures": [{"number": n, "name": name} for n, name in enumerate(structures, 1)], "slices": slices})


# ---- Arrangements of slices: (origin, normal) ----

def even(spacing=3.0, reach=30.0, axis=2):
    direction = tuple(1.0 if i == axis else 0.0 for i in range(3))
    return [(tuple((0.37 + spacing * k) * x for x in direction), direction) for k in range(-int(reach / spacing), int(reach / spacing))]


def uneven():
    rng, at, planes = random.Random(3), -30.0, []
    while at < 30:
        planes.append(((0.0, 0.0, at), (0.0, 0.0, 1.0)))
        at += 1.5 + 4.5 * rng.random()
    return planes


def swept(count=22, degrees=6.0):
    """A probe that is rocked: the planes lean against each other and meet outside the body."""
    return [((0.0, 0.0, -26 + 52 * k / (count - 1)), (math.sin(math.radians(degrees * (k / (count - 1) - 0.5) * 2)), 0.0, 1.0)) for k in range(count)]


def fan(count=19):
    """Planes that meet in a line 45 mm beside the middle."""
    angles = [math.radians(-45 + 90 * k / (count - 1)) for k in range(count)]
    return [((-45.0, 0.0, 0.0), (-math.sin(a), math.cos(a), 0.0)) for a in angles]


def about_axis(count=12, beside=0.0):
    angles = [math.pi * k / count for k in range(count)]
    return [((-beside * math.sin(a), beside * math.cos(a), 0.0), (-math.sin(a), math.cos(a), 0.0)) for a in angles]


def freehand(spacing, lean, seed):
    rng, at, planes = random.Random(seed), -28.0, []
    while at < 28:
        planes.append(((0.0, 0.0, at), (lean * (rng.random() - 0.5), lean * (rng.random() - 0.5), 1.0)))
        at += spacing * (0.6 + 0.8 * rng.random())
    return planes


def anywhere(count=9):
    rng, planes = random.Random(11), []
    while len(planes) < count:
        n = (rng.random() - 0.5, rng.random() - 0.5, rng.random() - 0.5)
        if dot(n, n) > 0.05:
            n = unit(n)
            planes.append((tuple(12 * (rng.random() - 0.5) * x for x in n), n))
    return planes


# ---- Solids ----

LUMP = {"solid": [ellipsoid((1.0, -0.5, 0.3), (20.0, 15.0, 24.0), 0.12)]}
SHELL = {"shell": [ellipsoid((0.0, 0.0, 0.0), (20.0, 18.0, 22.0)), ellipsoid((0.0, 0.0, 0.0), (18.4, 16.4, 20.4))]}
NESTED = {"organ": [ellipsoid((0.0, 0.0, 0.0), (20.0, 16.0, 22.0), 0.06)], "tumour": [ellipsoid((4.0, 1.0, 2.0), (7.0, 6.0, 7.5))]}
OVERLAPPING = {"left": [ellipsoid((-7.0, 0.0, 0.0), (14.0, 12.0, 15.0))], "right": [ellipsoid((8.0, 1.0, 1.0), (13.0, 12.0, 14.0))]}
PAIR = {"one": [ellipsoid((-11.0, 0.0, 0.0), (10.0, 10.0, 12.0))], "two": [ellipsoid((11.0, 2.0, 0.0), (9.5, 10.0, 11.0))]}


def branching():
    """A vessel that parts in two."""
    parts = {"vessel": []}
    planes = even(2.0, 24.0)
    slices = []
    for k, (origin, normal) in enumerate(planes):
        z = origin[2]
        if z < 0:
            rings = [ellipsoid((0.0, 0.0, z), (7.0, 6.0, 100.0))]
        else:
            rings = [ellipsoid((-7 - 0.25 * z, 0.0, z), (5.0, 5.0, 100.0)), ellipsoid((7 + 0.25 * z, 0.0, z), (4.5, 5.0, 100.0))]
        contours = [{"structure": 1, "points": [rounded(p) for p in section(ring, origin, normal, 2.0)]} for ring in rings]
        slices.append({"plane": {"origin": rounded(origin), "normal": normal}, "contours": contours})
    return json.dumps({"format": "anatomesh-contours", "version": 1, "space": "LPS", "unit": "mm",
                       "structures": [{"number": 1, "name": name} for name in parts], "slices": slices})


def walls_drawn_twice():
    """Two slabs on each other, the wall between them drawn for each with its own steps."""
    def wall(steps, off):
        return [(24 * k / steps, off + 0.8 * math.sin(0.7 * 24 * k / steps)) for k in range(steps + 1)]

    slices = []
    for k in range(7):
        below = [(0, -6), (24, -6)] + wall(14, 0.0)[::-1]
        above = wall(11, 0.03) + [(24, 6), (0, 6)]
        slices.append({"plane": {"origin": [0, 0, 2.5 * k], "normal": [0, 0, 1]},
                       "contours": [{"structure": n, "points": [rounded((x, y, 2.5 * k)) for x, y in ring]} for n, ring in ((1, below), (2, above))]})
    return json.dumps({"format": "anatomesh-contours", "version": 1, "space": "LPS", "unit": "mm",
                       "structures": [{"number": 1, "name": "below"}, {"number": 2, "name": "above"}], "slices": slices})


def contradicting():
    """An even stack, and two planes across it on which the solid was drawn larger and aside."""
    document = json.loads(contour_file(even(4.0), LUMP))
    moved = {"solid": [ellipsoid((2.2, -0.5, 0.8), (21.0, 15.5, 24.5), 0.12)]}
    document["slices"] += json.loads(contour_file(about_axis(2), moved))["slices"]
    return json.dumps(document)


# ---- Images ----

def nrrd(kind, values, size, spacing):
    """`values`: bytes, x fastest."""
    head = (f"NRRD0004\ntype: {kind}\ndimension: 3\nspace: left-posterior-superior\nsizes: {size[0]} {size[1]} {size[2]}\n"
            f"space directions: ({spacing[0]},0,0) (0,{spacing[1]},0) (0,0,{spacing[2]})\nkinds: domain domain domain\n"
            "endian: little\nencoding: gzip\nspace origin: (-25,-25,-25)\n\n")
    return head.encode() + gzip.compress(values, mtime=0)


def voxels(value_at, size, spacing):
    for k in range(size[2]):
        for j in range(size[1]):
            for i in range(size[0]):
                yield value_at((-25 + spacing[0] * i, -25 + spacing[1] * j, -25 + spacing[2] * k))


@functools.lru_cache
def label_map():
    size, spacing = (34, 34, 18), (1.5, 1.5, 2.8)
    organ, tumour, vessel = NESTED["organ"][0], NESTED["tumour"][0], ellipsoid((-3.0, -20.0, 0.0), (4.0, 4.0, 60.0))

    def label(p):
        return 2 if tumour.inside(p) < 0 else 1 if organ.inside(p) < 0 else 3 if vessel.inside(p) < 0 else 0
    return nrrd("uint8", bytes(voxels(label, size, spacing)), size, spacing)


def grey_image():
    size, spacing = (34, 34, 25), (1.5, 1.5, 2.0)
    solid = LUMP["solid"][0]

    def grey(p):
        return max(-1000, min(1000, round(-600 * solid.inside(p))))
    values = b"".join(value.to_bytes(2, "little", signed=True) for value in voxels(grey, size, spacing))
    return nrrd("int16", values, size, spacing)


def drawn(planes, structures, **options):
    return lambda: ("input.json", contour_file(planes, structures, **options))


def text(make, name="input.json"):
    return lambda: (name, make())


# Name: (options, function that gives the name and the content of the input file).
CASES = {
    "parallel": ([], drawn(even(), LUMP)),
    "uneven": ([], drawn(uneven(), LUMP)),
    "swept": ([], drawn(swept(), LUMP)),
    "fan": ([], drawn(fan(), LUMP)),
    "about_an_axis": ([], drawn(about_axis(12), LUMP, spacing=2.5)),
    "beside_an_axis": ([], drawn(about_axis(10, 2.0), LUMP, spacing=2.5)),
    "stack_and_crossing": ([], drawn(even(4.0) + about_axis(2), LUMP)),
    "two_stacks": ([], drawn(even(5.0) + even(5.0, axis=0), LUMP, spacing=2.5)),
    "freehand": ([], drawn(freehand(3.0, 0.12, 5), LUMP)),
    "freehand_dense": ([], drawn(freehand(1.2, 0.05, 6), LUMP, spacing=3.0)),
    "anywhere": ([], drawn(anywhere(), LUMP)),
    "label_map": ([], text(label_map, "input.nrrd")),
    "label_map_every_second": (["--every", "2", "--structure", "1", "--structure", "2"], text(label_map, "input.nrrd")),
    "grey_image": (["--threshold", "0"], text(grey_image, "input.nrrd")),
    "nested": ([], drawn(even(), NESTED)),
    "nested_crossing": ([], drawn(even(5.0) + about_axis(3), NESTED, spacing=2.5)),
    "own_slices": (["--priority", "tumour"], drawn(even(1.5), NESTED, skip=lambda number, k: (k % 3 == 0) == (number == 2))),
    "overlapping": ([], drawn(even(), OVERLAPPING)),
    "overlapping_priority": (["--priority", "right"], drawn(even(), OVERLAPPING)),
    "separate_structures": ([], drawn(even(2.5), PAIR)),
    "thin_walls": (["--size", "2.5"], drawn(even(2.5), SHELL)),
    "walls_drawn_twice": ([], text(walls_drawn_twice)),
    "contradicting": ([], text(contradicting)),
    "crossing_as_drawn": (["--reconcile", "0"], drawn(even(6.0) + about_axis(1), NESTED, spacing=4.0)),
    "aligned": (["--align"], text(contradicting)),
    "branching": ([], text(branching)),
    "flat_caps": (["--caps", "flat"], drawn(even(), LUMP)),
    "rounded_caps": (["--caps", "rounded"], drawn(even(), LUMP)),
    "gap": (["--max-gap", "3"], drawn([plane for plane in even() if abs(plane[0][2] - 3) > 2], LUMP)),
    "quadratic": (["--order", "2"], drawn(even(4.0), LUMP, spacing=3.0)),
    "uncertainty": (["--uncertainty"], drawn(even(4.0), LUMP, spacing=3.0)),
    "simplified": (["--epsilon", "0.2"], drawn(even(), LUMP, spacing=0.7)),
}
