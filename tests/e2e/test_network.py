"""The clinic's network: the receiver against good and bad peers, and the whole way round with a PACS."""
import http.server
import os
import random
import shutil
import socket
import ssl
import struct
import subprocess
import threading
import time
import unittest

import pydicom
import pydicom.misc

import harness
import network_peers as peers
from network_peers import Orthanc, Receiver, associated, data, data_set, needed, pdu, receive_pdu, store, write_study


def run_tool(name, *words, expect=0, timeout=120):
    done = subprocess.run([needed(name), *map(str, words)], capture_output=True, text=True, timeout=timeout)
    if expect is not None:
        assert done.returncode == expect, (name, words, done.returncode, done.stdout[-2000:], done.stderr[-2000:])
    return done


def content_of(path):
    """What an object says, without its meta header."""
    return pydicom.dcmread(path).to_json()


def closes_within(connection, seconds):
    """Whether the peer ends the connection in time; what it said before is read."""
    connection.settimeout(seconds)
    begun = time.monotonic()
    try:
        while connection.recv(65536):
            connection.settimeout(max(0.01, seconds - (time.monotonic() - begun)))
    except ConnectionResetError:
        pass
    except socket.timeout:
        return False
    return True


class NetworkCommands(harness.TestCase):
    def test_wrong_peers_and_options(self):
        for words in (["query", "--from", "127.0.0.1:104"], ["query", "--from", "A@"], ["query", "--from", "A@h:0"],
                      ["query", "--from", "A@h:70000"], ["query", "--from", "http://"], ["query", "--from", "http://u:p@h/"],
                      ["query", "--from", "A" * 17 + "@h"], ["query", "--from", "ftp://h/"]):
            self.assert_refused(words, 2, "E-NET-005")
        refused = self.run_program("query", "--from", "http://me:secret@h/", expect=2)
        self.assertNotIn("secret", refused.err)
        self.assert_refused(["query", "--from", "A@h", "--user", "x"], 2, "E-CMD-008")
        self.assert_refused(["query", "--from", "http://h", "--tls"], 2, "E-CMD-008")
        self.assert_refused(["query", "--from", "A@h", "--match", "Patient=7"], 2, "E-NET-021", "PatientID")
        self.assert_refused(["query", "--from", "A@h", "--match", "Modality=CT"], 2, "E-NET-021")
        self.assert_refused(["query", "--from", "A@h", "--study", "../x"], 2, "E-NET-022")
        self.assert_refused(["fetch", "--from", "A@h", "--study", "1.2"], 2, "-o")
        self.assert_refused(["fetch", "--from", "A@h", "--study", "1.2", "-o", "x", "--port", "11"], 2, "E-CMD-008")
        self.assert_refused(["receive", "x", "--address", "0.0.0.0"], 2, "E-NET-020")
        self.assert_refused(["receive", "x", "--address", "0.0.0.0", "--allow", "A@127.0.0.1"], 2, "E-NET-020", "--plain")
        self.assert_refused(["receive", "x", "--allow", "@"], 2, "E-NET-009")
        self.assert_refused(["receive", "x", "--settle", "5"], 2, "E-CMD-008")

    def test_nobody_there(self):
        self.write("notes.txt", "no DICOM")
        port = peers.free_port()
        refused = self.assert_refused(["query", "--from", f"A@127.0.0.1:{port}"], 6, "E-NET-010")
        self.assertNotIn("Traceback", refused.err)
        self.assert_refused(["query", "--from", f"http://127.0.0.1:{port}/x"], 6, "E-NET-016")
        self.assert_refused(["send", "notes.txt", "--to", f"A@127.0.0.1:{port}"], 3, "E-NET-006")
        self.assert_refused(["send", "nothing", "--to", f"A@127.0.0.1:{port}"], 6, "E-INP")

    def test_a_peer_that_is_silent_or_talks_nonsense(self):
        for answer in (b"", b"HTTP/1.0 400\r\n\r\n", pdu(2, b"short"), pdu(7, bytes(4)), b"\x02\0\xff\xff\xff\xff"):
            with socket.socket() as listener:
                listener.bind(("127.0.0.1", 0))
                listener.listen()

                def serve():
                    connection, _ = listener.accept()
                    with connection:
                        connection.sendall(answer)
                        closes_within(connection, 10)
                thread = threading.Thread(target=serve)
                thread.start()
                self.assert_refused(["query", "--from", f"A@127.0.0.1:{listener.getsockname()[1]}", "--timeout", "0.5"], 6,
                                    "E-NET-013")
                thread.join()

    def test_A22_ports_that_cannot_be_had(self):
        with socket.socket() as taken:
            taken.bind(("127.0.0.1", 0))
            taken.listen()
            done = self.run_program("receive", "x", "--port", taken.getsockname()[1], expect=6)
            self.assertIn("E-NET-003", done.err)
        done = self.run_program("receive", "y", "--address", "192.0.2.1", "--allow", "A@127.0.0.1", "--plain", expect=6)
        self.assertIn("E-NET-003", done.err)
        if os.geteuid() != 0:
            self.assertIn("E-NET-003", self.run_program("receive", "z", "--port", "104", expect=6).err)
        self.assertIn("E-NET-001", self.run_program("receive", "no/such/folder", "--port", "0", expect=6).err)

    def test_A22_ipv6(self):
        try:
            with socket.socket(socket.AF_INET6) as probe:
                probe.bind(("::1", 0))
        except OSError:
            self.skipTest("no IPv6")
        receiver = Receiver(self, "--address", "::1")
        with socket.create_connection(("::1", receiver.port)) as connection:
            connection.sendall(peers.associate_request())
            self.assertEqual(receive_pdu(connection)[0], 2)
        receiver.stop()


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

    def test_killed_it_leaves_whole_objects_alone(self):
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


