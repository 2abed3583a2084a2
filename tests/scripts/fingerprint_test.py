"""scripts/fingerprint on one job: the same lines twice, and --compare names what differs.

usage: fingerprint_test.py BUILD
"""
import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = sys.argv.pop()


def fingerprint(*words):
    return subprocess.run([sys.executable, ROOT / "scripts/fingerprint", *words], capture_output=True, text=True, check=False)


class Fingerprint(unittest.TestCase):
    def test_one_program_gives_one_list_and_changes_are_named(self):
        with tempfile.TemporaryDirectory(prefix="vrda-fingerprint-test-") as folder:
            lists = [pathlib.Path(folder) / name for name in ("before", "after")]
            for file in lists:
                done = fingerprint("--quick", "--build", BUILD, "--only", "ball-in-dish", "-o", str(file))
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertNotIn("missing", done.stderr)
            lines = lists[0].read_text(encoding="utf-8").splitlines()
            for part in ("model/", "trace/", "journal/", "export/", "show/", "report/", "said/read/"):
                self.assertTrue([line for line in lines if line.split("  ")[1].startswith(part)], part)
            same = fingerprint("--compare", *map(str, lists))
            self.assertEqual((same.returncode, same.stdout), (0, f"{len(lines)} equal, 0 not\n"))
            changed = lines[5].split("  ")[1]
            lists[1].write_text("\n".join([*lines[:5], "0" * 64 + "  " + changed, *lines[7:], "0  new"]) + "\n", encoding="utf-8")
            found = fingerprint("--compare", *map(str, lists))
            self.assertEqual(found.returncode, 1)
            self.assertEqual(sorted(found.stdout.splitlines()[:3]),
                             sorted([f"differs  {changed}", "missing  " + lines[6].split("  ")[1], "new  new"]))


unittest.main()
