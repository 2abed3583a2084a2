"""scripts/quickstart with fake programs: order, output, second run, failures."""
import os
import re
import unittest

from fake_machine import FakeMachine

# Fake cmake: configuring creates build.ninja, building creates the two programs.
CMAKE = r"""
if [[ $1 == --preset ]]; then mkdir -p build/release; touch build/release/build.ninja; exit; fi
[[ -e build/release/vrda ]] && exit
for program in vrda vrda-player; do cp "${0%/*}/fake-$program" "build/release/$program"; done
"""


class Quickstart(unittest.TestCase):
    def machine(self):
        """A machine on which all steps succeed."""
        machine = self.enterContext(FakeMachine())
        machine.write("jobs/knee-generic.toml", "title\n")
        machine.fake("cmake", CMAKE)
        machine.fake("fake-vrda", 'echo model >"$4"')
        machine.fake("fake-vrda-player", 'touch "$4/flexion-000.png"')
        return machine

    def test_says_where_everything_is_in_few_lines(self):
        machine = self.machine()
        done = machine.run("quickstart", cwd=machine.checkout / "jobs")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertLess(len(done.stdout.splitlines()), 20)
        self.assertIn("Motion model  ../results/knee-generic/knee-generic.h5", done.stdout)
        self.assertIn("../build/release/vrda info ../results/knee-generic/knee-generic.h5", done.stdout)
        self.assertTrue((machine.checkout / "results/knee-generic/pictures/flexion-000.png").is_file())
        self.assertIn("cmake --preset release -DVRDA_TESTS=OFF", machine.calls("cmake"))
        self.assertEqual(machine.calls("fake-vrda "),
                         ["fake-vrda run jobs/knee-generic.toml -o results/knee-generic/knee-generic.h5 --progress none"])

    def test_paths_of_another_folder_can_be_pasted(self):
        machine = self.machine()
        done = machine.run("quickstart")
        path = re.search(r"^Motion model +(.*)$", done.stdout, re.MULTILINE).group(1)
        self.assertIn(r"a\ check\ out", path)

    def test_the_second_run_keeps_the_configuration_and_solves_nothing(self):
        machine = self.machine()
        machine.run("quickstart")
        done = machine.run("quickstart")
        self.assertEqual(done.returncode, 0)
        self.assertEqual(len(machine.calls("fake-vrda run")), 1)
        self.assertEqual(machine.calls("cmake")[2], "cmake --preset release")

    def test_python_is_built_if_wanted(self):
        machine = self.machine()
        machine.write("scripts/packages.txt", "[programs]\nalpha\n[python]\nomega\n")
        done = machine.run("quickstart", "--python")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertEqual(machine.calls("cmake")[0], "cmake --preset release -DVRDA_TESTS=OFF -DVRDA_PYTHON=ON")
        self.assertTrue(machine.calls("cmake")[1].endswith(" vrda_python"))
        self.assertIn("omega", machine.calls("apt-get")[-1])
        self.assertIn("build/release/python python3 -c", done.stdout)

    def test_a_changed_job_is_solved_again(self):
        machine = self.machine()
        machine.run("quickstart")
        future = machine.checkout.stat().st_mtime + 100
        os.utime(machine.checkout / "jobs/knee-generic.toml", (future, future))
        machine.run("quickstart")
        self.assertEqual(len(machine.calls("fake-vrda run")), 2)

    def test_one_reason_for_a_failed_build(self):
        machine = self.machine()
        machine.fake("cmake", '[[ $1 == --preset ]] || { echo "[1/2] x"; echo "a.cpp:3:1: error: no type"; exit 1; }')
        done = machine.run("quickstart")
        self.assertEqual(done.returncode, 1)
        self.assertRegex(done.stderr.splitlines()[0], r"^quickstart: .*\bvrda-player\b.*: a\.cpp:3:1: error: no type$")
        self.assertIn("build/logs/build.log", done.stderr)
        self.assertNotIn("Motion model", done.stdout)

    def test_the_programs_own_message_and_exit_code(self):
        machine = self.machine()
        machine.fake("fake-vrda", 'echo "vrda: error: job: found 3" >&2; exit 2')
        done = machine.run("quickstart")
        self.assertEqual(done.returncode, 2)
        self.assertTrue(done.stderr.splitlines()[0].endswith("vrda: error: job: found 3"), done.stderr)

    def test_arguments_are_refused(self):
        done = self.machine().run("quickstart", "--fast")
        self.assertEqual(done.returncode, 2)
        self.assertIn("'--fast'", done.stderr)


if __name__ == "__main__":
    unittest.main()
