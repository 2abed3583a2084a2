"""scripts/count_tests on JUnit files as CTest writes them."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

SCRIPT = pathlib.Path(__file__).parents[2] / "scripts" / "count_tests"
PASSED = '<testcase name="core.A" status="run"><system-out>quiet</system-out></testcase>'
FAILED = ('<testcase name="core.B" status="fail"><failure message="Failed"/>'
          "<system-out>b.cpp:7: Failure\n1 &lt; 2</system-out></testcase>")
SKIPPED = ('<testcase name="load.Knee" status="notrun"><skipped message="SKIP_REGULAR_EXPRESSION_MATCHED"/>'
           "<system-out/></testcase>")
NOT_STARTED = '<testcase name="core_NOT_BUILT" status="notrun"><skipped message="Unable to find executable"/></testcase>'
DISABLED = '<testcase name="core.Limit" status="disabled"><skipped message="Disabled"/></testcase>'


class CountTests(unittest.TestCase):
    def count(self, *suites, options=()):
        """Exit code and lines for one JUnit file per suite."""
        with tempfile.TemporaryDirectory() as folder:
            paths = []
            for number, cases in enumerate(suites):
                paths.append(pathlib.Path(folder, f"{number}.xml"))
                paths[-1].write_text(f'<?xml version="1.0"?><testsuite>{cases}</testsuite>')
            done = subprocess.run([sys.executable, SCRIPT, *options, *paths], capture_output=True, text=True)
        return done.returncode, done.stdout.splitlines()

    def test_all_is_well(self):
        self.assertEqual(self.count(PASSED * 2), (0, ["2 passed, 0 failed, 0 skipped"]))

    def test_a_failure_shows_its_output_and_name(self):
        code, lines = self.count(PASSED + FAILED)
        self.assertEqual(code, 1)
        self.assertEqual(lines[-1], "1 passed, 1 failed, 0 skipped")
        self.assertEqual(lines[-2], "failed: core.B")
        self.assertIn("1 < 2", lines)
        self.assertNotIn("quiet", lines)

    def test_skips_are_named_and_fail_only_on_request(self):
        wanted = ["skipped: load.Knee", "1 passed, 0 failed, 1 skipped"]
        self.assertEqual(self.count(PASSED + SKIPPED), (0, wanted))
        self.assertEqual(self.count(PASSED + SKIPPED, options=["--no-skips"]), (1, wanted))

    def test_a_program_that_is_not_there_is_a_failure(self):
        code, lines = self.count(PASSED + NOT_STARTED)
        self.assertEqual((code, lines[-1]), (1, "1 passed, 1 failed, 0 skipped"))
        self.assertIn("Unable to find executable", lines[0])

    def test_a_known_limit_is_named_and_not_counted(self):
        self.assertEqual(self.count(PASSED + DISABLED, options=["--no-skips"]),
                         (0, ["disabled: core.Limit", "1 passed, 0 failed, 0 skipped"]))

    def test_a_room_is_replaced_by_its_tests(self):
        room = '<testcase name="room.core.1" status="run" time="3"/>'
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder, "tests.xml")
            path.write_text(f"<testsuite>{room}</testsuite>")
            rooms = pathlib.Path(folder, "rooms")
            rooms.mkdir()
            pathlib.Path(rooms, "room.core.1.xml").write_text(f"<testsuite>{PASSED}{FAILED}{SKIPPED}</testsuite>")
            done = subprocess.run([sys.executable, SCRIPT, path], capture_output=True, text=True)
        self.assertEqual(done.returncode, 1)
        self.assertEqual(done.stdout.splitlines()[-1], "1 passed, 1 failed, 1 skipped")

    def test_a_room_without_its_file_has_failed(self):
        self.assertEqual(self.count('<testcase name="room.core.1" status="run" time="3"/>')[1][-1],
                         "0 passed, 1 failed, 0 skipped")

    def test_the_slowest_are_named(self):
        cases = "".join(f'<testcase name="core.T{n}" status="run" time="{n}"/>' for n in range(30))
        lines = self.count(cases)[1]
        self.assertEqual([line.split()[-1] for line in lines[:-1]], [f"core.T{n}" for n in range(29, 9, -1)])

    def test_no_test_is_a_failure(self):
        self.assertEqual(self.count(""), (1, ["0 passed, 0 failed, 0 skipped"]))
        self.assertEqual(self.count(SKIPPED)[0], 1)

    def test_several_files_are_added_up(self):
        self.assertEqual(self.count(PASSED, PASSED + SKIPPED)[1][-1], "2 passed, 0 failed, 1 skipped")


if __name__ == "__main__":
    unittest.main()
