#!/usr/bin/python3
"""`vrda-player web` over TLS and with a bench: its stream to sockets and browsers, and its protections, which are those of plain http.

usage: live_test.py VRDA PLAYER CHROMIUM JOB PACKAGES [PICTURES]
"""
import base64
import contextlib
import hashlib
import json
import os
import pathlib
import signal
import socket
import ssl
import stat
import subprocess
import sys
import tempfile
import time
import unittest

import numpy
import zbar

from headset import Headset
from server_test import READY, Served, answer, client_hello, received
from viewer import Running, Viewer, free_port
from web_scenes import Page, make_models

VRDA, PLAYER, CHROMIUM, JOB, PACKAGES = sys.argv[1:6]
KEPT = pathlib.Path(sys.argv[6]) if len(sys.argv) > 6 else None
# Placements are sent in double precision; the page turns them in single precision of metres.
MM = 0.1
BENCH = """title = "Test"
leg = "two-bodies"
head = "stage"
[display]
width = 1280
height = 1024
layout = "quarters"
[tracker]
host = "127.0.0.1"
port = {port}
[body.femur]
tool = "femur"
[body.tibia]
tool = "tibia"
[calibration]
[[calibration.point]]
name = "medial epicondyle"
mm = [-1.0, 4.0, -42.9]
[[calibration.point]]
name = "lateral epicondyle"
mm = [-2.0, 3.0, 41.7]
[[calibration.point]]
name = "trochlea"
mm = [27.7, 30.0, 4.0]
[[calibration.point]]
name = "shaft"
mm = [-4.9, 90.0, 2.0]
[[calibration.tibia_point]]
name = "tuberosity"
mm = [24.6, -64.0, 1.0]
[[calibration.tibia_point]]
name = "medial plateau"
mm = [3.0, -38.0, -39.6]
[[calibration.tibia_point]]
name = "lateral plateau"
mm = [1.0, -38.0, 39.1]
[[calibration.tibia_point]]
name = "shin"
mm = [18.7, -125.0, 0.0]
[simulation]
{simulation}
"""
BENDING = 'leg = [[0, 10, 0], [4, 80, 1], [8, 10, 0]]'
# Between a drawn frame and the next message the page shows the streamed flexion; a leg that bends meets no other by chance.
FOLLOWS = """new Promise((done) => { const poll = () => { const { pose } = window.vrda.live();
    if (Math.abs(pose.flexion - window.vrda.shown().flexion) < 1e-6) done([pose, window.vrda.xr.state().drawn]); else setTimeout(poll); }; poll(); })"""
NOISE_MM = 5  # of the simulated femur at the joint, from one message to another, is below 2
STILL = "leg = [[0, 40, 0], [1000, 40, 0]]"


