"""scripts/setup: its calls of apt, and the reason it reports on failure."""
import unittest

from fake_machine import FakeMachine


class Setup(unittest.TestCase):
    def fails(self, machine, *reasons):
        """The script fails, and the first line of its error contains these texts."""
        done = machine.run("setup")
        self.assertNotEqual(done.returncode, 0)
        first = done.stderr.splitlines()[0]
        self.assertTrue(first.startswith("setup: "), first)
        for reason in reasons:
            self.assertIn(reason, first)
        return done

    def test_nothing_missing_means_no_apt_and_no_word(self):
        with FakeMachine() as machine:
            done = machine.run("setup")
            self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "", ""))
            self.assertEqual(machine.calls("apt-get") + machine.calls("sudo"), [])

    def test_only_what_is_missing_is_installed(self):
        with FakeMachine() as machine:
            machine.installed("beta")
            done = machine.run("setup")
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(len(done.stdout.splitlines()), 1)
            update, install = machine.calls("apt-get")
            self.assertTrue(update.endswith(" update"), update)
            self.assertTrue(install.endswith(" install --yes --no-install-recommends alpha gamma"), install)

    def test_a_part_alone(self):
        with FakeMachine() as machine:
            machine.installed("alpha")
            self.assertEqual(machine.run("setup", "programs").returncode, 0)
            self.assertTrue(machine.calls("apt-get")[-1].endswith(" beta"))
            done = machine.run("setup", "programs", "sorts")
            self.assertEqual(done.returncode, 2)
            self.assertRegex(done.stderr, r"'sorts'.*\bprograms tests\b")

    def test_a_failed_update_is_forgiven_when_the_installation_works(self):
        with FakeMachine() as machine:
            machine.installed()
            machine.fake("apt-get", '[[ $* != *update ]]')
            self.assertEqual(machine.run("setup").returncode, 0)

    def test_reasons_of_apt(self):
        rows = (("E: Failed to fetch http://x  Temporary failure resolving 'x'", "no network"),
                ("E: Unable to locate package alpha", "alpha is not known to apt"),
                ("E: You don't have enough free space in /var/cache/apt/archives/.", "disk is full"),
                ("E: Could not get lock /var/lib/dpkg/lock-frontend", "another program is installing"),
                ("E: dpkg was interrupted, you must manually run", "dpkg --configure -a"),
                ("reading\nE: Something else\nlast", "E: Something else"))
        for said, reason in rows:
            with self.subTest(reason), FakeMachine() as machine:
                machine.installed()
                machine.fake("apt-get", f'printf "%s\\n" "{said}"; exit 100')
                done = self.fails(machine, reason)
                self.assertIn("build/logs/setup.log", done.stderr)
                self.assertIn(said.splitlines()[0], done.stderr)

    def test_not_root(self):
        with FakeMachine() as machine:
            machine.installed("alpha")
            machine.fake("id", "echo 1000")
            self.fails(machine, "not root", "sudo is not installed", "as root run: apt-get install --no-install-recommends beta gamma")
            machine.fake("sudo", "exit 1")
            self.fails(machine, "password", "no terminal", "as root run: apt-get install")
            machine.fake("sudo", '[[ $1 == -n ]] && shift; "$@"')
            machine.fake("true", ":")
            self.assertEqual(machine.run("setup").returncode, 0)
            self.assertIn("env LC_ALL=C DEBIAN_FRONTEND=noninteractive apt-get", machine.calls("sudo")[-1])

    def test_npm_packages_are_installed_when_missing_and_when_the_lock_changes(self):
        with FakeMachine() as machine:
            lock = machine.write("player/web/package-lock.json", "one")
            machine.fake("npm", "mkdir -p player/web/node_modules")
            for text, n_calls in (("one", 1), ("one", 1), ("two", 2), ("two", 2)):
                lock.write_text(text)
                done = machine.run("setup")
                self.assertEqual((done.returncode, done.stderr), (0, ""))
                self.assertEqual(len(machine.calls("npm ci --prefix player/web --ignore-scripts")), n_calls)
            self.assertEqual(machine.calls("apt-get"), [])
            # Those of the tests with the part tests, which is in the default; without it they need not be there.
            self.assertEqual(len(machine.calls("npm ci --prefix player/web --ignore-scripts --no-audit --no-fund --omit=dev")), 0)
            self.assertEqual(machine.run("setup", "programs").returncode, 0)
            self.assertEqual(len(machine.calls("npm")), 2)
            lock.write_text("three")
            self.assertEqual(machine.run("setup", "tests").returncode, 0)
            self.assertEqual(len(machine.calls("npm")), 2)

    def test_npm_packages_of_the_tests_are_added_on_request(self):
        with FakeMachine() as machine:
            machine.write("player/web/package-lock.json", "one")
            machine.fake("npm", "rm -rf player/web/node_modules; mkdir -p player/web/node_modules")
            for parts, n_calls, is_lean in ((["programs"], 1, True), (["programs"], 1, True), (["programs", "tests"], 2, False), (["programs", "tests"], 2, False)):
                self.assertEqual(machine.run("setup", *parts).returncode, 0)
                self.assertEqual(len(machine.calls("npm")), n_calls)
                self.assertEqual("--omit=dev" in machine.calls("npm")[-1], is_lean)

    def test_reasons_of_npm(self):
        for said, reason in (("npm error code EAI_AGAIN", "no network: the npm registry"),
                             ("npm ERR! code SELF_SIGNED_CERT_IN_CHAIN", "npm does not trust the certificate"),
                             ("npm error: something else", "something else")):
            with self.subTest(reason), FakeMachine() as machine:
                machine.write("player/web/package-lock.json", "one")
                machine.fake("npm", f'printf "%s\n" "{said}"; exit 1')
                done = self.fails(machine, "installing npm packages", reason)
                self.assertIn("build/logs/npm.log", done.stderr)
                machine.fake("npm", "mkdir -p player/web/node_modules")
                self.assertEqual(machine.run("setup").returncode, 0)

    def test_an_npm_of_another_maker_is_good(self):
        with FakeMachine() as machine:
            machine.write("scripts/packages.txt", "[programs]\nalpha\nnpm\n[tests]\n")
            machine.installed("alpha")
            self.assertEqual(machine.run("setup").returncode, 0)
            self.assertTrue(machine.calls("apt-get")[-1].endswith(" npm"))
            machine.log.unlink()
            machine.fake("npm", ":")
            self.assertEqual(machine.run("setup").returncode, 0)
            self.assertEqual(machine.calls("apt-get"), [])

    def test_not_debian(self):
        with FakeMachine() as machine:
            (machine.bin / "apt-get").unlink()
            self.fails(machine, "not Debian", "wanted Debian 12")


if __name__ == "__main__":
    unittest.main()
