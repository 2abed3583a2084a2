"""Repeated calls keep no memory and no object. usage: leak_test.py VRDA

The bytes in use are those of the C library's allocator (mallinfo2), over all arenas, and Python's own blocks.
"""
import ctypes
import gc
import pathlib
import sys
import tempfile
import unittest

import numpy as np

import vrda
from support import COARSE, KNEE

FIELDS = ("arena", "ordblks", "smblks", "hblks", "hblkhd", "usmblks", "fsmblks", "uordblks", "fordblks", "keepcost")


class Mallinfo2(ctypes.Structure):
    _fields_ = [(name, ctypes.c_size_t) for name in FIELDS]


LIBC = ctypes.CDLL(None)
LIBC.mallinfo2.restype = Mallinfo2


def in_use():
    """Bytes allocated by malloc and its mmap, and blocks of Python."""
    gc.collect()
    info = LIBC.mallinfo2()
    return info.uordblks + info.hblkhd, sys.getallocatedblocks()


def growth(act, n, warm=3):
    """Bytes and blocks kept by each call, after some calls that fill caches."""
    for _ in range(warm):
        act()
    before = in_use()
    for _ in range(n):
        act()
    return tuple((now - then) / n for now, then in zip(in_use(), before))


class Leaks(unittest.TestCase):
    # The smallest thing that a call could keep, an exception or an array, takes more than these.
    BYTES, BLOCKS = 64, 1.0

    def check(self, act, n):
        n_bytes, n_blocks = growth(act, n)
        self.assertLess(n_bytes, self.BYTES)
        self.assertLess(n_blocks, self.BLOCKS)

    def test_the_measure_sees_a_leak(self):
        kept = []
        n_bytes, n_blocks = growth(lambda: kept.append(np.zeros(100)), 200)
        self.assertGreater(n_bytes, 100 * 8 - 1)
        self.assertGreater(n_blocks, 0.9)

    def test_solving_and_its_arrays(self):
        joint = vrda.Joint(KNEE)

        def act():
            solved = joint.solve(flexion=[0, 5], loads={"moment_nmm": 100})
            return solved.X_reference_moving[0], solved.status, solved.tension, joint.moving_vertices

        self.check(act, 300)

    def test_joints(self):
        n_bytes, n_blocks = growth(lambda: vrda.Joint(KNEE).solve(0).internal, 8)
        self.assertLess(n_bytes, 20000)  # a joint has megabytes; the allocator's thread caches differ by some kilobytes
        self.assertLess(n_blocks, 10)

    def test_errors(self):
        joint = vrda.Joint(KNEE)

        def act():
            for refused in (lambda: joint.solve(np.nan), lambda: vrda.Job(KNEE, set={"side": "top"}), lambda: joint.solve(0, seed=np.eye(3))):
                try:
                    refused()
                except vrda.InputError:
                    pass

        self.check(act, 200)

    def test_runs_and_reading(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder, "knee.h5")
            job = vrda.Job(KNEE, set=COARSE)

            def act():
                job.run(file, progress=lambda done, total: None)
                vrda.validate(file)

            n_bytes, n_blocks = growth(act, 20)
            # A thread of each call leaves its arena, which the next one takes: a few bytes either way.
            self.assertLess(n_bytes, 2000)
            self.assertLess(n_blocks, self.BLOCKS)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