class Live(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        if KEPT:
            KEPT.mkdir(parents=True, exist_ok=True)
        cls.folder = tempfile.TemporaryDirectory(prefix="vrda-live-test-")
        cls.root = pathlib.Path(cls.folder.name)
        cls.model = make_models(VRDA, JOB, cls.root, ("grid",))["grid"]
        cls.certificate, cls.key = cls.root / "own.pem", cls.root / "own.key"
        with Served(cls.model, "--self-signed", "--tls", cls.certificate, cls.key):
            pass
        cls.tls = ssl.create_default_context(cafile=cls.certificate)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def bench(self, simulation=STILL):
        port = free_port()
        path = self.root / f"bench-{port}.toml"
        path.write_text(BENCH.format(port=port, simulation=simulation))
        return path

    def simulated(self, bench):
        running = Running(PLAYER, "simulate", bench, "--model", self.model)
        running.process.stdout.readline()
        return running

    def keep(self, page, name):
        if KEPT:
            (KEPT / f"{name}.png").write_bytes(base64.b64decode(page.browser.call("Page.captureScreenshot", format="png")["data"]))

    def encrypted(self, served, sent=b""):
        line = self.tls.wrap_socket(socket.create_connection(("127.0.0.1", served.port), timeout=30), server_hostname="localhost")
        line.sendall(sent)
        return line

    # TLS

    def test_the_certificate_that_was_made(self):
        self.assertEqual(stat.S_IMODE(self.key.stat().st_mode), 0o600)
        text = subprocess.run(["openssl", "x509", "-in", self.certificate, "-noout", "-text"], capture_output=True, text=True, check=True).stdout
        for wanted in ("IP Address:127.0.0.1", "DNS:localhost", "TLS Web Server Authentication", "CA:FALSE", "prime256v1", "Version: 3"):
            self.assertIn(wanted, text)
        days = subprocess.run(["openssl", "x509", "-in", self.certificate, "-noout", "-checkend", str(364 * 86400)], capture_output=True, check=False).returncode
        self.assertEqual(days, 0)
        before = self.certificate.read_bytes()
        with Served(self.model, "--self-signed", "--tls", self.certificate, self.key) as served:
            self.assertRegex(served.address, "^https://127.0.0.1:[0-9]+/[0-9a-f]{32}/$")
        self.assertEqual(self.certificate.read_bytes(), before)  # used again
        # Of another address: it is served where it listens, with a warning.
        with Served(self.model, "--self-signed", "--tls", self.certificate, self.key, "--address", "127.0.0.3") as served:
            self.assertRegex(served.address, "^https://127.0.0.3:[0-9]+/")
            with socket.create_connection(("127.0.0.3", served.port), timeout=20):
                pass
        self.assertRegex(served.messages, "names 127.0.0.1, not 127.0.0.3: browsers warn; for another certificate delete it and .*")
        # Without files each run has its own.
        with Served(self.model, "--self-signed") as one, Served(self.model, "--self-signed") as other:
            self.assertNotEqual(*(ssl.get_server_certificate(("127.0.0.1", served.port)) for served in (one, other)))

    def test_page_and_model_come_whole_over_tls(self):
        with Served(self.model, "--tls", self.certificate, self.key) as served:
            for target, more, wanted in (("/model.h5", "", self.model.read_bytes()), ("/model.h5", "Range: bytes=5-9\r\n", self.model.read_bytes()[5:10])):
                with self.encrypted(served, served.request(target, more)) as line:
                    self.assertEqual(answer(line)[2], wanted)
            for words in ({"below": ""}, {"host": "evil.example"}):
                with self.encrypted(served, served.request("/model.h5", **words)) as line:
                    self.assertEqual(answer(line)[0], 403)
            old = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
            old.check_hostname, old.verify_mode = False, ssl.CERT_NONE
            old.set_ciphers("DEFAULT:@SECLEVEL=0")
            old.maximum_version = ssl.TLSVersion.TLSv1_1
            with self.assertRaises((ssl.SSLError, ConnectionResetError)), socket.create_connection(("127.0.0.1", served.port), timeout=20) as line:
                old.wrap_socket(line)

    def test_slow_and_silent_clients_over_tls(self):
        copy = self.root / "large.h5"
        copy.write_bytes(self.model.read_bytes())
        with Served(copy, "--tls", self.certificate, self.key) as served:
            whole = os.urandom(1 << 16) * 256
            copy.write_bytes(whole)
            # No handshake, half of one, nonsense instead of one, a handshake without a request.
            silent, half, nonsense, mute = served.open(), served.open(client_hello()[:50]), served.open(b"GET / HTTP/1.1\r\n\r\n"), self.encrypted(served)
            received(nonsense)
            begun = time.monotonic()
            slow = [self.encrypted(served, served.request("/model.h5")) for _ in range(34)]
            with self.encrypted(served, served.request("/model.h5")) as line:
                self.assertEqual(answer(line)[2], whole)
            self.assertEqual(answer(slow[-1])[2], whole)
            with contextlib.suppress(ssl.SSLError, ConnectionResetError):
                self.assertLess(len(received(slow[0])), len(whole))  # dropped
            for line in (silent, half):
                line.settimeout(30)
                received(line)
            self.assertIn(b" 408 ", received(mute))
            self.assertLess(time.monotonic() - begun, 25)
            many = [served.open() for _ in range(200)]
            with self.encrypted(served, served.request("/model.h5")) as line:
                self.assertEqual(answer(line)[2], whole)
            self.assertLess(served.sockets(), 180)
            for line in (silent, half, nonsense, mute, *slow, *many):
                line.close()

    def test_refusals(self):
        other, text, locked = self.root / "other.pem", self.root / "text.pem", self.root / "locked.key"
        other_key = self.root / "other.key"
        with Served(self.model, "--self-signed", "--tls", other, other_key):
            pass
        text.write_text("no certificate")
        locked.write_bytes(subprocess.run(["openssl", "ec", "-in", self.key, "-aes128", "-passout", "pass:x"], capture_output=True, check=True).stdout)
        taken = socket.create_server(("127.0.0.1", 0))
        none = self.root / "none.pem"
        for words, said in ((("--tls", none, self.key), (str(none), "unreadable")), (("--tls", text, self.key), (str(text), "no certificate")),
                            (("--tls", self.certificate, text), (str(text), "no private key")), (("--tls", self.certificate, other_key), (str(other_key), "another certificate")),
                            (("--tls", self.certificate, locked), (str(locked), "encrypted")), (("--tls", self.certificate), ("--tls",)),
                            (("--tls", none, self.key, "--self-signed"), (str(none),)), (("--tls", self.root / "no" / "a", self.root / "no" / "b", "--self-signed"), ("No such file",)),
                            (("--address", "198.51.100.7", "--self-signed"), ("--address", "198.51.100.7", "address of this machine")),
                            (("--address", "198.51.100.7"), ("--address", "without TLS", "--self-signed")), (("--address", "0.0.0.0", "--self-signed"), ("--address", "0.0.0.0")),
                            (("--address", "knee.example", "--self-signed"), ("--address", "knee.example")), (("--tls", self.certificate, self.key, "--port", taken.getsockname()[1]), ("--port", "in use")),
                            (("--bench", none), (str(none),)), (("--calibration", none), ("--calibration", "--bench")), (("--bench", self.bench(), "--set", "degree_9"), ("degree_9",))):
            with self.subTest(words):
                done = subprocess.run([PLAYER, "web", self.model, *map(str, words)], capture_output=True, text=True, timeout=60, check=False)
                self.assertEqual((done.returncode, done.stdout), (2, ""), done.stderr)
                self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)
                for one in said:
                    self.assertIn(one, done.stderr)
        taken.close()

    def test_the_qr_code_and_the_ways_to_a_phone(self):
        with Served(self.model, "--qr") as served:
            pass
        self.assertEqual(served.process.returncode, 0)
        self.assertIn(f"adb reverse tcp:{served.port} tcp:{served.port}", served.messages)
        self.assertEqual(self.read_qr(served.messages), f"http://localhost:{served.port}{served.below}/")
        with Served(self.model, "--self-signed", "--qr") as served:
            fingerprint = ssl.PEM_cert_to_DER_cert(ssl.get_server_certificate(("127.0.0.1", served.port)))
        self.assertEqual(self.read_qr(served.messages), served.address)
        self.assertIn("SHA-256", served.messages)
        self.assertIn(":".join(f"{b:02X}" for b in hashlib.sha256(fingerprint).digest()), served.messages)
        with Served(self.model, "--quiet", "--qr") as served:
            pass
        self.assertEqual(served.messages, "")

    @staticmethod
    def read_qr(messages):
        """The text of the QR code in half blocks, read by ZBar."""
        lines = [line for line in messages.splitlines() if line and set(line) <= set(" \u2580\u2584\u2588")]
        modules = numpy.array([[c in blocks for c in line] for line in lines for blocks in ("\u2588\u2580", "\u2588\u2584")])
        picture = numpy.kron(modules, numpy.ones((6, 6))).astype("uint8") * 255
        image = zbar.Image(picture.shape[1], picture.shape[0], "Y800", picture.tobytes())
        zbar.ImageScanner().scan(image)
        return next(iter(image)).data

    # The stream

    def test_any_number_of_viewers_at_any_time(self):
        bench = self.bench(BENDING)
        with self.simulated(bench), Served(self.model, "--bench", bench) as served:
            with Viewer(served) as first:
                greeting = first.message()
                self.assertEqual((greeting["kind"], greeting["version"], greeting["title"], greeting["scale"]), ("bench", 1, "Test", 1))
                self.assertEqual([p["body"] for p in greeting["points"]], ["reference"] * 4 + ["moving"] * 4)
                poses = [first.message() for _ in range(60)]
                self.assertTrue(all(p["kind"] == "pose" for p in poses))
                numbers = [p["number"] for p in poses]
                self.assertEqual(numbers, sorted(set(numbers)))
                while (pose := first.message())["marks"]:
                    pass
                start = pose
                while abs(first.message()["flexion"] - start["flexion"]) < 5:
                    pass
                # Latecomers, all at the same pose; one that leaves without a word, one that closes, one that sends a message.
                late = [Viewer(served) for _ in range(40)]
                for viewer in late:
                    self.assertEqual(viewer.message()["kind"], "bench")
                late[0].line.close()
                late[1].send(8)
                late[2].send(1, b"hello")
                with self.assertRaises(EOFError):
                    while late[2].frame():
                        pass
                late[3].send(9, b"ping")
                while (frame := late[3].frame())[0] != 10:
                    pass
                self.assertEqual(frame[1], b"ping")
                at = {v.message()["number"]: v for v in late[4:]}
                self.assertGreater(min(at), start["number"])
                newest = max(at)
                same = []
                for viewer in late[4:]:
                    while (pose := viewer.message())["number"] <= newest + 60:
                        pass
                    same.append(pose)
                self.assertGreaterEqual(min(p["number"] for p in same), newest + 60)
                for viewer in late:
                    viewer.line.close()
                self.assertEqual(first.message()["kind"], "pose")

    def test_the_stream_is_as_protected_as_the_files(self):
        bench = self.bench()
        with Served(self.model, "--bench", bench) as served, Served(self.model) as plain:
            for words, status in (({"below": ""}, 403), ({"host": "evil.example"}, 403), ({"more": "Origin: http://evil.example\r\n"}, 403),
                                  ({"more": f"Origin: https://127.0.0.1:{served.port}\r\n"}, 403), ({"more": f"Origin: http://127.0.0.1:{served.port}\r\n"}, 101), ({}, 101)):
                with self.subTest(words), Viewer(served, **words) as viewer:
                    self.assertEqual(viewer.status, status)
            with Viewer(plain) as viewer:
                self.assertEqual(viewer.status, 404)  # no bench
            self.assertEqual(served.ask("/live")[0], 426)
            self.assertEqual(served.ask("/")[1].count("/?model=model.h5&live=live"), 1)

    def test_slow_viewers_miss_messages_and_delay_no_other_viewer(self):
        bench = self.bench()
        with self.simulated(bench), Served(self.model, "--bench", bench, "--tls", self.certificate, self.key) as served:
            slow = [Viewer(served, self.tls, buffer=2048) for _ in range(20)]
            with Viewer(served, self.tls) as quick:
                self.assertEqual(quick.message()["kind"], "bench")
                first = quick.message()["number"]
                begun = time.monotonic()
                while (last := quick.message()["number"]) < first + 180:
                    pass
                self.assertLess(time.monotonic() - begun, 10)
                # A slow one continues with messages of now, not with all it has missed.
                slow[0].message()
                numbers = []
                while not numbers or numbers[-1] < last:
                    numbers.append(slow[0].message()["number"])
                self.assertGreater(max(numpy.diff(numbers)), 20)
                # Those that read nothing are dropped after 20 s; the files are served meanwhile.
                with self.encrypted(served, served.request("/model.h5")) as line:
                    self.assertEqual(answer(line)[2], self.model.read_bytes())
                deadline = time.monotonic() + 45
                while served.sockets() > 12 and time.monotonic() < deadline:
                    quick.message()
                    slow[0].message()
                self.assertLess(served.sockets(), 13)
            for viewer in slow:
                viewer.line.close()

    # In a browser

    def test_a_browser_follows_the_bench_and_marks_what_is_wrong(self):
        bench = self.bench(BENDING)
        with Served(self.model, "--bench", bench) as served, Headset(CHROMIUM, PACKAGES) as page:
            page.visit(served.address, READY)
            # Absent tracker: marked, and the page is usable.
            page.browser.wait("['tracker', 'not seen yet'].every((said) => document.getElementById('marks').textContent.includes(said))")
            self.assertFalse(page.browser.value("document.getElementById('follow-choice').hidden"))
            if not KEPT:
                page.hide_joint()
            self.keep(page, "live-absent")
            with self.simulated(bench):
                page.browser.wait("document.getElementById('marks').textContent === ''")
                page.browser.wait("window.vrda.shown().flexion > 30")
                self.keep(page, "live")
                # As streamed: the same attitude, which the page turns to the pose by its own motion.
                page.browser.value(FOLLOWS)
                self.assertEqual(page.shown()["set"], "two_sided")
                # The user's slider takes over until the box is ticked.
                page.set("flexion", 5)
                page.settle()
                self.assertEqual(page.shown()["flexion"], 5)
                page.browser.value("document.getElementById('follow').click()")
                page.browser.wait("window.vrda.shown().flexion !== 5")
            # Gone: the last pose stays, marked.
            page.browser.wait("document.getElementById('marks').textContent.includes('tracker')")
            self.assertGreater(page.shown()["flexion"], 5)
            served.end(signal.SIGINT)
            page.browser.wait("document.getElementById('marks').textContent.includes('no connection')")
            self.keep(page, "live-lost")
            page.set("flexion", 33)
            self.assertIn("flexion 33.0°", page.text("shown"))

    def test_a_lost_line_goes_on_and_liars_are_refused(self):
        """The messages are said by this test, in place of the server's."""
        pose = {"kind": "pose", "number": 1, "flexion": 20.0, "varus": 0.5, "placement": [1, 0, 0, 5, 0, 1, 0, 6, 0, 0, 1, 7], "marks": []}
        lies = ("{", "[]", "null", json.dumps({**pose, "flexion": 1e9}), json.dumps({**pose, "flexion": None}), json.dumps({**pose, "placement": [2, *pose["placement"][1:]]}),
                json.dumps({**pose, "placement": [0] * 12}), json.dumps({**pose, "placement": [-1, *pose["placement"][1:]]}), json.dumps({**pose, "marks": ["x" * 1000]}), json.dumps({**pose, "marks": "<b>"}),
                json.dumps({"kind": "bench", "version": 2}), json.dumps({"kind": "bench", "version": 1, "title": "t", "set": "raw", "scale": 9, "points": []}), json.dumps({**pose, "number": "1"}))
        bench = self.bench()
        with Served(self.model, "--bench", bench) as served, Page(CHROMIUM) as page:
            page.run_first("""
                window.sockets = [];
                window.WebSocket = class extends EventTarget {
                  constructor(address) { super(); this.address = address; window.sockets.push(this); }
                  close() { this.dispatchEvent(new Event("close")); }
                };
                window.opened = () => window.sockets.at(-1).dispatchEvent(new Event("open"));
                window.said = (data) => window.sockets.at(-1).dispatchEvent(new MessageEvent("message", { data }));""")
            page.visit(served.address, READY)
            self.assertEqual(page.browser.value("String(window.sockets[0].address)"), served.address.replace("http", "ws") + "live")
            say = lambda data: page.browser.value(f"window.said({json.dumps(data)})")  # noqa: E731
            page.browser.value("window.opened()")
            say(json.dumps(pose))
            page.settle()
            self.assertEqual(page.shown()["flexion"], 20)
            for lie in lies:
                with self.subTest(lie[:90]):
                    say(lie)
                    self.assertRegex(page.browser.value("window.vrda.live().marks[0]"), "^bench: found .*, wanted ")
                    page.settle()
                    self.assertEqual(page.shown()["flexion"], 20)
            hidden = json.dumps({**pose, "flexion": 25.0, "marks": ["tibia hidden for 1.0 s"]})
            self.assertEqual(page.browser.value(f"window.said({json.dumps(hidden)}), window.vrda.live().marks"), ["tibia hidden for 1.0 s"])
            page.browser.wait("window.vrda.shown().flexion === 25")
            # Slow: marked after half a second. Lost: it connects again, and goes on.
            page.browser.wait("document.getElementById('marks').textContent.includes('no message from the bench for')")
            page.browser.value("window.sockets[0].close()")
            page.browser.wait("window.sockets.length === 2")
            self.assertIn("no connection", page.browser.value("window.vrda.live().marks[0]"))
            again = json.dumps({**pose, "flexion": 30.0})
            self.assertEqual(page.browser.value(f"window.opened(), window.said({json.dumps(again)}), window.vrda.live().marks"), [])
            page.browser.wait("window.vrda.shown().flexion === 30")

    def test_in_ar_the_joint_follows_the_leg(self):
        bench = self.bench(BENDING)
        with self.simulated(bench), Served(self.model, "--bench", bench) as served, Headset(CHROMIUM, PACKAGES) as page:
            page.visit(served.address, READY, width=320, height=240)
            page.browser.wait("document.getElementById('marks').textContent === '' && window.vrda.live()?.pose")
            page.hide_joint()
            page.start("immersive-ar")
            page.aim((0.3, 0.75, -0.9))
            page.press()

            def seen():
                """Streamed and drawn placement at one moment, mm."""
                live, drawn = page.browser.value(FOLLOWS)
                P, D = numpy.eye(4), numpy.array(drawn).reshape(4, 4).T * ((1000,) * 4, (1000,) * 4, (1000,) * 4, (1,) * 4)
                P[:3, :3], P[:3, 3] = live["placement"]["R"], live["placement"]["t"]
                return P, D, live["flexion"]

            first, seen_flexions = seen(), []
            for _ in range(4):
                page.frames(5)
                now = seen()
                seen_flexions.append(now[2])
                # The joint moves as the femur, which moves by its noise alone; the two may be of neighbouring messages.
                wanted = first[1] @ numpy.linalg.inv(first[0]) @ now[0]
                numpy.testing.assert_allclose(now[1], wanted, atol=NOISE_MM)
            self.assertGreater(max(seen_flexions) - min(seen_flexions), 0.5)
            # The bench's points are those to touch, at its size.
            self.assertEqual(page.browser.value("window.vrda.xr.landmarks().map((p) => p.name)")[:2], ["medial epicondyle", "lateral epicondyle"])
            self.keep(page, "live-ar")
            page.use("live")
            page.frames(4)
            stopped = page.shown()["flexion"]
            page.frames(10)
            self.assertEqual(page.shown()["flexion"], stopped)
            page.use("leave")
            page.browser.wait("!window.vrda.xr.state().isPresenting")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
