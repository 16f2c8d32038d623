"""The receiver against good and bad senders: titles, habits, limits, kills, quota, names; models of complete studies."""
import os
import random
import re
import shutil
import signal
import socket
import struct
import subprocess
import threading
import time

import pydicom

import harness
import network_peers as peers
from network_peers import (Receiver, associated, closes_within, content_of, data, data_set, pdu, receive_pdu, run_tool,
                           send_at_once, store, write_study)


class ReceivingFromDcmtk(harness.TestCase):
    def test_A18_a_study_comes_in_shuffled_and_again(self):
        study, contours = write_study(self.folder / "study")
        shutil.copy(contours, study / "rs.dcm")
        sent = sorted(study.iterdir())
        random.Random(5).shuffle(sent)
        receiver = Receiver(self)
        run_tool("echoscu", "-aec", "ANATOMESH", "127.0.0.1", receiver.port)
        run_tool("storescu", "-aec", "ANATOMESH", "127.0.0.1", receiver.port, *sent)
        self.assertEqual(len(receiver.files()), 21)
        self.assertEqual(len({path.parent for path in receiver.files()}), 2)
        by_uid = {pydicom.dcmread(path).SOPInstanceUID: path for path in sent}
        for path in receiver.files():
            uid = pydicom.dcmread(path).SOPInstanceUID
            self.assertEqual(path.name, f"{uid}.dcm")
            self.assertEqual(content_of(path), content_of(by_uid[uid]))
        # A15: the same again is success, stored once.
        run_tool("storescu", "-aec", "ANATOMESH", "127.0.0.1", receiver.port, *sent)
        self.assertEqual(len(receiver.files()), 21)
        # A15: another content under the same UID is refused, and what is there stays.
        before = receiver.files()[0].read_bytes()
        other = pydicom.dcmread(receiver.files()[0])
        other.PatientID = "SOMEBODY ELSE"
        other.save_as(self.folder / "other.dcm")
        done = run_tool("storescu", "-v", "-aec", "ANATOMESH", "127.0.0.1", receiver.port, self.folder / "other.dcm", expect=None)
        self.assertIn("CannotUnderstand", done.stdout + done.stderr)  # DCMTK's word for 0xCxxx
        self.assertEqual(receiver.files()[0].read_bytes(), before)
        answer = receiver.stop()
        self.assertEqual((answer["stored"], answer["there_already"], answer["refused"]), (21, 21, 1))
        self.assertEqual((answer["studies"], answer["series"]), (1, 2))
        self.assertEqual(receiver.leftovers(), [])
        self.assertFalse(any("ZZPLANTED" in line.upper() for line in receiver.lines), receiver.lines)
        # What came in is a study that can be modelled.
        self.run_program("model", next(receiver.folder.iterdir()), "-o", "model.vtu", "--size", "6", "--quiet")

    def test_A21_senders_of_other_habits(self):
        study, _ = write_study(self.folder / "study")
        sent = sorted(study.iterdir())
        receiver = Receiver(self)
        run_tool("storescu", "-xi", "-aec", "ANATOMESH", "127.0.0.1", receiver.port, sent[0])
        run_tool("storescu", "-xb", "--max-pdu", "4096", "-aec", "ANATOMESH", "127.0.0.1", receiver.port, sent[1])
        run_tool("storescu", "--max-send-pdu", "4096", "--max-pdu", "131072", "-aec", "ANATOMESH", "127.0.0.1", receiver.port,
                 sent[2])
        self.assertEqual(len(receiver.files()), 3)
        for path in receiver.files():
            self.assertEqual(pydicom.dcmread(path).pixel_array.shape, (32, 32))
        for longest in (0, 16, 128, 1 << 20, 0xFFFFFFFF):
            with associated(receiver, longest=longest) as connection:
                connection.sendall(data(3, True, True, peers.store_command(b"9.9.%d" % longest))
                                   + data(3, False, True, data_set(b"9.9.%d" % longest)))
                got = b""
                while True:
                    kind, body = receive_pdu(connection)
                    self.assertEqual(kind, 4)
                    self.assertLessEqual(len(body), longest or 1 << 30)
                    got += body[6:]
                    if body[5] & 2:
                        break
                self.assertEqual(struct.unpack("<H", got[got.index(struct.pack("<HHI", 0, 0x900, 2)) + 8:][:2])[0], 0)
        receiver.stop()

    def test_A03_titles_and_hosts(self):
        receiver = Receiver(self, "--allow", "GOOD", "--allow", "FAR@192.0.2.7")
        run_tool("echoscu", "-aec", "ANATOMESH", "-aet", "GOOD", "127.0.0.1", receiver.port)
        for title, called, wanted in (("GOOD", "OTHER", (1, 1, 7)), ("BAD", "ANATOMESH", (1, 1, 3)), ("FAR", "ANATOMESH", (1, 1, 3)),
                                      ("", "ANATOMESH", (1, 1, 3)), ("GOOD", "", (1, 1, 7)), ("\0" * 16, "ANATOMESH", (1, 1, 3)),
                                      ("GÖÖD", "ANATOMESH", (1, 1, 3)), ("good", "ANATOMESH", (1, 1, 3))):
            with receiver.connect() as connection:
                connection.sendall(peers.associate_request(called, title))
                kind, body = receive_pdu(connection)
                self.assertEqual((kind, tuple(body[1:])), (3, wanted), title)
        done = run_tool("echoscu", "-aec", "WRONG", "127.0.0.1", receiver.port, expect=None)
        self.assertNotEqual(done.returncode, 0)
        # Ten lines a minute of a peer, whatever it does.
        for _ in range(50):
            with receiver.connect() as connection:
                connection.sendall(peers.associate_request("NOBODY"))
                receive_pdu(connection)
        answer = receiver.stop()
        self.assertGreaterEqual(answer["rejected"], 58)
        self.assertLessEqual(sum("rejected" in line for line in receiver.lines), 10)

    def test_A03_a_host_that_is_not_allowed(self):
        receiver = Receiver(self, "--allow", "TESTER@192.0.2.7")
        with receiver.connect() as connection:
            connection.sendall(peers.associate_request())
            kind, body = receive_pdu(connection)
            self.assertEqual((kind, tuple(body[1:])), (3, (1, 1, 1)))
        receiver.stop()

    def test_A16_A20_what_is_not_offered(self):
        receiver = Receiver(self)
        done = run_tool("findscu", "-S", "-aec", "ANATOMESH", "-k", "QueryRetrieveLevel=STUDY", "-k", "StudyInstanceUID",
                        "127.0.0.1", receiver.port, expect=None)
        self.assertNotEqual(done.returncode, 0)
        done = run_tool("movescu", "-S", "-aec", "ANATOMESH", "-aem", "X", "-k", "QueryRetrieveLevel=STUDY", "-k",
                        "StudyInstanceUID=1.2", "127.0.0.1", receiver.port, expect=None)
        self.assertNotEqual(done.returncode, 0)
        with receiver.connect() as connection:
            connection.sendall(peers.associate_request(contexts={1: ("1.2.840.10008.1.20.1", [peers.IMPLICIT]),
                                                                 3: (peers.CT, ["1.2.840.10008.1.2.1.99"]),
                                                                 5: (peers.CT, [peers.IMPLICIT])}))
            kind, body = receive_pdu(connection)
            self.assertEqual(kind, 2)
            results = {}
            at = 68
            while at < len(body):
                length = struct.unpack(">H", body[at + 2:at + 4])[0]
                if body[at] == 0x21:
                    results[body[at + 4]] = body[at + 6]
                at += 4 + length
            self.assertEqual(results, {1: 3, 3: 4, 5: 0})
        receiver.stop()


