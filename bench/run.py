#!/usr/bin/python3
"""The program beside every mesher that Debian has, on every case, in one table of Markdown.

    bench/run.py --update docs/benchmarks.md            every case, and keeps the tables in that page
    bench/run.py --case spleen --runs 1                 one case, once
    bench/run.py --all --update docs/benchmarks.md      also the growth (growth.py), segmentation beside labels, hot pieces alone

Needs `make bench` before (it builds the program and CGAL's Mesh_3 as a peer). Seconds are medians of the runs, which take turns, so
that a busy moment of the machine does not fall on one contender alone; the first model of each is judged by measuring.py, which shares
no code with the program. A contender that refuses, crashes or takes too long is a row that says so. Data: the CT skull of Debian's
package invesalius-examples; pelvis, spine, spleen and fetal brain in the folder of --data or ANATOMESH_DATA (default ../shared/data).
"""
import argparse
import json
import pathlib
import statistics
import tempfile

import growth
from common import (DATA, SKULL_OPTIONS, SOURCE, Failure, command, count, keep, machine, median, note, run, skull, table,
                    take_turns)
from contenders import Case

CASES = [  # name, file in the folder of data, or none for the skull, options
    ("skull, every 2nd slice", None, [*SKULL_OPTIONS, "--every", "2"]),
    ("pelvis (11 structures)", "contours/pelvis_ct_labels_3mm.csl", ["--frame", "RAS"]),
    ("spine (9)", "contours/spine_ct_axial_1mm_simplified.csl", ["--frame", "RAS"]),
    ("spleen", "contours/spleen_ct_3mm.csl", ["--frame", "RAS"]),
    ("fetal brain, planes in 3 orientations", "contours/fetal_brain_mr_3orient_aligned.csl", ["--frame", "RAS"]),
]
SEGMENTED = "body_ct_mr_labels"  # a CT and labels of it
HEAD = ["data", "mesher", "s", "with its surface, s", "CPU, s", "tetrahedra", "a second", "MB", "radius-edge mean / max / above 2",
        "dihedral angle min / 0.1 % / median", "manifold (bad edges / vertices)", "from the contours, mm: mean / max",
        "contour vertices on the surface"]
RATIOS = ["CGAL's meshing alone, 1 thread each (asked: 1.5)", "CGAL, 1 thread each", "CGAL, 2 threads each",
          "CGAL + perturb + exude, 1 thread", "the same, ours on 2 threads (asked: 10)", "ours on 2 threads over 1, meshing stages alone (asked: 1.6)"]
NOT_MESHING = (*growth.NOT_MESHING, "writing")
# Not in Debian 12, so not run here: figures that others measured, on a synthetic skull of 137,000 tetrahedra and on 40,000 points.
GIVEN = [
    ["a synthetic skull, as given", "MMG3D, optimising a mesh", "6 more", "", "", "137,000", "", "", "0.88 / 3.0 /",
     "12.8 (27.7 at 1 %)", "yes", "", ""],
    ["40,000 points of a skull, as given", "geogram, Delaunay alone, 1 and 2 threads", "0.125, 0.090", "", "", "", "", "", "", "", "", "", ""],
]


