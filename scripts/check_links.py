#!/usr/bin/env python3
"""check_links.py [ROOT]: every relative link, anchor and image in the Markdown files of the repository exists.

Every source file that these files or a comment of the sources name exists too; experiments and decisions may name what
stood there at their date. Prints file:line: what is wrong, and exits with 1 if anything is. Links to other hosts are not
followed.
"""
import pathlib
import re
import sys
import urllib.parse

LINK = re.compile(r"\]\(\s*<?([^)\s>]+)>?[^)]*\)|^ {0,3}\[[^\]]+\]:\s+(\S+)|<(?:img|a)\s[^>]*?(?:src|href)=\"([^\"]+)\"")
OTHER_HOST = re.compile(r"[a-zA-Z][\w+.-]*:|//")
SOURCE = re.compile(r"(?<![\w.<])[a-z][\w/]*\.(?:h|cpp|py)\b")
OF_OTHERS = {"nifti1.h", "nifti2.h"}  # headers that a file format's definition consists of
NOT_OURS = {".git", "build", "node_modules"}


def prose(path):
    """The numbered lines of a file, without those in fences, and without the code in the others."""
    fenced = False
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        if re.match(r"\s*(```|~~~)", line):
            fenced = not fenced
        elif not fenced:
            yield number, line


def anchors(path):
    """Those that GitHub makes of a file's headings."""
    found = set()
    for _, line in prose(path):
        if heading := re.match(r"#{1,6}\s+(.*)", line):
            text = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", heading.group(1)).strip().lower()
            slug = re.sub(r"[^\w\- ]", "", text).replace(" ", "-")
            found.add(next(s for s in [slug, *(f"{slug}-{n}" for n in range(1, 1000))] if s not in found))
    return found


def fault(root, path, target):
    """What is wrong with a link in a file; nothing if it is right."""
    name, _, anchor = urllib.parse.unquote(target).partition("#")
    linked = path if not name else root / name[1:] if name.startswith("/") else path.parent / name
    if not linked.exists():
        return f"no such file: {target}"
    return f"no such heading: {target}" if anchor and linked.suffix == ".md" and anchor not in anchors(linked) else None


def named_sources(root, pages):
    """Places where pages and comments of the sources name a source file, with its name."""
    for page in pages:
        if not {"experiments", "decisions"} & set(page.parts):
            for number, line in enumerate(page.read_text(encoding="utf-8").splitlines(), 1):
                yield from ((page, number, name) for name in SOURCE.findall(line))
    for folder in ("src", "apps"):
        for path in sorted((root / folder).rglob("*")):
            if path.suffix in (".h", ".cpp"):
                for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
                    yield from ((path, number, name) for name in SOURCE.findall(line.partition("//")[2]))


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parent.parent).resolve()
    files = sorted(p for p in root.rglob("*.md") if not NOT_OURS & set(p.relative_to(root).parts))
    links = [(p, n, next(filter(None, m.groups()))) for p in files for n, line in prose(p)
             for m in LINK.finditer(re.sub(r"`[^`]*`", "code", line))]
    faults = [f"{p.relative_to(root)}:{n}: {wrong}" for p, n, target in links
              if not OTHER_HOST.match(target) and (wrong := fault(root, p, target))]
    there = {p.name for p in root.rglob("*") if p.suffix in (".h", ".cpp", ".py")} | OF_OTHERS
    faults += [f"{p.relative_to(root)}:{n}: no such file: {name}" for p, n, name in named_sources(root, files)
               if name.rpartition("/")[2] not in there]
    print("\n".join(faults + [f"{len(files)} files, {len(links)} links, {len(faults)} broken"]))
    return 1 if faults or not links else 0


if __name__ == "__main__":
    sys.exit(main())