class HostilePeers(harness.TestCase):
    def good_sender(self, receiver, instance):
        """A sender that does all right; the seconds it took."""
        begun = time.monotonic()
        with associated(receiver) as connection:
            self.assertEqual(store(connection, instance, data_set(instance)), 0)
            connection.sendall(pdu(5, bytes(4)))
            self.assertEqual(receive_pdu(connection)[0], 6)
        return time.monotonic() - begun

    def test_A01_A02_silent_and_slow_peers(self):
        receiver = Receiver(self, "--timeout", "1.5")
        silent = [receiver.connect() for _ in range(5)]
        half = receiver.connect()
        half.sendall(peers.associate_request()[:60])
        slow = receiver.connect()
        stop = threading.Event()

        def trickle():
            for byte in peers.associate_request() * 4:
                try:
                    slow.sendall(bytes([byte]))
                except OSError:
                    return
                if stop.wait(0.3):
                    return
        thread = threading.Thread(target=trickle)
        thread.start()
        self.assertLess(self.good_sender(receiver, b"1.1"), 1)
        for connection in silent + [half, slow]:
            self.assertTrue(closes_within(connection, 5))
            connection.close()
        stop.set()
        thread.join()
        # An association that falls silent goes the same way, in the middle of an object too.
        idle = associated(receiver)
        middle = associated(receiver)
        middle.sendall(data(3, True, True, peers.store_command(b"1.2")) + data(3, False, False, data_set(b"1.2")[:40]))
        for connection in (idle, middle):
            self.assertTrue(closes_within(connection, 5))
            connection.close()
        self.assertEqual(len(receiver.files()), 1)
        self.assertEqual(receiver.leftovers(), [])
        self.assertLess(self.good_sender(receiver, b"1.3"), 1)
        receiver.stop()

    def test_A04_A05_A07_nonsense(self):
        receiver = Receiver(self, "--timeout", "2")
        self.good_sender(receiver, b"1.1")
        memory = receiver.status("VmRSS")
        nonsense = [b"GET / HTTP/1.1\r\nHost: x\r\n\r\n", b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03", b"\0\0\0\x85\xffSMBr",
                    bytes(range(256)) * 8, b"\x01\0\xff\xff\xff\xff" + bytes(1000), pdu(1, b""), pdu(1, bytes(40)),
                    pdu(0, b"x"), pdu(8, b"x"), pdu(255, b"x"), pdu(4, data(1, True, True, b"")[6:]), pdu(5, bytes(4)),
                    pdu(2, bytes(68)), pdu(3, bytes(4)), pdu(6, bytes(4)), pdu(7, bytes(4))]
        for bytes_ in nonsense:
            with receiver.connect() as connection:
                try:
                    connection.sendall(bytes_)
                    connection.shutdown(socket.SHUT_WR)
                except OSError:
                    pass
                self.assertTrue(closes_within(connection, 5), bytes_[:20])
        for bytes_ in nonsense[4:]:
            with associated(receiver) as connection:
                try:
                    connection.sendall(bytes_)
                except OSError:
                    pass
                connection.shutdown(socket.SHUT_WR)
                self.assertTrue(closes_within(connection, 5), bytes_[:20])
        self.assertLess(receiver.status("VmRSS") - memory, 4096)
        self.assertLess(self.good_sender(receiver, b"1.2"), 1)
        receiver.stop()
        self.assertLessEqual(sum("aborted" in line for line in receiver.lines), 10)

    def test_A10_too_many(self):
        receiver = Receiver(self, "--timeout", "20")
        held = [associated(receiver) for _ in range(8)]
        with receiver.connect() as ninth:
            ninth.sendall(peers.associate_request())
            kind, body = receive_pdu(ninth)
            self.assertEqual((kind, tuple(body[1:])), (3, (2, 3, 2)))
        # Those that are held still work, and one that ends makes room.
        self.assertEqual(store(held[0], b"1.1", data_set(b"1.1")), 0)
        held.pop().close()
        time.sleep(0.3)
        self.assertLess(self.good_sender(receiver, b"1.2"), 5)
        for connection in held:
            connection.close()
        time.sleep(0.3)
        # A crowd of silent connections: the good sender gets through, and nothing grows.
        descriptors, memory = receiver.descriptors(), receiver.status("VmRSS")
        crowd = []
        slowest = 0
        for i in range(600):
            crowd.append(receiver.connect())
            if i % 100 == 99:
                slowest = max(slowest, self.good_sender(receiver, b"2.%d" % i))
        self.assertLess(slowest, 10)
        self.assertLess(receiver.descriptors(), descriptors + 80)
        self.assertLess(receiver.status("VmRSS") - memory, 4096)
        for connection in crowd:
            connection.close()
        receiver.stop()

    def test_A11_opened_and_closed_many_times(self):
        receiver = Receiver(self)

        def often(times):
            for _ in range(times):
                with associated(receiver) as connection:
                    connection.sendall(pdu(5, bytes(4)))
                    self.assertEqual(receive_pdu(connection)[0], 6)
        often(300)
        memory, descriptors = receiver.status("VmRSS"), receiver.descriptors()
        often(20000)
        self.assertLessEqual(receiver.status("VmRSS") - memory, 1024)
        self.assertLessEqual(receiver.descriptors(), descriptors + 2)
        self.assertEqual(receiver.stop()["associations"], 20300)

    def test_A12_a_client_that_dies_while_it_sends(self):
        receiver = Receiver(self, "--timeout", "2")
        for cut in range(3):
            connection = associated(receiver)
            connection.sendall(data(3, True, True, peers.store_command(b"1.%d" % cut))
                               + data(3, False, False, data_set(b"1.%d" % cut, payload=bytes(100000))[:50000]))
            if cut == 2:  # the cable is pulled: no end of the connection is seen
                connection.settimeout(1)
                self.addCleanup(connection.close)
            else:
                if cut == 1:
                    connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
                connection.close()
        deadline = time.monotonic() + 10
        while receiver.leftovers() and time.monotonic() < deadline:
            time.sleep(0.1)
        self.assertEqual(receiver.leftovers(), [])
        self.assertEqual(receiver.files(), [])
        self.good_sender(receiver, b"1.9")
        receiver.stop()

    def test_A12_F08_killed_it_leaves_whole_objects_alone(self):
        receiver = Receiver(self)
        connection = associated(receiver)
        self.assertEqual(store(connection, b"1.1", data_set(b"1.1")), 0)
        connection.sendall(data(3, True, True, peers.store_command(b"1.2")) + data(3, False, False, data_set(b"1.2")[:40]))
        deadline = time.monotonic() + 10
        while not receiver.leftovers() and time.monotonic() < deadline:
            time.sleep(0.05)
        receiver.process.kill()
        receiver.process.wait()
        connection.close()
        self.assertEqual([path.name for path in receiver.files()], ["1.1.dcm"])
        again = Receiver(self)
        self.assertEqual(again.leftovers(), [])
        self.assertEqual(len(again.files()), 1)
        # F08: a second one does not take the folder.
        self.assertIn("E-NET-002", self.run_program("receive", again.folder, "--port", "0", expect=6).err)
        again.stop()

    def whole_files(self, receiver, payload):
        """How many objects are there; each has all of its pixels."""
        files = receiver.files()
        for path in files:
            self.assertEqual(len(pydicom.dcmread(path).PixelData), payload, path)
        return len(files)

    def test_A10_all_places_busy_beside_a_silent_peer(self):
        receiver = Receiver(self, "--timeout", "5")
        with receiver.connect():
            threads, statuses = send_at_once(receiver, 7, 30, 200000)
            for thread in threads:
                thread.join()
        self.assertEqual(statuses, [0] * 210)
        self.assertEqual(self.whole_files(receiver, 200000), 210)
        self.assertEqual((receiver.leftovers(), receiver.stop()["series"]), ([], 7))

    def test_A12_killed_while_eight_send(self):
        for trial, moment in enumerate((0.1, 0.3, 0.6)):
            receiver = Receiver(self, folder=f"killed{trial}")
            threads, statuses = send_at_once(receiver, 8, 200, 200000)
            time.sleep(moment)
            receiver.process.kill()
            receiver.process.wait()
            for thread in threads:
                thread.join()
            stored = self.whole_files(receiver, 200000)
            self.assertGreaterEqual(stored, statuses.count(0))  # what was confirmed is there
            again = Receiver(self, folder=f"killed{trial}")
            self.assertEqual((again.leftovers(), len(again.files())), ([], stored))
            again.stop()

    def test_A13_a_full_disk(self):
        small = self.folder / "small"
        small.mkdir()
        mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=3m", "none", str(small)], capture_output=True, text=True)
        if mounted.returncode:
            self.skipTest(f"no small disk can be mounted: {mounted.stderr.strip()}")
        self.addCleanup(subprocess.run, ["umount", "-l", str(small)], check=True)
        receiver = Receiver(self, folder="small/incoming")
        threads, statuses = send_at_once(receiver, 4, 10, 200000)
        for thread in threads:
            thread.join()
        self.assertEqual(set(statuses), {0, 0xA700})
        self.assertEqual(len(statuses), 40)
        self.assertEqual(self.whole_files(receiver, 200000), statuses.count(0))
        self.assertEqual(receiver.leftovers(), [])
        self.assertEqual(receiver.stop()["refused"], statuses.count(0xA700))

    def test_F09_the_folder_is_deleted_while_it_receives(self):
        receiver = Receiver(self)
        with associated(receiver) as connection:
            self.assertEqual(store(connection, b"1.1", data_set(b"1.1")), 0)
        shutil.rmtree(receiver.folder)
        with associated(receiver) as connection:
            self.assertEqual(store(connection, b"1.2", data_set(b"1.2")), 0xA700)
        receiver.folder.mkdir()
        with associated(receiver) as connection:
            for instance in (b"1.1", b"1.2"):
                self.assertEqual(store(connection, instance, data_set(instance)), 0)
        self.assertEqual(len(receiver.files()), 2)
        answer = receiver.stop()
        self.assertEqual((answer["stored"], answer["refused"]), (3, 1))

    def test_A13_the_quota(self):
        receiver = Receiver(self, "--quota", "0.1")
        with associated(receiver) as connection:
            self.assertEqual(store(connection, b"1.1", data_set(b"1.1", payload=bytes(60000))), 0)
            before = receiver.files()[0].read_bytes()
            content = data_set(b"1.2", payload=bytes(60000))
            self.assertEqual(store(connection, b"1.2", content), 0xA700)
            # Far beyond it: nothing is kept while it comes in.
            connection.sendall(data(3, True, True, peers.store_command(b"1.3")))
            for _ in range(400):
                connection.sendall(data(3, False, False, bytes(100000)))
            connection.sendall(data(3, False, True, b""))
            self.assertEqual(peers.status_of(receive_pdu(connection)[1]), 0xA700)
            self.assertEqual(store(connection, b"1.4", data_set(b"1.4")), 0)
        self.assertEqual(receiver.files()[0].read_bytes(), before)
        answer = receiver.stop()
        self.assertEqual((answer["stored"], answer["refused"]), (2, 2))
        self.assertEqual(receiver.leftovers(), [])

    def test_A15_what_cannot_be_read_is_never_replaced(self):
        receiver = Receiver(self, launcher=peers.WITHOUT_ROOT_RIGHTS)
        with associated(receiver) as connection:
            for name in (b"1.1", b"1.2"):
                self.assertEqual(store(connection, name, data_set(name)), 0)
            locked, linked = receiver.files()
            before = locked.read_bytes()
            locked.chmod(0)
            linked.rename(self.folder / "elsewhere.dcm")
            linked.symlink_to(self.folder / "elsewhere.dcm")
            for payload in (b"xx", b"other"):  # the same content cannot be known to be the same
                self.assertEqual(store(connection, b"1.1", data_set(b"1.1", payload=payload)), 0xC112)
                self.assertEqual(store(connection, b"1.2", data_set(b"1.2", payload=payload)), 0xC112)
            self.assertEqual(store(connection, b"1.3", data_set(b"1.3")), 0)
        locked.chmod(0o600)
        self.assertEqual(locked.read_bytes(), before)
        self.assertTrue(linked.is_symlink())
        answer = receiver.stop()
        self.assertEqual((answer["stored"], answer["refused"]), (3, 4))
        self.assertTrue(any("0xC112" in line and "cannot be read and compared" in line for line in receiver.lines))
        self.assertEqual(receiver.leftovers(), [])

    def test_A14_names_that_would_be_paths(self):
        receiver = Receiver(self)
        with associated(receiver) as connection:
            for name in (b"../../x", b"/etc/x", b"u" * 1000, b"1\0/../../x", b"..", b"."):
                self.assertEqual(store(connection, name, data_set(name, name, name)), 0, name)
            self.assertIn(store(connection, b"", data_set(b"")) >> 12, (0xA, 0xC))
            self.assertEqual(store(connection, b"1.1", data_set(b"1.2")), 0xA900)
            self.assertEqual(store(connection, b"1.1", data_set(b"1.1", b"", b"1")) >> 12, 0xC)
        self.assertEqual(len(receiver.files()), 6)
        for path in receiver.folder.rglob("*"):
            self.assertRegex(path.name, r"^x[0-9a-f]{40}(\.dcm)?$")
        self.assertEqual(sorted(os.listdir(self.folder)), ["incoming"])
        receiver.stop()

    def test_A17_damaged_objects(self):
        receiver = Receiver(self)
        chance = random.Random(4)
        good = data_set(b"1.1", payload=bytes(500))
        connection = associated(receiver)
        for i in range(500):
            damaged = bytearray(good)
            for _ in range(chance.randrange(1, 9)):
                damaged[chance.randrange(len(damaged))] = chance.randrange(256)
            status = store(connection, b"1.1", bytes(damaged[:chance.randrange(len(damaged))] if i % 3 == 0 else damaged))
            self.assertTrue(status == 0 or status >> 12 in (0xA, 0xC), status)
        connection.close()
        self.good_sender(receiver, b"2.2")
        self.assertEqual(receiver.leftovers(), [])
        receiver.stop()


