#!/usr/bin/python3
"""livewire_picture.py OUTPUT.png: a slice of the CT skull with three rings that a livewire led through a few clicks.

    --rings PROGRAM     anatomesh_livewire_rings of `make bench` (default: build/release/bench/anatomesh_livewire_rings)
    --project FILE      Cranium.inv3 (default: what scripts/skull.sh finds)
"""
import argparse
import pathlib
import struct
import subprocess
import tarfile
import zlib

import numpy

SOURCE = pathlib.Path(__file__).resolve().parent.parent
SIZE, STEP = (256, 256, 108), 0.957  # of the project; pixels, and mm
SLICE = 45
WINDOW = (-200, 500)  # HU: what is black, and what is white
ZOOM = 4
# Columns and rows of the clicks, and the colour of the ring: skin, inside of the skull, one eye.
RINGS = [([(52, 100), (62, 50), (91, 21), (128, 12), (168, 20), (186, 33), (199, 50), (209, 96), (200, 160), (129, 216), (58, 160)], (255, 200, 40)),
         ([(64, 80), (128, 27), (198, 80), (128, 163)], (60, 220, 255)),
         ([(94, 189), (104, 179), (113, 189), (103, 198)], (140, 255, 120))]


def write_png(path, pixels):
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    height, width = pixels.shape[:2]
    rows = b"".join(b"\0" + row.tobytes() for row in pixels)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))
                     + chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b""))


def slice_of(project):
    with tarfile.open(project) as files:
        name = next(name for name in files.getnames() if name.endswith("matrix.dat"))
        voxels = numpy.frombuffer(files.extractfile(name).read(), "<i2").reshape(SIZE[::-1])
    return voxels[SLICE].astype("<f4")


def rings_on(program, pixels):
    task = f"{pixels.shape[1]} {pixels.shape[0]} {STEP} {STEP} {len(RINGS)}\n"
    for clicks, _ in RINGS:
        task += f"{len(clicks)} " + " ".join(f"{STEP * i} {STEP * j}" for i, j in clicks) + "\n"
    done = subprocess.run([program], input=task.encode() + pixels.tobytes(), capture_output=True, check=True)
    return [numpy.array(line.split(), float).reshape(-1, 2) / STEP for line in done.stdout.decode().splitlines()]


def draw_dot(canvas, x, y, radius, colour):
    rows, columns = numpy.mgrid[0:canvas.shape[0], 0:canvas.shape[1]]
    share = numpy.clip(radius + 0.5 - numpy.hypot(columns - x, rows - y), 0, 1)[..., None]
    canvas[:] = (1 - share) * canvas + share * numpy.array(colour)


def draw_ring(canvas, ring, colour):
    place = ZOOM * (ring + 0.5) - 0.5
    nearest = numpy.full(canvas.shape[:2], numpy.inf)
    for a, b in zip(place, numpy.roll(place, -1, axis=0)):
        low = numpy.maximum(numpy.floor(numpy.minimum(a, b)).astype(int) - 3, 0)
        high = numpy.ceil(numpy.maximum(a, b)).astype(int) + 4
        rows, columns = numpy.mgrid[low[1]:min(high[1], canvas.shape[0]), low[0]:min(high[0], canvas.shape[1])]
        along = numpy.clip(((columns - a[0]) * (b - a)[0] + (rows - a[1]) * (b - a)[1]) / max((b - a) @ (b - a), 1e-9), 0, 1)
        away = numpy.hypot(columns - a[0] - along * (b - a)[0], rows - a[1] - along * (b - a)[1])
        part = nearest[rows[0, 0]:rows[-1, 0] + 1, columns[0, 0]:columns[0, -1] + 1]
        numpy.minimum(part, away, out=part)
    share = numpy.clip(1.8 - nearest, 0, 1)[..., None]
    canvas[:] = (1 - share) * canvas + share * numpy.array(colour)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("output", type=pathlib.Path)
    parser.add_argument("--rings", default=SOURCE / "build/release/bench/anatomesh_livewire_rings")
    parser.add_argument("--project")
    options = parser.parse_args()
    project = options.project or subprocess.run([SOURCE / "scripts/skull.sh"], capture_output=True, text=True,
                                                check=True, cwd=SOURCE).stdout.strip()
    pixels = slice_of(SOURCE / project)
    grey = 255 * numpy.clip((pixels - WINDOW[0]) / (WINDOW[1] - WINDOW[0]), 0, 1)
    canvas = numpy.repeat(numpy.kron(grey, numpy.ones((ZOOM, ZOOM)))[..., None], 3, axis=2)
    for (clicks, colour), ring in zip(RINGS, rings_on(options.rings, pixels)):
        draw_ring(canvas, ring, colour)
        for i, j in clicks:
            draw_dot(canvas, ZOOM * (i + 0.5) - 0.5, ZOOM * (j + 0.5) - 0.5, 7, (255, 255, 255))
            draw_dot(canvas, ZOOM * (i + 0.5) - 0.5, ZOOM * (j + 0.5) - 0.5, 5, colour)
    # The upper 226 rows and the middle columns: the rest is air.
    write_png(options.output, canvas[:ZOOM * 226, ZOOM * 24:ZOOM * 232].round().astype(numpy.uint8))


if __name__ == "__main__":
    main()
