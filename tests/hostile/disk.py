"""A disk whose power fails: plays the calls that recorded_calls.c logged, and gives what may be left after each of them.

The disk promises no more than POSIX does. What is written to a file is safe when the file is synced after it. A name that a folder
gets, loses or exchanges is safe when that folder is synced after it; before, each folder has kept some of its changes, the first
ones. Without a sync, data may be lost, or its length may be kept with zeros in place of it.
"""
import collections
import dataclasses
import itertools
import os
import pathlib
import re
import shutil

Call = collections.namedtuple("Call", "name number other one two")
IDENTITY = re.compile(rb"\d+ (\d+) (\d+) \d+\.\d+")  # of a file in a journal (set_journal.cpp): device, inode, size, time


def read_log(path):
    calls, log, at = [], pathlib.Path(path).read_bytes(), 0
    while at < len(log):
        end = log.index(b"\n", at)
        name, number, other, one, two = log[at:end].split()
        one, two = int(one), int(two)
        calls.append(Call(name.decode(), int(number), int(other), log[end + 1:end + 1 + one], log[end + 1 + one:end + 1 + one + two]))
        at = end + 1 + one + two
    return calls


@dataclasses.dataclass(eq=False)
class Node:
    """A file, or a folder (`changes` is not None)."""
    now: bytes = b""
    safe: bytes = b""
    changes: list = None      # of names: each a dictionary of names to nodes, None for one that is gone
    safe_changes: int = 0
    known: dict = None        # the nodes by inode when it was written, for a journal

    def names(self, count):
        names = {}
        for change in self.changes[:count]:
            names.update(change)
        return {name: node for name, node in names.items() if node is not None}

    def content(self, unsynced):
        if unsynced == "kept":
            return self.now
        if unsynced == "zeros" and self.now[:len(self.safe)] == self.safe:
            return self.safe + bytes(len(self.now) - len(self.safe))
        return self.safe


class Disk:
    """`root`: a folder whose present content is safe."""

    def __init__(self, root):
        self.root = pathlib.Path(root)
        self.by_inode = {}
        self.top = self._read(self.root)
        for node in self.by_inode.values():
            node.known = dict(self.by_inode)

    def _read(self, path):
        node = Node(changes=[]) if path.is_dir() else Node(path.read_bytes(), path.read_bytes())
        self.by_inode[path.stat().st_ino] = node
        if path.is_dir():
            node.changes.append({each.name: self._read(each) for each in path.iterdir()})
            node.safe_changes = 1
        return node

    def _folder(self, path):
        node = self.top
        for part in pathlib.Path(os.fsdecode(path)).parent.relative_to(self.root).parts:
            node = node.names(None)[part]
        return node, os.path.basename(os.fsdecode(path))

    def _change(self, *changes):
        """Names that change in one folder do so in one step."""
        by_folder = {}
        for folder, name, node in changes:
            by_folder.setdefault(folder, {})[name] = node
        for folder, change in by_folder.items():
            folder.changes.append(change)

    def play(self, call):
        if call.name in ("create", "mkdir"):
            node = Node(changes=[] if call.name == "mkdir" else None)
            self.by_inode[call.number] = node
            self._change((*self._folder(call.one), node))
        elif call.name == "write":
            node = self.by_inode[call.number]
            assert call.other <= len(node.now), "a hole"
            node.now = node.now[:call.other] + call.one + node.now[call.other + len(call.one):]
            node.known = dict(self.by_inode)
        elif call.name == "truncate":
            node = self.by_inode[call.number]
            node.now = node.now[:call.other].ljust(call.other, b"\0")
        elif call.name == "fsync":
            node = self.by_inode[call.number]
            node.safe = node.now
            node.safe_changes = len(node.changes) if node.changes is not None else 0
        elif call.name in ("unlink", "rmdir"):
            self._change((*self._folder(call.one), None))
        else:
            (of_one, one), (of_two, two) = self._folder(call.one), self._folder(call.two)
            node = of_one.names(None)[one]
            other = of_two.names(None)[two] if call.name == "exchange" else None
            self._change((of_two, two, node), *([] if call.name == "link" else [(of_one, one, other)]))

    def _folders(self):
        found, open_ones = [], [self.top]
        while open_ones:
            folder = open_ones.pop()
            if folder in found:
                continue
            found.append(folder)
            open_ones += [node for change in folder.changes for node in change.values() if node is not None and node.changes is not None]
        return found

    def survivals(self):
        """Ways in which the power may fail now: how many changes of each folder are kept, and what is kept of data."""
        folders = [folder for folder in self._folders() if folder.safe_changes < len(folder.changes)]
        ends = [(folder.safe_changes, len(folder.changes)) for folder in folders]
        ways = set(itertools.product(*ends)) if len(folders) <= 4 else {tuple(least for least, _ in ends), tuple(most for _, most in ends)}
        for n, (least, most) in enumerate(ends):
            for kept in range(least + 1, most):
                for others in (0, 1):
                    ways.add(tuple(kept if m == n else end[others] for m, end in enumerate(ends)))
        for way in sorted(ways):
            for unsynced in ("lost", "zeros", "kept"):
                yield {id(folder): kept for folder, kept in zip(folders, way)}, unsynced

    def left(self, survival):
        """What is left then: paths and contents, None for a folder; files of several names have one number."""
        kept, unsynced = survival
        found, numbers, open_ones = {}, {}, [("", self.top)]
        while open_ones:
            path, node = open_ones.pop()
            found[path] = (numbers.setdefault(id(node), len(numbers)), None if node.changes is not None else node.content(unsynced))
            if node.changes is not None:
                names = node.names(kept.get(id(node), len(node.changes)))
                open_ones += [(f"{path}/{name}" if path else name, each) for name, each in names.items()]
        return found

    def lay(self, survival):
        """Puts what is left in the place of the folder's content. The journals name the files that are there now."""
        for path in self.root.iterdir():
            shutil.rmtree(path) if path.is_dir() and not path.is_symlink() else path.unlink()
        kept, unsynced = survival
        places, open_ones = {}, [(self.root, self.top)]
        while open_ones:
            path, node = open_ones.pop()
            if node.changes is not None:
                path.mkdir(exist_ok=True)
                open_ones += [(path / name, each) for name, each in node.names(kept.get(id(node), len(node.changes))).items()]
            elif node in places:
                os.link(places[node], path)
            else:
                path.write_bytes(node.content(unsynced))
                places[node] = path
        for node, path in places.items():
            if path.name.endswith(".set") and node.known:
                path.write_bytes(IDENTITY.sub(lambda found: self._identity(found, node.known, places), path.read_bytes()))

    @staticmethod
    def _identity(found, known, places):
        """Of the file that the journal means, if it is there as it was."""
        path = places.get(known.get(int(found[1])))
        if not path or path.stat().st_size != int(found[2]):
            return found[0]
        state = path.stat()
        return b"%d %d %d %d.%d" % (state.st_dev, state.st_ino, state.st_size, *divmod(state.st_mtime_ns, 10 ** 9))
