#!/usr/bin/python3
"""count_tests.py RESULTS.xml STATUS: the closing line of `make test`, counted from ctest's JUnit file.

Exits with 1 when a test failed, when none ran, or when ctest itself ended with a STATUS other than 0.
"""
import sys
import xml.etree.ElementTree as ElementTree


def main():
    results, status = sys.argv[1], int(sys.argv[2])
    cases = ElementTree.parse(results).getroot().findall("testcase")
    passed = failed = 0
    skipped = []
    for case in cases:
        state = case.get("status")
        if state == "run":
            passed += 1
        elif state in ("notrun", "disabled") and case.find("skipped") is not None \
                and case.find("skipped").get("message", "").startswith(("SKIP_", "Skipped")):
            skipped.append(case.get("name"))
        else:
            failed += 1
            print(f"failed: {case.get('name')}")
    if skipped:
        print(f"{len(skipped)} skipped (what they need is not on this machine): {', '.join(skipped[:12])}"
              + (" ..." if len(skipped) > 12 else ""))
    print(f"{passed} passed, {failed} failed")
    sys.exit(0 if status == 0 and failed == 0 and passed > 0 else 1)


if __name__ == "__main__":
    main()
