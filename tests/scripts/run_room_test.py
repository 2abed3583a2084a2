"""scripts/run_room with a program that behaves like GoogleTest."""
import os
import pathlib
import stat
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree as ElementTree

SCRIPT = pathlib.Path(__file__).parents[2] / "scripts" / "run_room"
PROGRAM = """#!/usr/bin/python3
import os, sys, time
if "--gtest_list_tests" in sys.argv:
    print("Running main() from gtest_main.cc\\nA.\\n  Good\\n  Bad\\n  Crash\\n  Hang\\n  DISABLED_Limit\\nRow/B.\\n  Skip/0  # GetParam() = 7")
    sys.exit()
flags = next(a.split("=", 1)[1] for a in sys.argv if a.startswith("--gtest_flagfile="))
wanted = open(flags).read().strip().split("=", 1)[1].split(":")
failed = False
for name in wanted:
    print(f"[ RUN      ] {name}", flush=True)
    if name == "A.Crash":
        os.abort()
    if name == "A.Hang":
        time.sleep(600)
    if name == "A.Bad":
        print("b.cpp:7: Failure")
        failed = True
    mark = {"A.Bad": "  FAILED  ", "Row/B.Skip/0": "  SKIPPED "}.get(name, "       OK ")
    print(f"no end of line[{mark}] {name} (1500 ms)", flush=True)
sys.exit(failed)
"""


class RunRoomTests(unittest.TestCase):
    def run_room(self, *options, tests="", program=PROGRAM):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder, "program")
            path.write_text(program)
            path.chmod(path.stat().st_mode | stat.S_IXUSR)
            done = subprocess.run([sys.executable, SCRIPT, path, "a", pathlib.Path(folder, "sub", "a.xml"), *options],
                                  capture_output=True, text=True, env={**os.environ, "VRDA_TESTS": tests})
            cases = ElementTree.parse(pathlib.Path(folder, "sub", "a.xml")).getroot().findall("testcase")
        return done, {case.get("name"): case for case in cases}

    def test_each_test_has_a_case_and_a_crash_or_a_hang_hides_no_other(self):
        done, cases = self.run_room("--timeout", "2")
        self.assertEqual({name: case.get("status") for name, case in cases.items()},
                         {"a.A.Good": "run", "a.A.Bad": "fail", "a.A.Crash": "fail", "a.A.Hang": "fail",
                          "a.Row/B.Skip/0": "notrun", "a.A.DISABLED_Limit": "disabled"})
        self.assertEqual(done.returncode, 1)
        self.assertEqual(cases["a.A.Good"].get("time"), "1.500")
        self.assertIn("b.cpp:7", cases["a.A.Bad"].findtext("system-out"))
        self.assertIn("exit code -6", cases["a.A.Crash"].findtext("system-out"))
        self.assertIn("2 s", cases["a.A.Hang"].findtext("system-out"))

    def test_names_select(self):
        done, cases = self.run_room(tests=r"^a\.A\.G|Skip")
        self.assertEqual((done.returncode, sorted(cases)), (0, ["a.A.Good", "a.Row/B.Skip/0"]))

    def test_shards_share_the_tests(self):
        first, second = (set(self.run_room("--timeout", "2", "--shard", f"{n}/2")[1]) for n in (1, 2))
        self.assertFalse(first & second)
        self.assertEqual(len(first | second), 6)

    def test_a_program_that_runs_nothing_has_failed(self):
        end = PROGRAM.replace("failed = False", "sys.exit(3)")
        done, cases = self.run_room(tests="Good", program=end)
        self.assertEqual((done.returncode, cases["a.A.Good"].get("status")), (1, "fail"))


if __name__ == "__main__":
    unittest.main()
