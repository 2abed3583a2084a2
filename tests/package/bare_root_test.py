"""The tarballs, unpacked in a root with only glibc."""
import pathlib
import subprocess
import tempfile
import unittest

import bare_root
import release

JOB = "/opt/vrda/share/vrda/jobs/knee-generic.toml"


class BareRoot(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        if bare_root.refusal():
            raise unittest.SkipTest(bare_root.refusal())
        cls.folder = tempfile.TemporaryDirectory(prefix="vrda-bare-root-")
        cls.addClassCleanup(cls.folder.cleanup)
        cls.root = pathlib.Path(cls.folder.name)
        cls.before = bare_root.make(cls.root)
        (cls.root / "opt/vrda").mkdir(parents=True)
        cls.unpack("vrda")

    @classmethod
    def unpack(cls, name):
        release.run("tar", "-xzf", next(release.PACKAGES.glob(f"{name}-[0-9]*.tar.gz")), "-C", cls.root / "opt/vrda",
                    "--strip-components", "1", "--no-same-owner")

    def test_there_is_nothing_but_glibc(self):
        names = {path.rsplit("/", 1)[-1] for path in self.before}
        self.assertLess({"ld-linux-x86-64.so.2", "libc.so.6", "libm.so.6"}, names)
        self.assertFalse({name for name in names if name.startswith(("libstdc++", "libgcc_s", "libz", "sh", "bash"))})

    def test_the_build_trees_own_program_does_not_start_there(self):
        (self.root / "opt/own").mkdir()
        release.run("cp", release.BUILD / "vrda", self.root / "opt/own/vrda")
        with self.assertRaisesRegex(AssertionError, "cannot open shared object file"):
            bare_root.run(self.root, "/opt/own/vrda", "--version")

    def test_vrda_solves_the_knee_to_the_same_bytes_and_its_report_has_pictures(self):
        bare_root.run(self.root, "/opt/vrda/bin/vrda", "run", JOB, *release.COARSE, "-o", "/tmp/knee.h5")
        with tempfile.TemporaryDirectory() as folder:
            self.assertEqual(release.sha256(self.root / "tmp/knee.h5"), release.coarse_knee(folder))
        self.unpack("vrda-player")  # over it
        bare_root.run(self.root, "/opt/vrda/bin/vrda", "report", "/tmp/knee.h5", "-o", "/tmp/report")
        stills, note = release.stills_of(self.root / "tmp/report/index.html")
        self.assertIsNone(note)
        self.assertGreater(len(stills), 4)

    def test_nothing_stays_mounted(self):
        bare_root.run(self.root, "/opt/vrda/bin/vrda", "--version")
        mounts = subprocess.run(["cat", "/proc/self/mounts"], capture_output=True, text=True, check=True).stdout
        self.assertNotIn(str(self.root), mounts)


if __name__ == "__main__":
    unittest.main()
