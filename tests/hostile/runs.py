"""Running the program against hostile inputs: one run, what it left behind, and the findings of many.

A finding is what must never happen: a death by a signal, an exit code that the program does not document, an output after
a refusal, a missing output after success, a file left over, a run beyond its time or memory.
"""
import collections
import concurrent.futures
import os
import pathlib
import shutil
import signal
import subprocess
import tempfile
import threading
import time

CODES = (0, 2, 3, 4, 5, 6, 130)  # 7 is an error in the program's own result: a finding
MOST_SECONDS = 60
MOST_BYTES = 1 << 30


class Run:
    """One run of the program: exit code (negative: the signal), text, seconds, peak memory in bytes."""

    def __init__(self, words, folder, environment=None, kill_after=None):
        start = time.monotonic()
        errors = pathlib.Path(folder) / ".stderr"
        with open(errors, "wb") as stderr:
            process = subprocess.Popen(list(map(str, words)), cwd=folder, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=stderr,
                                       env={**os.environ, **(environment or {})})
            self.is_late = False

            def end():
                self.is_late = kill_after is None
                process.send_signal(signal.SIGKILL)
            timer = threading.Timer(MOST_SECONDS if kill_after is None else kill_after, end)
            timer.start()
            _, status, usage = os.wait4(process.pid, 0)
            timer.cancel()
            process.returncode = os.waitstatus_to_exitcode(status)
        self.code, self.seconds, self.bytes = process.returncode, time.monotonic() - start, usage.ru_maxrss * 1024
        self.text = errors.read_text(errors="replace")
        errors.unlink()

    def fault(self):
        """What is wrong with the run itself, or nothing."""
        if self.is_late:
            return f"not ended after {MOST_SECONDS} s"
        if self.code < 0 or self.code > 130:
            return f"died by signal {-self.code if self.code < 0 else self.code - 128}"
        if self.code not in CODES:
            return f"exit code {self.code}"
        if self.bytes > MOST_BYTES:
            return f"{self.bytes >> 20} MB of memory"
        return None


class Tally:
    """Counts of outcomes by row, and findings with what shows them."""

    def __init__(self, kept):
        self.rows = collections.defaultdict(collections.Counter)
        self.findings = []
        self.kept = pathlib.Path(kept)
        self.lock = threading.Lock()

    def add(self, row, code):
        with self.lock:
            self.rows[row][code] += 1

    def find(self, row, what, folder):
        """Keeps the folder of a finding, with a file that says what it shows."""
        with self.lock:
            place = self.kept / f"{len(self.findings):04}"
            self.findings.append((row, what, str(place)))
        shutil.copytree(folder, place, dirs_exist_ok=True)
        (place / "finding.txt").write_text(f"{row}\n{what}\n")

    def table(self):
        lines = ["| input | cases | done (0) | refused | of these by a limit (5) or the system (6) | findings |", "|---|---|---|---|---|---|"]
        for row in sorted(self.rows):
            counts = self.rows[row]
            cases = sum(counts.values())
            found = sum(1 for finding in self.findings if finding[0] == row)
            lines.append(f"| {row} | {cases} | {counts[0]} | {cases - counts[0]} | {counts[5] + counts[6]} | {found} |")
        return "\n".join(lines)


def in_parallel(cases, work, workers):
    """work(case, folder) in a folder of its own for every case."""
    def one(case):
        with tempfile.TemporaryDirectory(prefix="anatomesh-hostile-") as folder:
            work(case, pathlib.Path(folder))
    with concurrent.futures.ThreadPoolExecutor(workers) as pool:
        for done in [pool.submit(one, case) for case in cases]:
            done.result()
