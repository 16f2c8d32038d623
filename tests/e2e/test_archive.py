"""The whole way round with a PACS, by DIMSE and by DICOMweb; web services that answer badly."""
import concurrent.futures
import shutil
import socket
import struct
import time

import pydicom
import pydicom.misc

import harness
import network_peers as peers
from network_peers import Orthanc, Receiver, WebService, content_of, receive_pdu, run_tool, write_study


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

    def test_a_model_as_text_is_kept_as_it_is(self):
        orthanc = Orthanc(self)
        study, contours = write_study(self.folder / "study")
        self.run_program("model", contours, "-o", "model.vtu", "--size", "6", "--keep-patient-ids", "--dicom-obj", "obj.dcm", "--quiet")
        wanted = content_of(self.folder / "obj.dcm")
        series = pydicom.dcmread(self.folder / "obj.dcm").SeriesInstanceUID
        self.run_program("send", "obj.dcm", "--to", orthanc.peer)
        for number, (peer, login) in enumerate(((orthanc.peer, ()), (orthanc.url, orthanc.web_login))):
            self.run_program("fetch", "--from", peer, *login, "--study", peers.STUDY, "--series", series, "-o", f"back{number}")
            self.assertEqual(content_of(next((self.folder / f"back{number}").glob("*/*/*.dcm"))), wanted)

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


