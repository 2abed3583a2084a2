"""scripts/pages/validation.py on records in the form of the tests."""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

SCRIPT = pathlib.Path(__file__).parents[2] / "scripts" / "pages" / "validation.py"


def a_property(test, seed, **more):
    """One line of tests/validation."""
    return {"test": test, "scene": f"scene of {test}", "claim": "ends in the middle", "measure": "mm", "seed": seed, "allowed": 2.0,
            "cases": 1200, "failures": 0, "worst": 1.23456, "outcomes": {"stable": 1199, "no_contact": 1}, **more}


def an_oracle(scene, **more):
    """One line of tests/oracle."""
    return {"oracle": scene, "seed": 501, "poses": 3000, "colliding": 1400, "near": 1800, "disagreeing": 7, "farthest_mm": 1.5e-13,
            "fcl_wrong": 6, "textbook_wrong": 1, "we_wrong": 0, **more}


def a_trace(status="stable"):
    """`vrda trace --json` of a job of the repository."""
    search = {"node": "spine", "status": status, "in_contact": 9, "by_kind": {"translate": 5, "rotate": 3},
              "end": {"translation_mm": [-0.001, 19.0, 0.02], "theta_deg": -0.01}}
    return {"title": "Ball in a dish", "searches": [{**search, "node": "spine_probe"}, search]}


class ValidationPage(unittest.TestCase):
    def page(self, release, asan=None, traces=None):
        """Completed process for these records."""
        with tempfile.TemporaryDirectory() as folder:
            for name, lines in (("release", release), ("asan", asan)):
                if lines is None:
                    continue
                pathlib.Path(folder, name).mkdir()
                for k, line in enumerate(lines):
                    pathlib.Path(folder, name, f"{k}.jsonl").write_text(json.dumps(line) + "\n")
            for name, trace in (traces or {}).items():
                pathlib.Path(folder, "release", f"{name}.trace.json").write_text(json.dumps(trace))
            return subprocess.run([sys.executable, SCRIPT, folder], capture_output=True, text=True)

    def test_a_row_a_property_by_seed(self):
        done = self.page([a_property("B", 7), a_property("A", 9, failures=2, worst=None), a_property("C", 3)])
        self.assertEqual(done.returncode, 0, done.stderr)
        rows = [line for line in done.stdout.splitlines() if "scene of" in line]
        self.assertEqual(rows[1], "| scene of B | ends in the middle | stable 1199, no_contact 1 | mm | 1,200 | 7 | 1.23 | 2 | 0 |")
        self.assertTrue(rows[0].startswith("| scene of C ") and rows[2].endswith("| 9 | none | 2 | 2 |"), rows)
        self.assertIn("3,600 cases, 2 failures.", done.stdout)
        self.assertNotIn("FCL", done.stdout)

    def test_the_sanitizers_hold_what_has_the_same_record(self):
        both = [a_property("A", 1), an_oracle("knee")]
        self.assertIn("Not yet run under", self.page(both).stdout)
        self.assertIn("2 of 2 rows of the two tables.\n", self.page(both, both).stdout)
        other = self.page(both, [a_property("A", 1, worst=1.3), an_oracle("knee")]).stdout
        self.assertIn("1 of 2 rows of the two tables. Failed, or with different numbers: A.", other)

    def test_the_oracle_has_a_table_of_its_own(self):
        done = self.page([a_property("A", 1), an_oracle("knee"), an_oracle("hip")])
        self.assertIn("| hip | 3,000 | 501 | 1,400 | 1,800 | 7 | 1.5e-13 | 6 | 1 | 0 |", done.stdout)
        self.assertIn("6,000 poses.", done.stdout)

    def test_a_job_has_its_picture_and_what_happened(self):
        done = self.page([a_property("A", 1)], traces={"ball-in-dish": a_trace()})
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("![Ball in a dish, before and after](pictures/validation-ball-in-dish.png)", done.stdout)
        self.assertIn("to (0.00, 0.02) mm, rotated by 0.0 degrees, moves in contact 9, translations 5, rotations 3. End: `stable`", done.stdout)
        through = self.page([a_property("A", 1)], traces={"peg-in-hole": a_trace("no_contact")}).stdout
        self.assertIn("End: `no_contact`", through)

    def test_the_knee_has_its_totals(self):
        knee = {**a_trace(), "all": {"moves": 1234, "by_kind": {"approach": 1200, "rotate": 34}, "in_contact": 1100, "cycles": 7,
                                     "blocked_trials": 0}}
        done = self.page([a_property("A", 1)], traces={"knee-trace": knee})
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("2 searches, 2 `stable`; 1,234 moves (approach 1,200, rotate 34), 1,100 of them in contact, 7 cycles", done.stdout)

    def test_no_record_is_an_error(self):
        done = self.page([])
        self.assertEqual((done.returncode, done.stdout), (1, ""))
        self.assertEqual(len(done.stderr.splitlines()), 1)


if __name__ == "__main__":
    unittest.main()
