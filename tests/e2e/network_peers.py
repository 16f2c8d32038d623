"""Peers for the tests of the network: our receiver as a process, raw DICOM units over sockets, Orthanc, studies.

Everything runs on loopback, at ports of its own and in folders of its own.
"""
import http.server
import json
import os
import pathlib
import shutil
import signal
import socket
import struct
import subprocess
import threading
import time
import unittest
import urllib.request

import pydicom

import harness
import test_dicom

CT = "1.2.840.10008.5.1.4.1.1.2"
VERIFICATION = "1.2.840.10008.1.1"
IMPLICIT, EXPLICIT = "1.2.840.10008.1.2", "1.2.840.10008.1.2.1"
STUDY, SERIES = "1.2.826.0.1.3680043.8.498.7", "1.2.826.0.1.3680043.8.498.1"


def needed(tool):
    """The path of a tool; skips the test when it is not installed."""
    path = shutil.which(tool, path=os.environ.get("PATH", "") + ":/usr/sbin:/usr/local/sbin")
    if not path:
        raise unittest.SkipTest(f"no {tool} (make dependencies)")
    return path


def run_tool(name, *words, expect=0, timeout=120):
    done = subprocess.run([needed(name), *map(str, words)], capture_output=True, text=True, timeout=timeout)
    if expect is not None:
        assert done.returncode == expect, (name, words, done.returncode, done.stdout[-2000:], done.stderr[-2000:])
    return done


def content_of(path):
    """What an object says, without its meta header."""
    return pydicom.dcmread(path).to_json()


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def write_study(folder, **changes):
    """20 slices of a ball, and contours of it that refer to them."""
    folder.mkdir(parents=True)
    test_dicom.write_series(folder, names=[f"ct{k:02}.dcm" for k in range(20)], **changes)
    made = harness.run_program("contours", folder, "--threshold", "0", "--every", "2", "--keep-patient-ids", "-o",
                               folder.parent / "rs.dcm")
    assert made.code == 0, made.err
    return folder, folder.parent / "rs.dcm"


# Root reads whatever file there is, unless it gives that right away.
WITHOUT_ROOT_RIGHTS = ("setpriv", "--bounding-set", "-dac_override,-dac_read_search") if os.geteuid() == 0 else ()


class Receiver:
    """`anatomesh receive` as a process."""

    def __init__(self, test, *options, folder="incoming", title="ANATOMESH", port=0, launcher=()):
        self.folder = test.folder / folder
        self.title = title
        self.lines = []
        self.process = subprocess.Popen([*launcher, harness.PROGRAM, "receive", str(self.folder), "--port", str(port), "--title", title,
                                         "--json", *map(str, options)], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                        stderr=subprocess.PIPE, text=True)
        test.addCleanup(self.kill)
        self.ready = threading.Event()
        self.port = None
        self.reader = threading.Thread(target=self._read, daemon=True)
        self.reader.start()
        if not self.ready.wait(30) or self.port is None:
            raise AssertionError(f"it does not listen: {self.lines}")

    def _read(self):
        for line in self.process.stderr:
            self.lines.append(line.rstrip())
            if "listening at" in line:
                self.port = int(line.split(" port ")[1].split()[0])
                self.ready.set()
        self.ready.set()

    @property
    def peer(self):
        return f"{self.title}@127.0.0.1:{self.port}"

    def connect(self):
        made = socket.create_connection(("127.0.0.1", self.port))
        made.settimeout(20)
        return made

    def status(self, name):
        """A number in /proc/PID/status, kB."""
        for line in pathlib.Path(f"/proc/{self.process.pid}/status").read_text().splitlines():
            if line.startswith(name + ":"):
                return int(line.split()[1])
        raise KeyError(name)

    def descriptors(self):
        return len(os.listdir(f"/proc/{self.process.pid}/fd"))

    def children(self):
        """The processes that it has started and that run."""
        found = []
        for path in pathlib.Path("/proc").glob("[0-9]*/stat"):
            try:
                words = path.read_text().rsplit(")", 1)[1].split()
            except OSError:
                continue
            if int(words[1]) == self.process.pid and words[0] != "Z":
                found.append(int(path.parent.name))
        return found

    def files(self, pattern="*/*/*.dcm"):
        return sorted(self.folder.glob(pattern))

    def leftovers(self):
        return [path.name for path in self.folder.rglob(".anatomesh*")]

    def stop(self):
        """Ends it as a service manager does; its answer."""
        self.process.send_signal(signal.SIGTERM)
        out = self.process.stdout.read()
        code = self.process.wait(30)
        self.reader.join(10)
        assert code == 0, (code, self.lines)
        return json.loads(out)

    def kill(self):
        if self.process.poll() is None:
            self.process.kill()
            self.process.wait()
        self.process.stdout.close()
        self.process.stderr.close()


