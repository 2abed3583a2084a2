"""cmake --install under a prefix that is then moved: files, programs, and that no path is compiled in."""
import pathlib
import stat
import tempfile
import unittest

import release

DOCUMENTS = {"share/doc/vrda/" + name for name in ("README.md", "LICENSE", "CHANGELOG.md")}
PAGES = {f"share/man/man1/{program}.1" for program in release.PROGRAMS}


class Install(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory(prefix="vrda install ")
        cls.addClassCleanup(cls.folder.cleanup)
        base = pathlib.Path(cls.folder.name)
        cls.first, cls.prefix, cls.base = base / "first place", base / "elsewhere" / "second place", base
        release.run("cmake", "--install", release.BUILD, "--prefix", cls.first, umask=0o022)
        cls.prefix.parent.mkdir()
        cls.first.rename(cls.prefix)

    def test_exactly_the_listed_files(self):
        programs = {f"bin/{program}" for program in release.PROGRAMS}
        self.assertGreater(len(release.shared_files()), 10)
        self.assertEqual(release.files_below(self.prefix), programs | DOCUMENTS | PAGES | release.shared_files() | release.PLAYER_FILES | release.PYTHON_FILES)

    def test_all_may_read_and_run_it(self):
        for path in self.prefix.rglob("*"):
            wanted = 0o755 if path.is_dir() or path.parent.name == "bin" else 0o644
            self.assertEqual(stat.S_IMODE(path.stat().st_mode), wanted, path)

    def test_the_moved_programs_give_the_same_bytes_and_find_each_other_even_through_a_link(self):
        model, link = self.base / "knee.h5", self.base / "vrda"
        link.symlink_to(self.prefix / "bin/vrda")
        release.run(link, "run", self.prefix / "share/vrda/jobs/knee-generic.toml", *release.COARSE, "-o", model, cwd=self.base)
        self.assertEqual(release.sha256(model), release.coarse_knee(self.base))
        release.run(link, "report", model, "-o", self.base / "report")
        stills, note = release.stills_of(self.base / "report/index.html")
        self.assertIsNone(note)
        self.assertGreater(len(stills), 4)

    def test_no_file_knows_a_place_of_this_machine(self):
        for name in release.files_below(self.prefix):
            content = (self.prefix / name).read_bytes()
            for place in (release.SOURCE, release.BUILD, self.first):
                self.assertNotIn(str(place).encode(), content, name)

    def test_manual_pages_are_the_help_of_the_programs(self):
        for program in release.PROGRAMS:
            page = (self.prefix / f"share/man/man1/{program}.1").read_text()
            text = page.split(".nf\n")[1].split(".fi\n")[0].replace("\n\\&", "\n").replace("\\-", "-").replace("\\e", "\\")
            self.assertEqual(text, release.run(self.prefix / "bin" / program, "--help"))
            self.assertRegex(page, rf"\.SH NAME\n{program} \\- \w")


if __name__ == "__main__":
    unittest.main()
