"""The example of the package runs unchanged, and is short. usage: example_test.py VRDA"""
import pathlib
import subprocess
import sys
import tempfile
import unittest

from support import KNEE, ROOT

EXAMPLE = ROOT / "pipeline/python/examples/knee.py"


class Example(unittest.TestCase):
    def test_it_solves_a_knee_and_plots_screw_home_and_laxity(self):
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run([sys.executable, EXAMPLE, KNEE], cwd=folder, capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode, 0, done.stderr)
            last = done.stdout.splitlines()[-1].split()
            self.assertEqual(last[1], "stable")
            self.assertGreater(float(last[2]), 1.0)
            picture = pathlib.Path(folder, "knee.png").read_bytes()
            self.assertTrue(picture.startswith(b"\x89PNG"))
            self.assertGreater(len(picture), 20000)

    def test_it_has_twenty_lines(self):
        lines = [line for line in EXAMPLE.read_text(encoding="utf-8").splitlines() if line and not line.startswith("#")]
        self.assertLessEqual(len(lines), 20)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
