#!/usr/bin/python3
"""The house's plan against the sources: which room may include which, and how large a room may be.

    check_layers.py [ROOT]      exit code 1 and a line for each fault

A room is a folder of src/anatomesh. It includes only itself and rooms above it in ROOMS: data flows one way. It has a
README.md, at most 25 files and 3,200 lines besides tests. The core opens no file and prints nothing: it includes no
header for that, and of others only Boost's and oneTBB's. The libraries for files include the core, never the other way.
Their rooms, the folders of src/anatomesh_io, have a README.md too, which src/anatomesh_io/README.md names.
"""
import pathlib
import re
import sys

ROOMS = """
base geom image
contour/model contour/overlay contour/planes contour/simplify contour/walls contour/resolve contour/clean contour/trace
slices/arrangement slices/lines slices/coverage
reconcile/move reconcile/regularize reconcile/resolve reconcile/compare reconcile
mesh/model mesh/edit mesh/check mesh/shape mesh/stars
field/model field/slice field/warnings field/motion field/stack field/planes field/overlaps field
overlaps
sample delaunay cull cut measure
improve/core improve/operations improve/climb improve/sections improve/surgery improve/reroute improve/smooth improve
measure/certificate measure/topology outliers refine recover element
pipeline/model pipeline/retry pipeline/run pipeline
uncertainty
live/preview
live/draw/area live/draw
live/section
live/livewire
live/edit
""".split()
MOST_FILES, MOST_LINES = 25, 3200
FOREIGN = {"boost", "tbb", "oneapi"}
OF_FILES_AND_TERMINALS = {"fstream", "iostream", "filesystem", "fcntl.h", "unistd.h", "print"}
PRINTS = re.compile(r"\b(?:f|std::)?(?:printf|puts|fputs|fwrite|fopen)\(")
INCLUDE = re.compile(r'^\s*#include\s+(?:"([^"]+)"|<([^>]+)>)')


def is_test(name):
    return bool(re.search(r"_test\.(cpp|h)$|fixtures\.h$", name))


def includes(path):
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        found = INCLUDE.match(line)
        if found:
            yield number, found[1], found[2]


def faults_of_includes(core, path, room):
    place = ROOMS.index(room)
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        if PRINTS.search(line.partition("//")[0]):
            yield f"{path.relative_to(core.parent.parent)}:{number}: the core opens no file and prints nothing"
    for number, own, system in includes(path):
        where = f"{path.relative_to(core.parent.parent)}:{number}"
        if own and own.startswith("anatomesh/"):
            other = own[len("anatomesh/"):].rpartition("/")[0]
            if other not in ROOMS:
                yield f"{where}: includes {own}, which stands in no room"
            elif ROOMS.index(other) > place:
                yield f"{where}: {room} includes {own}, of a room below it"
        elif own:
            yield f"{where}: includes {own}: the core knows itself alone"
        elif "/" in system and system.split("/")[0] not in FOREIGN | {"sys"}:
            yield f"{where}: includes <{system}>: of others the core knows Boost and oneTBB alone"
        elif system in OF_FILES_AND_TERMINALS:
            yield f"{where}: includes <{system}>: the core opens no file and prints nothing"


def faults_of_size(folder, room, files):
    own = [path for path in files if not is_test(path.name)]
    lines = sum(len(path.read_text(encoding="utf-8").splitlines()) for path in own)
    if not own:
        yield f"{room}: no room without files"
    if len(own) > MOST_FILES:
        yield f"{room}: {len(own)} files, at most {MOST_FILES}"
    if lines > MOST_LINES:
        yield f"{room}: {lines} lines, at most {MOST_LINES}"
    if not (folder / "README.md").exists():
        yield f"{room}: has no README.md"


def faults(root):
    core = root / "src" / "anatomesh"
    found = {str(path.parent.relative_to(core)) for path in core.rglob("*") if path.suffix in (".h", ".cpp")}
    for room in sorted(found - set(ROOMS)):
        if any(not is_test(path.name) for path in (core / room).glob("*.*") if path.suffix in (".h", ".cpp")):
            yield f"{room}: is no room of ROOMS"
    for room in ROOMS:
        files = sorted(path for path in (core / room).glob("*") if path.suffix in (".h", ".cpp"))
        yield from faults_of_size(core / room, room, files)
        for path in files:
            if not is_test(path.name):
                yield from faults_of_includes(core, path, room)
    of_files = root / "src" / "anatomesh_io"
    listed = (of_files / "README.md").read_text(encoding="utf-8")
    for folder in sorted({path.parent for path in of_files.rglob("*.h")} - {of_files}):
        room = folder.relative_to(of_files)
        if not (folder / "README.md").exists():
            yield f"anatomesh_io/{room}: has no README.md"
        if f"`{room}/`" not in listed:
            yield f"anatomesh_io/{room}: is not named in src/anatomesh_io/README.md"


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else __file__).resolve()
    if root.is_file():
        root = root.parent.parent
    lines = list(faults(root))
    print("\n".join(lines) if lines else f"{len(ROOMS)} rooms: each includes only rooms above it")
    sys.exit(1 if lines else 0)


if __name__ == "__main__":
    main()