# Raw units of the DICOM upper layer.

def item(kind, content):
    return struct.pack(">BxH", kind, len(content)) + content


def associate_request(called="ANATOMESH", calling="TESTER", contexts=None, longest=16384, host=None):
    contexts = contexts or {1: (VERIFICATION, [IMPLICIT]), 3: (CT, [EXPLICIT])}
    body = struct.pack(">HH", 1, 0) + called.encode("latin-1").ljust(16)[:16] + calling.encode("latin-1").ljust(16)[:16] + bytes(32)
    body += item(0x10, b"1.2.840.10008.3.1.1.1")
    for number, (abstract, syntaxes) in contexts.items():
        body += item(0x20, bytes([number, 0, 0, 0]) + item(0x30, abstract.encode())
                     + b"".join(item(0x40, each.encode()) for each in syntaxes))
    body += item(0x50, item(0x51, struct.pack(">I", longest)) + item(0x52, b"1.2.3"))
    return pdu(1, body)


def pdu(kind, body):
    return struct.pack(">BxI", kind, len(body)) + body


def data(context, is_command, is_last, content):
    return pdu(4, struct.pack(">IBB", len(content) + 2, context, is_command | is_last << 1) + content)


def command(**elements):
    numbers = {"affected_class": 0x0002, "field": 0x0100, "message": 0x0110, "priority": 0x0700, "data_set": 0x0800,
               "instance": 0x1000}
    body = b""
    for name, value in sorted(elements.items(), key=lambda each: numbers[each[0]]):
        content = struct.pack("<H", value) if isinstance(value, int) else value
        content += b"\0" * (len(content) % 2)
        body += struct.pack("<HHI", 0, numbers[name], len(content)) + content
    return struct.pack("<HHII", 0, 0, 4, len(body)) + body


def store_command(instance, sop_class=CT):
    return command(affected_class=sop_class.encode(), field=1, message=1, priority=0, data_set=0, instance=instance)


def element(group, number, vr, value):
    value += (b"\0" if vr in ("UI", "OB") else b" ") * (len(value) % 2)
    if vr in ("OB", "OW", "SQ", "UN"):
        return struct.pack("<HH2sxxI", group, number, vr.encode(), len(value)) + value
    return struct.pack("<HH2sH", group, number, vr.encode(), len(value)) + value


def data_set(instance, study=b"1.2.3", series=b"1.2.3.4", payload=b"xx"):
    return (element(8, 0x16, "UI", CT.encode()) + element(8, 0x18, "UI", instance) + element(0x20, 0xD, "UI", study)
            + element(0x20, 0xE, "UI", series) + element(0x7FE0, 0x10, "OW", payload))


def dicom_file(instance, study=b"1.2.3", series=b"1.2.3.4", payload=b"xx"):
    """data_set() as a file."""
    meta = (element(2, 1, "OB", b"\0\1") + element(2, 2, "UI", CT.encode()) + element(2, 3, "UI", instance)
            + element(2, 0x10, "UI", EXPLICIT.encode()) + element(2, 0x12, "UI", b"1.2.3"))
    return bytes(128) + b"DICM" + element(2, 0, "UL", struct.pack("<I", len(meta))) + meta + data_set(instance, study, series, payload)


MULTIPART = "multipart/related; type=\"application/dicom\"; boundary=b"


def multipart(*files):
    """An answer of WADO-RS, of the type MULTIPART."""
    return b"".join(b"--b\r\nContent-Type: application/dicom\r\n\r\n" + each + b"\r\n" for each in files) + b"--b--\r\n"


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


