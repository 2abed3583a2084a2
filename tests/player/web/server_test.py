#!/usr/bin/python3
"""`vrda-player web` from outside: what it answers on its socket, to a browser, and to the signals that end it.

usage: server_test.py VRDA PLAYER CHROMIUM JOB PAGE
"""
import gzip
import pathlib
import signal
import socket
import subprocess
import sys
import tempfile
import unittest

from web_scenes import Page, make_models

VRDA, PLAYER, CHROMIUM, JOB, PAGE = sys.argv[1:6]
READY = "document.documentElement?.dataset.state === 'ready' && !document.getElementById('player').hidden"


class Served:
    """A server of one file. Use it in a `with`; leaving it ends the server by SIGINT."""

    def __init__(self, file, *words):
        self.process = subprocess.Popen([PLAYER, "web", file, *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.address = self.process.stdout.readline().strip()
        self.port = int(self.address.rstrip("/").rsplit(":", 1)[-1])

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.end(signal.SIGINT)

    def end(self, number):
        if self.process.poll() is None:
            self.process.send_signal(number)
        self.process.communicate(timeout=20)
        return self.process.returncode

    def open(self):
        return socket.create_connection(("127.0.0.1", self.port), timeout=20)

    def ask(self, target, more="", method="GET", host=None):
        """Status, head and body of an answer."""
        with self.open() as line:
            line.sendall(f"{method} {target} HTTP/1.1\r\nHost: {host or f'127.0.0.1:{self.port}'}\r\n{more}\r\n".encode())
            return answer(line)


def answer(line):
    whole = b""
    while piece := line.recv(1 << 16):
        whole += piece
    head, _, body = whole.partition(b"\r\n\r\n")
    return int(head.split()[1]), head.decode(), body


class Server(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory(prefix="vrda-web-server-")
        cls.root = pathlib.Path(cls.folder.name)
        made = make_models(VRDA, JOB, cls.root)
        cls.model = made["grid"].rename(cls.root / "my knee é.h5")
        cls.left = made["left"]

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_page_and_model_come_whole(self):
        with Served(self.model) as served:
            status, head, _ = served.ask("/")
            self.assertEqual(status, 302)
            self.assertIn("Location: /?model=model.h5", head)
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

    def test_nonsense_and_silence_hold_nobody_up(self):
        with Served(self.model) as served:
            silent = [served.open() for _ in range(20)]
            half = served.open()
            half.sendall(b"GET / HT")
            for nonsense in (b"\r\n\r\n", b"\0\xff\r\n\r\n", b"x" * 20000, b"GET / HTTP/1.1\r\n\r\n"):
                with served.open() as line:
                    line.sendall(nonsense)
                    self.assertEqual(answer(line)[0], 400)
            gone = served.open()
            gone.sendall(f"GET /model.h5 HTTP/1.1\r\nHost: 127.0.0.1:{served.port}\r\n\r\n".encode())
            gone.close()  # before the answer
            self.assertEqual(served.ask("/model.h5")[2], self.model.read_bytes())
            for line in (*silent, half):
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

    def test_in_a_browser(self):
        with Served(self.model) as served, Page(CHROMIUM) as page:
            page.browser.visit(served.address, READY)
            page.set("flexion", 45)
            self.assertTrue(page.shown()["isSolved"])
            self.assertIn("my knee é.h5", page.text("facts"))
            self.assertEqual(page.browser.said, [])
            asked = {address for address in page.browser.requests if not address.startswith(("data:", "blob:", "about:"))}
            self.assertEqual(asked, {served.address, f"{served.address}?model=model.h5", f"{served.address}model.h5"})


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
