#!/usr/bin/python3
"""Checks the libraries, functions and size of vrda-player.

usage: what_it_links.py PROGRAM [FOREIGN_ROOM.a]... -- [OWN_ROOM.a]...
It may link only LIBRARIES, and must contain no function of a foreign room's archive (unless an own room defines it) and no
name in FOREIGN_NAMES. Exit code 1 with one line per violation.
"""
import os
import re
import subprocess
import sys
import tempfile

# Direct dependencies of the program. toml++ is for settings files, stb for glyphs, OpenSSL for the web server's TLS.
LIBRARIES = re.compile(r"(ld-linux-x86-64|libc|libm|libgcc_s|libstdc\+\+|libpthread|libdl|libhdf5_serial(_hl)?|libz|liblzma|libssl|libcrypto|libsz|libpng16"
                       r"|libOSMesa|libEGL|libOpenGL|libGL|libglfw|libX11|libmeshoptimizer|libtomlplusplus|libOpenIGTLink|libnlopt|libseccomp|libstb)\.so[.\dd]*")
FOREIGN_NAMES = re.compile(r"\b(btCollision\w*|btGImpact\w*|btConvex\w*|Assimp::|spdlog::)")
LARGEST_BYTES = 5_000_000


def output_of(*command):
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def needed(program):
    return re.findall(r"\(NEEDED\).*\[(.+)\]", output_of("readelf", "-d", program))


def functions(file):
    """Mangled names of the exported functions, without weak symbols (inline functions)."""
    lines = output_of("nm", "--defined-only", "--extern-only", file).splitlines()
    return {line.split()[-1] for line in lines if re.match(r"[0-9a-f]+ T ", line)}


def stripped_bytes(program):
    with tempfile.TemporaryDirectory() as folder:
        copy = os.path.join(folder, "stripped")
        subprocess.run(["strip", "-o", copy, program], check=True)
        return os.path.getsize(copy)


def violations(program, foreign, own):
    for library in needed(program):
        if not LIBRARIES.fullmatch(library):
            yield f"needs {library}"
    inside = functions(program)
    of_own = set().union(*map(functions, own))
    for archive in foreign:
        found = sorted((functions(archive) - of_own) & inside)
        if found:
            yield f"contains {len(found)} functions of {os.path.basename(archive)}: {found[0]}"
    for name in sorted(set(FOREIGN_NAMES.findall(output_of("nm", "--demangle", program)))):
        yield f"contains {name}"
    size = stripped_bytes(program)
    print(f"{os.path.basename(program)}: {size} bytes stripped, needs {', '.join(needed(program))}")
    if size >= LARGEST_BYTES:
        yield f"takes {size} bytes stripped, wanted fewer than {LARGEST_BYTES}"


def main():
    program, *archives = sys.argv[1:]
    split = archives.index("--")
    foreign, own = archives[:split], archives[split + 1:]
    if not own:
        sys.exit("wanted the archives of the program's own rooms")
    found = list(violations(program, foreign, own))
    for line in found:
        print(f"{program} {line}", file=sys.stderr)
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
