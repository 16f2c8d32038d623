#!/usr/bin/python3
"""Golden bytes: small inputs of every kind, their models' bytes, and what making them took.

    golden.py PROGRAM                checks every case against golden.json; exit code 1 when one differs
    golden.py PROGRAM --update       writes golden.json anew, for a change that means to change bytes or work
    golden.py PROGRAM --only NAME    one case

Of each case stand there: the SHA-256 of the input, of the .vtu, of the report without `timing` and of the same without
its texts, the same on 1 and on 3 threads; and the work that one thread does: whole meshings, cells made, cells that
improvement edits, places at which the field was asked. These numbers are the same on every machine, so that a slowdown
shows where seconds would not tell; and where the texts of a report alone are others, it is told.
"""
import argparse
import concurrent.futures
import hashlib
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time

import inputs

GOLDEN = pathlib.Path(__file__).resolve().parent / "golden.json"
LIMIT = 60  # seconds a run may take
TEXTS = {"message", "what_was_done", "statement", "evidence", "forced_by", "rules", "rule"}  # of the report, for people


def sha256(content):
    return hashlib.sha256(content).hexdigest()


def without_texts(value):
    if isinstance(value, dict):
        return {key: without_texts(part) for key, part in value.items() if key not in TEXTS}
    return [without_texts(part) for part in value] if isinstance(value, list) else value


def sha256_of_json(value):
    return sha256(json.dumps(value, sort_keys=True, ensure_ascii=False).encode())


def modelled(program, folder, name, options, threads):
    """Hashes of the model and of the report, and the work; a refusal is a result too: its exit code and its message."""
    words = [program, "model", name, "-o", "model.vtu", "--threads", str(threads), "--quiet", *options]
    done = subprocess.run(words, cwd=folder, capture_output=True, text=True, timeout=LIMIT)
    if done.returncode != 0:
        return {"refused": f"exit code {done.returncode}: {done.stderr.strip()}"}, None
    report = json.loads((folder / "model.report.json").read_text())
    work = report.pop("timing").get("work")
    return {"model": sha256((folder / "model.vtu").read_bytes()), "report": sha256_of_json(report),
            "report_without_texts": sha256_of_json(without_texts(report)), "tetrahedra": report["counts"]["tetrahedra"]}, work


def measured(program, case):
    """What the case gives, and how 1 and 3 threads differ, if they do."""
    options, make = inputs.CASES[case]
    with tempfile.TemporaryDirectory(prefix="anatomesh-golden-") as folder:
        folder = pathlib.Path(folder)
        name, content = make()
        content = content if isinstance(content, bytes) else content.encode()
        (folder / name).write_bytes(content)
        found, work = modelled(program, folder, name, options, 1)
        again, _ = modelled(program, folder, name, options, 3)
    return {"input": sha256(content), **found, "work": work}, None if found == again else f"{case}: 1 and 3 threads differ:\n  {found}\n  {again}"


def differences(case, wanted, found):
    if wanted is None:
        return [f"{case}: not in {GOLDEN.name}; run with --update"]
    if wanted["input"] != found["input"]:
        return [f"{case}: this machine writes another input file than the golden run had; models cannot be compared"]
    changed = [key for key in sorted({*wanted, *found}) if wanted.get(key) != found.get(key)]
    if changed == ["report"]:
        return [f"{case}: of the report the texts alone are others"]
    return [f"{case}: {key} was {wanted.get(key)}, is {found.get(key)}" for key in changed]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--update", action="store_true", help="write golden.json anew")
    parser.add_argument("--only", choices=sorted(inputs.CASES), help="one case")
    options = parser.parse_args()
    program = str(pathlib.Path(options.program).resolve())
    golden = json.loads(GOLDEN.read_text()) if GOLDEN.exists() else {}
    failed, start = [], time.monotonic()
    cases = [options.only] if options.only else list(inputs.CASES)
    with concurrent.futures.ProcessPoolExecutor(os.cpu_count()) as workers:
        for case, (found, difference) in zip(cases, workers.map(measured, [program] * len(cases), cases)):
            if options.update and difference is None:
                golden[case] = found
            lines = [difference] if difference else [] if options.update else differences(case, golden.get(case), found)
            failed += [case] if lines else []
            print("\n".join(lines or [f"{case}: {'written' if options.update else 'as it was'}"]))
    if not options.only:
        for case in sorted(golden.keys() - inputs.CASES.keys()):
            failed.append(case)
            print(f"{case}: in {GOLDEN.name}, but no case any more")
    if options.update:
        GOLDEN.write_text(json.dumps({case: golden[case] for case in inputs.CASES if case in golden}, indent=1) + "\n")
    print(f"{len(failed)} differ, {time.monotonic() - start:.0f} s")
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
