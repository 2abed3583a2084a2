"""scripts/package: what it builds, packs, prints and leaves behind; tests/package checks the packages' contents."""
import hashlib
import unittest

from fake_machine import FakeMachine

# Writes its arguments into the folder given by -B, as cpack does.
CPACK = 'mkdir -p "$4"; echo "$SOURCE_DATE_EPOCH" >"$4/vrda_1_amd64.deb"; echo b >"$4/vrda-1-linux.tar.gz"; echo c >"$4/vrda.json"'


class Package(unittest.TestCase):
    def machine(self):
        machine = self.enterContext(FakeMachine())
        machine.installed("alpha", "beta", "delta")
        machine.fake("cmake", ":")
        machine.fake("git", "echo 1234567890")
        machine.fake("cpack", CPACK)
        return machine

    def test_builds_then_packs_and_names_the_packages(self):
        machine = self.machine()
        machine.write("build/packages/of-an-earlier-version.deb", "old")
        done = machine.run("package", cwd=machine.checkout)
        self.assertEqual(done.returncode, 0, done.stderr)
        kept = {path.name: path.read_bytes() for path in (machine.checkout / "build/packages").iterdir()}
        self.assertEqual(set(kept), {"vrda_1_amd64.deb", "vrda-1-linux.tar.gz"})
        self.assertFalse((machine.checkout / "build/package-work").exists())
        for name, content in kept.items():
            self.assertIn([name, str(len(content)), "bytes", hashlib.sha256(content).hexdigest()],
                          [line.split() for line in done.stdout.splitlines()])
        configured, with_python, built = machine.calls("cmake")
        self.assertEqual(configured, "cmake --preset release -DVRDA_TESTS=OFF")
        self.assertIn("-DVRDA_PYTHON=ON", with_python)
        self.assertIn("--target vrda vrda-player vrda-webcam vrda_python", built)
        self.assertEqual(machine.calls("apt-get"), [])

    def test_the_time_is_the_commits_unless_it_is_given(self):
        machine = self.machine()
        machine.run("package")
        self.assertEqual((machine.checkout / "build/packages/vrda_1_amd64.deb").read_text(), "1234567890\n")
        machine.fake("git", "exit 128")
        changelog = machine.write("CHANGELOG.md", "")
        self.assertEqual(machine.run("package").returncode, 0)
        self.assertEqual(int((machine.checkout / "build/packages/vrda_1_amd64.deb").read_text()), int(changelog.stat().st_mtime))

    def test_what_is_missing_is_installed(self):
        machine = self.machine()
        machine.installed("alpha", "beta")
        self.assertEqual(machine.run("package").returncode, 0)
        self.assertTrue(machine.calls("apt-get")[-1].endswith(" install --yes --no-install-recommends delta"))

    def test_a_failure_is_reported_and_leaves_no_partial_packages(self):
        machine = self.machine()
        machine.fake("cpack", 'echo "CPack Error: no room"; exit 1')
        done = machine.run("package")
        self.assertEqual(done.returncode, 1)
        self.assertRegex(done.stderr, r"\bPacking\b.*\bno room\b")
        self.assertEqual(list((machine.checkout / "build/packages").iterdir()), [])

    def test_an_argument_is_refused(self):
        done = self.machine().run("package", "--fast")
        self.assertEqual((done.returncode, done.stderr), (2, "package: found argument '--fast', wanted none\n"))


if __name__ == "__main__":
    unittest.main()