class Archive(harness.TestCase):
    """The whole way round with Orthanc: in, found, fetched, modelled, the model back, and found again."""

    def there_and_back(self, orthanc, peer, login=()):
        study, contours = write_study(self.folder / "study")
        shutil.copy(contours, study / "rs.dcm")
        (study / "notes.txt").write_text("no DICOM")
        sent = self.run_program("send", study, "--to", peer, *login, "--json").json()
        self.assertEqual((sent["objects"], sent["stored"], sent["skipped"]), (21, 21, 1))

        found = self.run_program("query", "--from", peer, *login, "--json").json()["answers"]
        self.assertEqual([each["StudyInstanceUID"] for each in found], [peers.STUDY])
        self.assertEqual(found[0]["NumberOfStudyRelatedInstances"], "21")
        self.assertEqual(sorted(found[0]["ModalitiesInStudy"].split("\\")), ["CT", "RTSTRUCT"])
        # O05: what could name the patient is shown on request alone.
        text = self.run_program("query", "--from", peer, *login).out
        self.assertNotIn("ZZPLANTED", text.upper())
        named = self.run_program("query", "--from", peer, *login, "--keep-patient-ids", "--match", "PatientID=ZZPLANTEDID",
                                 "--match", "StudyDate=19990101-20001231", "--json").json()["answers"]
        self.assertEqual(named[0]["PatientName"], "Zzplanted^Name")
        self.assertEqual(self.run_program("query", "--from", peer, *login, "--match", "PatientID=NOBODY", "--json").json()["answers"], [])
        series = self.run_program("query", "--from", peer, *login, "--level", "series", "--study", peers.STUDY, "--json").json()["answers"]
        self.assertEqual(sorted(each["Modality"] for each in series), ["CT", "RTSTRUCT"])
        images = self.run_program("query", "--from", peer, *login, "--level", "instance", "--study", peers.STUDY, "--series",
                                  peers.SERIES, "--json").json()["answers"]
        self.assertEqual(len(images), 20)
        cut = self.run_program("query", "--from", peer, *login, "--level", "instance", "--study", peers.STUDY, "--series",
                               peers.SERIES, "--most", "7", "--json").json()
        self.assertEqual((len(cut["answers"]), cut["warnings"][0]["code"]), (7, "W-NET-001"))

        fetched = self.run_program("fetch", "--from", peer, *login, "--study", peers.STUDY, "-o", "fetched", "--json").json()
        self.assertEqual((fetched["stored"], fetched["failed"], fetched["refused"]), (21, 0, 0))
        by_uid = {pydicom.dcmread(path).SOPInstanceUID: path for path in study.glob("*.dcm")}
        for path in (self.folder / "fetched").glob("*/*/*.dcm"):
            self.assertEqual(content_of(path), content_of(by_uid.pop(path.name[:-4])))
        self.assertEqual(by_uid, {})
        again = self.run_program("fetch", "--from", peer, *login, "--study", peers.STUDY, "-o", "fetched", "--json").json()
        self.assertEqual((again["stored"], again["there_already"]), (0, 21))
        one = self.run_program("fetch", "--from", peer, *login, "--study", peers.STUDY, "--series", peers.SERIES, "--instance",
                               images[0]["SOPInstanceUID"], "-o", "one", "--json").json()
        self.assertEqual(one["stored"], 1)
        self.assert_refused(["fetch", "--from", peer, *login, "--study", "1.2.3.4.5", "-o", "none"], 3, "E-NET-023")

        self.run_program("model", next((self.folder / "fetched").iterdir()), "-o", "model.vtu", "--size", "6",
                         "--keep-patient-ids", "--dicom-surface", "surface.dcm", "--quiet")
        sent = self.run_program("send", "surface.dcm", "--to", peer, *login, "--json").json()
        self.assertEqual(sent["stored"], 1)
        found = self.run_program("query", "--from", peer, *login, "--level", "series", "--study", peers.STUDY, "--match",
                                 "Modality=M3D", "--json").json()["answers"]
        self.assertEqual(len(found), 1)
        back = self.run_program("fetch", "--from", peer, *login, "--study", peers.STUDY, "--series",
                                found[0]["SeriesInstanceUID"], "-o", "back", "--json").json()
        self.assertEqual(back["stored"], 1)
        self.assertEqual(content_of(next((self.folder / "back").glob("*/*/*.dcm"))), content_of(self.folder / "surface.dcm"))

    def test_by_dimse(self):
        orthanc = Orthanc(self)
        self.there_and_back(orthanc, orthanc.peer)
        # Others find and get what was sent.
        got = self.folder / "got"
        got.mkdir()
        done = run_tool("getscu", "-v", "-S", "-aec", "ORTHANC", "-od", got, "-k", "QueryRetrieveLevel=SERIES", "-k",
                        f"StudyInstanceUID={peers.STUDY}", "-k", f"SeriesInstanceUID={peers.SERIES}", "127.0.0.1", orthanc.dicom)
        self.assertEqual(len(list(got.iterdir())), 20, done.stdout + done.stderr)
        rejected = self.run_program("query", "--from", orthanc.peer.replace("ORTHANC", "OTHER"), expect=6)
        self.assertIn("E-NET-011", rejected.err)

    def test_by_dicomweb(self):
        orthanc = Orthanc(self)
        self.there_and_back(orthanc, orthanc.url, orthanc.web_login)
        self.assertIn("E-NET-017", self.run_program("query", "--from", orthanc.url, expect=6).err)
        self.assertIn("--user", self.run_program("send", "surface.dcm", "--to", orthanc.url, expect=6).err)

    def test_by_move(self):
        port = peers.free_port()
        orthanc = Orthanc(self, port)
        study, _ = write_study(self.folder / "study")
        self.run_program("send", study, "--to", orthanc.peer)
        fetched = self.run_program("fetch", "--from", orthanc.peer, "--study", peers.STUDY, "--move-to", "MOVEHERE", "--port",
                                   port, "-o", "fetched", "--json").json()
        self.assertEqual((fetched["stored"], fetched["sent"]), (20, 20))
        # To another program: a receiver that runs.
        receiver = Receiver(self, title="MOVEHERE", port=port)
        moved = self.run_program("fetch", "--from", orthanc.peer, "--study", peers.STUDY, "--move-to", "MOVEHERE", "--json").json()
        self.assertEqual(moved["sent"], 20)
        self.assertEqual(len(receiver.files()), 20)
        receiver.stop()
        unknown = self.run_program("fetch", "--from", orthanc.peer, "--study", peers.STUDY, "--move-to", "NOBODY", expect=6)
        self.assertIn("E-NET-019", unknown.err)


