#!/usr/bin/python3
"""Reads OpenIGTLink messages as the protocol's specification (versions 1 and 2, openigtlink.org/developers/spec) defines them.

usage: read_igtl.py HOST:PORT [--seconds S]
Prints one JSON object: numbers of messages by type and device, first and last matrix of each TRANSFORM, every text of "angles",
sizes and bounds of each POLYDATA, the rate of the frames, frames that are missing by their numbers, and the longest pause.
Uses the standard library only, and no code of the product. Exit code 1 if a message does not fit the specification.
"""
import argparse
import json
import socket
import struct
import sys
import time

HEADER = struct.Struct(">H12s20sQQQ")  # version, type, device, time stamp, body size, CRC


def crc64_table():
    """ECMA-182 polynomial, most significant bit first."""
    table = []
    for byte in range(256):
        value = byte << 56
        for _ in range(8):
            value = (value << 1 ^ 0x42F0E1EBA9EA3693 if value >> 63 else value << 1) & 0xFFFFFFFFFFFFFFFF
        table.append(value)
    return table


CRC = crc64_table()


def crc64(data):
    value = 0
    for byte in data:
        value = (value << 8 & 0xFFFFFFFFFFFFFFFF) ^ CRC[value >> 56 ^ byte]
    return value


class Connection:
    def __init__(self, host, port):
        self.socket = socket.create_connection((host, port), timeout=20)
        self.buffer = b""

    def bytes(self, n):
        while len(self.buffer) < n:
            piece = self.socket.recv(max(65536, n - len(self.buffer)))
            if not piece:
                raise EOFError
            self.buffer += piece
        taken, self.buffer = self.buffer[:n], self.buffer[n:]
        return taken

    def message(self):
        version, kind, device, stamp, size, crc = HEADER.unpack(self.bytes(HEADER.size))
        body = self.bytes(size)
        if version not in (1, 2):
            raise ValueError(f"found header version {version}, wanted 1 or 2")
        if crc64(body) != crc:
            raise ValueError(f"found a wrong checksum of {kind}")
        return version, kind.rstrip(b"\0").decode("ascii"), device.rstrip(b"\0").decode("ascii"), stamp / 2**32, body


def matrix_of(body):
    """Three columns of the rotation, then the position; float32."""
    if len(body) != 48:
        raise ValueError(f"found a TRANSFORM of {len(body)} bytes, wanted 48")
    v = struct.unpack(">12f", body)
    return [[v[3 * c + r] for c in range(4)] for r in range(3)] + [[0.0, 0.0, 0.0, 1.0]]


def text_of(body):
    encoding, n = struct.unpack(">HH", body[:4])
    if encoding != 3 or len(body) != 4 + n:
        raise ValueError(f"found encoding {encoding} and {len(body) - 4} bytes, wanted 3 (US-ASCII) and {n}")
    return body[4:].decode("ascii")


def polydata_of(body):
    counts = struct.unpack(">10I", body[:40])
    n_points, n_polygons, polygon_bytes, n_attributes = counts[0], counts[5], counts[6], counts[9]
    if len(body) != 40 + 12 * n_points + counts[2] + counts[4] + polygon_bytes + counts[8] or n_attributes:
        raise ValueError("found a POLYDATA whose size does not fit its counts")
    points = struct.unpack(f">{3 * n_points}f", body[40:40 + 12 * n_points])
    words = struct.unpack(f">{polygon_bytes // 4}I", body[40 + 12 * n_points + counts[2] + counts[4]:][:polygon_bytes])
    at, triangles = 0, []
    while at < len(words):
        triangles.append(words[at + 1:at + 1 + words[at]])
        at += 1 + words[at]
    if len(triangles) != n_polygons or any(k >= n_points for triangle in triangles for k in triangle):
        raise ValueError("found polygons that do not fit the counts")
    return {"points": n_points, "triangles": n_polygons, "first_triangle": list(triangles[0]) if triangles else [],
            "first_point": list(points[:3]), "least": [min(points[k::3]) for k in range(3)], "most": [max(points[k::3]) for k in range(3)]}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("address")
    parser.add_argument("--seconds", type=float, default=2.0)
    options = parser.parse_args()
    host, port = options.address.rsplit(":", 1)
    connection = Connection(host, int(port))
    counts, first, last, angles, meshes, arrivals, order = {}, {}, {}, [], {}, [], []
    end = time.monotonic() + options.seconds
    while time.monotonic() < end or not angles:  # at least one frame, however slow the machine
        try:
            version, kind, device, stamp, body = connection.message()
        except EOFError:
            break
        order.append(kind)
        counts[f"{kind} {device}"] = counts.get(f"{kind} {device}", 0) + 1
        if abs(stamp - time.time()) > 60:
            raise ValueError(f"found the time stamp {stamp}, wanted seconds since 1970")
        if kind == "TRANSFORM":
            last[device] = matrix_of(body)
            first.setdefault(device, last[device])
        elif kind == "STRING":
            angles.append(json.loads(text_of(body)))
            arrivals.append(time.monotonic())
        elif kind == "POLYDATA":
            meshes[device] = polydata_of(body)
        else:
            raise ValueError(f"found the type {kind}, wanted TRANSFORM, STRING or POLYDATA")
    numbers = [one["frame"] for one in angles]
    pauses = [b - a for a, b in zip(arrivals, arrivals[1:])]
    json.dump({"messages": counts, "first": first, "last": last, "angles": angles, "meshes": meshes,
               "first_kinds": order[:3], "frames": len(numbers),
               "rate_hz": len(pauses) / (arrivals[-1] - arrivals[0]) if pauses else 0.0,
               "frames_missing": numbers[-1] - numbers[0] + 1 - len(numbers) if numbers else 0,
               "longest_pause_s": max(pauses, default=0.0)}, sys.stdout)


if __name__ == "__main__":
    try:
        main()
    except (ValueError, OSError) as error:
        sys.exit(f"read_igtl.py: {error}")
