#!/usr/bin/env python3
"""run.py --program PROGRAM --build BUILD [--runs 3] [--quick] [--update FILE]

Times the program beside CGAL's Mesh_3 and TetGen on the same contours and prints the tables of docs/benchmarks.md as
Markdown. Every figure is the median of the runs, which take turns, so that a busy moment of the machine does not fall
on one contender alone; a contender that takes more than half a minute runs once. Shapes are measured by one function for all (measure_model of the core library).

Data: the CT skull of Debian's package invesalius-examples, and what is found of more data in ANATOMESH_DATA (default
../shared/data). --quick: the skull once. --update: puts the tables into FILE between its two markers.
"""
import argparse
import datetime
import json
import math
import os
import pathlib
import platform
import statistics
import subprocess
import sys
import tempfile
import time

SOURCE = pathlib.Path(__file__).resolve().parent.parent
BEGIN, END = "<!-- measured: begin -->", "<!-- measured: end -->"
MAX_EXPONENT = 1.2
TIME_LIMIT = 150  # seconds a contender may take
SLOW = 30  # a contender that takes longer runs once

# Mesh_3 bounds circumradii, not edges. In our target edge lengths; these give the mean edge length that ours has.
FACET_RADIUS, CELL_RADIUS, FACET_DISTANCE, SURFACE_ERROR = 0.7, 0.7, 0.1, 0.02

SKULL_OPTIONS = ["--threshold", "226", "--keep-largest", "1"]
MORE_DATA = [  # name, file, options; every file lists its contours or labels on parallel slices
    ("spleen (1 structure)", "contours/spleen_ct_3mm.csl", ["--frame", "RAS"]),
    ("abdomen (5)", "contours/abdomen_mr_20x3mm_spleen_liver_kidneys.csl", ["--frame", "RAS"]),
    ("pelvis (11)", "contours/pelvis_ct_labels_3mm.csl", ["--frame", "RAS"]),
    ("spine (9)", "contours/spine_ct_axial_1mm_simplified.csl", ["--frame", "RAS"]),
    ("spine labels (9)", "spine_ct_labels/sub-verse004_seg-vert_msk.nii.gz", []),
    ("body labels (61)", "body_ct_mr_labels/example_seg_fast_force_split.nii.gz", []),
]


class Failure(Exception):
    pass


def note(text):
    print(text, file=sys.stderr, flush=True)


def run(words, accept=(0,)):
    """Standard output, seconds, CPU seconds and peak megabytes of a command."""
    words = [str(word) for word in words]
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        start = time.monotonic()
        process = subprocess.Popen(words, stdout=out, stderr=err, stdin=subprocess.DEVNULL)
        deadline = start + TIME_LIMIT
        while True:
            pid, status, usage = os.wait4(process.pid, os.WNOHANG)
            if pid:
                break
            if time.monotonic() > deadline:
                process.kill()
                os.wait4(process.pid, 0)
                process.returncode = -9
                raise Failure(f"not done after {TIME_LIMIT} s")
            time.sleep(0.002)
        seconds = time.monotonic() - start
        process.returncode = os.waitstatus_to_exitcode(status)
        out.seek(0)
        err.seek(0)
        text, errors = out.read().decode("utf-8", "replace"), err.read().decode("utf-8", "replace")
    if process.returncode not in accept:
        lines = (errors + text).strip().splitlines()
        raise Failure(f"exit code {process.returncode}: {lines[-1] if lines else ''}")
    return {"out": text, "seconds": seconds, "cpu": usage.ru_utime + usage.ru_stime, "mb": usage.ru_maxrss / 1024}


class Bench:
    def __init__(self, arguments, folder):
        self.program, self.build, self.folder = arguments.program, pathlib.Path(arguments.build), folder

    def ours(self, words, threads=1):
        report = self.folder / "ours.json"
        done = run([self.program, "model", *words, "--threads", threads, "--quiet", "-o", self.folder / "ours.vtu",
                    "--report", report])
        result = figures(json.loads(report.read_text()), done)
        result["stages"]["writing"] = max(0.0, done["seconds"] - sum(result["stages"].values()))
        return result

    def cgal(self, words, size, variant="sequential", threads=1, slivers=False, surface=None):
        extra = (["--perturb-exude"] if slivers else []) + (["--surface", surface] if surface else [])
        done = run([self.build / f"bench/anatomesh_peers_{variant}", "cgal", *words, "--threads", threads, *extra,
                    "--facet-radius", f"{FACET_RADIUS * size:.9f}", "--cell-radius", f"{CELL_RADIUS * size:.9f}",
                    "--facet-distance", f"{FACET_DISTANCE * size:.9f}",
                    "--surface-error", f"{SURFACE_ERROR * size:.9f}"])
        answer = json.loads(done["out"])
        # What measuring took does not count.
        done.update(seconds=sum(answer["seconds"].values()), cpu=answer["cpu_seconds"], mb=answer["peak_memory_mb"])
        result = figures(answer["report"], done)
        result["stages"] = answer["seconds"]
        return result

    def tetgen(self, words, surface):
        done = run(["tetgen", "-pq1.414YgQ", surface])
        answer = run([self.build / "bench/anatomesh_peers_sequential", "measure", "--model",
                      surface.with_suffix(".1.mesh"), *words])
        return figures(json.loads(answer["out"])["report"], done)


