"""Ctrl-C during a run, a comparison and a row of attitudes. usage: interrupt_test.py VRDA"""
import hashlib
import logging
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import numpy as np

import vrda
from support import COARSE, KNEE, VRDA

FINE = {"grid.flexion": {"from": 0, "to": 90, "step": 3}}  # 31 x 21 attitudes: a second


def press_later(seconds):
    threading.Timer(seconds, os.kill, (os.getpid(), signal.SIGINT)).start()


class Interrupt(unittest.TestCase):
    def test_a_run_ends_and_resumes_to_the_same_bytes(self):
        with tempfile.TemporaryDirectory() as folder:
            broken, whole = pathlib.Path(folder, "broken.h5"), pathlib.Path(folder, "whole.h5")
            pressed = []

            def press(done, total):
                if done > 3 and not pressed:
                    pressed.append(done)
                    os.kill(os.getpid(), signal.SIGINT)

            job = vrda.Job(KNEE, set=FINE | {"grid.varus": {"from": -4, "to": 4, "step": 1}})
            with self.assertRaises(KeyboardInterrupt):
                job.run(broken, progress=press)
            self.assertTrue(pressed)
            self.assertFalse(broken.exists())
            self.assertTrue(pathlib.Path(f"{broken}.journal").exists())
            counts = []
            job.run(broken, progress=lambda *now: counts.append(now))
            self.assertGreaterEqual(counts[0][0], pressed[0])
            job.run(whole)
            self.assertEqual(*(hashlib.sha256(file.read_bytes()).hexdigest() for file in (broken, whole)))

    def test_an_error_of_the_progress_ends_the_run(self):
        def fail(done, total):
            raise ZeroDivisionError

        with tempfile.TemporaryDirectory() as folder, self.assertRaises(ZeroDivisionError):
            vrda.Job(KNEE, set=COARSE).run(pathlib.Path(folder, "knee.h5"), progress=fail)

    def test_rows_end_between_two_of_them(self):
        joint = vrda.Joint(KNEE)
        press_later(0.2)
        begin = time.monotonic()
        with self.assertRaises(KeyboardInterrupt):
            joint.solve(flexion=np.tile(np.linspace(0, 90, 91), 200))
        self.assertLess(time.monotonic() - begin, 3.0)
        self.assertEqual(joint.solve(0).status[0], "stable")

    def test_a_comparison_ends_before_its_next_measurement(self):
        with tempfile.TemporaryDirectory() as folder:
            file = vrda.Job(KNEE, set=FINE | {"grid.varus.step": 5}).run(pathlib.Path(folder, "knee.h5"))
            press_later(0.5)
            with self.assertRaises(KeyboardInterrupt):
                vrda.compare(file, refine=4)
            self.assertEqual(vrda.validate(file), [])

    def test_an_interrupt_during_a_message_is_not_lost(self):
        class Press(logging.Handler):
            def emit(self, record):
                logger.removeHandler(self)
                os.kill(os.getpid(), signal.SIGINT)

        logger = logging.getLogger("vrda")
        with tempfile.TemporaryDirectory() as folder:
            job = vrda.Job(KNEE, set=FINE | {"grid.varus.step": 5})  # a warning first: the grid is too small for degree 6
            logger.addHandler(Press())
            with self.assertRaises(KeyboardInterrupt):
                job.run(pathlib.Path(folder, "knee.h5"))
            self.assertEqual(logger.handlers, [])

    def test_a_preparation_ends_with_nothing_written_and_leaves_python_its_handler(self):
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run([VRDA, "shape", "knee-template", "-o", f"{folder}/scan"], check=True, capture_output=True)
            press_later(0.5)
            with self.assertRaises(KeyboardInterrupt):
                vrda.prepare(f"{folder}/knee", femur=f"{folder}/scan/femur.stl", tibia=f"{folder}/scan/tibia.stl")
            self.assertFalse(pathlib.Path(folder, "knee/knee.toml").exists())
            with self.assertRaises(KeyboardInterrupt):
                os.kill(os.getpid(), signal.SIGINT)
                time.sleep(5)

    def test_the_handler_of_python_stays(self):
        before = signal.getsignal(signal.SIGINT)
        with tempfile.TemporaryDirectory() as folder:
            vrda.Job(KNEE, set=COARSE).run(pathlib.Path(folder, "knee.h5"))
        self.assertIs(signal.getsignal(signal.SIGINT), before)
        with self.assertRaises(KeyboardInterrupt):
            os.kill(os.getpid(), signal.SIGINT)
            time.sleep(5)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
