#!/usr/bin/python3
"""Lists the named numbers of the sources with unit, range and source; docs/constants.md is to hold them.

    list_constants.py              says which numbers have no tag, and how many sources are not recorded (exit 1 if any has no tag)
    list_constants.py --write      writes docs/constants.md as well, if all have one
    list_constants.py --check      says as well whether docs/constants.md is out of date (exit 1)
    list_constants.py --wordless   names the numbers as well that have a tag and no word beside it

A named number is a constexpr of an arithmetic type outside of tests, or a list of such with a decimal point in it. The comment on
its line, or the comment block directly above it, ends with a tag: [unit; range; SOURCE]. SOURCE begins with a letter:

    C   the contract: docs and base/contract.h say it to users
    P   a paper (author, year, section)
    M   measured (year-month, data set): the rule was tried with this number on that data; where nobody wrote down which, the tag
        says "set not recorded"
    B   a budget: it bounds time or memory
    D   a definition: mathematics, rounding of doubles, a file format's own number, or a number made of another one; or a choice for
        which no measurement is recorded: the tag says "a choice, measurement not recorded"

A number has a declaration of its own. These need no tag:

- Numbers that are made of mathematical constants, limits of a type and other names alone: they follow from what has one.
- Default member initialisers of options: a caller chooses those. The comment beside an option says its unit and range, and the
  header and the page of its stage say why the default is what it is.
- Lists of whole numbers: these are tables of corners, edges and codes, which decide nothing by themselves.

Whatever else has a tag, such as a table of a structure's own type, is listed as well.
"""
import collections
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "constants.md"
CONSTANT = re.compile(r"^\s*(?:inline |static )*constexpr (?:inline |static )*(?P<type>[\w:]+(?:<[^;={]*>)?(?: (?:long|int))*) (?P<name>\w+)(?P<list>\[\w*\])?\s*"
                      r"(?:=\s*(?P<assigned>[^;]*)|\{(?P<braced>[^;]*)\});(?P<rest>.*)$")
ARITHMETIC = re.compile(r"(?:std::)?(?:double|float|int|long|unsigned|short|size_t|ptrdiff_t|u?int\d+_t|Region)(?: (?:long|int))*")
TAG = re.compile(r"\[(?P<unit>[^;\[\]]+); (?P<range>[^;\[\]]+); (?P<source>(?P<kind>[CPMBD])(?:[ ,][^\[\]]*)?)\]")
KINDS = {"C": "contract", "P": "paper", "M": "measured", "B": "budget", "D": "definition"}
NOT_RECORDED = "not recorded"
LONGEST_VALUE = 60
Constant = collections.namedtuple("Constant", "path line name value text tag several")


def is_number(match, value):
    """Whether a declaration is of a number, or of a list of numbers with a decimal point in it."""
    of_list = match["list"] or match["type"].startswith("std::array")
    element = re.match(r"std::array<([\w:]+),", match["type"])
    if not of_list:
        return bool(ARITHMETIC.fullmatch(match["type"]))
    if element and not ARITHMETIC.fullmatch(element[1]) or match["list"] and not ARITHMETIC.fullmatch(match["type"]):
        return False
    return bool(re.fullmatch(r"[-+\d.,eFf{}\s]*", value) and re.search(r"\d\.\d", value))


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
            match = CONSTANT.match(joined(lines, at))
            if not match:
                continue
            value = (match["assigned"] or match["braced"] or "").strip()
            text = comment_of(lines, at, match["rest"])
            is_list = bool(match["list"]) or match["type"].startswith("std::array")
            several = declares_several(value) and not is_list
            tag = None if several else TAG.search(text)
            if not tag and (not is_number(match, value) or is_named_elsewhere(value)):
                continue
            found.append(Constant(path.relative_to(ROOT), at + 1, match["name"], value, text, tag, several))
    return found


def cell(text):
    return text.replace("|", "\\|").replace("<", "&lt;").replace("*", "\\*").replace("_", "\\_")