class HostileServices(harness.TestCase):
    def test_answers_to_a_query(self):
        study = b'[{"0020000D":{"vr":"UI","Value":["%s"]}}]'
        for status, content, code in ((500, b"", "E-NET-017"), (302, b"", "E-NET-017"), (404, b"", "E-NET-017"),
                                      (200, b"[" * 100000, "E-NET-018"), (204, b"", None), (200, b"[]", None), (200, study % b"1.2", None)):
            with WebService(lambda path: (status, "application/dicom+json", content)) as url:
                done = self.run_program("query", "--from", url, expect=6 if code else 0)
                self.assertIn(code or "", done.err)
        with WebService(lambda path: (200, "application/dicom+json", study.replace(b"D", b"E") % b"1.2.3")) as url:
            self.run_program("query", "--from", url, "--level", "series", "--study", "1.2")

    def test_what_is_no_answer_is_no_empty_answer(self):
        """Whatever a service says with success that is no DICOM JSON or no multipart message is told, never 'nothing found'."""
        page = b"<!DOCTYPE html><title>Login of Doe^Jane</title>"
        other_study = b'[{"0020000D":{"Value":["1.3"]},"0020000E":{"Value":["1.3.4"]}}]'
        for kind, content in (("text/html", page), ("application/dicom+json", page), ("application/dicom+json", b""), ("", b" \n"),
                              ("application/dicom+json", b"null"), ("application/dicom+json", b"{}"), ("application/dicom+json", b'"[]"'),
                              ("application/json", b'{"error":"token expired"}'), ("application/dicom+json", b"[7]"),
                              ("application/dicom+json", b"[{}]"), ("application/dicom+json", b"[null]"),
                              ("application/dicom+json", b'[{"0020000D":{"Value":[{"a":1}]}}]'),
                              ("application/dicom+json", b'[{"0020000D":{"Value":["../x"]}}]'), ("application/dicom+json", b"[]]"),
                              ("application/dicom+json", b"[" + b"\xff"), ("application/dicom", peers.dicom_file(b"1.2.7", b"1.2")),
                              ("multipart/related", b"--b--"), ("application/dicom+json", other_study)):
            with WebService(lambda path: (200, kind, content)) as url:
                for words in (["query", "--level", "series" if content == other_study else "study", "--study", "1.2"],
                              ["fetch", "--study", "1.2", "-o", "x"]):
                    done = self.assert_refused([*words, "--from", url], 6, "E-NET-018")
                    self.assertNotIn("Jane", done.err)
                    self.assertNotIn("0 answers", done.out)
                    if content == page:
                        self.assertIn(f"{kind}, which looks like a web page", done.err)

    def test_what_is_no_answer_of_a_dicom_archive(self):
        for content, text in ((b"", "StudyInstanceUID"), (b"nonsense", "malformed"), (ANSWER[:-4] + b"../x", "StudyInstanceUID"),
                              (ANSWER, "another study")):
            with peers.RawService(pending(0x8020, 5, content, data_set=0 if content else 0x101)) as service:
                self.assert_refused(["query", "--from", f"A@127.0.0.1:{service.port}", "--study", "1.3", "--timeout", "0.5"], 6, "E-NET-019", text)

    def test_a_reply_without_a_status_is_no_success(self):
        (self.folder / "object.dcm").write_bytes(peers.dicom_file(b"1.2.7", b"1.2"))
        for field, words in ((0x8001, ["send", "object.dcm", "--to"]), (0x8020, ["query", "--from"])):
            whole = peers.reply(field, 0)
            cut = struct.pack("<HHII", 0, 0, 4, len(whole) - 22) + whole[12:-10]
            for answer, code in ((whole, 0), (cut, 6)):
                def serve(connection, contexts):
                    connection.sendall(peers.data(next(iter(contexts.values())), True, True, answer))
                    receive_pdu(connection)
                    connection.sendall(peers.pdu(6, bytes(4)))
                with peers.RawService(associated(serve)) as service:
                    self.run_program(*words, f"A@127.0.0.1:{service.port}", "--timeout", "1", expect=code)

    def test_answers_to_a_retrieval(self):
        good = b"--b\r\nContent-Type: application/dicom\r\n\r\n" + b"x" * 1000 + b"\r\n--b--"
        for kind, content, code in ((peers.MULTIPART, good, "E-NET-015"), (peers.MULTIPART, good[:500], "E-NET-018"),
                                    ("application/dicom", good, "E-NET-018"), ("multipart/related", good, "E-NET-018"),
                                    (peers.MULTIPART, b"", "E-NET-018"),
                                    (peers.MULTIPART, b"--b\r\n" + b"h" * 100000, "E-NET-018")):
            with WebService(lambda path: (200, kind, content)) as url:
                self.assert_refused(["fetch", "--from", url, "--study", "1.2", "-o", "x"], 6, code)
        with WebService(lambda path: (404, "text/plain", b"")) as url:
            self.assert_refused(["fetch", "--from", url, "--study", "1.2", "-o", "x"], 3, "E-NET-023")

    def test_A15_what_cannot_be_read_is_never_replaced(self):
        content = [peers.dicom_file(name, b"1.2", payload=b"one") for name in (b"1.2.7", b"1.2.8")]
        with WebService(lambda path: (200, peers.MULTIPART, peers.multipart(*content))) as url:
            fetch = ["fetch", "--from", url, "--study", "1.2", "-o", "in", "--json"]
            self.run_program(*fetch)
            self.assertEqual(self.run_program(*fetch).json()["there_already"], 2)
            there = self.folder / "in/1.2/1.2.3.4/1.2.7.dcm"
            there.rename(self.folder / "elsewhere.dcm")
            there.symlink_to(self.folder / "elsewhere.dcm")
            content[0] = peers.dicom_file(b"1.2.7", b"1.2", payload=b"other")
            done = self.run_program(*fetch, expect=6)
        for text in ("E-NET-015", "in/1.2/1.2.3.4/1.2.7.dcm", "it is a link"):
            self.assertIn(text, done.err)
        self.assertEqual((done.json()["refused"], done.json()["there_already"]), (1, 1))
        self.assertEqual(done.json()["not_stored"][0]["object"], "1.2/1.2.3.4/1.2.7.dcm")
        self.assertTrue(there.is_symlink())
        self.assertIn(b"one", (self.folder / "elsewhere.dcm").read_bytes())

    def test_what_was_not_asked_for_is_not_stored(self):
        asked = {"--study": b"1.2", "--series": b"1.2.3", "--instance": b"1.2.3.4"}
        right = peers.dicom_file(b"1.2.3.4", b"1.2", b"1.2.3")
        for given in range(1, 4):
            options = [str(word, "ascii") if isinstance(word, bytes) else word
                       for each in list(asked.items())[:given] for word in each]
            for wrong in range(given):
                uids = [uid if k != wrong else b"1.99.%d" % k for k, uid in enumerate(asked.values())]
                stranger = peers.dicom_file(uids[2], uids[0], uids[1])
                for files in ((stranger,), (right, stranger), (stranger, right)):
                    folder = f"in{given}{wrong}{len(files)}{files[0] is right}"
                    with WebService(lambda path: (200, peers.MULTIPART, peers.multipart(*files))) as url:
                        done = self.run_program("fetch", "--from", url, *options, "-o", folder, "--json", expect=6)
                    self.assertIn("E-NET-024", done.err)
                    answer = done.json()
                    self.assertEqual((answer["not_asked_for"], answer["stored"]), (1, len(files) - 1))
                    self.assertEqual([str(path.relative_to(self.folder / folder)) for path in (self.folder / folder).rglob("*.dcm")],
                                     ["1.2/1.2.3/1.2.3.4.dcm"][:len(files) - 1])

    def test_a_dicom_archive_that_sends_strangers_or_less_than_it_says(self):
        statuses = []

        def sends(study, counts):
            def serve(connection, context, ct_context):
                if study:
                    connection.sendall(peers.data(ct_context, True, True, peers.store_command(b"1.5"))
                                       + peers.data(ct_context, False, True, peers.data_set(b"1.5", study)))
                    statuses.append(peers.status_of(receive_pdu(connection)[1]))
                connection.sendall(peers.data(context, True, True, peers.reply(0x8010, 0, counts=counts)))
                receive_pdu(connection)
                connection.sendall(peers.pdu(6, bytes(4)))

            def answer(connection):
                contexts = peers.accept_association(connection)
                context = next(iter(contexts.values()))
                _, body = receive_pdu(connection)
                receive_pdu(connection)
                if peers.field_of(body) == 0x20:  # a C-FIND: what classes there are
                    connection.sendall(peers.data(context, True, True, peers.reply(0x8020, 0)))
                    receive_pdu(connection)
                    connection.sendall(peers.pdu(6, bytes(4)))
                else:
                    serve(connection, context, contexts[peers.CT])
            return answer
        for study, counts, code, numbers, status in ((b"1.2", (0, 1, 0, 0), None, (1, 0), 0), (b"1.99", (0, 0, 1, 0), "E-NET-024", (0, 1), 0x124),
                                                     (b"1.2", (0, 6, 0, 0), "E-NET-015", (1, 0), 0), (b"", (0, 5, 0, 0), "E-NET-015", (0, 0), None)):
            with peers.RawService(sends(study, counts)) as service:
                done = self.run_program("fetch", "--from", f"A@127.0.0.1:{service.port}", "--study", "1.2", "-o", f"in{counts}{study}",
                                        "--json", expect=6 if code else 0)
            self.assertIn(code or "", done.err)
            self.assertEqual((done.json()["stored"], done.json()["not_asked_for"]), numbers)
            if status is not None:
                self.assertEqual(statuses.pop(), status)
            if code == "E-NET-015":
                self.assertIn("5 objects", done.err)

    def test_A13_the_quota_of_a_fetch(self):
        files = [peers.dicom_file(b"1.2.%d" % k, b"1.2", payload=bytes(60000)) for k in range(3)]
        with WebService(lambda path: (200, peers.MULTIPART, peers.multipart(*files))) as url:
            fetch = ["fetch", "--from", url, "--study", "1.2", "-o", "in", "--json"]
            done = self.run_program(*fetch, "--quota", "0.13", expect=6)
            self.assertIn("quota", done.err)
            self.assertEqual((done.json()["stored"], done.json()["refused"]), (2, 1))
            self.assertLess(sum(path.stat().st_size for path in (self.folder / "in").rglob("*.dcm")), 130000)
            self.assertEqual(self.run_program(*fetch, "--quota", "0.2").json()["stored"], 1)
        self.assert_refused(["fetch", "--from", "A@h", "--study", "1.2", "--move-to", "B", "--quota", "1"], 2, "E-CMD-008")

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


