#!/usr/bin/python3
"""`vrda-player web` as a process: its responses on a socket and to a browser, and its reaction to signals.

usage: server_test.py VRDA PLAYER CHROMIUM JOB PAGE
"""
import contextlib
import gzip
import os
import pathlib
import select
import signal
import socket
import ssl
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import urllib.parse

from web_scenes import Page, make_models

VRDA, PLAYER, CHROMIUM, JOB, PAGE = sys.argv[1:6]
READY = "document.documentElement?.dataset.state === 'ready' && !document.getElementById('player').hidden"

# Opens connections without end and finishes no request.
FLOOD = """
import socket, sys
opened = []
for n in range(10**9):
    line = socket.create_connection(("127.0.0.1", int(sys.argv[1])), timeout=20)
    line.sendall(b"GET /half HTTP/1.1\\r\\nHost: ")
    opened.append(line)
    if len(opened) > 400:
        opened.pop(0).close()
    if n == 300:
        print("flooding", flush=True)
"""


class Served:
    """A server of one file. Use it in a `with`, which ends the server by SIGINT."""

    def __init__(self, file, *words, env=None):
        self.process = subprocess.Popen([PLAYER, "web", file, *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=env)
        self.address = self.process.stdout.readline().strip()
        url = urllib.parse.urlsplit(self.address)
        self.port, self.below = url.port, url.path.rstrip("/")  # the path of the token

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.end(signal.SIGINT)

    def end(self, number):
        if self.process.poll() is None:
            self.process.send_signal(number)
        if not self.process.stderr.closed:
            self.messages = self.process.communicate(timeout=20)[1]
        return self.process.returncode

    def open(self, sent=b""):
        line = socket.create_connection(("127.0.0.1", self.port), timeout=20)
        line.sendall(sent)
        return line

    def request(self, target, more="", method="GET", host=None, below=None):
        """The bytes of a request; `below` replaces the path of the token."""
        path = (self.below if below is None else below) + target
        return f"{method} {path} HTTP/1.1\r\nHost: {host or f'127.0.0.1:{self.port}'}\r\n{more}\r\n".encode()

    def ask(self, target, *words, **how):
        """Status, header and body of a response."""
        with self.open(self.request(target, *words, **how)) as line:
            return answer(line)

    def sockets(self):
        """Number of open sockets of the server."""
        links = []
        for link in pathlib.Path(f"/proc/{self.process.pid}/fd").iterdir():
            with contextlib.suppress(FileNotFoundError):
                links.append(os.readlink(link))
        return sum(link.startswith("socket:") for link in links)


def received(line):
    """All data until the server closes the connection."""
    pieces = []
    with contextlib.suppress(ConnectionResetError):
        while piece := line.recv(1 << 16):
            pieces.append(piece)
    return b"".join(pieces)


def answer(line):
    head, _, body = received(line).partition(b"\r\n\r\n")
    return int(head.split()[1]), head.decode(), body


def client_hello():
    """The first bytes of a browser that uses https."""
    sent = ssl.MemoryBIO()
    with contextlib.suppress(ssl.SSLWantReadError):
        ssl.create_default_context().wrap_bio(ssl.MemoryBIO(), sent, server_hostname="localhost").do_handshake()
    return sent.read()


def is_silent(line):
    """True if the connection is open and nothing was received."""
    return not select.select([line], [], [], 0)[0]


class Server(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory(prefix="vrda-web-server-")
        cls.root = pathlib.Path(cls.folder.name)
        made = make_models(VRDA, JOB, cls.root, ("grid", "left"))
        cls.model = made["grid"].rename(cls.root / "my knee é.h5")
        cls.left = made["left"]

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_page_and_model_come_whole(self):
        with Served(self.model) as served:
            status, head, _ = served.ask("/")
            self.assertEqual(status, 302)
            self.assertIn(f"Location: {served.below}/?model=model.h5", head)
            status, _, body = served.ask("/?model=model.h5")
            self.assertEqual((status, gzip.decompress(body)), (200, pathlib.Path(PAGE).read_bytes()))
            status, _, body = served.ask("/model.h5")
            self.assertEqual((status, body), (200, self.model.read_bytes()))
            status, _, body = served.ask("/model.h5", "Range: bytes=100-199\r\n")
            self.assertEqual((status, body), (206, self.model.read_bytes()[100:200]))

    def test_only_this_machine_and_what_it_serves(self):
        with Served(self.model) as served:
            self.assertEqual(served.ask("/model.h5", host="evil.example")[0], 403)
            self.assertEqual(served.ask("/../../../../etc/passwd")[0], 404)
            self.assertEqual(served.ask("/", method="POST")[0], 405)
            listening = pathlib.Path("/proc/net/tcp").read_text() + pathlib.Path("/proc/net/tcp6").read_text()
            own = [line.split()[1] for line in listening.splitlines() if line.split()[3] == "0A" and line.split()[1].endswith(f":{served.port:04X}")]
            self.assertEqual(own, [f"0100007F:{served.port:04X}"])

    def test_invalid_and_silent_clients_do_not_delay_others(self):
        with Served(self.model) as served:
            silent = [served.open() for _ in range(20)]
            half = served.open()
            half.sendall(b"GET / HT")
            for nonsense in (b"\r\n\r\n", b"\0\xff\r\n\r\n", b"x" * 20000, b"GET / HTTP/1.1\r\n\r\n"):
                with served.open() as line:
                    line.sendall(nonsense)
                    self.assertEqual(answer(line)[0], 400)
            gone = served.open()
            gone.sendall(served.request("/model.h5"))
            gone.close()  # before the response
            self.assertEqual(served.ask("/model.h5")[2], self.model.read_bytes())
            for line in (*silent, half):
                line.close()

    def test_half_open_connections_do_not_stall_the_page(self):
        """A client that opens connections all the time and ends no request: the page comes before they time out."""
        with Served(self.model) as served:
            # A process of its own, which cannot hold the interpreter's lock between this client's connecting and sending.
            with subprocess.Popen([sys.executable, "-c", FLOOD, str(served.port)], stdout=subprocess.PIPE) as attacker:
                try:
                    attacker.stdout.readline()  # after 300 connections
                    for _ in range(20):
                        status, _, body = served.ask("/model.h5")
                        self.assertEqual((status, body), (200, self.model.read_bytes()))
                    self.assertIsNone(attacker.poll())
                    self.assertLess(served.sockets(), 180)
                finally:
                    attacker.kill()

    def test_requests_without_the_token_are_refused(self):
        with Served(self.model) as served, Served(self.model) as other:
            self.assertRegex(served.below, "^/[0-9a-f]{32}$")
            self.assertNotEqual(served.below, other.below)
            said = set()
            for below in ("", other.below, served.below[:-1], served.below + "0", "/"):
                for target in ("", "/", "/?model=model.h5", "/model.h5", "/none"):
                    with self.subTest(below + target):
                        status, head, body = served.ask(target or "/", below=below)
                        self.assertEqual(status, 403)
                        said.add((head, body))
            self.assertEqual(len(said), 1)  # reveals neither the file nor its existence
            self.assertNotIn(b"knee", said.pop()[1])

    def test_what_is_no_request_is_answered_at_once(self):
        """400 at once, not 408 after the time limit."""
        with Served(self.model) as served:
            host = f"Host: 127.0.0.1:{served.port}".encode()
            line = b"GET " + served.below.encode() + b"/ HTTP/1.1\r\n"
            for nonsense in (client_hello(), b"\x80\x2e\x01\0\x02", b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n", b"GET / HTTP/0.9\r\n", b"GET / FTP\r\n\r\n", b" / HTTP/1.1\r\n",
                             b"GET / HTTP/1.1 \r\n", b"GET /\x01 HTTP/1.1\r\n", b"GET x HTTP/1.1\r\n" + host + b"\r\n\r\n", b"\n", b"GET / HTTP/1.1\n", b"GET / HTTP/1.1\n" + host + b"\n\n",
                             line + host + b"\n\n", line + host + b"\n", line + b"\n", line + host + b"\r\nX: y\n", line + host + b"\r\n" + host + b"\r\n\r\n", line + b"Host:\r\n\r\n",
                             line + b"Host : a\r\n\r\n", line + host + b"\r\nno colon\r\n\r\n", line + host + b"\r\n: x\r\n\r\n", line + host + b"\r\nX: \0b\r\n\r\n",
                             line + host + b"\r\nX: " + b"y" * 20000, line + host + b"\r\nContent-Length: x\r\n\r\n"):
                with self.subTest(nonsense[:60]), served.open(nonsense) as silent:
                    self.assertEqual(answer(silent)[0], 400)
            for piecemeal in (b"\x16\x03\x01", b"GET / HTTP/1.1\nHost: a\n"):
                with self.subTest(piecemeal), served.open() as slow:
                    for byte in piecemeal:
                        with contextlib.suppress(BrokenPipeError, ConnectionResetError):
                            slow.sendall(bytes([byte]))
                    self.assertEqual(answer(slow)[0], 400)
            with served.open(line + host) as cut:
                cut.shutdown(socket.SHUT_WR)
                self.assertEqual(answer(cut)[0], 400)

    def test_a_request_has_10_seconds(self):
        with Served(self.model) as served:
            request = served.request("/", more="X: y\r\n")
            silent, half, steady, slow = served.open(), served.open(request[:-1]), served.open(), served.open()
            silent.settimeout(60)
            half.settimeout(60)
            for k in range(len(request)):  # in 3 seconds
                slow.sendall(request[k:k + 1])
                time.sleep(3 / len(request))
            self.assertEqual(answer(slow)[0], 302)
            # Bytes at short intervals, which together would take two minutes.
            steady.sendall(request[:-2])
            for _ in range(240):
                steady.sendall(b"z")
                if select.select([steady], [], [], 0.5)[0]:
                    break
            self.assertFalse(is_silent(steady))
            for line in (silent, half, steady):
                self.assertEqual(answer(line)[0], 408)
                line.close()
            slow.close()

    def test_slow_requests_give_way(self):
        with Served(self.model) as served:
            slow = [served.open(b"GET / HTTP/1.1\r\nX: ") for _ in range(130)]
            self.assertEqual(served.ask("/model.h5")[2], self.model.read_bytes())
            # The valid request was answered before the slow ones timed out: the first of them was dropped.
            self.assertTrue(is_silent(slow[-1]))
            self.assertEqual(received(slow[0]), b"")
            slow += [served.open() for _ in range(200)]
            self.assertEqual(served.ask("/model.h5")[2], self.model.read_bytes())
            self.assertTrue(is_silent(slow[-1]))
            self.assertLess(served.sockets(), 150)
            for line in slow:
                line.close()

    def test_slow_readers_give_way(self):
        copy = self.root / "large.h5"
        copy.write_bytes(self.model.read_bytes())
        with Served(copy) as served:
            whole = os.urandom(1 << 16) * 512  # more than sockets hold
            copy.write_bytes(whole)
            slow = [served.open(served.request("/model.h5")) for _ in range(34)]
            self.assertEqual(served.ask("/model.h5")[2], whole)
            self.assertEqual(answer(slow[-1])[2], whole)
            self.assertLess(len(received(slow[0])), len(whole))  # dropped
            # The oldest session, but not the longest idle one.
            steady, taken = served.open(served.request("/model.h5")), []

            def take():
                while piece := steady.recv(1 << 16):
                    taken.append(piece)
                    time.sleep(0.005)

            reader = threading.Thread(target=take)
            reader.start()
            for _ in range(40):
                slow.append(served.open(served.request("/model.h5")))
                time.sleep(0.05)
            self.assertLess(served.sockets(), 60)
            reader.join()
            self.assertTrue(b"".join(taken).endswith(whole))
            for line in (steady, *slow):
                line.close()

    def test_a_new_run_shows_after_a_reload(self):
        copy = self.root / "copy.h5"
        copy.write_bytes(self.model.read_bytes())
        with Served(copy) as served:
            served.ask("/model.h5")
            copy.write_bytes(self.left.read_bytes())
            self.assertEqual(served.ask("/model.h5")[2], self.left.read_bytes())
            copy.unlink()
            self.assertEqual(served.ask("/model.h5")[0], 404)

    def test_ends_with_0(self):
        for number in (signal.SIGINT, signal.SIGTERM):
            served = Served(self.model, "--quiet")
            self.assertEqual(served.end(number), 0)

    def test_bad_input(self):
        text = self.root / "text.h5"
        text.write_text("no model")
        with Served(self.model) as served:
            for words, said in (([text], "text.h5"), ([self.root / "none.h5"], "none.h5"), ([self.model, "--port", str(served.port)], "--port"),
                                ([self.model, "--port", "70000"], "--port")):
                done = subprocess.run([PLAYER, "web", *words], capture_output=True, text=True, timeout=60, check=False)
                self.assertEqual((done.returncode, done.stdout), (2, ""))
                self.assertIn(said, done.stderr)
                self.assertEqual(len(done.stderr.splitlines()), 1)

    def test_the_browser_is_opened_without_the_token_on_its_command_line(self):
        """Command lines are visible to all users, so the browser gets a file readable by this user only."""
        fake, kept = self.root / "xdg-open", self.root / "kept"
        fake.write_text(f"#!/bin/sh\nprintf '%s\\n' \"$@\" \"$(stat -c %a \"$1\")\" >'{kept}.new'\nmv '{kept}.new' '{kept}'\n")
        fake.chmod(0o755)
        folder = self.root / "temporary"
        folder.mkdir()
        surroundings = {**os.environ, "PATH": f"{self.root}:{os.environ['PATH']}", "TMPDIR": str(folder)}
        with Served(self.model, "--open", env=surroundings) as served, Page(CHROMIUM) as page:
            while not kept.exists():
                time.sleep(0.05)
            file, mode = kept.read_text().splitlines()
            self.assertEqual(mode, "600")
            self.assertNotIn(served.below[1:], file)
            page.visit(f"file://{file}", READY)
            self.assertEqual(page.browser.value("location.href"), f"{served.address}?model=model.h5")
        self.assertEqual(list(folder.iterdir()), [])

    def test_progress_while_the_model_arrives(self):
        with Served(self.model) as served, Page(CHROMIUM) as page:
            page.browser.call("Network.emulateNetworkConditions", offline=False, latency=0, downloadThroughput=150_000, uploadThroughput=-1)
            bar = "document.getElementById('loading-share')"
            page.visit(served.address, f"{bar}?.value > 0 && {bar}.value < 1")
            self.assertRegex(page.text("loading-text"), r"Loading .*: [0-9.]+ of [0-9.]+ MB")
            self.assertFalse(page.browser.value("document.getElementById('loading').hidden"))
            page.browser.wait(READY)
            self.assertTrue(page.browser.value("document.getElementById('loading').hidden"))
            self.assertEqual(page.browser.said, [])

    def test_in_a_browser(self):
        with Served(self.model) as served, Page(CHROMIUM) as page:
            page.visit(served.address, READY)
            page.set("flexion", 45)
            self.assertTrue(page.shown()["isSolved"])
            self.assertIn("my knee é.h5", page.text("facts"))
            self.assertEqual(page.browser.said, [])
            requested = {address for address in page.browser.requests if not address.startswith(("data:", "blob:", "about:"))}
            self.assertEqual(requested, {served.address, f"{served.address}?model=model.h5", f"{served.address}model.h5"})


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