def receive_pdu(connection):
    """Type and body; (None, b"") when the peer has closed."""
    def exactly(count):
        got = b""
        while len(got) < count:
            try:
                more = connection.recv(count - len(got))
            except ConnectionResetError:
                more = b""
            if not more:
                return None
            got += more
        return got
    head = exactly(6)
    if head is None:
        return None, b""
    kind, length = struct.unpack(">BxI", head)
    return kind, exactly(length) if length else b""


def associated(receiver, **options):
    connection = receiver.connect()
    connection.sendall(associate_request(**options))
    kind, body = receive_pdu(connection)
    assert kind == 2, (kind, body)
    return connection


def status_of(body):
    """The status in a P-DATA body that holds a whole reply."""
    at = 6 + 12
    while at + 8 <= len(body):
        _, number, length = struct.unpack("<HHI", body[at:at + 8])
        if number == 0x0900:
            return struct.unpack("<H", body[at + 8:at + 10])[0]
        at += 8 + length
    raise AssertionError("no status")


def field_of(body):
    """The Command Field in a P-DATA body."""
    at = body.index(struct.pack("<HHI", 0, 0x0100, 2))
    return struct.unpack("<H", body[at + 8:at + 10])[0]


def store(connection, instance, content, context=3):
    connection.sendall(data(context, True, True, store_command(instance)) + data(context, False, True, content))
    kind, body = receive_pdu(connection)
    assert kind == 4, kind
    return status_of(body)


def store_in_pieces(connection, instance, content, piece=60000):
    """As store(), for objects longer than a unit may be."""
    connection.sendall(data(3, True, True, store_command(instance)))
    for at in range(0, len(content), piece):
        connection.sendall(data(3, False, at + piece >= len(content), content[at:at + piece]))
    kind, body = receive_pdu(connection)
    assert kind == 4, kind
    return status_of(body)


def send_at_once(receiver, senders, objects, payload):
    """So many senders at the same time, each so many objects of a series of its own; the statuses they got."""
    statuses = []

    def send(number):
        try:
            with associated(receiver) as connection:
                for k in range(objects):
                    instance = b"%d.%d" % (number + 1, k)
                    content = data_set(instance, b"1.%d" % number, b"1.2.%d" % number, bytes(payload))
                    statuses.append(store_in_pieces(connection, instance, content))
        except (OSError, AssertionError):
            pass  # the receiver has ended
    threads = [threading.Thread(target=send, args=(number,)) for number in range(senders)]
    for thread in threads:
        thread.start()
    return threads, statuses


class Orthanc:
    """A PACS of its own: DICOM as ORTHANC, DICOMweb with user and password."""

    def __init__(self, test, destination_port=104):
        program = needed("Orthanc")
        plugin = pathlib.Path("/usr/share/orthanc/plugins/libOrthancDicomWeb.so")
        if not plugin.exists():
            raise unittest.SkipTest("no orthanc-dicomweb (make dependencies)")
        folder = test.folder / "orthanc"
        folder.mkdir()
        self.dicom, self.http = free_port(), free_port()
        settings = {"Name": "test", "StorageDirectory": str(folder / "objects"), "IndexDirectory": str(folder / "index"),
                    "HttpPort": self.http, "DicomPort": self.dicom, "DicomAet": "ORTHANC", "RemoteAccessAllowed": False,
                    "AuthenticationEnabled": True, "RegisteredUsers": {"me": "secret"}, "DicomCheckCalledAet": True,
                    "DicomAlwaysAllowGet": True, "DicomAlwaysAllowFind": True, "DicomAlwaysAllowMove": True,
                    "DicomModalities": {"here": ["MOVEHERE", "127.0.0.1", destination_port]}, "Plugins": [str(plugin)],
                    "DicomWeb": {"Enable": True, "Root": "/dicom-web/"}}
        (folder / "settings.json").write_text(json.dumps(settings))
        self.log = open(folder / "log", "w")
        self.process = subprocess.Popen([program, str(folder / "settings.json")], stdin=subprocess.DEVNULL, stdout=self.log,
                                        stderr=subprocess.STDOUT, cwd=folder)
        test.addCleanup(self.kill)
        test.write("password", "secret\n")
        self.web_login = ("--user", "me", "--password-file", test.folder / "password")
        deadline = time.monotonic() + 60
        while not self._answers():
            if self.process.poll() is not None or time.monotonic() > deadline:
                raise AssertionError("Orthanc does not start: " + (folder / "log").read_text()[-2000:])
            time.sleep(0.1)

    def _answers(self):
        request = urllib.request.Request(f"http://127.0.0.1:{self.http}/system",
                                         headers={"Authorization": "Basic bWU6c2VjcmV0"})
        try:
            with urllib.request.urlopen(request, timeout=2):
                return True
        except OSError:
            return False

    @property
    def peer(self):
        return f"ORTHANC@127.0.0.1:{self.dicom}"

    @property
    def url(self):
        return f"http://127.0.0.1:{self.http}/dicom-web"

    def kill(self):
        if self.process.poll() is None:
            self.process.terminate()
            try:
                self.process.wait(20)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()
        self.log.close()