# What hostile services do for ever, once a request has come: every way to answer without an end.

def every(seconds, piece):
    def serve(connection):
        while True:
            connection.sendall(piece)
            time.sleep(seconds)
    return serve


def after(head, serve, is_post=False):
    def answer(connection):
        got = b""
        while b"\r\n\r\n" not in got:
            got += connection.recv(65536)
        if is_post:
            connection.settimeout(0.3)
            try:
                while connection.recv(65536):
                    pass
            except socket.timeout:
                connection.settimeout(20)
        connection.sendall(head)
        serve(connection)
    return answer


def associated(serve):
    def answer(connection):
        contexts = peers.accept_association(connection)
        while not receive_pdu(connection)[1][5] & 1:  # the command; its data set follows
            pass
        serve(connection, contexts)
    return answer


def pending(field, seconds, content=b"", **more):
    """The same answer again and again."""
    def serve(connection, contexts):
        context = next(iter(contexts.values()))
        answer = peers.data(context, True, True, peers.reply(field, 0xFF00, **more))
        if content:
            answer += peers.data(context, False, True, content)
        every(seconds, answer)(connection)
    return associated(serve)


def handshake(connection):
    """A record of TLS of 16 KiB, byte by byte."""
    connection.recv(65536)
    connection.sendall(b"\x16\x03\x03\x3f\xff\x02\x00\x3f\xf0\x03\x03")
    every(0.2, b"\0")(connection)


