#!/usr/bin/python3
"""Figures of the code's form: lengths of functions and classes, parameters, members, named numbers, fullest folder.

    measure_structure.py [FOLDER]      a table as Markdown; of src/anatomesh if no folder is named

Tests are left out. Functions and classes are found by Universal Ctags (Debian's universal-ctags); a class has the data
members that are declared in it, and a named number is a constant of a namespace or function that begins with constexpr.
"""
import collections
import json
import pathlib
import re
import subprocess
import sys


def sources(folder):
    return [path for path in sorted(folder.rglob("*")) if path.suffix in (".h", ".cpp") and not re.search(r"_test\.(cpp|h)$|fixtures\.h$", path.name)]


def tags(paths):
    words = ["ctags", "--output-format=json", "--fields=+neSK", "--c++-kinds=fcsm", "-f", "-", *map(str, paths)]
    done = subprocess.run(words, capture_output=True, text=True, check=True)
    return [json.loads(line) for line in done.stdout.splitlines()]


def parameters(signature):
    """How many a signature has; commas in brackets of any kind part none."""
    inside = signature.strip()[1:signature.rfind(")")]
    depth, count = 0, 1 if inside.strip() not in ("", "void") else 0
    for c in inside:
        depth += (c in "<([{") - (c in ">)]}")
        count += c == "," and depth == 0
    return count


def largest(items, count=5):
    return ", ".join(f"{name} {value}" for value, name in sorted(items, reverse=True)[:count])


def main():
    folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).resolve().parent.parent / "src" / "anatomesh")
    paths = sources(folder)
    lines = {path: path.read_text(encoding="utf-8").splitlines() for path in paths}
    total = sum(map(len, lines.values()))
    functions, classes, members, wide = [], [], collections.Counter(), []
    for tag in tags(paths):
        length = tag.get("end", tag["line"]) - tag["line"] + 1
        if tag["kind"] == "function":
            functions.append((length, tag["name"]))
            if parameters(tag.get("signature", "()")) > 8:
                wide.append((parameters(tag["signature"]), tag["name"]))
        elif tag["kind"] in ("class", "struct"):
            classes.append((length, tag["name"]))
        elif tag["kind"] == "member" and "scope" in tag:
            members[tag["scope"]] += 1
    lengths = sorted(length for length, _ in functions)
    constants = sum(len(re.findall(r"^\s*(?:inline |static )*constexpr [\w:<>, ]+? \w+\s*[={]", "\n".join(text), flags=re.M)) for text in lines.values())
    folders = collections.Counter(str(path.parent.relative_to(folder)) for path in paths)
    of_classes = {name for _, name in classes}
    crowded = [(count, scope.rpartition("::")[2]) for scope, count in members.items() if count > 15 and scope.rpartition("::")[2] in of_classes]
    rows = [("lines", f"{total:,}"),
            ("functions over 80 lines / longest", f"{sum(length > 80 for length in lengths)} / {lengths[-1]}"),
            ("99th percentile of function length", lengths[int(0.99 * len(lengths))]),
            ("functions with more than 8 parameters", f"{len(wide)}: {largest(wide)}" if wide else 0),
            ("classes over 350 lines", largest([item for item in classes if item[0] > 350], 9) or 0),
            ("classes with more than 15 data members", f"{len(crowded)}: {largest(crowded)}" if crowded else 0),
            ("named numbers per 1,000 lines", f"{1000 * constants / total:.1f} ({constants})"),
            ("files in the fullest folder", "{1} in {0}".format(*folders.most_common(1)[0])),
            ("longest .cpp", largest([(len(text), path.name) for path, text in lines.items() if path.suffix == ".cpp"], 3))]
    print(f"| {folder.name} | |\n|---|---|")
    for name, value in rows:
        print(f"| {name} | {value} |")


if __name__ == "__main__":
    main()
