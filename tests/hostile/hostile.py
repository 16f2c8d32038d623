#!/usr/bin/python3
"""Runs the program against hostile inputs and a hostile system, and prints what came of it as tables.

    hostile.py PROGRAM [KIND...] [--cases N] [--faults N] [--kills N] [--answers N] [--seed S] [--workers N] [--keep FOLDER]
                                 [--write PAGE]

Kinds: mutations of files of every format; faults, calls of the system that fail; kills, runs that are ended anywhere;
peers, services and senders that answer with anything. All by default. The exit code is 1 when something was found; what shows a
finding stays in FOLDER, which is then named. The same seed gives the same cases. --write puts the tables into a page, between the
lines FIRST and LAST.
"""
import argparse
import hashlib
import os
import pathlib
import random
import shutil
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import mutations  # noqa: E402
import peers  # noqa: E402

import runs  # noqa: E402
import seeds  # noqa: E402

FIRST, LAST = "<!-- figures of make hostile -->", "<!-- end of figures -->"
OLD = b"what stood there before\n"
CALLS = ("malloc", "open", "read", "write", "rename", "fsync", "pthread_create")
ERRORS = {"open": (2, 13, 24, 23, 5), "read": (5, 4), "write": (28, 5, 4, 27), "rename": (18, 13, 28, 5), "fsync": (5, 28), "malloc": (12,),
          "pthread_create": (11,)}


def state_of(folder):
    """What lies in a folder beside the input, by name."""
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}


def fault_of(run, seed, folder, were_there, can_speak=True):
    """What is wrong after a run; were_there: the outputs stood there before, with other content; can_speak: its messages
    can be written."""
    if run.fault():
        return run.fault()
    files = state_of(folder)
    strange = set(files) - set(seed.outputs)
    if strange:
        return f"left behind: {sorted(strange)}"
    for name in seed.outputs:
        if run.code == 0 and files.get(name, OLD) == OLD:
            return f"exit code 0 without {name}"
        if run.code != 0 and files.get(name) != (OLD if were_there else None):
            return f"exit code {run.code}, and {name} changed"
    if run.code != 0 and can_speak and "E-" not in run.text:
        return f"exit code {run.code} without a message that has a code"
    return None


