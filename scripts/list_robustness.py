#!/usr/bin/python3
"""Lists the tests of every row of docs/robustness.md, the table of hostile inputs and faults.

    list_robustness.py              says how many rows are done, have no test, or are not applicable; names those without a test
    list_robustness.py --write      writes the last column of the table as well; a row that has got a test is done
    list_robustness.py --check      says as well what is wrong with the table (exit 1)

A row is | id | input | what the program does | state | tests |. A test carries the id of a row in its name, without the hyphen: D17,
RS20, A15. Names are those of suite and test in TEST, TEST_F and TEST_P of the C++ sources, and those of the functions test_* and of
their classes in Python. A name may carry several ids. The state of a row is

    done             a test carries its id
    no test          the program does something, as the row says, but no test carries the id
    not applicable   there is nothing to test; the row says why

--check fails if the last column is out of date, if a row is done without a test, has one and is not done, has another state or is
there twice, and if a test carries an id that no row has.
"""
import argparse
import collections
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "robustness.md"
ROW = re.compile(r"\| *(?P<id>[A-Z]{1,2}-\d\d) *\|(?P<input>[^|]*)\|(?P<does>[^|]*)\| *(?P<state>[^|]*?) *\| *(?P<tests>[^|]*?) *\|")
CHAPTERS = "D|G|RS|L|N|C|M|P|F|A|WB|O"
ID = re.compile(rf"(?<![A-Za-z0-9])({CHAPTERS})(\d\d)(?![a-z0-9])")
CPP_TEST = re.compile(r"^TEST(?:_F|_P)?\(\s*(\w+)\s*,\s*(\w+)\s*\)", re.MULTILINE)
PYTHON_TEST = re.compile(r"^class (\w+)|^ *def (test_\w+)\(", re.MULTILINE)
DONE, NO_TEST, NOT_APPLICABLE = "done", "no test", "not applicable"
Test = collections.namedtuple("Test", "path name")


def names_in(path):
    """The names of the tests of a file, with their suites or classes."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".cpp":
        return [f"{suite}.{name}" for suite, name in CPP_TEST.findall(text)]
    names, group = [], ""
    for of_class, of_test in PYTHON_TEST.findall(text):
        if of_class:
            group = of_class
        else:
            names.append(f"{group}.{of_test}")
    return names


def ids_in(name):
    """The ids that a name carries. An underscore ends one."""
    return {f"{chapter}-{number}" for chapter, number in ID.findall(name.replace("_", " "))}


def tests_by_id():
    found = collections.defaultdict(list)
    paths = [path for folder in ("src", "tests") for path in (ROOT / folder).rglob("*") if path.suffix in (".cpp", ".py")]
    for path in sorted(paths):
        for name in names_in(path):
            for row in ids_in(name):
                found[row].append(Test(path, name))
    return found


def cell(tests):
    """The first file and the number of tests, for the last column."""
    return f"{tests[0].path.name} ({len(tests)})" if tests else ""


def rewritten(text, tests):
    """The page with the tests of today. A row that has got one is done."""
    lines = []
    for line in text.split("\n"):
        row = ROW.fullmatch(line)
        if row:
            of_row = tests.get(row["id"], [])
            state = DONE if of_row and row["state"] == NO_TEST else row["state"]
            line = f"| {row['id']} | {row['input'].strip()} | {row['does'].strip()} | {state} | {cell(of_row)}".rstrip() + " |"
        lines.append(line)
    return "\n".join(lines)


def faults_of(rows, tests):
    """What is wrong with the table, but for its last column."""
    for row, times in collections.Counter(row["id"] for row in rows).items():
        if times > 1:
            yield f"{row}: the table has this row {times} times"
    for row in rows:
        of_row = tests.get(row["id"], [])
        if row["state"] not in (DONE, NO_TEST, NOT_APPLICABLE):
            yield f"{row['id']}: the state is '{row['state']}', not one of: {DONE}, {NO_TEST}, {NOT_APPLICABLE}"
        elif row["state"] == DONE and not of_row:
            yield f"{row['id']}: the row is done, but no test carries its id"
        elif row["state"] != DONE and of_row:
            yield f"{row['id']}: the row says '{row['state']}', but a test carries its id: {of_row[0].name}"
    for unknown in sorted(set(tests) - {row["id"] for row in rows}):
        test = tests[unknown][0]
        yield f"{test.path.relative_to(ROOT)}: {test.name} carries the id {unknown}, which the table does not have"


def main():
    parser = argparse.ArgumentParser(description="Lists the tests of every row of docs/robustness.md.")
    parser.add_argument("--write", action="store_true", help="write the last column of the table")
    parser.add_argument("--check", action="store_true", help="fail if the table is out of date or wrong")
    options = parser.parse_args()
    tests = tests_by_id()
    text = PAGE.read_text(encoding="utf-8")
    fresh = rewritten(text, tests)
    if options.write and fresh != text:
        PAGE.write_text(fresh, encoding="utf-8")
        text = fresh
    rows = [row for row in map(ROW.fullmatch, text.split("\n")) if row]
    states = collections.Counter(row["state"] for row in rows)
    print(f"{len(rows)} rows: {states[DONE]} done, {states[NO_TEST]} without a test, {states[NOT_APPLICABLE]} not applicable")
    print("no test: " + (" ".join(row["id"] for row in rows if row["state"] == NO_TEST) or "none"))
    faults = list(faults_of(rows, tests))
    if text != fresh:
        faults.append("docs/robustness.md is out of date: run scripts/list_robustness.py --write")
    if not rows:
        faults.append("docs/robustness.md has no row")
    if options.check:
        for fault in faults:
            print(fault)
        return 1 if faults else 0
    return 0


if __name__ == "__main__":
    sys.exit(main())
