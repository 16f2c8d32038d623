#!/usr/bin/python3
"""What the time goes to, stage by stage: sampled functions on one thread.

    bench/time_by_stage.py --update docs/benchmarks.md            the CT skull, every 2nd slice
    bench/time_by_stage.py -- labels.nii.gz                       other data, with options of `anatomesh model`

Needs `make` before, and `perf` (Debian: linux-perf) with leave to sample one's own processes. Samples are of CPU time, and are put
into stages by their time after the start; other work on the machine hardly matters.
"""
import argparse
import collections
import json
import pathlib
import re
import tempfile

from common import SKULL_OPTIONS, SOURCE, Failure, command, keep, machine, run, skull, table

FREQUENCY = 997  # a second
SHOWN = 5  # functions of a stage
LIMIT = 600
KINDS = [  # of work, by names of functions
    ("the field's values", r"Track::|DistanceMap::|PieceIndex::|LayeredField|FieldQueries::|InterfaceProbe::|ParallelField::|add_matches|"
                           r"following_edges|SliceMotion"),
    ("Delaunay kernel", r"DelaunayKernel::|Tetrahedralization::|orient3d|insphere"),
    ("vertices moved and edges flipped (improve)",
     r"StarRatios::|ratio_slopes|cell_terms|Smoother::|VertexMover::|Flipper::|EditMesh::|Workbench::|Balancer::|StarAnalyzer::|scaled_angles"),
    ("the kernel (pages, files) and libraries without symbols (zlib)", r"the kernel$|\[unknown\]$|__mem|deflate|_?malloc|_int_|do_lookup"),
]


def short(symbol):
    """Of a demangled name the function, or the one that a lambda stands in."""
    symbol = re.sub(r"\(anonymous namespace\)::|anatomesh::", "", symbol.strip())
    if "{lambda" in symbol:
        names = re.findall(r"([A-Za-z_]\w*(?:::[A-Za-z_]\w*)*)(?:<\w+>)?\(", symbol)
        return names[0] if names else "a lambda"
    return re.sub(r"<.*>", "", symbol.split("(")[0])


def samples(program, words, folder):
    """Of one run: (stage, function) -> samples."""
    report, data = folder / "report.json", folder / "perf.data"
    run(["perf", "record", "-q", "-e", "cpu-clock", "-F", FREQUENCY, "-o", data, program, "model", *words, "--threads", 1, "--quiet",
         "-o", folder / "model.vtu", "--report", report], LIMIT)
    stages = [(stage["name"], stage["seconds"]) for stage in json.loads(report.read_text())["timing"]["stages"]]
    found = collections.Counter()
    start = None
    for line in run(["perf", "script", "-i", data, "-F", "time,ip,sym"], LIMIT)["out"].splitlines():
        time, _, place = line.strip().partition(":")
        address, _, symbol = place.strip().partition(" ")
        start = float(time) if start is None else start
        left = float(time) - start
        name = "writing"
        for stage, seconds in stages:
            if left < seconds:
                name = stage
                break
            left -= seconds
        found[name, "the kernel" if address.startswith("ffffffff") else short(symbol)] += 1
    return found, [name for name, _ in stages] + ["writing"]


def by_kind(everywhere, total):
    kinds = collections.Counter()
    for function, n in everywhere.items():
        kinds[next((kind for kind, names in KINDS if re.match(names, function)), "all else: sampling, searches, checks")] += n
    return table(["kind of work", "share of the CPU time"], [[kind, f"{100 * n / total:.0f} %"] for kind, n in kinds.most_common()])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", type=pathlib.Path, default=SOURCE / "build/release/anatomesh")
    parser.add_argument("--runs", type=int, default=5, help="samples of so many runs are added (default 5)")
    parser.add_argument("input", nargs="*", help="other data, with options of `anatomesh model`; after --")
    parser.add_argument("--update", type=pathlib.Path, metavar="PAGE", help="put the table between its markers in PAGE")
    arguments = parser.parse_args()
    words = arguments.input or [skull(), *SKULL_OPTIONS, "--every", "2"]
    if words[0] is None:
        parser.error("no Cranium.inv3: install the package invesalius-examples, or give an input")
    how = f"{machine()}{command()}"
    found = collections.Counter()
    with tempfile.TemporaryDirectory(prefix="anatomesh-profile-") as folder:
        for _ in range(arguments.runs):
            try:
                more, stages = samples(arguments.program.resolve(), words, pathlib.Path(folder))
            except Failure as failure:
                raise SystemExit(f"time_by_stage.py: {failure}") from failure
            found += more
    total = found.total()
    rows = []
    for stage in stages:
        inside = collections.Counter({function: n for (name, function), n in found.items() if name == stage})
        most = ", ".join(f"{function} {100 * n / inside.total():.0f}" for function, n in inside.most_common(SHOWN))
        rows.append([stage, f"{100 * inside.total() / total:.1f} %", most])
    everywhere = collections.Counter()
    for (_, function), n in found.items():
        everywhere[function] += n
    rows.append(["all", f"{total:,} samples", ", ".join(f"{function} {100 * n / total:.0f}" for function, n in everywhere.most_common(8))])
    text = table(["stage", "share of the CPU time", "functions with most of it, % of the stage"], rows, texts=3)
    text += f"\n{by_kind(everywhere, total)}"
    print(text)
    if arguments.update:
        keep(arguments.update, "profile", f"{how}\n{text}")


if __name__ == "__main__":
    main()
