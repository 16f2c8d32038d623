#!/usr/bin/env python3
"""check_links.py [ROOT]: every relative link, anchor and image in the Markdown files of the repository exists.

Prints file:line: what is wrong, and exits with 1 if anything is. Links to other hosts are not followed.
"""
import pathlib
import re
import sys
import urllib.parse

LINK = re.compile(r"\]\(\s*<?([^)\s>]+)>?[^)]*\)|^ {0,3}\[[^\]]+\]:\s+(\S+)|<(?:img|a)\s[^>]*?(?:src|href)=\"([^\"]+)\"")
OTHER_HOST = re.compile(r"[a-zA-Z][\w+.-]*:|//")
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


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parent.parent).resolve()
    files = sorted(p for p in root.rglob("*.md") if not NOT_OURS & set(p.relative_to(root).parts))
    links = [(p, n, next(filter(None, m.groups()))) for p in files for n, line in prose(p)
             for m in LINK.finditer(re.sub(r"`[^`]*`", "code", line))]
    faults = [f"{p.relative_to(root)}:{n}: {wrong}" for p, n, target in links
              if not OTHER_HOST.match(target) and (wrong := fault(root, p, target))]
    print("\n".join(faults + [f"{len(files)} files, {len(links)} links, {len(faults)} broken"]))
    return 1 if faults or not links else 0


if __name__ == "__main__":
    sys.exit(main())
