"""Analytic shapes as contour files, with their volumes and the distance of any point from their surface.

Every function gives a Shape: contours on parallel slices (polygons whose vertices lie on the true outline), the exact
volume per structure, and where it is known a function that gives the distance of points from the true surface.
"""
import math

import numpy as np


class Shape:
    def __init__(self, structures, spacing):
        self.structures = structures  # {number: name}
        self.spacing = spacing
        self.slices = []              # (z, [(structure, points (n, 2))])
        self.volume = {}              # {number: mm3}
        self.distance = None          # points (n, 3) -> distance from the surface of all structures
        self.genus = {}
        self.shells = {}

    def add_slice(self, z, polygons):
        if polygons:
            self.slices.append((z, polygons))

    def document(self, to_space=None, order=None):
        """The contour file as a dictionary. `to_space` moves points (x, y, z) -> (x, y, z); `order` picks slices."""
        to_space = to_space or (lambda p: p)
        slices = []
        for z, polygons in self.slices:
            contours = []
            for structure, points in polygons:
                moved = [[float(v) for v in to_space((x, y, z))] for x, y in points]
                contours.append({"structure": structure, "points": moved})
            origin, other = to_space((0.0, 0.0, z)), to_space((0.0, 0.0, z + 1.0))
            plane = {"origin": [float(v) for v in origin], "normal": [float(b - a) for a, b in zip(origin, other)]}
            slices.append({"plane": plane, "contours": contours})
        if order is not None:
            slices = [slices[i] for i in order]
        return {"format": "anatomesh-contours", "version": 1, "space": "LPS", "unit": "mm",
                "structures": [{"number": n, "name": name} for n, name in self.structures.items()], "slices": slices}

    def vertices(self):
        return np.array([(x, y, z) for z, polygons in self.slices for _, points in polygons for x, y in points])


def circle(radius, count=96, center=(0.0, 0.0)):
    a = 2 * np.pi * (np.arange(count) + 0.5) / count
    return np.c_[center[0] + radius * np.cos(a), center[1] + radius * np.sin(a)]


def heights(top, spacing):
    """Slices at -top + spacing / 2, ..., top - spacing / 2: the half caps then end at the poles."""
    count = int(round(2 * top / spacing))
    return [-top + spacing * (i + 0.5) for i in range(count)]


def points_on(radius):
    """Vertices of a circle about 1.4 mm apart, at least 12."""
    return max(12, int(round(2 * math.pi * radius / 1.4)))


def sphere(radius=20.0, spacing=2.0):
    return ellipsoid((radius, radius, radius), spacing, "sphere")


def ellipsoid(half_axes=(30.0, 20.0, 15.0), spacing=2.0, name="ellipsoid"):
    a, b, c = half_axes
    shape = Shape({1: name}, spacing)
    for z in heights(c, spacing):
        scale = math.sqrt(1 - (z / c) ** 2)
        shape.add_slice(z, [(1, circle(scale, points_on(scale * max(a, b))) * [a, b])])
    shape.volume = {1: 4 / 3 * math.pi * a * b * c}
    shape.genus, shape.shells = {1: 0}, {1: 1}
    if a == b == c:
        shape.distance = lambda p: np.abs(np.linalg.norm(p, axis=1) - a)
    return shape


def torus(ring=20.0, tube=8.0, spacing=2.0):
    """Lying: its axis along z, so that every slice is a ring."""
    shape = Shape({1: "torus"}, spacing)
    for z in heights(tube, spacing):
        r = math.sqrt(tube ** 2 - z ** 2)
        shape.add_slice(z, [(1, circle(ring + r, points_on(ring + r))), (1, circle(ring - r, points_on(ring - r)))])
    # Between the outer slices the torus, beyond them half a slice of their sections.
    last = heights(tube, spacing)[-1]
    half_width = math.sqrt(tube ** 2 - last ** 2)
    shape.volume = {1: 4 * math.pi * ring * (last * half_width + tube ** 2 * math.asin(last / tube) + spacing * half_width)}
    shape.genus, shape.shells = {1: 1}, {1: 1}
    shape.distance = lambda p: np.abs(np.hypot(np.hypot(p[:, 0], p[:, 1]) - ring, p[:, 2]) - tube)
    return shape