def mutated(program, found, count, seed, workers, tally):
    def work(case, folder):
        number, which, way = case
        source = random.Random(f"{seed} mutation {number}")
        which.lay(folder, mutations.WAYS[way](which.content, source))
        if were_there := number % 2 == 0:
            for name in which.outputs:
                (folder / name).write_bytes(OLD)
        run = runs.Run([program, *which.words], folder)
        row = which.kind
        tally.add(row, run.code)
        if fault := fault_of(run, which, folder, were_there):
            tally.find(row, f"{way}: {fault}\n{' '.join(which.words)}\n{run.text[-2000:]}", folder)
    ways = list(mutations.WAYS)
    runs.in_parallel([(n, found[n % len(found)], ways[n // len(found) % len(ways)]) for n in range(count)], work, workers)


def library_of_calls(folder):
    library = pathlib.Path(folder) / "calls.so"
    source = pathlib.Path(__file__).resolve().parent / "failing_calls.c"
    subprocess.run([os.environ.get("CC", "cc"), "-shared", "-fPIC", "-O1", "-o", str(library), str(source), "-ldl", "-lm"], check=True)
    return library


def failed(program, found, count, seed, workers, tally, library):
    def work(case, folder):
        number, which, call = case
        source = random.Random(f"{seed} fault {number}")
        most = {"malloc": 4.7, "open": 2.2, "read": 2.2}.get(call, 1.5)
        settings = {"FAIL_CALL": call, "FAIL_AT": str(int(10 ** source.uniform(0, most))), "FAIL_ERRNO": str(source.choice(ERRORS[call])),
                    "LD_PRELOAD": str(library)}
        if source.random() < 0.5 and settings["FAIL_ERRNO"] != "4":
            settings["FAIL_FROM_THEN_ON"] = "1"
        which.lay(folder)
        if were_there := number % 2 == 0:
            for name in which.outputs:
                (folder / name).write_bytes(OLD)
        words = [word if word != "1" else "2" for word in which.words] if call == "pthread_create" else which.words
        run = runs.Run([program, *words], folder, settings)
        row = f"{call} fails"
        tally.add(row, run.code)
        fault = fault_of(run, which, folder, were_there, can_speak=call != "write")
        # Where renaming or syncing itself fails for good, the journal of the outputs may stay for the next run.
        if fault and fault.startswith("left behind") and call in ("rename", "fsync", "open", "write") and "FAIL_FROM_THEN_ON" in settings:
            again = runs.Run([program, *which.words], folder)
            fault = fault_of(again, which, folder, True)
        if fault:
            tally.find(row, f"{fault}\n{settings}\n{' '.join(words)}\n{run.text[-2000:]}", folder)
    runs.in_parallel([(n, found[n // len(CALLS) % len(found)], CALLS[n % len(CALLS)]) for n in range(count)], work, workers)


def killed(program, found, count, seed, workers, tally):
    """Ends a run anywhere: each output is whole, and the next run leaves nothing else behind."""
    writing = [each for each in found if each.outputs]
    whole, seconds = {}, {}

    def learn(which, folder):
        which.lay(folder)
        run = runs.Run([program, *which.words], folder)
        seconds[id(which)] = run.seconds
        whole[id(which)] = {name: hashlib.sha256(without_times(name, content)).hexdigest() for name, content in state_of(folder).items()}
    runs.in_parallel(writing, learn, workers)

    def work(case, folder):
        number, which = case
        source = random.Random(f"{seed} kill {number}")
        which.lay(folder)
        for name in which.outputs:
            (folder / name).write_bytes(OLD)
        share = source.random() if number % 2 else source.uniform(0.8, 1.1)
        run = runs.Run([program, *which.words], folder, kill_after=share * seconds[id(which)])
        row = which.kind
        tally.add(row, 0 if run.code == 0 else 6)
        fault = None
        for name, content in state_of(folder).items():
            right = whole[id(which)].get(name)
            if right and content != OLD and hashlib.sha256(without_times(name, content)).hexdigest() != right:
                fault = f"{name} is neither what it was nor whole"
        again = runs.Run([program, *which.words], folder)
        fault = fault or fault_of(again, which, folder, True)
        if again.code != 0:
            fault = fault or f"the next run ends with {again.code}"
        if fault:
            tally.find(row, f"{fault}\n{' '.join(which.words)}\n{run.text[-1000:]}\n{again.text[-1000:]}", folder)
    runs.in_parallel([(n, writing[n % len(writing)]) for n in range(count)], work, workers)


def without_times(name, content):
    """A report says how long its run took; all else is the same in every run."""
    if not name.endswith(".report.json"):
        return content
    import json
    report = json.loads(content)
    for member in ("timing", "run"):
        report.pop(member, None)
    return json.dumps(report, sort_keys=True).encode()


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("program")
    arguments.add_argument("kinds", nargs="*", metavar="KIND", help="mutations, faults, kills, peers")
    arguments.add_argument("--cases", type=int, default=120, help="mutated files")
    arguments.add_argument("--faults", type=int, default=140, help="failing calls")
    arguments.add_argument("--kills", type=int, default=30, help="killed runs")
    arguments.add_argument("--answers", type=int, default=60, help="answers of hostile peers")
    arguments.add_argument("--seed", default="1")
    arguments.add_argument("--workers", type=int, default=os.cpu_count())
    arguments.add_argument("--keep", help="folder for what shows a finding")
    arguments.add_argument("--write", metavar="PAGE", help="a page whose tables are written anew")
    given = arguments.parse_args()
    program = str(pathlib.Path(given.program).resolve())
    kinds = given.kinds or ["mutations", "faults", "kills", "peers"]
    keep = pathlib.Path(given.keep or tempfile.mkdtemp(prefix="anatomesh-findings-"))
    findings, tables = [], []
    with tempfile.TemporaryDirectory(prefix="anatomesh-seeds-") as folder:
        found = seeds.made(program, folder)
        library = library_of_calls(folder) if "faults" in kinds else None
        for kind in kinds:
            start = time.monotonic()
            tally = runs.Tally(keep / kind)
            if kind == "mutations":
                mutated(program, found, given.cases, given.seed, given.workers, tally)
            elif kind == "faults":
                failed(program, found, given.faults, given.seed, given.workers, tally, library)
            elif kind == "kills":
                killed(program, found, given.kills, given.seed, given.workers, tally)
            elif kind == "peers":
                peers.answered(program, pathlib.Path(folder) / "study", given.answers, given.seed, given.workers, tally)
            else:
                arguments.error(f"there is no kind {kind}")
            tables.append(f"{kind}: {sum(sum(row.values()) for row in tally.rows.values())} cases, {len(tally.findings)} findings, "
                          f"{time.monotonic() - start:.0f} s\n\n{tally.table()}\n")
            print(f"\n{tables[-1]}", flush=True)
            findings += tally.findings
    if given.write:
        page = pathlib.Path(given.write)
        before, _, rest = page.read_text().partition(FIRST)
        page.write_text(f"{before}{FIRST}\n\n" + "\n".join(tables) + f"\n{LAST}" + rest.partition(LAST)[2])
    for row, what, place in findings[:20]:
        print(f"\nFOUND {row}: {what}\n{place}")
    if not findings and not given.keep:
        shutil.rmtree(keep, ignore_errors=True)
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())
