"""A viewer of the stream: a WebSocket written from RFC 6455; and processes that are ended by SIGINT."""
import base64
import json
import os
import signal
import socket
import struct
import subprocess


def free_port():
    with socket.create_server(("127.0.0.1", 0)) as one:
        return one.getsockname()[1]


class Running:
    """A process that is ended by SIGINT. Use it in a `with`."""

    def __init__(self, *words):
        self.process = subprocess.Popen([str(w) for w in words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
        self.process.communicate(timeout=20)


class Viewer:
    """A WebSocket written from RFC 6455, over plain TCP or TLS."""

    def __init__(self, served, tls=None, buffer=None, **request):
        self.line = socket.socket()
        if buffer:
            self.line.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, buffer)
        self.line.settimeout(20)
        self.line.connect(("127.0.0.1", served.port))
        if tls:
            self.line = tls.wrap_socket(self.line, server_hostname="localhost")
        key = base64.b64encode(os.urandom(16)).decode()
        more = f"Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: {key}\r\n" + request.pop("more", "")
        self.line.sendall(served.request("/live", more, **request))
        self.rest = b""
        while b"\r\n\r\n" not in self.rest:
            piece = self.line.recv(4096)
            if not piece:
                break
            self.rest += piece
        head, _, self.rest = self.rest.partition(b"\r\n\r\n")
        self.status = int(head.split()[1])

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.line.close()

    def _bytes(self, n):
        while len(self.rest) < n:
            piece = self.line.recv(65536)
            if not piece:
                raise EOFError("the server closed")
            self.rest += piece
        taken, self.rest = self.rest[:n], self.rest[n:]
        return taken

    def frame(self):
        first, second = self._bytes(2)
        n = second & 127
        if n == 126:
            n, = struct.unpack(">H", self._bytes(2))
        assert not second & 128, "servers send no masks"
        return first & 15, self._bytes(n)

    def message(self):
        while True:
            kind, content = self.frame()
            if kind == 1:
                return json.loads(content)
            if kind == 9:
                self.send(10, content)

    def send(self, kind, content=b""):
        mask = os.urandom(4)
        self.line.sendall(bytes([128 | kind, 128 | len(content)]) + mask + bytes(b ^ mask[k % 4] for k, b in enumerate(content)))
