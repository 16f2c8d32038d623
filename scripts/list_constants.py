#!/usr/bin/python3
"""Lists the named numbers of the sources with unit, range and source; docs/constants.md is to hold them.

    list_constants.py              says which numbers have no tag, and how many sources are not recorded (exit 1 if any has no tag)
    list_constants.py --write      writes docs/constants.md as well, if all have one
    list_constants.py --check      says as well whether docs/constants.md is out of date (exit 1)

A named number is a constexpr of an arithmetic type outside of tests. The comment on its line, or the comment block directly
above it, ends with a tag: [unit; range; SOURCE]. SOURCE begins with a letter:

    C   the contract: docs and base/contract.h say it to users
    P   a paper (author, year, section)
    M   measured (year-month, data set)
    B   a budget: it bounds time or memory
    D   a definition: mathematics, rounding of doubles, a file format's own number

A number has a declaration of its own. Numbers that are made of mathematical constants, limits of a type and other names alone need no tag.
"""
import collections
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "constants.md"
NUMBER = re.compile(r"^\s*(?:inline |static )*constexpr (?:inline |static )*(?:std::)?(?:double|float|int|long|unsigned|short|size_t|u?int\d+_t)(?: (?:long|int))* "
                    r"(?P<name>\w+)\s*(?:=\s*(?P<assigned>[^;]*)|\{(?P<braced>[^;]*)\});(?P<rest>.*)$")
TAG = re.compile(r"\[(?P<unit>[^;\[\]]+); (?P<range>[^;\[\]]+); (?P<source>(?P<kind>[CPMBD])(?:[ ,][^\[\]]*)?)\]")
KINDS = {"C": "contract", "P": "paper", "M": "measured", "B": "budget", "D": "definition"}
Constant = collections.namedtuple("Constant", "path line name value text tag")


def is_named_elsewhere(value):
    """Whether a value is made of names alone: it has no digit that is not part of a name."""
    return not re.search(r"(?<![\w.])\d", value)


def declares_several(value):
    """Whether a declaration goes on with a further number: it has a comma outside of brackets."""
    depth = 0
    for c in value:
        depth += (c in "({[<") - (c in ")}]>")
        if c == "," and depth == 0:
            return True
    return False


def joined(lines, at):
    """A declaration that goes over several lines, as one line; the first line's comment stays at its end."""
    text = lines[at]
    number = at
    while ";" not in text.split("//")[0] and number + 1 < len(lines) and number < at + 4:
        number += 1
        text = text.split("//")[0].rstrip() + " " + lines[number].strip()
    return text


def comment_of(lines, at, rest):
    """The comment on a declaration's line and its further lines, or the block above."""
    trailing = rest.partition("//")[2].strip()
    if trailing:
        for line in lines[at + 1:]:
            # Further lines of a trailing comment stand far to the right of any declaration.
            if not re.match(r"^\s{20,}//", line):
                break
            trailing += " " + line.strip().lstrip("/").strip()
        if TAG.search(trailing):
            return trailing
    block = []
    for line in reversed(lines[:at]):
        if not line.strip().startswith("//"):
            break
        block.insert(0, line.strip().lstrip("/").strip())
    return " ".join([*block, trailing]).strip()


def constants(folder):
    found = []
    for path in sorted(folder.rglob("*")):
        if path.suffix not in (".h", ".cpp") or re.search(r"_test\.(cpp|h)$|fixtures\.h$", path.name):
            continue
        lines = path.read_text(encoding="utf-8").splitlines()
        for at, line in enumerate(lines):
            if "constexpr" not in line:
                continue
            match = NUMBER.match(joined(lines, at))
            if not match:
                continue
            value = (match["assigned"] or match["braced"] or "").strip()
            if is_named_elsewhere(value):
                continue
            text = comment_of(lines, at, match["rest"])
            tag = None if declares_several(value) else TAG.search(text)
            found.append(Constant(path.relative_to(ROOT), at + 1, match["name"], value, text, tag))
    return found


def cell(text):
    return text.replace("|", "\\|").replace("<", "&lt;").replace("*", "\\*")


def page(found):
    kinds = collections.Counter(constant.tag["kind"] for constant in found if constant.tag)
    lines = ["# Named numbers", "",
             "This page is written by `scripts/list_constants.py --write` from the comments beside the numbers.",
             f"It lists {len(found)} numbers: " + ", ".join(f"{kinds[kind]} {word} ({kind})" for kind, word in KINDS.items()) + ".", "",
             "- **C**: the contract says the number to users (`base/contract.h`, documents).",
             "- **P**: a paper gives it.",
             "- **M**: somebody measured it; the month and the data set follow.",
             "- **B**: it is a budget. It bounds time or memory and shapes no model that stays within it.",
             "- **D**: it is a definition: mathematics, rounding of doubles, or a number of a file format.", ""]
    rooms = collections.defaultdict(list)
    for constant in found:
        rooms[str(constant.path.parent)].append(constant)
    for room, items in rooms.items():
        lines += [f"## {room}", "", "| number | value | unit | range | source | what it is |", "|---|---|---|---|---|---|"]
        for item in items:
            what = TAG.sub("", item.text).strip()
            what = re.split(r"(?<=[a-z0-9)][.:;]) ", what)[0].rstrip(":;")
            lines.append(f"| `{item.name}` ({item.path.name}) | `{item.value}` | {cell(item.tag['unit'])} | {cell(item.tag['range'])} | {cell(item.tag['source'])} | {cell(what)} |")
        lines.append("")
    return "\n".join(lines)


def main():
    found = [item for folder in ("src", "apps") for item in constants(ROOT / folder)]
    untagged = [item for item in found if not item.tag]
    for item in untagged:
        several = declares_several(item.value)
        print(f"{item.path}:{item.line}: {item.name} " + ("stands in one declaration with others" if several else "has no tag [unit; range; SOURCE]"))
    unrecorded = sum("not recorded" in item.tag["source"] for item in found if item.tag)
    print(f"{len(untagged)} of {len(found)} named numbers have no tag; of {unrecorded} the data set is not recorded")
    if untagged:
        print("the head of scripts/list_constants.py explains tags")
        return 1
    if "--write" in sys.argv[1:]:
        PAGE.write_text(page(found), encoding="utf-8")
        return 0
    if "--check" not in sys.argv[1:]:
        return 0
    if not PAGE.exists() or PAGE.read_text(encoding="utf-8") != page(found):
        print("docs/constants.md is out of date: run scripts/list_constants.py --write")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
