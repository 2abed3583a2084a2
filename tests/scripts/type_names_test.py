"""No two types of one program have the same qualified name: that would be undefined behaviour.

Types are listed by universal-ctags. Types in anonymous namespaces are local to a file and exempt, and so are the rooms
`app`, of which each program has its own.
"""
import collections
import json
import pathlib
import subprocess
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]


def types_of(*folders):
    """Qualified name: files that define it, for classes, structs, unions and enumerations."""
    command = ["ctags", "-R", "--languages=C++", "--kinds-C++=cgsu", "--fields=+Zs", "--output-format=json", "-f", "-"]
    tags = subprocess.run([*command, *map(str, folders)], cwd=ROOT, check=True, capture_output=True, text=True).stdout
    found = collections.defaultdict(list)
    for line in tags.splitlines():
        tag = json.loads(line)
        scope = tag.get("scope", "")
        if tag["_type"] == "tag" and "__anon" not in scope + tag["name"]:
            found[f"{scope}::{tag['name']}"].append(tag["path"])
    return found


class TypeNames(unittest.TestCase):
    def check_program(self, *folders):
        types = types_of(*folders)
        self.assertGreater(len(types), 300)
        self.assertEqual({name: files for name, files in types.items() if len(files) > 1}, {})

    def test_vrda(self):
        self.check_program("pipeline")

    def test_vrda_player(self):
        rooms = [folder for folder in (ROOT / "pipeline").iterdir() if folder.is_dir() and folder.name != "app"]
        self.check_program("player", *rooms)

    def test_every_file_opens_the_namespace_of_its_room(self):
        wrong = []
        for program in ("pipeline", "player"):
            for file in (ROOT / program).glob("*/*.[ch]pp"):
                room = file.parent.name
                lines = [line for line in file.read_text().splitlines() if line.startswith("namespace vrda")]
                wanted = f"namespace vrda::{'inline ' * (room in ('core', 'model'))}{room}"
                if lines and not any(line.startswith(wanted) for line in lines):
                    wrong.append(f"{file.relative_to(ROOT)}: found {lines[0]}, wanted {wanted}")
        self.assertEqual(wrong, [])


if __name__ == "__main__":
    unittest.main()