class RawService:
    """Whatever listens at a port: `serve` gets each connection, in a thread of its own, and may fail as it likes."""

    def __init__(self, serve):
        self.serve = serve
        self.listener = socket.socket()
        self.listener.bind(("127.0.0.1", 0))
        self.listener.listen()
        self.port = self.listener.getsockname()[1]

    def _accept(self):
        while True:
            try:
                connection = self.listener.accept()[0]
            except OSError:
                return
            threading.Thread(target=self._serve, args=(connection,), daemon=True).start()

    def _serve(self, connection):
        with connection:
            connection.settimeout(20)
            try:
                self.serve(connection)
            except OSError:
                pass  # the other side has closed

    def __enter__(self):
        threading.Thread(target=self._accept, daemon=True).start()
        return self

    def __exit__(self, *_):
        self.listener.shutdown(socket.SHUT_RDWR)
        self.listener.close()


def accept_association(connection):
    """As a provider that takes whatever is asked for, in the first transfer syntax: its contexts by their classes."""
    _, body = receive_pdu(connection)
    answer, at, contexts = body[:68] + item(0x10, b"1.2.840.10008.3.1.1.1"), 68, {}
    while at < len(body):
        length = struct.unpack(">H", body[at + 2:at + 4])[0]
        if body[at] == 0x20:
            content = body[at + 4:at + 4 + length]
            end = 8 + struct.unpack(">H", content[6:8])[0]
            syntax = content[end:]
            syntax = syntax[:4 + struct.unpack(">H", syntax[2:4])[0]]
            answer += item(0x21, bytes([content[0], 0, 0, 0]) + syntax)
            contexts.setdefault(content[8:end].decode(), content[0])
        at += 4 + length
    connection.sendall(pdu(2, answer + item(0x50, item(0x51, struct.pack(">I", 16384)) + item(0x52, b"1.2.3"))))
    return contexts


def reply(field, status, **more):
    """A command that answers request 1; more["data_set"] = 0: a data set follows."""
    body = struct.pack("<HHIH", 0, 0x100, 2, field) + struct.pack("<HHIH", 0, 0x120, 2, 1)
    body += struct.pack("<HHIH", 0, 0x800, 2, more.get("data_set", 0x101)) + struct.pack("<HHIH", 0, 0x900, 2, status)
    for number, value in zip((0x1020, 0x1021, 0x1022, 0x1023), more.get("counts", ())):
        body += struct.pack("<HHIH", 0, number, 2, value)
    return struct.pack("<HHII", 0, 0, 4, len(body)) + body


class Measured:
    """A run of the program that may be ended by a signal: exit code, what it said, seconds, and its peak of memory in MB."""

    def __init__(self, *words, folder, ended_after=None):
        begun = time.monotonic()
        process = subprocess.Popen([harness.PROGRAM, *map(str, words)], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                                   stderr=subprocess.PIPE, cwd=folder)
        if ended_after is not None:
            time.sleep(ended_after)
            process.send_signal(signal.SIGTERM)
            begun = time.monotonic()
        self.err = process.stderr.read().decode("utf-8", "replace")
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        process.stderr.close()
        self.code, self.seconds, self.peak_mb = process.returncode, time.monotonic() - begun, usage.ru_maxrss / 1024


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
        threading.Thread(target=self.server.serve_forever, args=(0.02,), daemon=True).start()
        return self.url

    def __exit__(self, *_):
        self.server.shutdown()
        self.server.server_close()
