"""Peers that answer with anything: web services whose bytes are damaged, and senders whose DICOM units are."""
import pathlib
import random
import socket
import subprocess
import sys
import tempfile
import time

import mutations
import runs

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "e2e"))
import network_peers as dicom  # noqa: E402

CRLF = b"\r\n"
STUDY, SERIES = "1.2.826.0.1.3680043.8.498.7", "1.2.826.0.1.3680043.8.498.1"


def message(kind, content, status=b"200 OK"):
    return b"HTTP/1.1 " + status + CRLF + b"Content-Type: " + kind + CRLF + b"Content-Length: " + str(len(content)).encode() + CRLF * 2 + content


def sound_answers(study):
    """(words of the command, a right answer of the service) for a query and a retrieval."""
    listed = b'[{"0020000D":{"vr":"UI","Value":["%s"]},"00100010":{"vr":"PN","Value":[{"Alphabetic":"A^B"}]}}]' % STUDY.encode()
    objects = [path.read_bytes() for path in sorted(study.iterdir())[:2]]
    parts = b"".join(b"--b\r\nContent-Type: application/dicom\r\n\r\n" + each + CRLF for each in objects) + b"--b--\r\n"
    return [(["query", "--level", "study"], message(b"application/dicom+json", listed)),
            (["fetch", "--study", STUDY, "-o", "in"], message(b'multipart/related; type="application/dicom"; boundary=b', parts))]


def saying(answer):
    """What a service does that sends the same bytes to whoever asks, and closes."""
    def serve(connection):
        while CRLF * 2 not in connection.recv(65536):
            pass
        connection.sendall(answer)
        connection.shutdown(socket.SHUT_WR)
        connection.recv(1)
    return serve


def web_services(program, study, count, seed, workers, tally):
    sound = sound_answers(study)
    ways = list(mutations.WAYS)

    def work(number, folder):
        source = random.Random(f"{seed} answer {number}")
        words, answer = sound[number % len(sound)]
        way = ways[number // len(sound) % len(ways)]
        with dicom.RawService(saying(mutations.WAYS[way](answer, source))) as service:
            run = runs.Run([program, *words, "--from", f"http://127.0.0.1:{service.port}/web", "--timeout", "2"], folder)
        row = f"DICOMweb service answers a {words[0]}"
        tally.add(row, run.code)
        fault = run.fault()
        for path in folder.rglob("*"):
            if path.is_file() and (path.suffix != ".dcm" or path.read_bytes()[128:132] != b"DICM"):
                fault = fault or f"left behind: {path.name}"
        if run.seconds > 20:
            fault = fault or f"{run.seconds:.0f} s although the peer is silent for 2"
        if fault:
            (folder / "answer.bin").write_bytes(mutations.WAYS[way](answer, random.Random(f"{seed} answer {number}")))
            tally.find(row, f"{way}: {fault}\n{words}\n{run.text[-1000:]}", folder)
    runs.in_parallel(range(count), work, workers)


def sound_stream(number):
    """An association, an object and a release, as one sender says them."""
    instance = b"1.2.3.4.%d" % number
    body = dicom.data_set(instance)
    return (dicom.associate_request() + dicom.data(3, True, True, dicom.store_command(instance)) + dicom.data(3, False, True, body)
            + dicom.pdu(5, bytes(4)))


def is_served(port):
    """Whether a good sender is accepted."""
    with socket.create_connection(("127.0.0.1", port), 10) as connection:
        connection.sendall(dicom.associate_request())
        kind, _ = dicom.receive_pdu(connection)
        connection.sendall(dicom.pdu(5, bytes(4)))
        return kind == 2


def senders(program, count, seed, tally):
    row, ways = "DICOM sender to the receiver", list(mutations.WAYS)
    with tempfile.TemporaryDirectory(prefix="anatomesh-hostile-") as name:
        folder = pathlib.Path(name)
        port = dicom.free_port()
        receiver = subprocess.Popen([program, "receive", "in", "--port", str(port), "--timeout", "2"], cwd=folder, stdin=subprocess.DEVNULL,
                                    stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            for _ in range(100):
                try:
                    socket.create_connection(("127.0.0.1", port), 1).close()
                    break
                except OSError:
                    time.sleep(0.1)
            for number in range(count):
                source = random.Random(f"{seed} sender {number}")
                stream = mutations.WAYS[ways[number % len(ways)]](sound_stream(number), source)
                try:
                    with socket.create_connection(("127.0.0.1", port), 5) as connection:
                        connection.sendall(stream)
                        connection.shutdown(socket.SHUT_WR)
                        dicom.closes_within(connection, 5)
                except OSError:
                    pass
                fault = None if receiver.poll() is None else f"the receiver ended with {receiver.returncode}"
                if not fault and number % 10 == 9 and not is_served(port):
                    fault = "a good sender is not served any more"
                tally.add(row, 0)
                if fault:
                    (folder / "stream.bin").write_bytes(stream)
                    tally.find(row, fault, folder)
                    return
            strange = [path.name for path in folder.rglob("*") if path.is_file() and path.suffix != ".dcm"]
            if strange:
                tally.find(row, f"left behind: {strange}", folder)
        finally:
            receiver.terminate()
            if receiver.wait(20) not in (0, 130):
                tally.find(row, f"the receiver ended with {receiver.returncode}", folder)


def answered(program, study, count, seed, workers, tally):
    """Two thirds of `count` are answers of web services, one third are senders."""
    web_services(program, study, count - count // 3, seed, workers, tally)
    senders(program, count // 3, seed, tally)