def row(case, name, runs, surfaces):
    """surfaces: whose -> seconds that the model took which the surface is of."""
    if isinstance(runs, str):
        return [case, name, f"no model: {runs[:200].replace('|', '/')}", *[""] * (len(HEAD) - 3)]
    found = runs[0]["figures"]
    seconds, whole = median(runs, "seconds"), ""
    if "surface" in runs[0]:
        name += f" on {runs[0]['surface']}{' surface' if runs[0]['surface'] != 'ours' else ''}"
        name += f" ({runs[0]['refused'][:160]})" if runs[0]["refused"] else ""
        before = surfaces.get(runs[0]["surface"])
        whole = "" if before is None else f"{seconds + before:.2f}"
    bad = (found["bad_edges"], found["bad_vertices"])
    ratio, angle, apart = found["radius_edge"], found["dihedral"], found["contour_distance"]
    return [case, name, f"{seconds:.2f}", whole, f"{median(runs, 'cpu'):.2f}", count(found["tetrahedra"]),
            count(found["tetrahedra"] / max(seconds, 1e-9)), count(median(runs, "mb")),
            f"{ratio['mean']:.2f} / {ratio['max']:.1f} / {100 * ratio['share_over_2']:.2f} %",
            f"{angle['min']:.2f} / {angle['p001']:.1f} / {angle['median']:.1f}",
            "yes" if bad == (0, 0) else f"no ({count(bad[0])} / {count(bad[1])})", f"{apart['mean']:.4f} / {apart['max']:.3f}",
            f"{100 * found['on_surface'] / max(1, found['contour_vertices']):.2f} %"]


def chosen(contenders, names):
    """Those of exactly these names, or of names that begin so; all without names."""
    wanted = {each for name in names for each in ([name] if name in contenders else
                                                  [who for who in contenders if who.lower().startswith(name.lower())])}
    return {who: contender for who, contender in contenders.items() if not names or who in wanted}


def one_case(arguments, name, words):
    """Rows of the table, and the runs of the contenders."""
    note(name)
    with tempfile.TemporaryDirectory(prefix="anatomesh-bench-") as folder:
        case = Case(arguments.program, arguments.build, words, pathlib.Path(folder), arguments.limit)
        try:
            case.prepare()
        except Failure as failure:
            return [row(name, "anatomesh", str(failure), {})], {}
        done = take_turns(chosen(case.contenders(), arguments.mesher), arguments.runs, arguments.slow)
    surfaces = {whose: median(done[who], "seconds") for whose, who in (("CGAL's", "CGAL"), ("ours", "anatomesh"))
                if not isinstance(done.get(who, ""), str)}
    return [row(name if i == 0 else "", who, runs, surfaces) for i, (who, runs) in enumerate(done.items())], done


def cases(arguments):
    """After every case: the table of every mesher on the cases so far, and that of our stages."""
    rows, ratio_rows, ours = [], [], {}
    for name, file, options in CASES:
        if arguments.case and not any(name.startswith(each) for each in arguments.case):
            continue
        path = skull() if file is None else arguments.data / file
        if path is None or not path.exists():
            rows.append([name, f"left out: no {file or 'Cranium.inv3'}", *[""] * (len(HEAD) - 2)])
        else:
            more, done = one_case(arguments, name, [path, *options])
            rows += more
            ratio_rows += [[name, *ratios(done)]] if done else []
            ours.update({(name, who): runs for who, runs in done.items() if who.startswith("anatomesh") and not isinstance(runs, str)})
        text = table(HEAD, rows + GIVEN, texts=2)
        if ratio_rows:
            text += f"\nTetrahedra a second of ours, as so many times those of:\n\n{table(['data', *RATIOS], ratio_rows)}"
        yield text, stages(ours)


def meshing(runs):
    return statistics.median(sum(seconds for stage, seconds in each["stages"].items() if stage not in NOT_MESHING) for each in runs)


def ratios(done):
    """What is asked of the speed: case -> columns beside RATIOS; of what could not be run, a dash."""
    def speed(who, seconds="seconds"):
        runs = done.get(who, "")
        return None if isinstance(runs, str) else runs[0]["figures"]["tetrahedra"] / median(runs, seconds)

    def ratio(above, below):
        return "-" if above is None or below is None else f"{above / below:.2f}"

    one, two = (done.get(who, "") for who in ("anatomesh", "anatomesh, 2 threads"))
    return [ratio(speed("anatomesh"), speed("CGAL", "meshing")), ratio(speed("anatomesh"), speed("CGAL")),
            ratio(speed("anatomesh, 2 threads"), speed("CGAL, 2 threads")),
            ratio(speed("anatomesh"), speed("CGAL + perturb + exude")), ratio(speed("anatomesh, 2 threads"), speed("CGAL + perturb + exude")),
            "-" if isinstance(one, str) or isinstance(two, str) else f"{meshing(one) / meshing(two):.2f}"]