def figures(report, done):
    """What the tables show of one run."""
    quality, structures = report["quality"], report["structures"]

    def total(key):
        return sum(structure[key] for structure in structures)

    differences = [abs(s["volume_mesh_mm3"] / s["volume_field_mm3"] - 1) for s in structures if s["volume_field_mm3"]]
    return {
        "seconds": done["seconds"], "cpu": done["cpu"], "mb": done["mb"],
        "tetrahedra": report["counts"]["tetrahedra"],
        "contour_vertices": total("contour_vertices"), "on_surface": total("contour_vertices_on_surface"),
        "size_mm": report["sizes"]["size_mm"],
        "radius_edge": {key: quality["radius_edge"][key] for key in ("mean", "max", "share_over_2")},
        "dihedral": {key: quality["dihedral_deg"][key] for key in ("min", "p01_of_min", "median_of_min")},
        "edge_mm": quality["edge_mm"]["mean"],
        "below_10": quality["dihedral_deg"]["tetrahedra_below_10"],
        "open_edges": total("open_edges"), "nonmanifold_edges": total("nonmanifold_edges"),
        "nonmanifold_vertices": total("nonmanifold_vertices"),
        "volume_difference": max(differences, default=math.nan),
        "stages": {stage["name"]: stage["seconds"] for stage in report["timing"]["stages"]},
    }


def median(runs):
    """The median of every figure over the runs: of the numbers one by one, also inside dictionaries."""
    first = runs[0]
    if isinstance(first, dict):
        return {key: median([each[key] for each in runs]) for key in first}
    if any(value is None for value in runs):
        return None
    return statistics.median(runs)


def take_turns(contenders, runs):
    """The medians of the contenders (name -> function); of one that failed, the reason as a text."""
    results = {name: [] for name in contenders}
    failed = {}
    for turn in range(runs):
        for name, contender in contenders.items():
            if name in failed or (results[name] and results[name][0]["seconds"] > SLOW):
                continue
            note(f"  run {turn + 1} of {runs}: {name}")
            try:
                results[name].append(contender())
            except Failure as failure:
                failed[name] = str(failure)
                note(f"    {failure}")
    return {name: failed.get(name) or median(results[name]) for name in contenders}


