"""What every benchmark shares: running a command and what it cost, turns, medians, tables, the machine, and the page of documentation
that keeps them.
"""
import datetime
import json
import math
import os
import pathlib
import platform
import signal
import statistics
import subprocess
import sys
import tempfile
import time

SOURCE = pathlib.Path(__file__).resolve().parent.parent
DATA = pathlib.Path(os.environ.get("ANATOMESH_DATA") or SOURCE.parent / "shared/data")
SKULL_OPTIONS = ["--threshold", "226", "--keep-largest", "1"]
PACKAGES = ("libcgal-dev", "tetgen", "gmsh", "python3-netgen")


class Failure(Exception):
    """No result, and why."""


def note(text):
    print(text, file=sys.stderr, flush=True)


def run(words, limit):
    """Standard output, seconds, CPU seconds and peak megabytes of a command that may take `limit` seconds."""
    words = [str(word) for word in words]
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        start = time.monotonic()
        try:
            process = subprocess.Popen(words, stdout=out, stderr=err, stdin=subprocess.DEVNULL, start_new_session=True)
        except OSError as error:
            raise Failure(f"{words[0]}: {error.strerror}") from error
        while True:
            pid, status, usage = os.wait4(process.pid, os.WNOHANG)
            if pid:
                break
            if time.monotonic() > start + limit:
                os.killpg(process.pid, signal.SIGKILL)  # with what it started itself
                os.wait4(process.pid, 0)
                process.returncode = -9
                raise Failure(f"not done after {limit:.0f} s")
            time.sleep(0.002)
        seconds = time.monotonic() - start
        process.returncode = os.waitstatus_to_exitcode(status)
        out.seek(0)
        err.seek(0)
        text, errors = out.read().decode("utf-8", "replace"), err.read().decode("utf-8", "replace")
    if process.returncode < 0:
        raise Failure(f"killed by {signal.Signals(-process.returncode).name}")
    if process.returncode > 0:
        lines = (text + errors).strip().splitlines()
        told = [line for line in lines if "rror" in line] or lines[-1:]
        raise Failure(told[0].strip() if told else f"exit code {process.returncode}")
    return {"out": text, "seconds": seconds, "cpu": usage.ru_utime + usage.ru_stime, "mb": usage.ru_maxrss / 1024}


def modelled(program, path, folder, limit):
    """The report of a model of the contours at `path`, and seconds; None where it is refused, and why is said."""
    try:
        seconds = run([program, "model", path, "-o", folder / "model.vtu", "--quiet", "--threads", "2"], limit)["seconds"]
    except Failure as failure:
        note(f"  {failure}")
        return None
    return json.loads((folder / "model.report.json").read_text()), seconds


def skull():
    """The CT skull of Debian's package invesalius-examples; nothing where it cannot be had."""
    found = subprocess.run([SOURCE / "scripts/skull.sh"], cwd=SOURCE, stdout=subprocess.PIPE, text=True)
    return SOURCE / found.stdout.strip() if found.returncode == 0 and found.stdout.strip() else None


def take_turns(contenders, runs, slow):
    """name -> the costs of its runs, in turns; one run of what took more than `slow` seconds; of one that failed, why."""
    done, failed = {name: [] for name in contenders}, {}
    for turn in range(runs):
        for name, contender in contenders.items():
            if name in failed or (done[name] and done[name][0]["seconds"] > slow):
                continue
            note(f"  run {turn + 1} of {runs}: {name}")
            try:
                done[name].append(contender())
            except Failure as failure:
                failed[name] = str(failure)
                note(f"    {failure}")
    return {name: failed.get(name) or done[name] for name in contenders}


def median(runs, *keys):
    """Of what the keys lead to in every run."""
    values = []
    for value in runs:
        for key in keys:
            value = value[key]
        values.append(value)
    return statistics.median(values)


def exponent(points):
    """Slope of log(y) over log(x) by least squares."""
    xs, ys = [math.log(x) for x, _ in points], [math.log(y) for _, y in points]
    x_mean, y_mean = statistics.fmean(xs), statistics.fmean(ys)
    return sum((x - x_mean) * (y - y_mean) for x, y in zip(xs, ys)) / sum((x - x_mean) ** 2 for x in xs)


def table(head, rows, texts=1):
    """In Markdown; the first columns, `texts` of them, to the left, numbers to the right."""
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * texts + "---:|" * (len(head) - texts)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows]) + "\n"


def count(value):
    return f"{value:,.0f}"


def add_programs(parser):
    """Which program is measured, which other one beside it in turns, and the page that keeps the table."""
    parser.add_argument("--program", type=pathlib.Path, default=SOURCE / "build/release/anatomesh")
    parser.add_argument("--beside", type=pathlib.Path, help="another program, after the first on each input")
    parser.add_argument("--update", type=pathlib.Path, metavar="PAGE", help="put the table between its markers in PAGE")


def programs_of(arguments):
    return [program.resolve() for program in (arguments.program, arguments.beside) if program]


def columns(programs, first, *others):
    """Heads of the columns of each program; the first one says which it is, where there are two."""
    names = [""] if len(programs) == 1 else [" (first)", " (beside)"]
    return [head for name in names for head in (first.format(name), *others)]


def show(arguments, name, how, text):
    """Prints a table, and puts it into the page if that is asked for."""
    print(text)
    if arguments.update:
        keep(arguments.update, name, f"{how}\n{text}")


def first_line(words):
    try:
        return subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True).stdout.splitlines()[0].strip()
    except (OSError, IndexError):
        return "unknown"


def machine():
    """When, where and how a table was measured."""
    model = platform.machine()
    for line in pathlib.Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            model = line.split(":", 1)[1].strip()
            break
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2 ** 30
    packages = ", ".join(f"{name} {first_line(['dpkg-query', '-W', '-f=${Version}', name])}" for name in PACKAGES)
    commit = first_line(["git", "-C", SOURCE, "rev-parse", "--short", "HEAD"])
    return (f"Measured {datetime.datetime.now(datetime.timezone.utc):%Y-%m-%d %H:%M} UTC at commit {commit}: {os.cpu_count()} cores, {model}, "
            f"{memory:.0f} GB; load before the start {os.getloadavg()[0]:.1f}; {first_line(['c++', '--version'])}, -O2; {packages}.\n")


def command():
    """That was given, with paths of this repository relative to it."""
    words = [word.replace(f"{SOURCE}/", "") for word in sys.argv]
    return f"By `{' '.join(words)}`.\n"


def keep(page, name, text):
    """Puts the text into the page between the markers of that name."""
    begin, end = f"<!-- {name}: begin -->", f"<!-- {name}: end -->"
    whole = page.read_text()
    if whole.count(begin) != 1 or whole.count(end) != 1:
        raise SystemExit(f"{page}: the markers {begin} and {end} must be there once each")
    before, rest = whole.split(begin)
    page.write_text(f"{before}{begin}\n{text.strip()}\n{end}{rest.split(end)[1]}")
