"""scripts/check_syntax on a small build."""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

SCRIPT = pathlib.Path(__file__).parents[2] / "scripts" / "check_syntax"


class CheckSyntaxTests(unittest.TestCase):
    def check(self, **sources):
        """Exit code and output; sources named built_* have an object file."""
        with tempfile.TemporaryDirectory() as folder:
            entries = []
            for name, text in sources.items():
                source, target = pathlib.Path(folder, f"{name}.cpp"), pathlib.Path(folder, f"{name}.o")
                source.write_text(text)
                if name.startswith("built_"):
                    target.touch()
                entries.append({"directory": folder, "file": str(source),
                                "command": f"ccache /usr/bin/clang++-14 -Wall -Werror -o {target} -c {source}"})
            pathlib.Path(folder, "compile_commands.json").write_text(json.dumps(entries))
            done = subprocess.run([sys.executable, SCRIPT, folder], capture_output=True, text=True)
            self.assertFalse(list(pathlib.Path(folder).glob("good*.o")))
        return done.returncode, done.stdout

    def test_only_what_is_not_built_is_parsed(self):
        code, text = self.check(built_bad="not C++", good="int main() {}")
        self.assertEqual((code, text.splitlines()[-1]), (0, "1 sources parsed, 0 refused"))

    def test_a_warning_refuses(self):
        code, text = self.check(good="int main() {}", bad="void f() { int unused; }")
        self.assertEqual(code, 1)
        self.assertIn("unused variable", text)

    def test_nothing_to_parse_is_a_failure(self):
        self.assertEqual(self.check(built_all="int main() {}")[0], 1)


if __name__ == "__main__":
    unittest.main()