def table(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|---|" + "---:|" * (len(head) - 1)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows]) + "\n"


def count(value):
    return f"{value:,.0f}"


def ratio(value, digits=2):
    return "infinite" if value is None else f"{value:.{digits}f}"


def percent(value, digits=2):
    return "-" if value is None or math.isnan(value) else f"{100 * value:.{digits}f} %"


FIGURES = [
    ("whole command, s", lambda r: f"{r['seconds']:.2f}"),
    ("CPU, s", lambda r: f"{r['cpu']:.2f}"),
    ("tetrahedra", lambda r: count(r["tetrahedra"])),
    ("tetrahedra a second", lambda r: count(r["tetrahedra"] / r["seconds"])),
    ("mean edge, mm", lambda r: f"{r['edge_mm']:.2f}"),
    ("peak memory, MB", lambda r: count(r["mb"])),
    ("contour vertices on the surface", lambda r: f"{count(r['on_surface'])} ({percent(r['on_surface'] / r['contour_vertices'])})"),
    ("open edges", lambda r: count(r["open_edges"])),
    ("non-manifold edges", lambda r: count(r["nonmanifold_edges"])),
    ("non-manifold vertices", lambda r: count(r["nonmanifold_vertices"])),
    ("volume against the field's", lambda r: percent(r["volume_difference"], 3)),
    ("radius-edge, mean", lambda r: ratio(r["radius_edge"]["mean"])),
    ("radius-edge, max", lambda r: ratio(r["radius_edge"]["max"])),
    ("radius-edge above 2", lambda r: percent(r["radius_edge"]["share_over_2"], 3)),
    ("dihedral angle, min", lambda r: f"{r['dihedral']['min']:.2f}"),
    ("dihedral angle, 1 %", lambda r: f"{r['dihedral']['p01_of_min']:.1f}"),
    ("dihedral angle, median", lambda r: f"{r['dihedral']['median_of_min']:.1f}"),
    ("tetrahedra with an angle below 10", lambda r: count(r["below_10"])),
]


def comparison(results):
    """Figures down, contenders across."""
    done = {name: result for name, result in results.items() if not isinstance(result, str)}
    rows = [[name, *(show(result) for result in done.values())] for name, show in FIGURES]
    speeds = [result["tetrahedra"] / result["seconds"] for result in done.values()]
    rows.append(["its tetrahedra a second / the first column's", *(f"{speed / speeds[0]:.2f}" for speed in speeds)])
    text = table(["", *done], rows)
    for name, result in results.items():
        if isinstance(result, str):
            text += f"\n{name}: no mesh ({result}).\n"
    return text


def stages(results):
    names = list(next(iter(results.values()))["stages"])
    rows = [[name, *(f"{result['stages'][name]:.2f}" for result in results.values())] for name in names]
    return table(["stage, s", *results], rows)


def meshing_seconds(result):
    return sum(seconds for name, seconds in result["stages"].items() if name not in ("read", "contours", "writing"))


def exponent(points):
    """Slope of log(y) over log(x) by least squares."""
    xs, ys = [math.log(x) for x, _ in points], [math.log(y) for _, y in points]
    x_mean, y_mean = statistics.fmean(xs), statistics.fmean(ys)
    return sum((x - x_mean) * (y - y_mean) for x, y in zip(xs, ys)) / sum((x - x_mean) ** 2 for x in xs)


def growth(bench, skull, runs):
    contenders = {every: (lambda words=[skull, *SKULL_OPTIONS, "--every", every]: bench.ours(words)) for every in (8, 4, 2, 1)}
    results = take_turns(contenders, runs)
    for every, result in results.items():
        if isinstance(result, str):
            return f"every {every}: no model ({result}).\n"
    rows = [[str(every), count(r["contour_vertices"]), f"{r['size_mm']:.2f}", count(r["tetrahedra"]),
             f"{meshing_seconds(r):.2f}", f"{r['cpu']:.2f}", count(r["mb"])] for every, r in results.items()]
    slope = exponent([(r["contour_vertices"], meshing_seconds(r)) for r in results.values()])
    cpu_slope = exponent([(r["contour_vertices"], r["cpu"]) for r in results.values()])
    verdict = "kept" if slope <= MAX_EXPONENT else "NOT kept"
    return (table(["every Nth slice", "contour vertices", "size, mm", "tetrahedra", "meshing, s", "CPU, s", "MB"], rows) +
            f"\nMeshing time grows with contour vertices to the power of **{slope:.2f}** (at most {MAX_EXPONENT}: {verdict}); "
            f"CPU time of the whole command, {cpu_slope:.2f}.\n")


def more_data(bench, root, runs):
    rows = []
    for name, file, options in MORE_DATA:
        if not (root / file).exists():
            continue
        note(name)
        words = [root / file, *options]
        ours = take_turns({"anatomesh": lambda: bench.ours(words)}, runs)["anatomesh"]
        if isinstance(ours, str):
            rows.append([name, "anatomesh", f"no model: {ours}", *[""] * 9])
            continue
        peer = take_turns({"CGAL": lambda: bench.cgal(words, ours["size_mm"])}, runs)["CGAL"]
        for who, r in (("anatomesh", ours), ("CGAL", peer)):
            if isinstance(r, str):
                rows.append([name, who, f"no mesh: {r}", *[""] * 9])
                continue
            rows.append([name, who, f"{r['seconds']:.2f}", f"{r['cpu']:.2f}", count(r["tetrahedra"]), count(r["tetrahedra"] / r["seconds"]),
                         count(r["mb"]), percent(r["on_surface"] / r["contour_vertices"]),
                         f"{count(r['open_edges'])} / {count(r['nonmanifold_edges'])} / {count(r['nonmanifold_vertices'])}",
                         percent(r["volume_difference"], 3),
                         f"{ratio(r['radius_edge']['mean'])} / {percent(r['radius_edge']['share_over_2'], 3)}",
                         f"{r['dihedral']['min']:.2f} / {r['dihedral']['p01_of_min']:.1f} / {r['dihedral']['median_of_min']:.1f}"])
    if not rows:
        return "No more data found (ANATOMESH_DATA).\n"
    return table(["data (structures)", "mesher", "s", "CPU, s", "tetrahedra", "a second", "MB", "contour vertices on the surface",
                  "edges open / non-manifold, vertices non-manifold", "largest volume difference",
                  "radius-edge mean / above 2", "dihedral min / 1 % / median"], rows)


def micro(build):
    done = json.loads(run([build / "bench/anatomesh_micro", "--benchmark_format=json", "--benchmark_min_time=0.3"])["out"])
    rows = []
    for each in done["benchmarks"]:
        rates = [f"{each[key]:.3g} {key}" for key in each if key.endswith("/s")]
        rows.append([each["name"], f"{each['cpu_time']:,.3f} {each['time_unit']}", ", ".join(rates)])
    return table(["piece", "CPU time", "rate"], rows)


def first_line(words):
    try:
        return subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True).stdout.splitlines()[0].strip()
    except (OSError, IndexError):
        return "unknown"


