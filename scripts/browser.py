"""Headless Chromium over its DevTools pipe: opens a page, records console messages and requests, takes screenshots."""
import base64
import contextlib
import json
import os
import select
import shlex
import signal
import subprocess
import tempfile
import time

FLAGS = ("--headless --no-sandbox --disable-quic --no-first-run --disable-background-networking --disable-component-update --disable-sync "
         "--disable-dev-shm-usage --disable-gpu-compositing --use-angle=swiftshader --enable-unsafe-swiftshader --hide-scrollbars --remote-debugging-pipe").split()


class Browser:
    """One tab; a context manager that ends the browser."""

    def __init__(self, chromium, deadline_s=150.0):
        self._deadline = time.monotonic() + deadline_s
        self._profile = tempfile.TemporaryDirectory(prefix="vrda-browser-", ignore_cleanup_errors=True)
        to_read, self._to = os.pipe()
        self._from, from_write = os.pipe()
        # The browser reads commands from descriptor 3 and writes answers to 4.
        words = [chromium, *FLAGS, f"--user-data-dir={self._profile.name}", "about:blank"]
        line = f"exec {shlex.join(words)} 3<&{to_read} 4>&{from_write}"
        self._log = tempfile.TemporaryFile(prefix="vrda-browser-log-")
        self._process = subprocess.Popen(["bash", "-c", line], pass_fds=(to_read, from_write), stdin=subprocess.DEVNULL,
                                         stdout=subprocess.DEVNULL, stderr=self._log,
                                         start_new_session=True)
        os.close(to_read)
        os.close(from_write)
        self._rest, self._last, self._session = b"", 0, None
        self.said, self.requests = [], []  # console errors and exceptions; requested addresses
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self._session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Network", "Log"):
            self.call(f"{domain}.enable")

    def begin(self, deadline_s):
        """For another use: nothing is recorded, and there is time."""
        self._deadline = time.monotonic() + deadline_s
        self.said.clear()
        self.requests.clear()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        for end in (self._to, self._from):
            os.close(end)
        self._process.terminate()
        try:
            self._process.wait(10)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        with contextlib.suppress(ProcessLookupError):  # child processes outlive it and write to the profile
            os.killpg(self._process.pid, signal.SIGKILL)
        self._log.close()
        self._profile.cleanup()

    def _message(self):
        while b"\0" not in self._rest:
            left = self._deadline - time.monotonic()
            if left <= 0 or not select.select([self._from], [], [], left)[0]:
                raise TimeoutError("the browser does not answer")
            piece = os.read(self._from, 1 << 20)
            if not piece:
                raise EOFError("the browser exited: " + self._last_words())
            self._rest += piece
        line, self._rest = self._rest.split(b"\0", 1)
        return json.loads(line)

    def _last_words(self):
        self._log.seek(0)
        return self._log.read()[-2000:].decode(errors="replace")

    def _note(self, message):
        method, facts = message.get("method"), message.get("params", {})
        if method == "Runtime.exceptionThrown":
            self.said.append(json.dumps(facts["exceptionDetails"].get("exception", facts["exceptionDetails"])))
        elif method == "Runtime.consoleAPICalled" and facts["type"] in ("error", "assert"):
            self.said.append(facts["type"] + ": " + " ".join(str(a.get("value", a.get("description"))) for a in facts["args"]))
        elif method == "Log.entryAdded" and facts["entry"]["level"] == "error":
            self.said.append(facts["entry"]["level"] + ": " + facts["entry"]["text"])
        elif method == "Network.requestWillBeSent":
            self.requests.append(facts["request"]["url"])

    def call(self, method, **parameters):
        """Sends a command and returns its result."""
        self._last += 1
        command = {"id": self._last, "method": method, "params": parameters}
        if self._session:
            command["sessionId"] = self._session
        os.write(self._to, json.dumps(command).encode() + b"\0")
        while True:
            message = self._message()
            if message.get("id") == self._last:
                if "error" in message:
                    raise RuntimeError(f"{method}: {message['error']}")
                return message["result"]
            self._note(message)

    def value(self, expression):
        """Value of a JavaScript expression."""
        answer = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in answer:
            raise RuntimeError(str(answer["exceptionDetails"]))
        return answer["result"].get("value")

    def open(self, path, width=1200, height=900, is_dark=False, is_phone=False):
        """Opens a report file at a window size and waits until it is drawn."""
        self.visit(f"file://{path}", "document.documentElement?.dataset.report === 'ready'", width=width, height=height, is_dark=is_dark, is_phone=is_phone)
        self.settle()

    def visit(self, address, is_there, width=1200, height=900, is_dark=False, is_phone=False, scale=1):
        """Opens an address at a window size and waits until the JavaScript expression `is_there` holds; `scale`: pixels of the screen by those of CSS."""
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=scale, mobile=is_phone)
        scheme = "dark" if is_dark else "light"
        self.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])
        self.call("Page.navigate", url=address)
        self.wait(is_there)

    def wait(self, is_there):
        """Waits until a JavaScript expression holds, also in a page that redirects meanwhile."""
        while not self._holds(is_there):
            time.sleep(0.1)

    def _holds(self, expression):
        try:
            return self.value(expression)
        except RuntimeError as error:
            if "target navigated or closed" not in str(error):
                raise
            return False

    def give(self, selector, path):
        """Sets a file input of a form."""
        root = self.call("DOM.getDocument")["root"]["nodeId"]
        node = self.call("DOM.querySelector", nodeId=root, selector=selector)["nodeId"]
        self.call("DOM.setFileInputFiles", nodeId=node, files=[str(path)])

    def settle(self):
        """Waits 30 animation frames, which drawing takes at most."""
        self.value("new Promise((done) => { let n = 30; const next = () => (--n ? requestAnimationFrame(next) : done()); next(); })")

    def element(self, expression):
        """PNG of the element that a JavaScript expression returns."""
        box = self.value(f"(() => {{ const e = {expression}; e.scrollIntoView({{ block: 'center', behavior: 'instant' }}); "
                         "const r = e.getBoundingClientRect(); return [r.x + scrollX, r.y + scrollY, r.width, r.height]; })()")
        self.value("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
        clip = {**dict(zip(("x", "y", "width", "height"), box)), "scale": 1}
        return base64.b64decode(self.call("Page.captureScreenshot", format="png", optimizeForSpeed=True, clip=clip)["data"])