def code(value):
    value = re.sub(r"\s+", " ", value).strip()
    if len(value) > LONGEST_VALUE:
        value = value[:LONGEST_VALUE].rsplit(" ", 1)[0].rstrip(",") + " ..."
    return "`" + value.replace("|", "\\|") + "`"


def anchor(heading):
    return re.sub(r"[^\w\- ]", "", heading).replace(" ", "-").lower()


def page(found):
    kinds = collections.Counter(constant.tag["kind"] for constant in found)
    unrecorded = collections.Counter(constant.tag["kind"] for constant in found if NOT_RECORDED in constant.tag["source"])
    lines = ["# Named numbers", "",
             "This page lists the numbers that decide what the program does: what each is, where it is from, and what it decides. "
             "`scripts/list_constants.py` makes it of the comments beside the numbers, so change those. A test compares both.", "",
             "| source | meaning | numbers |", "|---|---|---:|",
             f"| C | The contract: documents and `base/contract.h` say the number to users. | {kinds['C']} |",
             f"| P | A paper gives it. | {kinds['P']} |",
             "| M | It was measured: the rule was tried with this number on the data that is named, in the month that is named. "
             f"[Experiments](experiments/README.md) have the figures. Of {unrecorded['M']} of them the set is not recorded. | {kinds['M']} |",
             f"| B | It is a budget: it bounds time or memory, and shapes no model that stays within it. | {kinds['B']} |",
             f"| D | It is a definition: mathematics, rounding, a number of a file format, or one made of another number; "
             f"or a choice for which no measurement is recorded ({unrecorded['D']} of them). | {kinds['D']} |", "",
             "Options that a caller chooses are not here: `anatomesh COMMAND --help-all` and the headers state their defaults. "
             "Defaults that no command sets, such as `target_degrees`, stand in the headers only. "
             "The [stages](overview.md) say what the numbers are used for.", "", "## Rooms", "",
             "| room | numbers | C | P | M | B | D |", "|---|---:|---:|---:|---:|---:|---:|"]
    rooms = collections.defaultdict(list)
    for constant in found:
        rooms[str(constant.path.parent)].append(constant)
    for room, items in rooms.items():
        count = collections.Counter(item.tag["kind"] for item in items)
        lines.append(f"| [{room}](#{anchor(room)}) | {len(items)} | " + " | ".join(str(count[kind] or "") for kind in KINDS) + " |")
    lines.append("")
    for room, items in rooms.items():
        lines += [f"## {room}", "", "| number | value | unit | range | source | what it decides |", "|---|---|---|---|---|---|"]
        for item in items:
            what = TAG.sub("", item.text).strip().rstrip(",")
            lines.append(f"| [{item.name}](../{item.path}) | {code(item.value)} | {cell(item.tag['unit'])} | {cell(item.tag['range'])} | "
                         f"{cell(item.tag['source'])} | {cell(what)} |")
        lines.append("")
    return "\n".join(lines)


def main():
    found = [item for folder in ("src", "apps") for item in constants(ROOT / folder)]
    untagged = [item for item in found if not item.tag]
    for item in untagged:
        print(f"{item.path}:{item.line}: {item.name} " + ("stands in one declaration with others" if item.several else "has no tag [unit; range; SOURCE]"))
    unrecorded = collections.Counter(item.tag["kind"] for item in found if item.tag and NOT_RECORDED in item.tag["source"])
    wordless = [item for item in found if item.tag and not TAG.sub("", item.text).strip()]
    if "--wordless" in sys.argv[1:]:
        for item in wordless:
            print(f"{item.path}:{item.line}: {item.name} has a tag and no word that says what it decides")
    print(f"{len(untagged)} of {len(found)} named numbers have no tag; of {unrecorded['M']} the data set is not recorded; "
          f"{unrecorded['D']} are choices without a recorded measurement; {len(wordless)} have a tag and no word")
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
