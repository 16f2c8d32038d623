#!/usr/bin/python3
"""Time and memory of the program from 50,000 to 20 million tetrahedra, on one and two threads, with the exponents.

    bench/growth.py --update docs/benchmarks.md               the CT skull, to 20 million: seven minutes, 9 GB
    bench/growth.py --max 1000000                             no further than a million
    bench/growth.py --sizes 6,4,3 -- spleen.csl --frame RAS   other data, at these target edge lengths in mm

Needs `make` before. The skull is that of Debian's package invesalius-examples. The largest rows have every 2nd slice; the smallest leave
more slices out, because every contour vertex is in the mesh and bounds it from below.
"""
import argparse
import json
import pathlib
import tempfile

from common import SKULL_OPTIONS, SOURCE, command, count, exponent, keep, machine, median, note, run, skull, table, take_turns

MOST = 20e6
SERIES = [  # every Nth slice, target edge length in mm, tetrahedra about
    (16, 16, 50e3), (8, 9, 90e3), (4, 4.4, 170e3), (2, 3.27, 330e3), (2, 2.1, 940e3), (2, 1.4, 2.8e6), (2, 0.9, 10e6), (2, 0.695, 20e6),
]
CONTOURS = (8, 4, 2, 1)  # every Nth slice, the target edge length as the program finds it
THREADS = (1, 2)
MAX_EXPONENT, MAX_CONTOUR_EXPONENT = 1.1, 1.2
TEN_MILLION, TEN_MILLION_SECONDS, TEN_MILLION_MB = (9.5e6, 11e6), 60, 8192  # asked of two threads
LIMIT = 600  # seconds a run may take
NOT_MESHING = ("read", "contours", "reconcile")


def modelled(program, words, threads):
    """What one run cost, and what its report says of the model."""
    with tempfile.TemporaryDirectory(prefix="anatomesh-growth-") as folder:
        report = pathlib.Path(folder) / "report.json"
        done = run([program, "model", *words, "--threads", threads, "--quiet", "-o", pathlib.Path(folder) / "model.vtu",
                    "--report", report], LIMIT)
        made = json.loads(report.read_text())
    done["size"] = made["sizes"]["size_mm"]
    done["tetrahedra"] = made["counts"]["tetrahedra"]
    done["contour_vertices"] = made["counts"]["contour_vertices"]
    done["quality"] = made["quality"]
    done["meshing"] = sum(stage["seconds"] for stage in made["timing"]["stages"] if stage["name"] not in NOT_MESHING)
    return done


def verdict(value, bound):
    return f"at most {bound:g}: {'kept' if value <= bound else 'NOT kept'}"


def steepest(points):
    return max(exponent(points[i:i + 2]) for i in range(len(points) - 1))


def over_tetrahedra(program, series, runs):
    """series: label -> words. The table, the exponents, and what is asked of ten million."""
    def named(label, threads):
        return f"{label}, {threads} thread{'s' * (threads > 1)}"

    contenders = {named(label, threads): (lambda words=words, threads=threads: modelled(program, words, threads))
                  for label, words in series.items() for threads in THREADS}
    done = take_turns(contenders, runs, slow=10)
    rows, points = [], {(key, threads): [] for key in ("seconds", "cpu", "mb") for threads in THREADS}
    for label in series:
        results = [done[named(label, threads)] for threads in THREADS]
        refused = [result for result in results if isinstance(result, str)]
        if refused:
            rows.append([label, f"no model: {refused[0][:160]}", *[""] * 9])
            continue
        for threads, result in zip(THREADS, results):
            for key in ("seconds", "cpu", "mb"):
                points[key, threads].append((result[0]["tetrahedra"], median(result, key)))
        one, two = results
        quality, tetrahedra = one[0]["quality"], one[0]["tetrahedra"]
        rows.append([label, count(tetrahedra), *(f"{median(each, key):.2f}" for key in ("seconds", "cpu") for each in results),
                     *(count(median(each, "mb")) for each in results), f"{1e6 * median(one, 'cpu') / tetrahedra:.1f}",
                     count(median(two, "mb") * 2 ** 20 / tetrahedra),
                     f"{quality['radius_edge']['mean']:.2f} / {quality['radius_edge']['max']:.1f} / {quality['dihedral_deg']['min']:.1f}"])
    text = table(["input, target edge", "tetrahedra", "s, 1 thread", "2 threads", "CPU s, 1 thread", "2 threads", "MB, 1 thread", "2 threads",
                  "CPU microseconds a tetrahedron, 1 thread", "bytes a tetrahedron, 2 threads", "ratio mean / max, least angle"], rows)
    return text + exponents(points) + ten_million(points)


