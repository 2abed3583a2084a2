"""Names, messages and pages use standard terms: none of the idioms that the glossary replaced. Sources begin with their purpose.

A new idiom is added to IDIOMS; a legitimate use of a listed word to ALLOWED, with its reason.
"""
import pathlib
import re
import subprocess
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
FOLDERS = ["pipeline", "player", "schemas", "jobs", "scripts", "results", "tests", "README.md", "CMakeLists.txt"]
SUFFIXES = {".cpp", ".hpp", ".c", ".h", ".in", ".js", ".mjs", ".html", ".css", ".md", ".toml", ".json", ".py", ".sh", ".txt",
            ".cmake", ""}
EXEMPT = re.compile(r"^tests/scripts/wording_test\.py$|^tests/fuzz/corpus/|node_modules|package-lock\.json")

IDIOMS = [
    r"\banew\b",
    r"\bonce more\b",
    r"\bbegun (before|again|earlier)\b",
    r"\b(is|are) none\b",
    r"\bthere (is|are) none\b",
    r"\btold\b",
    r"\b(some|no)body\b",
    r"\bstands?\b",
    r"\bhand(s|ed|ing)? (over|out|on)\b",
    r"\b(leads?|led|carr(y|ies|ied)) off\b",
    r"\bwanted (is|are)\b",
    r"\ba hair\b",
    r"\bvouch",
    r"\bmischief\b",
    r"\bobstacles?\b",
    r"\bGrip\b",
    r"\bGapSight\b|\blooks_closer\b|\btelling_cells\b|\bhand_out\b|\bhand_over\b|\bSightings\b|\bFooting\b",
    r"\bplaces? of rest\b",
    r"\bof what is perceptible\b",
    r"\bour mistake\b",
    r"\blives? in numbers\b|\bin numbers\b",
    r"\bstills? a move\b",
    r"\bgo(es)? on from\b",
    r"\bspeaks?\b",
    r"\btells? (of|apart|whether|by)\b",
    r"\basked\b",
    r"\bquarrel",
    r"\btalk(s|ed|ing)?\b",
    r"\btroubles?\b",
    r"\bwish(es|ed)?\b",
]
# Of names only; prose may compare "ours" with the thesis.
NAME_IDIOMS = [r"\bours?\b", r"\btells?\b", r"\bbelieved?\b", r"\bgives? up\b"]
ALLOWED = {
    r"\b(is|are) None\b|\bassertIs(Not)?None\b|\.is_none\(\)": "Python's value",
    r"\bstand-offs?\b": "the small distance that the solver keeps, a term of robotics",
    r"\bstands for\b": "plain English for represents",
    r'"trouble\\?"': "key of the JSON of vrda-player devices",
    r"--anew|options\.anew|\.anew\b|\banew = |\banew;": "option of vrda-player calibrate, part of the command line",
    r'"nobody"|user=nobody|nobody:nogroup|-o nobody|as_user\("nobody"\)|"nobody\\n"': "the system's user of that name",
}


ANY_IDIOM = re.compile("|".join(IDIOMS + NAME_IDIOMS), re.I)
NAME = re.compile(r"[A-Za-z]\w+")
END_OF_WORD = re.compile(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])|_")


def names_as_prose(line):
    """The CamelCase and snake_case names of a line, split into words: "TaskIsTold" gives "task is told"."""
    words = (END_OF_WORD.sub(" ", name).lower() for name in NAME.findall(line))
    return "; ".join(name for name in words if " " in name)


def findings(path, text):
    """(path, line, text) of each idiom that is not allowed."""
    for number, line in enumerate(text.splitlines(), 1):
        if not ANY_IDIOM.search(line) and not ANY_IDIOM.search(names_as_prose(line)):
            continue
        rest = line
        for allowed in ALLOWED:
            rest = re.sub(allowed, "", rest)
        names = names_as_prose(rest)
        for idiom in IDIOMS + NAME_IDIOMS:
            is_prose = idiom not in NAME_IDIOMS and re.search(idiom, rest, re.I if idiom.islower() else 0)
            if is_prose or re.search(idiom, names):
                yield f"{path}:{number}: {idiom}: {line.strip()[:120]}"