class RealStudies(harness.TestCase):
    """Studies of real scanners through the archive, by both ways: what comes out is what went in."""

    def through(self, folder, peer, login, orthanc_count):
        sent = self.run_program("send", folder, "--to", peer, *login, "--json").json()
        self.assertEqual(sent["stored"], sent["objects"])
        self.assertEqual(sent["objects"], orthanc_count)
        uid = next(str(pydicom.dcmread(path, stop_before_pixels=True).StudyInstanceUID)
                   for path in sorted(folder.rglob("*")) if path.is_file() and pydicom.misc.is_dicom(path))
        fetched = self.run_program("fetch", "--from", peer, *login, "--study", uid, "-o", "fetched", "--json").json()
        self.assertEqual(fetched["stored"], orthanc_count)
        study = self.folder / "fetched" / uid
        return study

    def ways(self, orthanc):
        return ((orthanc.peer, ()), (orthanc.url, orthanc.web_login))

    def test_contours_and_images_of_a_thigh(self):
        folder = harness.data("thigh_mr", "STS_001")
        count = sum(path.is_file() and pydicom.misc.is_dicom(path) for path in folder.rglob("*"))
        orthanc = Orthanc(self)
        self.run_program("contours", folder, "--structure", "GTV_Mass", "-o", "before.json", "--quiet")
        for peer, login in self.ways(orthanc):
            study = self.through(folder, peer, login, count)
            self.run_program("contours", study, "--structure", "GTV_Mass", "-o", "after.json", "--quiet")
            self.assertEqual((self.folder / "before.json").read_bytes(), (self.folder / "after.json").read_bytes())
            shutil.rmtree(self.folder / "fetched")

    def test_compressed_images(self):
        source = harness.data("body_ct_mr_labels", "example_ct_dicom")
        folder = self.folder / "ct"
        folder.mkdir()
        # As they were before they lost their identity: without it nothing can be sent.
        self.assert_refused(["send", source, "--to", "A@127.0.0.1:1"], 3, "E-NET-006")
        for count, path in enumerate(sorted(source.iterdir()), 1):
            each = pydicom.dcmread(path)
            each.SOPClassUID, each.SOPInstanceUID = each.file_meta.MediaStorageSOPClassUID, each.file_meta.MediaStorageSOPInstanceUID
            each.StudyInstanceUID, each.SeriesInstanceUID = peers.STUDY, peers.SERIES
            each.save_as(folder / f"{count}.dcm")
        orthanc = Orthanc(self)
        self.run_program("segment", folder, "--threshold", "200", "-o", "before.nrrd", "--quiet")
        for peer, login in self.ways(orthanc):
            study = self.through(folder, peer, login, count)
            self.run_program("segment", study, "--threshold", "200", "-o", "after.nrrd", "--quiet")
            self.assertEqual((self.folder / "before.nrrd").read_bytes(), (self.folder / "after.nrrd").read_bytes())
            shutil.rmtree(self.folder / "fetched")