def exponents(points):
    if min(len(each) for each in points.values()) < 2:
        return "\nToo few models for exponents.\n"
    names = {"seconds": "time", "cpu": "CPU time", "mb": "memory"}
    rows, worst = [], 0
    for (key, threads), each in points.items():
        fit, most = exponent(each), steepest(each)
        worst = max(worst, fit, most)
        rows.append([f"{names[key]}, {threads} thread{'s' * (threads > 1)}", f"{fit:.2f}", f"{most:.2f}"])
    return (f"\n{table(['power of the tetrahedra', 'by least squares', 'most between neighbouring rows'], rows)}"
            f"\nThe largest exponent is **{worst:.2f}** ({verdict(worst, MAX_EXPONENT)}).\n")


def ten_million(points):
    low, high = TEN_MILLION
    text = ""
    for (tetrahedra, seconds), (_, mb) in zip(points["seconds", 2], points["mb", 2]):
        if low <= tetrahedra <= high:
            text += (f"\n{count(tetrahedra)} tetrahedra on 2 threads: {seconds:.1f} s ({verdict(seconds, TEN_MILLION_SECONDS)}), "
                     f"{count(mb)} MB ({verdict(mb, TEN_MILLION_MB)}).\n")
    return text


def over_contours(program, path, runs):
    """The skull with more and more slices, the target edge length following their distance, as in real use."""
    contenders = {f"every {every}": (lambda every=every: modelled(program, [path, *SKULL_OPTIONS, "--every", every], 1)) for every in CONTOURS}
    rows, points = [], []
    for every, runs_done in take_turns(contenders, runs, slow=10).items():
        if isinstance(runs_done, str):
            rows.append([every, f"no model: {runs_done[:160]}", *[""] * 5])
            continue
        first = runs_done[0]
        points.append((first["contour_vertices"], median(runs_done, "meshing")))
        rows.append([every, count(first["contour_vertices"]), f"{first['size']:.2f}", count(first["tetrahedra"]),
                     f"{points[-1][1]:.2f}", f"{median(runs_done, 'cpu'):.2f}", count(median(runs_done, "mb"))])
    text = table(["slices", "contour vertices", "size, mm", "tetrahedra", "meshing, s", "CPU, s", "MB"], rows)
    if len(points) < 2:
        return text
    slope = exponent(points)
    return (f"{text}\nMeshing time on one thread (all stages after the contours) grows with the contour vertices to the power of "
            f"**{slope:.2f}** ({verdict(slope, MAX_CONTOUR_EXPONENT)}).\n")


def tables(program, most, runs):
    path = skull()
    if path is None:
        return "Left out: no Cranium.inv3.\n"
    note("growth")
    series = {f"skull, every {every}, {size:g} mm": [path, *SKULL_OPTIONS, "--every", every, "--size", size]
              for every, size, about in SERIES if about <= most}
    return f"{over_tetrahedra(program, series, runs)}\n{over_contours(program, path, runs)}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", type=pathlib.Path, default=SOURCE / "build/release/anatomesh")
    parser.add_argument("--max", type=float, default=MOST, help="tetrahedra of the largest model, about (default 20 million)")
    parser.add_argument("--runs", type=int, default=1)
    parser.add_argument("--sizes", help="target edge lengths of other data, mm, with commas")
    parser.add_argument("input", nargs="*", help="other data, with options of `anatomesh model`; after --")
    parser.add_argument("--update", type=pathlib.Path, metavar="PAGE", help="put the tables between their markers in PAGE")
    arguments = parser.parse_args()
    if bool(arguments.sizes) != bool(arguments.input):
        parser.error("--sizes and an input belong together")
    program = arguments.program.resolve()
    how = f"{machine()}{command()}"
    if arguments.input:
        series = {f"{size} mm": [*arguments.input, "--size", size] for size in arguments.sizes.split(",")}
        text = over_tetrahedra(program, series, arguments.runs)
    else:
        text = tables(program, arguments.max, arguments.runs)
    print(text)
    if arguments.update:
        keep(arguments.update, "growth", f"{how}\n{text}")


if __name__ == "__main__":
    main()
