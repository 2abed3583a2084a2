"""Binary STL files: triangles, each of three points."""
import struct

FACET = struct.Struct("<12fH")


def read(path):
    data = path.read_bytes()
    n = struct.unpack_from("<I", data, 80)[0]
    return [(f[3:6], f[6:9], f[9:12]) for f in FACET.iter_unpack(data[84:84 + FACET.size * n])]


def write(path, triangles):
    facets = [FACET.pack(0, 0, 0, *a, *b, *c, 0) for a, b, c in triangles]
    path.write_bytes(b" " * 80 + struct.pack("<I", len(facets)) + b"".join(facets))
