#!/usr/bin/env python3
"""run.py --program PROGRAM --build BUILD [--runs 3] [--case NAME]... [--quick] [--update FILE]

Times the program beside every mesher that Debian has (CGAL's Mesh_3, TetGen, Gmsh, Netgen) on the same contours and prints
the tables of docs/benchmarks.md as Markdown. Every figure is the median of the runs, which take turns, so that a busy moment
of the machine does not fall on one contender alone; a contender that takes more than half a minute runs once. Shapes are
measured by one function for all (measure_model of the core library).

Data: the CT skull of Debian's package invesalius-examples, and pelvis, spine, spleen and fetal brain in ANATOMESH_DATA
(default ../shared/data); what is not there is left out, with a word. --case: only cases whose names begin so, and only their
table. --quick: the table of cases alone. --update: puts the tables into FILE between its two markers.
"""
import argparse
import datetime
import json
import math
import os
import pathlib
import platform
import signal
import statistics
import subprocess
import sys
import tempfile
import time

SOURCE = pathlib.Path(__file__).resolve().parent.parent
BEGIN, END = "<!-- measured: begin -->", "<!-- measured: end -->"
MAX_EXPONENT = 1.2
TIME_LIMIT = 120  # seconds a contender may take
SLOW = 30  # a contender that takes longer runs once

# Mesh_3 bounds circumradii, not edges. In our target edge lengths; these give the mean edge length that ours has.
FACET_RADIUS, CELL_RADIUS, FACET_DISTANCE, SURFACE_ERROR = 0.7, 0.7, 0.1, 0.02