class Sending(harness.TestCase):
    def test_to_our_own_receiver_byte_for_byte(self):
        study, contours = write_study(self.folder / "study")
        receiver = Receiver(self)
        answer = self.run_program("send", study, contours, "--to", receiver.peer, "--json").json()
        self.assertEqual(answer["stored"], 21)
        for path in receiver.files():
            self.assertEqual(pydicom.dcmread(path).SOPInstanceUID + ".dcm", path.name)
        # A sender learns which objects were refused, and why.
        other = pydicom.dcmread(receiver.files()[0])
        other.PatientID = "SOMEBODY ELSE"
        other.save_as(self.folder / "other.dcm")
        done = self.run_program("send", "other.dcm", "--to", receiver.peer, "--json", expect=6)
        self.assertIn("E-NET-014", done.err)
        self.assertEqual(done.json()["failed"][0]["status"], "0xC111")
        receiver.stop()

    def test_a_large_contour_survives(self):
        """A list of points beyond 64 KiB, which explicit VR cannot hold in the length of a decimal string."""
        study, contours = write_study(self.folder / "study")
        made = pydicom.dcmread(contours)
        contour = made.ROIContourSequence[0].ContourSequence[4]
        points = list(contour.ContourData)
        many = []
        for k in range(0, len(points), 3):
            a, b = points[k:k + 3], (points[k + 3:] + points)[:3]
            for step in range(200):
                many += [f"{float(p) + (float(q) - float(p)) * step / 200:.6f}" for p, q in zip(a, b)]
        contour.ContourData, contour.NumberOfContourPoints = many, len(many) // 3
        made.save_as(self.folder / "large.dcm")
        self.assertGreater(sum(map(len, many)), 70000)
        receiver = Receiver(self)
        self.run_program("send", "large.dcm", "--to", receiver.peer)
        run_tool("storescu", "-aec", "ANATOMESH", "127.0.0.1", receiver.port, *sorted(study.iterdir()))
        got = pydicom.dcmread(next(path for path in receiver.files() if pydicom.dcmread(path).Modality == "RTSTRUCT"))
        self.assertEqual(len(got.ROIContourSequence[0].ContourSequence[4].ContourData), len(many))
        receiver.stop()

    def test_a_peer_that_takes_implicit_alone(self):
        study, _ = write_study(self.folder / "study")
        port = peers.free_port()
        (self.folder / "got").mkdir()
        peer = subprocess.Popen([needed("storescp"), "+xi", "-od", str(self.folder / "got"), str(port)], stdin=subprocess.DEVNULL,
                                stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.addCleanup(peer.wait)
        self.addCleanup(peer.kill)
        deadline = time.monotonic() + 20
        while time.monotonic() < deadline:
            try:
                socket.create_connection(("127.0.0.1", port)).close()
                break
            except OSError:
                time.sleep(0.1)
        answer = self.run_program("send", study, "--to", f"ANY@127.0.0.1:{port}", "--json").json()
        self.assertEqual(answer["stored"], 20)
        by_uid = {pydicom.dcmread(path).SOPInstanceUID: path for path in study.iterdir()}
        for path in (self.folder / "got").iterdir():
            got = pydicom.dcmread(path)
            self.assertEqual(got.file_meta.TransferSyntaxUID, peers.IMPLICIT)
            self.assertEqual((got.pixel_array == pydicom.dcmread(by_uid[got.SOPInstanceUID]).pixel_array).all(), True)


class WebService:
    """A DICOMweb service that answers as it is told: status, type and content for every path."""

    def __init__(self, answer, tls=None):
        class Handler(http.server.BaseHTTPRequestHandler):
            def do_GET(self):
                status, kind, content = answer(self.path)
                self.send_response(status)
                self.send_header("Content-Type", kind)
                self.send_header("Content-Length", str(len(content)))
                if status == 302:
                    self.send_header("Location", "http://192.0.2.1/")
                self.end_headers()
                self.wfile.write(content)

            def do_POST(self):
                self.rfile.read(int(self.headers["Content-Length"]))
                self.do_GET()

            def log_message(self, *_):
                pass

        self.server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        if tls:
            self.server.socket = tls.wrap_socket(self.server.socket, server_side=True)
        self.url = f"{'https' if tls else 'http'}://127.0.0.1:{self.server.server_address[1]}/web"

    def __enter__(self):
        threading.Thread(target=self.server.serve_forever, daemon=True).start()
        return self.url

    def __exit__(self, *_):
        self.server.shutdown()
        self.server.server_close()


class HostileServices(harness.TestCase):
    def test_answers_to_a_query(self):
        for status, content, code in ((500, b"", "E-NET-017"), (302, b"", "E-NET-017"), (200, b"<html>", "E-NET-018"),
                                      (200, b"[" * 100000, "E-NET-018"), (200, b"{}", "E-NET-019"), (200, b"[7]", None),
                                      (200, b"", None), (204, b"", None), (200, b'[{"0020000D":{"Value":[{"a":1}]}}]', None)):
            with WebService(lambda path: (status, "application/dicom+json", content)) as url:
                done = self.run_program("query", "--from", url, expect=6 if code else 0)
                self.assertIn(code or "", done.err)

    def test_answers_to_a_retrieval(self):
        good = b"--b\r\nContent-Type: application/dicom\r\n\r\n" + b"x" * 1000 + b"\r\n--b--"
        multipart = "multipart/related; type=\"application/dicom\"; boundary=b"
        for kind, content, code in ((multipart, good, "E-NET-015"), (multipart, good[:500], "E-NET-018"),
                                    ("application/dicom", good, "E-NET-018"), ("multipart/related", good, "E-NET-018"),
                                    (multipart, b"", "E-NET-018"), (multipart, b"--b\r\n" + b"h" * 100000, "E-NET-018")):
            with WebService(lambda path: (200, kind, content)) as url:
                self.assert_refused(["fetch", "--from", url, "--study", "1.2", "-o", "x"], 6, code)
        with WebService(lambda path: (404, "text/plain", b"")) as url:
            self.assert_refused(["fetch", "--from", url, "--study", "1.2", "-o", "x"], 3, "E-NET-023")

    def test_answers_to_what_is_sent(self):
        study, _ = write_study(self.folder / "study")
        stored = '{"00081199":{"vr":"SQ","Value":[%s]}}' % ",".join(
            '{"00081155":{"vr":"UI","Value":["%s"]}}' % pydicom.dcmread(path).SOPInstanceUID for path in sorted(study.iterdir())[:19])
        for status, content, code in ((200, b"", "E-NET-014"), (200, stored.encode(), "E-NET-014"), (200, b"nonsense", "E-NET-018"),
                                      (413, b"", "E-NET-017")):
            with WebService(lambda path: (status, "application/dicom+json", content)) as url:
                done = self.run_program("send", study, "--to", url, "--json", expect=6)
                self.assertIn(code, done.err)
                if content == stored.encode():
                    self.assertEqual((done.json()["stored"], len(done.json()["failed"])), (19, 1))


class OverTls(harness.TestCase):
    """A19: certificates that hold, and those that do not."""

    def setUp(self):
        super().setUp()
        needed("openssl")
        for name in ("authority", "stranger"):
            self.openssl("req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-days", "2", "-subj",
                         f"/CN={name}", "-keyout", f"{name}.key", "-out", f"{name}.pem")
        for name, days in (("here", 2), ("there", 2), ("old", -1)):
            self.openssl("req", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-subj", f"/CN={name}", "-addext",
                         "subjectAltName=IP:127.0.0.1", "-keyout", f"{name}.key", "-out", f"{name}.csr")
            self.openssl("x509", "-req", "-in", f"{name}.csr", "-CA", "authority.pem", "-CAkey", "authority.key", "-CAcreateserial",
                         "-copy_extensions", "copyall", "-days", str(days), "-out", f"{name}.pem")
        self.study, _ = write_study(self.folder / "study")

    def openssl(self, *words):
        done = subprocess.run([needed("openssl"), *words], cwd=self.folder, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)

    def tls(self, name, authorities="authority"):
        return ("--tls-certificate", self.folder / f"{name}.pem", "--tls-key", self.folder / f"{name}.key", "--tls-authorities",
                self.folder / f"{authorities}.pem")

    def test_A19_send_and_receive(self):
        receiver = Receiver(self, *self.tls("here"), "--timeout", "3")
        answer = self.run_program("send", self.study, "--to", receiver.peer, "--tls", *self.tls("there"), "--json").json()
        self.assertEqual(answer["stored"], 20)
        self.assertEqual(len(receiver.files()), 20)
        # No certificate, an expired one, one of a stranger, an authority the receiver does not come from, no TLS at all.
        for options in (("--tls", "--tls-authorities", self.folder / "authority.pem"), ("--tls", *self.tls("old")),
                        ("--tls", *self.tls("stranger")), ("--tls", *self.tls("there", "stranger")), ()):
            done = self.run_program("send", self.study, "--to", receiver.peer, *options, "--timeout", "5", expect=6)
            self.assertIn("E-NET-013", done.err)
        # TLS 1.1, and an object that nobody waits for.
        subprocess.run([needed("openssl"), "s_client", "-connect", f"127.0.0.1:{receiver.port}", "-tls1_1", "-cipher",
                        "ALL:@SECLEVEL=0"], stdin=subprocess.DEVNULL, capture_output=True, timeout=20)
        self.assertEqual(receiver.stop()["associations"], 1)
        self.assertTrue(any("no TLS" in line for line in receiver.lines), receiver.lines)

    def test_A19_dicomweb(self):
        settings = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        settings.load_cert_chain(self.folder / "here.pem", self.folder / "here.key")
        with WebService(lambda path: (200, "application/dicom+json", b"[]"), settings) as url:
            options = ("--tls-authorities", self.folder / "authority.pem")
            self.assertEqual(self.run_program("query", "--from", url, *options, "--json").json()["answers"], [])
            for wrong in (("--tls-authorities", self.folder / "stranger.pem"), ()):
                self.assertIn("E-NET-016", self.run_program("query", "--from", url, *wrong, expect=6).err)

    def test_files_that_are_no_certificates(self):
        self.write("junk.pem", "junk")
        done = self.run_program("receive", "x", "--port", "0", "--tls-certificate", "junk.pem", "--tls-key", "here.key", expect=6)
        self.assertIn("E-NET-004", done.err)
        done = self.run_program("receive", "x", "--port", "0", "--tls-certificate", "here.pem", "--tls-key", "there.key", expect=6)
        self.assertIn("E-NET-004", done.err)
        self.assertIn("E-CMD-008", self.run_program("receive", "x", "--tls-certificate", "here.pem", expect=2).err)


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
        self.wait_for(receiver, "incomplete")
        self.assertFalse(models.exists())
        # The late ones complete it.
        self.run_program("send", *slices[15:], "--to", receiver.peer)
        self.wait_for(receiver, "model 1 made")
        names = sorted(path.name for path in (models / "1").iterdir())
        self.assertEqual(names, ["instances.sha256", "model.html", "model.report.json", "model.stl", "model.vtu", "surface.dcm"])
        self.run_program("check", models / "1/model.vtu")
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