def stages(ours):
    """Columns: cases on one and on two threads."""
    if not ours:
        return "No model.\n"
    columns = list(ours.items())
    names = list(dict.fromkeys(stage for _, runs in columns for stage in runs[0]["stages"]))
    rows = [[stage, *(f"{median(runs, 'stages', stage):.2f}" if stage in runs[0]["stages"] else "-" for _, runs in columns)]
            for stage in names]
    rows.append(["whole command", *(f"{median(runs, 'seconds'):.2f}" for _, runs in columns)])
    heads = [f"{case.split(',')[0].split(' (')[0]}{', 2 threads' if '2' in who else ''}" for (case, who), _ in columns]
    return table(["stage, s", *heads], rows)


def micro(arguments):
    done = json.loads(run([arguments.build / "bench/anatomesh_micro", "--benchmark_format=json", "--benchmark_min_time=0.3"],
                          arguments.limit)["out"])
    rows = []
    for each in done["benchmarks"]:
        rates = [f"{each[key]:.3g} {key}" for key in each if key.endswith("/s")]
        rows.append([each["name"], f"{each['cpu_time']:,.3f} {each['time_unit']}", ", ".join(rates)])
    return table(["piece, 1 thread", "CPU time", "rate"], rows)


def segmentation(arguments):
    if not (arguments.data / SEGMENTED).exists():
        return f"Left out: no {SEGMENTED}.\n"
    return run([SOURCE / "bench/segment_dice.py", "--program", arguments.program, "--data", arguments.data / SEGMENTED],
               arguments.limit)["out"]


def parse():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", type=pathlib.Path, default=SOURCE / "build/release/anatomesh")
    parser.add_argument("--build", type=pathlib.Path, default=SOURCE / "build/release", help="where bench/anatomesh_peers_* are")
    parser.add_argument("--data", type=pathlib.Path, default=DATA, help="folder of real data (default: ANATOMESH_DATA, ../shared/data)")
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--case", action="append", default=[], help="cases whose names begin so; may be repeated")
    parser.add_argument("--mesher", action="append", default=[], help="the mesher of this name, or those whose names begin so; may be repeated")
    parser.add_argument("--limit", type=float, default=180, help="seconds that a contender may take (default 180)")
    parser.add_argument("--slow", type=float, default=10, help="what takes more seconds runs once (default 10)")
    parser.add_argument("--all", action="store_true", help="also growth, segmentation and hot pieces")
    parser.add_argument("--update", type=pathlib.Path, metavar="PAGE", help="put the tables between their markers in PAGE")
    arguments = parser.parse_args()
    arguments.program = arguments.program.resolve()
    return arguments


def main():
    arguments = parse()
    how = f"{machine()}{command()}"
    turns = (f"Medians of {arguments.runs} runs; one of what takes more than {arguments.slow:g} s." if arguments.runs > 1 else "One run each.")

    def update(name, text):
        if arguments.update:
            keep(arguments.update, name, f"{how}\n{text}")

    def emit(name, text):
        print(f"### {name}\n\n{text}", flush=True)
        update(name, text)

    tables = {}
    for every_case, by_stage in cases(arguments):
        tables = {"every mesher on every case": f"{turns}\n\n{every_case}", "seconds by stage": f"{turns}\n\n{by_stage}"}
        for name, text in tables.items():
            update(name, text)
    for name, text in tables.items():
        print(f"### {name}\n\n{text}", flush=True)
    if arguments.all:
        emit("growth", growth.tables(arguments.program, growth.MOST, 1))
        emit("segmentation beside labels", segmentation(arguments))
        emit("hot pieces", micro(arguments))


if __name__ == "__main__":
    main()