SEGMENTED = "body_ct_mr_labels"  # a CT and labels of it
SKULL_OPTIONS = ["--threshold", "226", "--keep-largest", "1"]
CASES = [  # name, file, options; the skull's file is found by scripts/skull.sh
    ("skull, every 2nd slice", None, [*SKULL_OPTIONS, "--every", "2"]),
    ("pelvis (11 structures)", "contours/pelvis_ct_labels_3mm.csl", ["--frame", "RAS"]),
    ("spine (9)", "contours/spine_ct_axial_1mm_simplified.csl", ["--frame", "RAS"]),
    ("spleen", "contours/spleen_ct_3mm.csl", ["--frame", "RAS"]),
    ("fetal brain, planes in 3 orientations", "contours/fetal_brain_mr_3orient_aligned.csl", ["--frame", "RAS"]),
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
        try:
            process = subprocess.Popen(words, stdout=out, stderr=err, stdin=subprocess.DEVNULL, start_new_session=True)
        except OSError as error:
            raise Failure(f"{words[0]}: {error.strerror}") from error
        deadline = start + TIME_LIMIT
        while True:
            pid, status, usage = os.wait4(process.pid, os.WNOHANG)
            if pid:
                break
            if time.monotonic() > deadline:
                os.killpg(process.pid, signal.SIGKILL)  # with what it started itself
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

    def measured(self, words, model, *options):
        """The report of a mesh that any mesher made of the contours, by one function for all."""
        answer = run([self.build / "bench/anatomesh_peers_sequential", "measure", "--model", model, *options, *words])
        return json.loads(answer["out"])["report"]

    def ours(self, words, threads=1, surface=None):
        report, model = self.folder / "ours.json", self.folder / "ours.vtu"
        done = run([self.program, "model", *words, "--threads", threads, "--quiet", "-o", model, "--report", report])
        result = figures(self.measured(words, model), done)
        made = json.loads(report.read_text())
        result["size_mm"] = made["sizes"]["size_mm"]
        result["stages"] = {stage["name"]: stage["seconds"] for stage in made["timing"]["stages"]}
        result["stages"]["writing"] = max(0.0, done["seconds"] - sum(result["stages"].values()))
        if surface:
            run([self.build / "bench/anatomesh_peers_sequential", "surface", "--model", model, "--surface", surface])
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

    def tetgen(self, words, surface, size):
        done = run(["tetgen", "-pq1.414YgQ", surface])
        return figures(self.measured(words, surface.with_suffix(".1.mesh"), "--relabel"), done)

    def by_script(self, mesher, words, surface, size):
        model = surface.with_suffix(f".{mesher}.mesh")
        done = run(["/usr/bin/python3", SOURCE / "bench/surface_meshers.py", mesher, surface, model, size])
        done["seconds"] = done["cpu"] = json.loads(done["out"].splitlines()[-1])["seconds"]
        return figures(self.measured(words, model, "--relabel"), done)

    def from_surface(self, mesher, words, size, surfaces):
        """On the first surface that the mesher takes: CGAL's, else ours."""
        reasons = []
        for whose, surface in surfaces.items():
            if not surface.exists():
                continue
            try:
                result = mesher(words, surface, size)
                result["surface"] = whose
                return result
            except (Failure, ValueError) as failure:
                reasons.append(f"{whose}: {failure}")
        raise Failure("; ".join(reasons) or "no surface")


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
        "dihedral": {key: quality["dihedral_deg"][key] for key in ("min", "p001_of_min", "p01_of_min", "median_of_min")},
        "contour_distance": {key: report["contour_distance_mm"][key] for key in ("mean", "max")},
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
    if isinstance(first, str):
        return first
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


def one_decimal(value):
    return "-" if value is None else f"{value:.1f}"


CASE_HEAD = ["data", "mesher", "s", "CPU, s", "tetrahedra", "a second", "MB", "radius-edge mean / max / above 2",
             "dihedral angle min / 0.1 % / median", "manifold (bad edges / vertices)", "contour vertices on the surface",
             "from the contours, mm: mean / max", "volume"]


def case_row(case, name, r):
    if isinstance(r, str):
        return [case, name, f"no mesh: {r[:160]}", *[""] * (len(CASE_HEAD) - 3)]
    bad_edges, bad_vertices = r["open_edges"] + r["nonmanifold_edges"], r["nonmanifold_vertices"]
    manifold = "yes" if bad_edges + bad_vertices == 0 else f"no ({count(bad_edges)} / {count(bad_vertices)})"
    radius_edge, dihedral, distance = r["radius_edge"], r["dihedral"], r["contour_distance"]
    if "surface" in r:
        name += f" on {r['surface']}"
    return [case, name, f"{r['seconds']:.2f}", f"{r['cpu']:.2f}", count(r["tetrahedra"]), count(r["tetrahedra"] / max(r["seconds"], 1e-9)),
            count(r["mb"]), f"{ratio(radius_edge['mean'])} / {ratio(radius_edge['max'], 1)} / {percent(radius_edge['share_over_2'])}",
            f"{dihedral['min']:.2f} / {one_decimal(dihedral['p001_of_min'])} / {one_decimal(dihedral['median_of_min'])}", manifold,
            percent(r["on_surface"] / max(1, r["contour_vertices"])), f"{distance['mean']:.4f} / {distance['max']:.3f}",
            percent(r["volume_difference"], 3)]


def one_case(bench, name, words, runs):
    """Rows of the table, and what was measured of the program on 1 and 2 threads; no model: one row."""
    note(name)
    surfaces = {"CGAL's surface": bench.folder / "cgal.poly", "ours": bench.folder / "ours.poly"}
    for path in surfaces.values():
        path.unlink(missing_ok=True)
    try:
        size = bench.ours(words, surface=surfaces["ours"])["size_mm"]  # also warms the file cache
    except Failure as failure:
        return [case_row(name, "anatomesh", str(failure))], {}
    start_from = lambda mesher: bench.from_surface(mesher, words, size, surfaces)
    contenders = {
        "anatomesh": lambda: bench.ours(words),
        "anatomesh, 2 threads": lambda: bench.ours(words, threads=2),
        "CGAL": lambda: bench.cgal(words, size, surface=surfaces["CGAL's surface"]),
        "CGAL, 2 threads": lambda: bench.cgal(words, size, variant="parallel", threads=2),
        "CGAL + perturb + exude": lambda: bench.cgal(words, size, slivers=True),
        "TetGen": lambda: start_from(bench.tetgen),
        "Gmsh HXT": lambda: start_from(lambda *rest: bench.by_script("gmsh", *rest)),
        "Netgen": lambda: start_from(lambda *rest: bench.by_script("netgen", *rest)),
    }
    results = take_turns(contenders, runs)
    rows = [case_row(name if i == 0 else "", who, result) for i, (who, result) in enumerate(results.items())]
    return rows, results


def cases(bench, skull, root, runs, wanted):
    """The table, and the results of the skull."""
    rows, of_skull = [], {}
    for name, file, options in CASES:
        if wanted and not any(name.startswith(each) for each in wanted):
            continue
        path = skull if file is None else root / file
        if path is None or not path.exists():
            note(f"{name}: no {file or 'Cranium.inv3'}, left out")
            rows.append([name, f"left out: no {file or 'Cranium.inv3'}", *[""] * (len(CASE_HEAD) - 2)])
            continue
        more, results = one_case(bench, name, [path, *options], runs)
        rows += more
        if file is None:
            of_skull = results
    return table(CASE_HEAD, rows), of_skull


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
    packages = [f"{name} {first_line(['dpkg-query', '-W', '-f=${Version}', name])}" for name in ("libcgal-dev", "tetgen", "gmsh", "python3-netgen")]
    return (f"{datetime.date.today().isoformat()}; {os.cpu_count()} cores, {model}; load before the start "
            f"{os.getloadavg()[0]:.1f}; {first_line(['c++', '--version'])}, -O2; {', '.join(packages)}.\n")


def write_tables(arguments, folder, emit):
    bench = Bench(arguments, folder)
    found = subprocess.run([SOURCE / "scripts/skull.sh"], cwd=SOURCE, stdout=subprocess.PIPE, text=True)
    skull = SOURCE / found.stdout.strip() if found.returncode == 0 and found.stdout.strip() else None
    runs = f"Medians of {arguments.runs} runs; of what takes more than {SLOW} s, one run." if arguments.runs > 1 else "One run each."
    emit(f"Measured {machine()}\n{runs}\n")

    root = pathlib.Path(os.environ.get("ANATOMESH_DATA") or SOURCE.parent / "shared/data")
    emit("### Every mesher on every case\n")
    text, of_skull = cases(bench, skull, root, arguments.runs, arguments.case)
    emit(text)
    if arguments.case:
        return
    ours = {name: result for name, result in of_skull.items() if name.startswith("anatomesh") and not isinstance(result, str)}
    if ours:
        emit("### The skull: seconds by stage\n")
        emit(stages(ours))
    if arguments.quick:
        return
    if skull:
        note("growth")
        emit("### Growth with the number of contour vertices (skull, 1 thread)\n")
        emit(growth(bench, skull, arguments.runs))
    if (root / SEGMENTED).exists():
        note("segmentation")
        emit("### Segmentation of a CT beside labels that a trained network made\n")
        emit(run([SOURCE / "bench/segment_dice.py", "--program", arguments.program, "--data", root / SEGMENTED])["out"])
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
    parser.add_argument("--case", action="append", default=[])
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