class Watching(harness.TestCase):
    def wait_for(self, receiver, what, seconds=120):
        deadline = time.monotonic() + seconds
        while time.monotonic() < deadline:
            if any(what in line for line in receiver.lines):
                return
            self.assertIsNone(receiver.process.poll(), receiver.lines)
            time.sleep(0.1)
        self.fail(f"no '{what}' in {receiver.lines}")

    def test_A18_a_model_when_the_study_is_complete(self):
        study, contours = write_study(self.folder / "study")
        slices = sorted(study.iterdir())
        receiver = Receiver(self, "--model", "--settle", "0.4")
        # Images alone make none, and neither do contours some of whose images are missing.
        self.run_program("send", *slices[:15], "--to", receiver.peer)
        self.run_program("send", contours, "--to", receiver.peer)
        models = receiver.folder / "models" / peers.STUDY
        self.wait_for(receiver, "no model yet")
        self.assertFalse(models.exists())
        # The late ones complete it.
        self.run_program("send", *slices[15:], "--to", receiver.peer)
        self.wait_for(receiver, "model 1 made")
        names = sorted(path.name for path in (models / "1").iterdir())
        self.assertEqual(names, ["instances.sha256", "model.html", "model.report.json", "model.stl", "model.vtu", "surface.dcm"])
        self.run_program("check", models / "1/model.vtu")
        # O05: what lies in them may leave the folder, which is called after the study.
        for path in (models / "1").iterdir():
            self.assertIsNone(re.search(rb"zzplanted|1\.2\.826\.0\.1\.3680043\.8\.498", path.read_bytes(), re.I), path.name)
        before = (models / "1/model.vtu").read_bytes()
        # One more slice, later: another version, and the first one stays.
        late = pydicom.dcmread(slices[0])
        late.SOPInstanceUID = late.file_meta.MediaStorageSOPInstanceUID = "1.2.826.0.1.3680043.8.498.1.99"
        late.ImagePositionPatient[2] -= 3
        late.save_as(self.folder / "late.dcm")
        self.run_program("send", "late.dcm", "--to", receiver.peer)
        self.wait_for(receiver, "model 2 made")
        self.assertEqual((models / "1/model.vtu").read_bytes(), before)
        self.assertEqual(receiver.stop()["models"], 2)
        self.assertFalse(any("498.7" in line or "ZZPLANTED" in line.upper() for line in receiver.lines), receiver.lines)
        # Another run knows what has been done, and makes up for what was not: here the second was killed.
        (models / "2/model.vtu").unlink()
        (models / "2/failure.txt").touch()
        again = Receiver(self, "--model", "--settle", "0.4")
        self.wait_for(again, "model 2 made")
        self.assertEqual(again.stop()["models"], 1)
        again = Receiver(self, "--model", "--settle", "0.4")
        time.sleep(1.5)
        self.assertEqual(again.stop()["models"], 0)
        self.assertEqual(len(list(models.iterdir())), 2)

    def test_F14_models_that_crash_hang_or_are_killed_hold_up_no_other(self):
        study, contours = write_study(self.folder / "study")
        odd = [("11", signal.SIGSEGV, "signal 11 ended the process"), ("12", signal.SIGSTOP, "it took longer than 1 s"),
               ("13", signal.SIGKILL, "as the system does when memory runs out")]
        for number, _, _ in odd:
            folder = self.folder / number
            folder.mkdir()
            for path in [*study.iterdir(), contours]:
                each = pydicom.dcmread(path)
                each.StudyInstanceUID = f"{peers.STUDY}.{number}"
                each.save_as(folder / path.name)
        receiver = Receiver(self, "--model", "--settle", "0.4", "--model-time", "1")
        self.run_program("send", *(number for number, _, _ in odd), "--to", receiver.peer)
        seen, deadline = [], time.monotonic() + 60
        while len(seen) < len(odd) and time.monotonic() < deadline:
            for child in set(receiver.children()) - set(seen):
                os.kill(child, odd[len(seen)][1])
                seen.append(child)
            time.sleep(0.002)
        for _, _, text in odd:
            self.wait_for(receiver, text)
        # The receiver lives on, and says of each in its folder why there is no model.
        with associated(receiver) as connection:
            self.assertEqual(store(connection, b"1.1", data_set(b"1.1")), 0)
        texts = []
        for number, _, _ in odd:
            version = receiver.folder / "models" / f"{peers.STUDY}.{number}" / "1"
            self.assertEqual(sorted(path.name for path in version.iterdir()), ["failure.txt", "instances.sha256"])
            texts.append((version / "failure.txt").read_text())
        for _, _, text in odd:
            self.assertEqual(sum(text in each for each in texts), 1, texts)
        self.assertEqual(receiver.stop()["models"], 0)
        # The next start does not try them again: a crash would come back at every start.
        again = Receiver(self, "--model", "--settle", "0.4")
        time.sleep(1)
        self.assertEqual(again.children(), [])
        # A process that does not heed the end of the receiver is killed, and its study is made up for.
        late = pydicom.dcmread(self.folder / "11" / "ct00.dcm")
        late.SOPInstanceUID = late.file_meta.MediaStorageSOPInstanceUID = "1.2.826.0.1.3680043.8.498.1.99"
        late.ImagePositionPatient[2] -= 3
        late.save_as(self.folder / "late.dcm")
        self.run_program("send", "late.dcm", "--to", again.peer)
        deadline = time.monotonic() + 60
        while not again.children() and time.monotonic() < deadline:
            time.sleep(0.002)
        os.kill(again.children()[0], signal.SIGSTOP)
        begun = time.monotonic()
        again.stop()
        self.assertLess(time.monotonic() - begun, 6)
        self.assertFalse((again.folder / "models" / f"{peers.STUDY}.11" / "2").exists())

    def test_A17_a_study_that_cannot_be_modelled(self):
        study, contours = write_study(self.folder / "study")
        made = pydicom.dcmread(contours)
        for each in made.ROIContourSequence[0].ContourSequence:
            each.ContourData = ["1e30"] * len(each.ContourData)
        made.save_as(self.folder / "bad.dcm")
        receiver = Receiver(self, "--model", "--settle", "0.4")
        self.run_program("send", study, "bad.dcm", "--to", receiver.peer)
        self.wait_for(receiver, "no model 1")
        self.assertEqual(sorted(path.name for path in (receiver.folder / "models" / peers.STUDY / "1").iterdir()),
                         ["failure.txt", "instances.sha256"])
        self.assertIn("E-", (receiver.folder / "models" / peers.STUDY / "1/failure.txt").read_text())
        with associated(receiver) as connection:
            self.assertEqual(store(connection, b"1.1", data_set(b"1.1")), 0)
        self.assertEqual(receiver.stop()["models"], 0)


if __name__ == "__main__":
    harness.main("__main__")
