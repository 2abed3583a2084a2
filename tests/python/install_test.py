"""pip installs the package in a virtual environment without network, as schemas/README.md says. usage: install_test.py VRDA

pip builds in build/release, so this is a test of that build only.
"""
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

from support import KNEE, ROOT, VRDA

USE = f"""
import vrda
joint = vrda.Job({str(KNEE)!r}).joint()
print(vrda.__file__, vrda.__version__, joint.dataset(joint.solve(0)).status.values[0])
"""


class Install(unittest.TestCase):
    def test_the_commands_of_the_readme_give_a_package_that_works_anywhere(self):
        examples = (ROOT / "schemas/README.md").read_text(encoding="utf-8")
        commands = re.findall(r"^(?:/usr/bin/python3 -m venv|my-venv/bin/pip) .*$", examples, re.MULTILINE)
        self.assertEqual(len(commands), 2)
        with tempfile.TemporaryDirectory() as folder:
            for command in commands:
                done = subprocess.run(["bash", "-c", command.replace("my-venv", f"{folder}/my-venv")], cwd=ROOT, env={"PATH": "/usr/bin:/bin", "HOME": folder},
                                      capture_output=True, text=True, check=False)
                self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            python = f"{folder}/my-venv/bin/python3"
            used = subprocess.run([python, "-c", USE], cwd="/", env={"PATH": "/usr/bin:/bin"}, capture_output=True, text=True, check=False)
            self.assertEqual(used.returncode, 0, used.stderr)
            file, *rest = used.stdout.split()
            self.assertTrue(pathlib.Path(file).is_relative_to(folder), file)
            version = subprocess.run([VRDA, "--version"], capture_output=True, text=True, check=True).stdout.split()[1]
            self.assertEqual(rest, [version, "stable"])
            listed = subprocess.run([python, "-m", "pip", "show", "--files", "vrda"], capture_output=True, text=True, check=True).stdout
            for name in ("__init__.py", "_core.pyi", "py.typed", "_core.cpython"):
                self.assertIn(f"vrda/{name}", listed)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