OK = b"HTTP/1.1 200 OK\r\n"
PARTS = OK + b"Content-Type: " + peers.MULTIPART.encode() + b"\r\nTransfer-Encoding: chunked\r\n\r\n"
JSON = OK + b"Content-Type: application/dicom+json\r\nTransfer-Encoding: chunked\r\n\r\n"
ANSWER = peers.element(8, 0x52, "CS", b"STUDY")[:4] + struct.pack("<I", 6) + b"STUDY " + struct.pack("<HHI", 0x20, 0xD, 4) + b"1.2\0"


def chunk(content):
    return b"%x\r\n" % len(content) + content + b"\r\n"


class EndlessServices(harness.TestCase):
    """No service holds the program for ever or fills its memory, and the program always hears that it shall stop."""

    def commands(self, kind, port):
        web, dicom = f"http://127.0.0.1:{port}/d", f"A@127.0.0.1:{port}"
        return {"query": ["query", "--from", web], "https": ["query", "--from", web.replace("http", "https")],
                "dicom over tls": ["query", "--from", dicom, "--tls"], "fetch": ["fetch", "--from", web, "--study", "1.2", "-o", "in"],
                "send": ["send", "object.dcm", "--to", web], "find": ["query", "--from", dicom],
                "get": ["fetch", "--from", dicom, "--study", "1.2", "-o", "in"],
                "move": ["fetch", "--from", dicom, "--study", "1.2", "--move-to", "B"]}[kind]

    def run_all(self, cases, judge):
        """Every case at the same time as others: they wait most of the time."""
        def run(number, kind, serve, limits, *more):
            folder = self.folder / str(number)
            folder.mkdir()
            (folder / "object.dcm").write_bytes(peers.dicom_file(b"1.2.7", b"1.2"))
            with peers.RawService(serve) as service:
                words = self.commands(kind, service.port) + ["--timeout", "3", "--quiet"]
                for limit in limits:
                    words += ["--limit", limit]
                return peers.Measured(*words, folder=folder, **judge.get("run", {})), more
        with concurrent.futures.ThreadPoolExecutor(12) as pool:
            futures = [pool.submit(run, number, *case) for number, case in enumerate(cases)]
        for case, future in zip(cases, futures):
            with self.subTest(case=(case[0], case[2:])):
                judge["check"](*future.result())

    # One sends a little every while: its silence is never too long.
    SLOW = [("query", after(OK, every(0.2, b"X-A: b\r\n"))), ("query", after(b"", every(0.2, b"HTTP/1.1 100 Continue\r\n\r\n"))),
            ("query", after(b"", every(0.2, b"H"))), ("query", after(JSON, every(0.2, chunk(b" ")))),
            ("query", after(JSON, every(0.2, b"0"))), ("fetch", after(PARTS, every(0.2, chunk(b"-")))),
            ("send", after(JSON, every(0.2, chunk(b" ")), is_post=True)), ("find", every(0.2, b"\2\0\0\0\1\0")),
            ("https", handshake), ("dicom over tls", handshake),
            ("find", pending(0x8020, 0.2, ANSWER, data_set=0)), ("move", pending(0x8021, 0.2)), ("get", pending(0x8010, 0.2))]

    def test_the_time_of_a_request(self):
        def check(run, _):
            self.assertEqual(run.code, 5, run.err)
            self.assertIn("E-NET-025", run.err)
            self.assertIn("within 1 s", run.err)
            self.assertLess(run.seconds, 4)
        self.run_all([(*case, ["request-seconds=1"]) for case in self.SLOW], {"check": check})

    def test_a_signal_is_heard_at_once(self):
        def check(run, _):
            self.assertEqual(run.code, 130, run.err)
            self.assertLess(run.seconds, 1.5)
        self.run_all([(*case, []) for case in self.SLOW], {"check": check, "run": {"ended_after": 0.7}})

    def test_bytes_answers_and_memory(self):
        part = b"--b\r\n\r\n\r\n"

        def store(connection, contexts):
            context = contexts.get(peers.CT, 1)  # the query for the classes has no storage
            connection.sendall(peers.data(context, True, True, peers.store_command(b"1.2")))
            every(0, peers.data(context, False, False, bytes(16000)))(connection)
        cases = [("query", after(OK, every(0, b"X-A: " + b"b" * 1000 + b"\r\n")), [], 6, "E-NET-018"),
                 ("fetch", after(OK + b"X-A: ", every(0, b"b" * 10000)), [], 6, ""),
                 ("query", after(JSON, every(0, b"0" * 10000)), [], 6, ""),
                 ("query", after(JSON, every(0, chunk(b" " * 100000))), [], 6, "64 MiB"),
                 ("send", after(JSON, every(0, chunk(b" " * 100000)), is_post=True), [], 6, "64 MiB"),
                 ("fetch", after(PARTS, every(0, chunk(b" " * 100000))), ["request-bytes=30000000"], 5, "E-NET-026"),
                 ("fetch", after(PARTS, every(0, chunk(part * 100))), ["request-answers=1000"], 5, "E-NET-027"),
                 ("find", pending(0x8020, 0, ANSWER, data_set=0), ["request-answers=3000"], 5, "E-NET-027"),
                 ("find", pending(0x8020, 0, ANSWER, data_set=0), ["request-bytes=300000"], 5, "E-NET-026"),
                 ("move", pending(0x8021, 0), ["request-answers=1000"], 5, "E-NET-027"),
                 ("get", pending(0x8010, 0), ["request-answers=1000"], 5, "E-NET-027"),
                 ("get", associated(store), ["request-bytes=3000000"], 5, "E-NET-026")]

        def check(run, wanted):
            code, text = wanted
            self.assertEqual(run.code, code, run.err)
            self.assertIn(text, run.err)
            self.assertLess(run.peak_mb, 250)
        self.run_all(cases, {"check": check})

    def test_an_association_that_is_not_released(self):
        def serve(connection, contexts):
            every(0.1, peers.data(next(iter(contexts.values())), True, True, peers.reply(0x8020, 0)))(connection)
        self.run_all([("find", associated(serve), [])], {"check": lambda run, _: (self.assertEqual(run.code, 0, run.err),
                                                                       self.assertLess(run.seconds, 6))})


if __name__ == "__main__":
    harness.main("__main__")
