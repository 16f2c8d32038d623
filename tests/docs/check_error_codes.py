#!/usr/bin/python3
"""check_error_codes.py ROOT: every E- and W- code in the sources stands in docs/errors.md, and no other does.

A code stands in a source as text ("E-RTS-005"). Tests and comments alone do not make a code.
"""
import pathlib
import re
import sys

CODE = re.compile(r'"([EW]-[A-Z]{2,4}-\d{3})"')
LISTED = re.compile(r"^\| `?([EW]-[A-Z]{2,4}-\d{3})`? \|", re.M)


def main():
    root = pathlib.Path(sys.argv[1])
    used = set()
    for folder in ("src", "apps"):
        for source in sorted((root / folder).rglob("*")):
            if source.suffix in (".cpp", ".h") and not source.name.endswith("_test.cpp"):
                used |= set(CODE.findall(source.read_text()))
    rows = LISTED.findall((root / "docs/errors.md").read_text())
    twice = sorted({code for code in rows if rows.count(code) > 1})
    missing, stale = sorted(used - set(rows)), sorted(set(rows) - used)
    for what, codes in (("not in docs/errors.md", missing), ("in docs/errors.md but not in the sources", stale),
                        ("in docs/errors.md twice", twice)):
        if codes:
            print(f"{what}: {', '.join(codes)}")
    print(f"{len(used)} codes in the sources, {len(rows)} rows")
    sys.exit(1 if missing or stale or twice or not used else 0)


if __name__ == "__main__":
    main()