SOURCE = re.compile(r"^(pipeline|player)/\w+/(page/)?\w+\.(hpp|cpp|js)$")
COMMENT = re.compile(r"//.*")
FILE = re.compile(r"(?<![\w/.<-])\w+/\w+\.[ch]pp\b")


def without_purpose(sources):
    """Headers, scripts and sources without a header of their own that do not begin with a comment. `sources`: path to text."""
    return [path for path, text in sources.items()
            if not (text.startswith("//") or (path.endswith(".cpp") and path[:-4] + ".hpp" in sources))]


def missing_files(sources):
    """(path, name) of each room/file.hpp or .cpp in a comment that no program has."""
    return [(path, name) for path, text in sources.items() for comment in COMMENT.findall(text) for name in FILE.findall(comment)
            if not {f"{program}/{name}" for program in ("pipeline", "player")} & sources.keys()]


class Wording(unittest.TestCase):
    def test_sources_begin_with_their_purpose_and_name_existing_files(self):
        listed = subprocess.run(["git", "ls-files", "-z", "pipeline", "player"], cwd=ROOT, check=True, capture_output=True, text=True)
        paths = [path for path in listed.stdout.split("\0") if SOURCE.match(path) and (ROOT / path).is_file()]
        self.assertGreater(len(paths), 300)
        sources = {path: (ROOT / path).read_text() for path in paths}
        self.assertEqual(without_purpose(sources), [])
        self.assertEqual(missing_files(sources), [])

    def test_a_source_without_purpose_and_a_missing_file_are_found(self):
        sources = {"pipeline/core/a.hpp": "/// A.\n", "pipeline/core/a.cpp": '#include "core/a.hpp"\n',
                   "pipeline/core/b.cpp": '#include "core/a.hpp"\n// As core/a.hpp, unlike guide/task.hpp.\n'}
        self.assertEqual(without_purpose(sources), ["pipeline/core/b.cpp"])
        self.assertEqual(missing_files(sources), [("pipeline/core/b.cpp", "guide/task.hpp")])

    def test_an_idiom_is_found_and_an_allowed_use_is_not(self):
        self.assertEqual(len(list(findings("a.md", "a tracker that is none\nThe run is begun again, once more."))), 3)
        self.assertEqual(list(findings("a.py", 'as_user("nobody")')), [])

    def test_an_idiom_in_a_name_is_found(self):
        for name in ("AProbeThatNobodyTurnsIsRefused", "AFirstRailThatIsNoneIsRefused", "AnIndexIsMadeAnew", "CasesAreTold",
                     "ABoardThatSpeaks", "test_both_unpack_without_a_quarrel", "is_offset_asked", "set_trouble", "talk_", "is_ours"):
            self.assertEqual(len(set(findings("a.cpp", f"TEST(Suite, {name})"))), 1, name)
        for name in ("AStandardIsRead", "hours_left", "self.assertIsNone(x)", "talker", "n_tasks"):
            self.assertEqual(list(findings("a.cpp", name)), [], name)

    def test_no_file_uses_an_idiom(self):
        listed = subprocess.run(["git", "ls-files", "-z", *FOLDERS], cwd=ROOT, check=True, capture_output=True, text=True)
        paths = [path for path in listed.stdout.split("\0") if path and not EXEMPT.search(path)]
        texts = [path for path in paths if pathlib.Path(path).suffix in SUFFIXES and (ROOT / path).is_file()]
        self.assertGreater(len(texts), 1000)
        found = []
        for path in texts:
            try:
                found += findings(path, (ROOT / path).read_text())
            except UnicodeDecodeError:
                continue
        self.assertEqual(found, [])


if __name__ == "__main__":
    unittest.main()
