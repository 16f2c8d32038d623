"""The power fails at any moment: what was not synced may be lost, and yet every output is what it was or whole and new."""
import pathlib

import harness
import network_peers as peers
import power
import shapes
from power import disk

OLD = b"what stood there before\n"


class Outputs(power.TestCase):
    """Runs that write several files. After any failure and the next run all of them are as they were, or all are new."""

    MODEL = {"m.vtu": "-o", "m.report.json": "--report", "m.stl": "--surface", "m.html": "--html", "m.contours.json": "--contours"}

    def setUp(self):
        super().setUp()
        self.write("ball.json", shapes.sphere(8.0, 3.0).document())
        self.run_program("model", "ball.json", "--size", "4", "-o", "ball.vtu")

    def prepare(self, outputs, before):
        """An empty place but for the outputs that are there before."""
        self.log.unlink(missing_ok=True)
        for path in sorted(self.place.rglob("*"), reverse=True):
            path.rmdir() if path.is_dir() else path.unlink()
        for name in outputs:
            (self.place / name).parent.mkdir(exist_ok=True)
        for name in before:
            (self.place / name).write_bytes(OLD)

    def files(self):
        return {path: content for path, content in self.found().items() if content is not None}

    def run_next(self, outputs):
        """The next runs that write into the folders of the outputs, the first one's first."""
        for folder in dict.fromkeys((self.place / name).parent for name in outputs):
            self.run_program("contours", "ball.json", "-o", folder / "next.json", "--quiet")
            (folder / "next.json").unlink()

    def faults(self, played, outputs, allowed, ignored=()):
        """What is wrong after any failure at this moment. Each state is tried once."""
        for survival in played.survivals():
            state = (len(allowed), *sorted(played.left(survival).items()))
            if state in self.tried:
                continue
            self.tried.add(state)
            played.lay(survival)
            self.run_next(outputs)
            left = {name: content for name, content in self.files().items() if name not in ignored}
            if left not in allowed:
                told = {name: next((word for word, files in zip(("new", "old"), allowed) if files.get(name) == content), f"{len(content)} bytes")
                        for name, content in left.items()}
                yield f"{told}, unsynced data {survival[1]}, changes kept {list(survival[0].values())}"

    def record(self, words, outputs, before, ends=(0,)):
        """The calls of the runs, each but the last ended after so many records; the disk before them; the files after them."""
        self.prepare(outputs, before)
        fresh, whole = disk.Disk(self.place), disk.Disk(self.place)
        for last in ends:
            self.run_program(*words, expect=power.KILLED if last else 0, env=self.recording(last))
        calls = disk.read_log(self.log)
        for call in calls:
            whole.play(call)
        self.assert_complete(whole)
        return calls, fresh, self.files()

    def all_faults(self, words, outputs, before, without=()):
        """Of every failure during a run and after it. `without`: syncs that are taken out of its calls."""
        calls, played, new = self.record(words, outputs, before)
        self.assertEqual(set(new), set(outputs))
        old, self.tried = {name: OLD for name in before}, set()
        faults = list(self.faults(played, outputs, [new, old]))
        for n, call in enumerate(calls, 1):
            if call.name == "fsync" and (played.by_inode[call.number].changes is None) in without:
                continue
            played.play(call)
            is_done = n == len(calls)
            faults += [f"after call {n} of {len(calls)}, {call.name}: {fault}" for fault in self.faults(played, outputs, [new] if is_done else [new, old])]
        self.assertGreater(len(self.tried), 3)
        return faults

    def model(self, *names):
        """A run that makes these files in the place."""
        words = ["model", "ball.json", "--size", "4", "--quiet"]
        for name in names:
            words += [self.MODEL[pathlib.Path(name).name], self.place / name]
        return words

    def contours(self, contours, report):
        """The same, in less time."""
        return ["contours", "ball.json", "-o", self.place / contours, "--report", self.place / report, "--quiet"]

    def test_F05_outputs_of_a_model_are_old_or_new_together(self):
        outputs = list(self.MODEL)
        for before in (outputs, outputs[1::2], []):
            self.assertEqual(self.all_faults(self.model(*outputs), outputs, before), [], before)

    def test_F05_outputs_in_several_folders(self):
        outputs = ["m.vtu", "m.report.json", "other/m.stl", "third/m.html"]
        self.assertEqual(self.all_faults(self.model(*outputs), outputs, outputs[::2]), [])

    def test_F05_one_output(self):
        for words, name in ((("convert", "ball.vtu", "-o"), "m.inp"), (("contours", "ball.json", "-o"), "c.vtp"),
                            (("field", "ball.json", "-o"), "f.nrrd")):
            for before in ([name], []):
                self.assertEqual(self.all_faults([*words, self.place / name], [name], before), [], (words, before))

    def test_F05_a_run_after_a_killed_one(self):
        """What the killed one has renamed and not synced is safe when the next one has ended."""
        outputs = ["c.vtp", "other/c.report.json"]
        words = self.contours(*outputs)
        records = len(self.record(words, outputs, outputs)[0])
        for last in range(1, records):
            calls, played, new = self.record(words, outputs, outputs, (last, 0))
            for call in calls:
                played.play(call)
            self.tried = set()
            self.assertEqual(list(self.faults(played, outputs, [new])), [], f"killed after call {last} of {records}")

    def test_F05_a_second_failure_while_the_next_run_cleans_up(self):
        outputs = ["c.vtp", "other/c.report.json"]
        calls, played, new = self.record(self.contours(*outputs), outputs, outputs)
        old, self.tried, seconds = {name: OLD for name in outputs}, set(), 0
        for call in calls:
            played.play(call)
            if call.name not in ("exchange", "rename"):
                continue
            for survival in played.survivals():
                if survival[1] == "zeros":  # the files are synced by now
                    continue
                played.lay(survival)
                self.log.unlink()
                again = disk.Disk(self.place)
                self.run_program("contours", "ball.json", "-o", self.place / "next.json", "--quiet", env=self.recording())
                for second in disk.read_log(self.log):
                    again.play(second)
                    # Of that run's own output nothing is asked.
                    faults = list(self.faults(again, outputs, [new, old], ("next.json",)))
                    self.assertEqual(faults, [], (call.name, survival[1], second.name))
                    seconds += 1
        self.assertGreater(seconds, 50)

    def test_F05_without_syncs_the_law_is_broken(self):
        outputs = ["m.vtu", "m.report.json"]
        for of_files in (True, False):
            faults = self.all_faults(self.model(*outputs), outputs, outputs, without=(of_files,))
            self.assertTrue(any(fault.startswith("after call") for fault in faults), "files" if of_files else "folders")