def machine():
    model = platform.machine()
    for line in pathlib.Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            model = line.split(":", 1)[1].strip()
            break
    packages = [f"{name} {first_line(['dpkg-query', '-W', '-f=${Version}', name])}" for name in ("libcgal-dev", "tetgen")]
    return (f"{datetime.date.today().isoformat()}; {os.cpu_count()} cores, {model}; load before the start "
            f"{os.getloadavg()[0]:.1f}; {first_line(['c++', '--version'])}, -O2; {', '.join(packages)}.\n")


def write_tables(arguments, folder, emit):
    bench = Bench(arguments, folder)
    found = subprocess.run([SOURCE / "scripts/skull.sh"], cwd=SOURCE, stdout=subprocess.PIPE, text=True, check=True)
    skull = SOURCE / found.stdout.strip()
    words = [skull, *SKULL_OPTIONS, "--every", "2"]
    runs = f"Medians of {arguments.runs} runs; of what takes more than {SLOW} s, one run." if arguments.runs > 1 else "One run each."
    emit(f"Measured {machine()}\n{runs}\n")

    note("skull")
    try:
        size = bench.ours(words)["size_mm"]  # also warms the file cache
    except Failure as failure:
        sys.exit(f"run.py: the program makes no model of the skull: {failure}")
    surface = folder / "skull.poly"
    contenders = {
        "anatomesh": lambda: bench.ours(words),
        "anatomesh, 2 threads": lambda: bench.ours(words, threads=2),
        "CGAL": lambda: bench.cgal(words, size, surface=surface),
        "CGAL, 2 threads": lambda: bench.cgal(words, size, variant="parallel", threads=2),
        "CGAL + perturb + exude": lambda: bench.cgal(words, size, slivers=True),
        "TetGen on CGAL's surface": lambda: bench.tetgen(words, surface),
    }
    results = take_turns(contenders, arguments.runs)
    emit(f"### The skull, every 2nd slice, target edge {size:.2f} mm\n")
    emit(comparison(results))
    ours = {name: result for name, result in results.items() if name.startswith("anatomesh") and not isinstance(result, str)}
    emit("### Seconds by stage\n")
    emit(stages(ours))
    if arguments.quick:
        return
    note("growth")
    emit("### Growth with the number of contour vertices (skull, 1 thread)\n")
    emit(growth(bench, skull, arguments.runs))
    emit("### More data (1 thread, one run each)\n")
    root = pathlib.Path(os.environ.get("ANATOMESH_DATA") or SOURCE.parent / "shared/data")
    emit(more_data(bench, root, 1))
    note("pieces")
    emit("### Hot pieces alone (1 thread)\n")
    emit(micro(bench.build))


def update(path, text):
    page = path.read_text()
    before, rest = page.split(BEGIN)
    _, after = rest.split(END)
    path.write_text(f"{before}{BEGIN}\n{text}\n{END}{after}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", type=pathlib.Path, default=SOURCE / "build/release/anatomesh")
    parser.add_argument("--build", type=pathlib.Path, default=SOURCE / "build/release")
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--update", type=pathlib.Path)
    arguments = parser.parse_args()
    arguments.program = arguments.program.resolve()
    parts = []

    def emit(text):
        parts.append(text)
        print(text, flush=True)

    with tempfile.TemporaryDirectory(prefix="anatomesh-bench-") as folder:
        write_tables(arguments, pathlib.Path(folder), emit)
    if arguments.update:
        update(arguments.update, "\n".join(parts))


if __name__ == "__main__":
    main()
