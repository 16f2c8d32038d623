"""Images for the end-to-end tests: reading what the program wrote, writing what it shall read."""
import gzip

import numpy as np

TYPES = {"uint8": "<u1", "uint16": "<u2", "int32": "<i4", "float": "<f4"}


def read_nrrd(path):
    """(values [i, j, k], origin, steps [axis][xyz], fields, pairs) of a gzipped NRRD as the program writes it."""
    head, data = path.read_bytes().split(b"\n\n", 1)
    lines = head.decode().split("\n")
    assert lines[0].startswith("NRRD")
    fields = dict(line.split(": ", 1) for line in lines[1:] if ":=" not in line)
    pairs = dict(line.split(":=", 1) for line in lines[1:] if ":=" in line)
    sizes = [int(n) for n in fields["sizes"].split()]
    values = np.frombuffer(gzip.decompress(data), TYPES[fields["type"]]).reshape(sizes, order="F")
    vectors = [np.array([float(v) for v in text.strip("()").split(",")]) for text in
               fields["space directions"].split() + [fields["space origin"]]]
    return values, vectors[3], np.array(vectors[:3]), fields, pairs


def positions(shape, origin, steps):
    """The centre of every voxel, LPS mm: [i, j, k, xyz]."""
    i, j, k = np.meshgrid(*[np.arange(n) for n in shape], indexing="ij")
    return origin + i[..., None] * steps[0] + j[..., None] * steps[1] + k[..., None] * steps[2]


def write_nrrd(path, values, spacing=(1, 1, 1), origin=(0, 0, 0)):
    kind = {"int16": "short", "uint8": "uint8", "float32": "float"}[values.dtype.name]
    directions = " ".join("(" + ",".join(str(s if a == b else 0) for b in range(3)) + ")" for a, s in enumerate(spacing))
    head = (f"NRRD0004\ntype: {kind}\ndimension: 3\nspace: LPS\nsizes: {' '.join(map(str, values.shape))}\n"
            f"space directions: {directions}\nendian: little\nencoding: raw\nspace origin: ({','.join(map(str, origin))})\n\n")
    path.write_bytes(head.encode() + values.tobytes(order="F"))
    return path


def dice(a, b):
    return 2 * np.count_nonzero(a & b) / max(1, np.count_nonzero(a) + np.count_nonzero(b))
