"""The other side of the DICOM network: command lines, peers that are silent or wrong, what is sent, and TLS."""
import os
import socket
import ssl
import subprocess
import threading
import time

import pydicom

import harness
import network_peers as peers
from network_peers import Receiver, WebService, closes_within, needed, pdu, receive_pdu, run_tool, write_study


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
        self.assert_refused(["receive", "x", "--model-time", "5"], 2, "E-CMD-008")

    def test_nobody_there(self):
        self.write("notes.txt", "no DICOM")
        port = peers.free_port()
        refused = self.assert_refused(["query", "--from", f"A@127.0.0.1:{port}"], 6, "E-NET-010")
        self.assertNotIn("Traceback", refused.err)
        self.assert_refused(["query", "--from", f"http://127.0.0.1:{port}/x"], 6, "E-NET-016", "no connection")
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

    def storescp(self, *options):
        """DCMTK's receiver, storing into the folder got; its port."""
        port = peers.free_port()
        (self.folder / "got").mkdir()
        peer = subprocess.Popen([needed("storescp"), *options, "-od", str(self.folder / "got"), str(port)], stdin=subprocess.DEVNULL,
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
        return port

    def test_models_bit_for_bit(self):
        """A receiver that writes the data set as it comes (+B): what lies there is what we wrote."""
        _, contours = write_study(self.folder / "study")
        self.run_program("model", contours, "-o", "m.vtu", "--size", "6", "--dicom-obj", "obj.dcm", "--dicom-surface", "stl.dcm", "--quiet")
        port = self.storescp("+B")
        for name in ("obj.dcm", "stl.dcm"):
            made = pydicom.dcmread(self.folder / name)
            self.run_program("send", name, "--to", f"ANY@127.0.0.1:{port}")
            # The data set: all behind the meta group, which is the receiver's own.
            data_sets = []
            for path in (self.folder / name, *(self.folder / "got").glob(f"*{made.SOPInstanceUID}*")):
                content = path.read_bytes()
                data_sets.append(content[128 + 4 + 12 + int.from_bytes(content[140:144], "little"):])
            self.assertEqual(len(data_sets), 2)
            self.assertEqual(data_sets[0], data_sets[1])

    def test_a_peer_that_takes_implicit_alone(self):
        study, _ = write_study(self.folder / "study")
        port = self.storescp("+xi")
        answer = self.run_program("send", study, "--to", f"ANY@127.0.0.1:{port}", "--json").json()
        self.assertEqual(answer["stored"], 20)
        by_uid = {pydicom.dcmread(path).SOPInstanceUID: path for path in study.iterdir()}
        for path in (self.folder / "got").iterdir():
            got = pydicom.dcmread(path)
            self.assertEqual(got.file_meta.TransferSyntaxUID, peers.IMPLICIT)
            self.assertEqual((got.pixel_array == pydicom.dcmread(by_uid[got.SOPInstanceUID]).pixel_array).all(), True)


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


if __name__ == "__main__":
    harness.main("__main__")