def shell(outer=20.0, inner=14.0, spacing=2.0):
    shape = Shape({1: "shell"}, spacing)
    for z in heights(outer, spacing):
        r = math.sqrt(outer ** 2 - z ** 2)
        polygons = [(1, circle(r, points_on(r)))]
        if abs(z) < inner:
            r = math.sqrt(inner ** 2 - z ** 2)
            polygons.append((1, circle(r, points_on(r))))
        shape.add_slice(z, polygons)
    shape.volume = {1: 4 / 3 * math.pi * (outer ** 3 - inner ** 3)}
    shape.genus, shape.shells = {1: 0}, {1: 2}
    shape.distance = lambda p: np.minimum(np.abs(np.linalg.norm(p, axis=1) - outer),
                                          np.abs(np.linalg.norm(p, axis=1) - inner))
    return shape


def touching_balls(radius=12.0, spacing=2.0, two_structures=True):
    """Two balls that touch in one point, of which no slice goes through."""
    shape = Shape({1: "left", 2: "right"} if two_structures else {1: "pair"}, spacing)
    for z in heights(radius, spacing):
        r = math.sqrt(radius ** 2 - z ** 2)
        count = points_on(r)
        shape.add_slice(z, [(1, circle(r, count, (-radius, 0.0))),
                            (2 if two_structures else 1, circle(r, count, (radius, 0.0)))])
    ball = 4 / 3 * math.pi * radius ** 3
    shape.volume = {1: ball, 2: ball} if two_structures else {1: 2 * ball}
    shape.distance = lambda p: np.minimum(np.abs(np.linalg.norm(p - [-radius, 0, 0], axis=1) - radius),
                                          np.abs(np.linalg.norm(p - [radius, 0, 0], axis=1) - radius))
    return shape


def wall_drawn_twice(gap=0.0, below=14, above=11, spacing=2.0, length=20.0):
    """Two slabs on each other, whose common wall was drawn for each with its own steps along one curve."""
    shape = Shape({1: "below", 2: "above"}, spacing)

    def side(steps, y):
        x = np.linspace(0, length, steps + 1)
        return np.c_[x, y + 0.8 * np.sin(0.7 * x)]

    for k in range(8):
        shape.add_slice(spacing * k, [(1, np.vstack([[(0, -6), (length, -6)], side(below, 0.0)[::-1]])),
                                      (2, np.vstack([side(above, gap), [(length, 6), (0, 6)]]))])
    return shape


def two_discs(radius, half_gap, count=40):
    """Outline of the union of discs at (-half_gap, 0) and (half_gap, 0): one polygon or two."""
    if half_gap >= radius:
        return [circle(radius, count, (-half_gap, 0.0)), circle(radius, count, (half_gap, 0.0))]
    cut = math.acos(-half_gap / radius)  # the right disc's outline runs from -cut to cut
    a = np.linspace(-cut, cut, count)
    right = np.c_[half_gap + radius * np.cos(a), radius * np.sin(a)]
    left = -right[1:-1]
    return [np.vstack([right, left])]


def two_discs_area(radius, half_gap):
    if half_gap >= radius:
        return 2 * math.pi * radius ** 2
    lens = 2 * radius ** 2 * math.acos(half_gap / radius) - 2 * half_gap * math.sqrt(radius ** 2 - half_gap ** 2)
    return 2 * math.pi * radius ** 2 - lens


def crossing_cylinders(radius=12.0, apart=15.0, length=20.0, spacing=2.0):
    """Two structures, upright cylinders that overlap."""
    shape = Shape({1: "first", 2: "second"}, spacing)
    for z in np.arange(0, length + 1e-9, spacing):
        shape.add_slice(float(z), [(1, circle(radius, 40)), (2, circle(radius, 37, (apart, 0.3)))])
    return shape


def bifurcating_tube(radius=6.0, length=60.0, spacing=2.0):
    """A tube that parts in two: discs whose centres move apart linearly from the middle on."""
    shape = Shape({1: "tube"}, spacing)

    def half_gap(z):
        return max(0.0, 0.45 * (z - length / 2))

    count = int(length / spacing)
    for i in range(count):
        z = (i + 0.5) * spacing
        gap = half_gap(z)
        polygons = [circle(radius, 28)] if gap == 0 else two_discs(radius, gap, 28)
        shape.add_slice(z, [(1, p) for p in polygons])
    steps = 6000
    shape.volume = {1: sum(two_discs_area(radius, half_gap((i + 0.5) * length / steps)) for i in range(steps))
                    * length / steps}
    shape.genus, shape.shells = {1: 0}, {1: 1}
    return shape


ALL = {"sphere": sphere, "ellipsoid": ellipsoid, "torus": torus, "shell": shell,
       "touching_balls": touching_balls, "touching_pair": lambda: touching_balls(two_structures=False),
       "bifurcating_tube": bifurcating_tube}
