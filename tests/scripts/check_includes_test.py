"""Every rule of scripts/check_includes on a small checkout: one without violations, then one violation at a time."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

SCRIPT = pathlib.Path(__file__).parents[2] / "scripts" / "check_includes"

# A checkout without violations, including code that resembles one.
GOOD = {
    "pipeline/CMakeLists.txt": "add_subdirectory(core)\nadd_subdirectory(model)\nadd_subdirectory(store)\nadd_subdirectory(job)\n"
                               "if(X)\n  add_subdirectory(solve)\nendif()\n",
    "player/CMakeLists.txt": "add_subdirectory(view)\nadd_subdirectory(show)\n",
    "pipeline/core/CMakeLists.txt": "add_room(core)\n",
    "pipeline/core/README.md": "# core: shared types\n",
    "pipeline/core/units.cpp": '#include "core/units.hpp"\n#include <cmath>\ndouble sine(double x) { return std::sin(x); }\n',
    "pipeline/core/mesh.hpp": "#include <Eigen/Core>\n#include <vector>\n#include <sys/stat.h>\n",
    "pipeline/store/file.cpp": '#include "store/file.hpp"\n#include "core/mesh.hpp"\n#include <hdf5.h>\n',
    "pipeline/solve/step.cpp": '// std::sin(x) of a comment\n#include "job/case.hpp"\n'
                               'double f(Trig t) { return std::sqrt(2.0) * t.sin + cosine(1.0); }\n'
                               'const char* s = "exp(1) in a string";\n/* pow(2, 3)\n */ int sin_cos(int);\n',
    "player/view/read.cpp": '#include "store/file.hpp"\n#include "model/pose.hpp"\n#include "core/mesh.hpp"\n',
    "player/show/draw.cpp": '#include "view/read.hpp"\n#include <GL/osmesa.h>\n#include <cmath>\n'
                              "float f(float x) { return std::sin(x); }\n",
    "tests/core/mesh_test.cpp": "#include <gtest/gtest.h>\n#include <cmath>\ndouble x = std::exp(1.0);\n",
    "results/knee/notes.md": "TO" "DO in generated results is not looked at\n",
}


class CheckIncludes(unittest.TestCase):
    def findings(self, changes=None):
        """Exit code and lines for GOOD with `changes` applied."""
        with tempfile.TemporaryDirectory() as folder:
            for name, text in {**GOOD, **(changes or {})}.items():
                path = pathlib.Path(folder, name)
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text(text)
            done = subprocess.run([sys.executable, SCRIPT, folder], capture_output=True, text=True)
        return done.returncode, done.stdout.splitlines()

    def assert_one(self, name, text, line, found, wanted):
        """Exactly one finding, at this position, with both texts."""
        code, lines = self.findings({name: text})
        self.assertEqual(code, 1)
        self.assertEqual(len(lines), 1, lines)
        self.assertTrue(lines[0].startswith(f"{name}:{line}: found "), lines[0])
        self.assertIn(found, lines[0])
        self.assertIn(wanted, lines[0].split(", wanted ", 1)[1])

    def test_a_good_tree_passes(self):
        self.assertEqual(self.findings(), (0, ["nothing found"]))

    def test_later_rooms_are_out_of_reach(self):
        self.assert_one("pipeline/job/a.cpp", '\n#include "solve/step.hpp"\n', 2, '"solve/step.hpp"', "job, core, model, store")
        self.assert_one("player/view/a.cpp", '#include "show/draw.hpp"\n', 1, '"show/draw.hpp"', "view, core, model, geometry, store")
        self.assert_one("player/show/a.cpp", '#include "job/case.hpp"\n', 1, '"job/case.hpp"', "view")

    def test_commands_alone_catch_input_errors(self):
        for caught in ("const InputError& error", "InputError", "const vrda::InputError&", "const std::exception& e"):
            text = "void f()\n{\n  try {\n    g();\n  } catch (" + caught + ") {\n  }\n}\n"
            self.assert_one("pipeline/solve/a.cpp", text, 5, "catch of ", "facts returned by a function")
            self.assert_one("player/view/a.hpp", text, 5, "catch of ", "app catches")
            self.assertEqual(self.findings({"pipeline/app/a.cpp": text, "pipeline/store/read_separately.cpp": text})[0], 0)
        others = "try { g(); } catch (const Stopped&) {} // catch (const InputError&)\n"
        self.assertEqual(self.findings({"pipeline/solve/a.cpp": others})[0], 0)

    def test_project_includes_name_their_room(self):
        self.assert_one("pipeline/solve/a.cpp", '#include "step.hpp"\n', 1, '"step.hpp"', "room/file.hpp")
        self.assert_one("pipeline/solve/a.cpp", '#include "../core/mesh.hpp"\n', 1, '"../core', "room/file.hpp")

    def test_a_library_lives_in_one_room_and_not_in_headers(self):
        self.assert_one("pipeline/store/file.hpp", "#include <H5public.h>\n", 1, "<H5public.h> in a header", ".cpp")
        code, lines = self.findings({"pipeline/job/a.cpp": "#include <H5Tpublic.h>\n"})
        self.assertEqual((code, len(lines)), (1, 1))
        self.assertRegex(lines[0], r", wanted .*\bHDF5\b.*\bpipeline/job\b")
        self.assert_one("player/view/a.cpp", "#include <boost/beast/http.hpp>\n", 1, "boost/beast", "Boost.Asio in player/web and bench only")
        self.assert_one("player/view/a.cpp", "#include <newlib/x.hpp>\n#include <gtest/gtest.h>\n", 2, "gtest", "tests only")

    def test_functions_that_differ_by_processor(self):
        for call in ("std::sin(x)", "::cos(x)", "atan2(y, x)", "std::powf(x, 2)", "v.array().exp()", "fn(&std::hypot)",
                     "Eigen::AngleAxisd(x, a)", "a.slerp(t, b)", "R.eulerAngles(0, 1, 2)", "log1p(x)"):
            with self.subTest(call):
                self.assert_one("pipeline/solve/a.cpp", f"double y = {call};\n", 1, "found ", "core/units.hpp")
        self.assert_one("pipeline/store/a.cpp", "float y = cosf(x);\n", 1, "cosf()", "core/units.hpp")

    def test_random_numbers_that_differ_by_library(self):
        for call in ("std::normal_distribution<double> d;", "std::random_device r;", "std::shuffle(a, b, g);", "x = rand();"):
            with self.subTest(call):
                self.assert_one("pipeline/solve/a.cpp", f"{call}\n", 1, "found ", "seed")

    def test_sizes(self):
        self.assert_one("pipeline/solve/a.cpp", "int x;\n" * 1201, 1201, "1201 lines", "at most 1200")
        self.assert_one("pipeline/core/README.md", "# core\n" + "line\n" * 60, 61, "61 lines", "at most 60")
        self.assert_one("pipeline/core/README.md", "# core\n" + "x" * 101 + "\n", 2, "101 characters", "at most 100")
        rooms = "".join(f"add_subdirectory(r{k})\n" for k in range(21))
        code, lines = self.findings({"player/CMakeLists.txt": GOOD["player/CMakeLists.txt"] + rooms})
        self.assertEqual((code, lines), (1, ["pipeline/CMakeLists.txt:1: found 28 rooms, wanted at most 20 in both programs"]))
        self.assert_one("pipeline/core/README.md", "# corelib: types\n", 1, "title # corelib", "# core")

    def test_a_room_has_a_readme_and_a_place(self):
        self.assert_one("pipeline/job/CMakeLists.txt", "add_room(job)\n", 1, "no README.md in pipeline/job", "purpose")
        code, lines = self.findings({"player/web/CMakeLists.txt": "add_room(web)\n", "player/web/README.md": "# web\n"})
        self.assertEqual((code, len(lines)), (1, 1))
        self.assertRegex(lines[0], r"\bweb\b.*, wanted .*\bplayer/CMakeLists.txt\b")

    def test_words_and_paths(self):
        for word in ("TO" "DO", "FIX" "ME", "XX" "X"):
            self.assert_one("scripts/a", f"# {word}: later\n", 1, word, "finished work")
        for path in ("/ho" "me/someone/x", "/wo" "rk/x", "C:" "\\data"):
            self.assert_one("jobs/a.toml", f'file = "{path}"\n', 1, path[:3], "relative to the checkout")
        self.assertEqual(self.findings({"README.md": "see https://example.org/ho" "me/x and a/ro" "ot/y\n"})[0], 0)

    def test_no_checkout(self):
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run([sys.executable, SCRIPT, folder], capture_output=True, text=True)
        self.assertEqual(done.returncode, 2)
        self.assertIn(folder, done.stderr)


if __name__ == "__main__":
    unittest.main()
