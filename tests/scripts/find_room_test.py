"""scripts/find_room: the words of the two programs' READMEs name the rooms of functions."""
import pathlib
import subprocess
import sys
import unittest

SCRIPT = pathlib.Path(__file__).parents[2] / "scripts" / "find_room"


def find_room(*arguments):
    """Exit code, output and messages."""
    done = subprocess.run([sys.executable, SCRIPT, *arguments], capture_output=True, text=True)
    return done.returncode, done.stdout, done.stderr


class FindRoomTests(unittest.TestCase):
    def test_most_functions(self):
        """0.76 when the rows were written: less means that a README no longer says what its rooms hold."""
        code, out, _ = find_room("--at-least", "0.7")
        self.assertEqual(code, 0, out)
        self.assertEqual(find_room("--at-least", "1")[0], 1)

    def test_one_function(self):
        code, out, _ = find_room("find_contacts")
        self.assertEqual(code, 0, out)
        self.assertTrue(out.startswith("pipeline/contact: find_contacts: pipeline/contact by "), out)

    def test_unknown_function(self):
        code, _, messages = find_room("no_such_function")
        self.assertEqual(code, 2)
        self.assertIn("no_such_function", messages)


if __name__ == "__main__":
    unittest.main()
