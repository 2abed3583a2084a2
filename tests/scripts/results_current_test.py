"""Every page of results/ was made with today's solvers, jobs and meshes, and is what its record gives.

usage: results_current_test.py VRDA VRDA_PLAYER
The program says which versions and keys are today's; meshes that are missing are not compared.
"""
import json
import pathlib
import subprocess
import sys
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
import result_pages as results  # noqa: E402
from pages import calibration  # noqa: E402

VRDA, PLAYER = sys.argv.pop(1), sys.argv.pop(1)


class ResultsAreCurrent(unittest.TestCase):
    maxDiff = None

    def test_every_page_has_a_command_and_a_record(self):
        self.assertEqual(results.pages_on_disk(), sorted(page.path for page in results.PAGES.values()))
        self.assertEqual([name for name, page in results.PAGES.items()
                          if not results.record_path(name).is_file() and not page.is_long], [])

    def test_no_page_is_stale(self):
        today = results.Today(VRDA)
        self.assertEqual([line for name in results.PAGES for line in results.stale(name, today)], [])

    def test_the_calibration_still_gives_its_sample(self):
        options = ("calibrate", "all", "--virtual", "--headless", "--benches", "2", "--json")
        done = subprocess.run([PLAYER, *options], capture_output=True, text=True, check=True)
        found, recorded = calibration.summary(json.loads(done.stdout)), results.read_record("calibration")["numbers"]["sample"]
        for new, old in zip(found["numbers"], recorded["numbers"], strict=True):
            self.assertEqual(new[:5], old[:5])
            for a, b in zip(new[5:], old[5:]):
                self.assertAlmostEqual(a, b, delta=2e-3 * abs(b), msg=f"{new[:2]}: make the page again with scripts/results calibration")


if __name__ == "__main__":
    unittest.main()
