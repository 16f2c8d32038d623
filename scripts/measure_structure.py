#!/usr/bin/python3
"""Figures of the code's form: lengths of functions and classes, parameters, members, named numbers, fullest folder.

    measure_structure.py [FOLDER]           a table as Markdown; of src/anatomesh if no folder is named
    measure_structure.py --list [FOLDER]    every function and class above a limit, with its file and line

Tests are left out. Functions and classes are found by Universal Ctags (Debian's universal-ctags); a class has the data
members that are declared in it, and a named number is a constant of a namespace or function that begins with constexpr.
"""
import collections
import json
import pathlib
import re
import shutil
import subprocess
import sys

MOST = {"functions": 80, "parameters": 8, "classes": 350, "members": 15}

def sources(folder):
    return [path for path in sorted(folder.rglob("*")) if path.suffix in (".h", ".cpp") and not re.search(r"_test\.(cpp|h)$|fixtures\.h$", path.name)]


def tags(paths):
    words = ["ctags", "--output-format=json", "--fields=+neSK", "--c++-kinds=fcsm", "-f", "-", *map(str, paths)]
    if shutil.which("ctags") is None:
        sys.exit("measure_structure.py: ctags was not found; install universal-ctags")
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
    return ", ".join(f"{item[1]} {item[0]}" for item in sorted(items, reverse=True)[:count])


def scope_of(tag):
    return (f"{tag['scope']}::" if "scope" in tag else "") + tag["name"]


class Figures:
    """What is measured of the files: (value, name, place) of each function and class."""

    def __init__(self, folder):
        paths = sources(folder)
        self.text = {path: path.read_text(encoding="utf-8").splitlines() for path in paths}
        self.functions, self.parameters, self.classes, self.members = [], [], [], []
        places, counts = {}, collections.Counter()
        for tag in tags(paths):
            length = tag.get("end", tag["line"]) - tag["line"] + 1
            place = f"{pathlib.Path(tag['path']).relative_to(folder)}:{tag['line']}"
            if tag["kind"] == "function":
                self.functions.append((length, tag["name"], place))
                self.parameters.append((parameters(tag.get("signature", "()")), tag["name"], place))
            elif tag["kind"] in ("class", "struct"):
                self.classes.append((length, tag["name"], place))
                places[tag["path"], scope_of(tag)] = (tag["name"], place)
            elif tag["kind"] == "member" and "scope" in tag:
                counts[tag["path"], tag["scope"]] += 1
        self.members = [(count, *places[scope]) for scope, count in counts.items() if scope in places]

    def above(self, kind):
        return sorted((item for item in getattr(self, kind) if item[0] > MOST[kind]), reverse=True)


def print_offenders(figures):
    for kind, what in (("functions", "lines of a function"), ("parameters", "parameters of a function"), ("classes", "lines of a class"), ("members", "data members of a class")):
        print(f"{what}, above {MOST[kind]}:")
        for value, name, place in figures.above(kind):
            print(f"  {value:4} {name}  {place}")


def print_table(figures, folder):
    total = sum(map(len, figures.text.values()))
    lengths = sorted(length for length, _, _ in figures.functions)
    constants = sum(len(re.findall(r"^\s*(?:inline |static )*constexpr [\w:<>, ]+? \w+\s*[={]", "\n".join(text), flags=re.M)) for text in figures.text.values())
    folders = collections.Counter(str(path.parent.relative_to(folder)) for path in figures.text)
    wide, crowded = figures.above("parameters"), figures.above("members")
    rows = [("lines", f"{total:,}"),
            ("functions over 80 lines / longest", f"{len(figures.above('functions'))} / {lengths[-1]}"),
            ("99th percentile of function length", lengths[int(0.99 * len(lengths))]),
            ("functions with more than 8 parameters", f"{len(wide)}: {largest(wide)}" if wide else 0),
            ("classes over 350 lines", largest(figures.above("classes"), 9) or 0),
            ("classes with more than 15 data members", f"{len(crowded)}: {largest(crowded)}" if crowded else 0),
            ("named numbers per 1,000 lines", f"{1000 * constants / total:.1f} ({constants})"),
            ("files in the fullest folder", "{1} in {0}".format(*folders.most_common(1)[0])),
            ("longest .cpp", largest([(len(text), path.name) for path, text in figures.text.items() if path.suffix == ".cpp"], 3))]
    print(f"| {folder.name} | |\n|---|---|")
    for name, value in rows:
        print(f"| {name} | {value} |")


def main():
    words = [word for word in sys.argv[1:] if word != "--list"]
    folder = pathlib.Path(words[0] if words else pathlib.Path(__file__).resolve().parent.parent / "src" / "anatomesh")
    figures = Figures(folder)
    if "--list" in sys.argv[1:]:
        print_offenders(figures)
    else:
        print_table(figures, folder)


if __name__ == "__main__":
    main()
