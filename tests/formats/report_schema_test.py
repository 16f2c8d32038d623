#!/usr/bin/python3
"""Validates a report against schemas/report.schema.json, and shows that the schema is strict.

    report_schema_test.py REPORT.json

Exit code 0 when the report is valid and every spoilt copy of it is refused, 1 otherwise.
"""
import copy
import json
import pathlib
import sys

import jsonschema

SCHEMA = pathlib.Path(__file__).resolve().parents[2] / "schemas" / "report.schema.json"


def spoilt(report):
    """Copies of the report with one thing wrong, and what it is."""
    for key in report:
        bad = copy.deepcopy(report)
        del bad[key]
        yield f"without {key}", bad
    for name, value in (("extra", 1), ("unit", "cm"), ("space", "RAS"), ("share_culled", 1.5), ("format_version", 2)):
        bad = copy.deepcopy(report)
        bad[name] = value
        yield f"{name} = {value}", bad
    bad = copy.deepcopy(report)
    bad["counts"]["tetrahedra"] = -1
    yield "negative count", bad
    for clause in range(len(report["certificate"])):
        bad = copy.deepcopy(report)
        bad["certificate"][clause]["state"] = "perhaps"
        yield f"unknown state of clause {clause + 1}", bad


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    schema = json.loads(SCHEMA.read_text(encoding="utf-8"))
    jsonschema.Draft202012Validator.check_schema(schema)
    validator = jsonschema.Draft202012Validator(schema)
    report = json.loads(pathlib.Path(sys.argv[1]).read_text(encoding="utf-8"))
    faults = [f"{'/'.join(map(str, e.absolute_path))}: {e.message}" for e in validator.iter_errors(report)]
    faults += [f"the schema accepts a report {what}" for what, bad in spoilt(report) if validator.is_valid(bad)]
    for fault in faults:
        print(fault)
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