class Objects(power.TestCase):
    """The receiver: an object that it has confirmed is safe, and none is there in part."""

    OBJECTS = [(b"1.1", b"1.2.3", b"1.2.3.4"), (b"1.2", b"1.2.3", b"1.2.3.4"), (b"1.3", b"1.2.3", b"1.2.3.5"), (b"1.4", b"1.2.4", b"1.2.4.1")]

    def receiver(self, last=0):
        settings = [f"{name}={value}" for name, value in self.recording(last).items()]
        return peers.Receiver(self, folder="place/incoming", launcher=("env", *settings))

    def name_of(self, number):
        instance, study, series = (each.decode() for each in self.OBJECTS[number])
        return f"incoming/{study}/{series}/{instance}.dcm"

    def store(self, receiver, number):
        """Whether it confirms the object."""
        instance, study, series = self.OBJECTS[number]
        with peers.associated(receiver) as connection:
            return peers.store(connection, instance, peers.data_set(instance, study, series, bytes(1000))) == 0

    def assert_law(self, played, whole, confirmed, where):
        for survival in played.survivals():
            left = {path: content for path, (_, content) in played.left(survival).items() if path.endswith(".dcm")}
            for name in confirmed:
                self.assertIn(name, left, f"{where}: a confirmed object is lost, unsynced data {survival[1]}")
            for name, content in left.items():
                self.assertEqual(content, whole[name], f"{where}: {name} is not whole, unsynced data {survival[1]}")

    def test_F05_a_confirmed_object_is_safe_and_none_is_in_part(self):
        played, whole_disk = disk.Disk(self.place), disk.Disk(self.place)
        receiver = self.receiver()
        confirmed_at = {}
        for number in (0, 1, 2, 3, 0):
            self.assertTrue(self.store(receiver, number))
            confirmed_at.setdefault(len(disk.read_log(self.log)), set()).add(self.name_of(number))
        receiver.stop()
        calls = disk.read_log(self.log)
        for call in calls:
            whole_disk.play(call)
        self.assert_complete(whole_disk)
        whole = {path: content for path, content in self.found().items() if path.endswith(".dcm")}
        self.assertEqual(len(whole), len(self.OBJECTS))
        confirmed = set()
        for n, call in enumerate(calls, 1):
            played.play(call)
            confirmed |= confirmed_at.get(n, set())
            self.assert_law(played, whole, confirmed, f"after call {n} of {len(calls)}, {call.name}")
        self.assertEqual(len(confirmed), len(self.OBJECTS))

    def test_F05_what_a_killed_receiver_left_is_safe_when_the_next_one_confirms_it(self):
        receiver = self.receiver()
        self.assertTrue(self.store(receiver, 0))
        receiver.stop()
        records = len(disk.read_log(self.log))
        whole = {self.name_of(0): (self.place / self.name_of(0)).read_bytes()}
        killed = 0
        for last in range(1, records + 1):
            self.log.unlink()
            for path in sorted(self.place.rglob("*"), reverse=True):
                path.rmdir() if path.is_dir() else path.unlink()
            played = disk.Disk(self.place)
            try:
                first = self.receiver(last)
                self.store(first, 0)
                first.kill()
                killed += first.process.returncode == power.KILLED
            except (AssertionError, OSError):
                killed += 1  # it ended before it answered
            second = self.receiver()
            self.assertTrue(self.store(second, 0))
            calls = disk.read_log(self.log)
            second.stop()
            for call in calls:
                played.play(call)
            self.assert_law(played, whole, set(whole), f"killed after call {last} of {records}")
        self.assertGreater(killed, 5)


if __name__ == "__main__":
    harness.main(__name__)
