"""The packages made by cpack from this build: files, owners, dependencies, and reproducibility."""
import functools
import gzip
import io
import json
import os
import pathlib
import re
import stat
import subprocess
import tarfile
import tempfile
import time
import unittest

import release

PACKED_AT = 1700000000  # the SOURCE_DATE_EPOCH of tests/package/CMakeLists.txt
FOLDER = "vrda-{version}-linux-x86_64"  # of both tarballs


def version():
    return release.run(release.BUILD / "vrda", "--version").split()[1]


def tarball(name):
    return release.PACKAGES / f"{name}-{version()}-linux-x86_64.tar.gz"


def debian(name):
    return release.PACKAGES / f"{name}_{version()}_amd64.deb"


def members_of(archive):
    """TarInfo by path, of an opened tar file; no path twice."""
    members = archive.getmembers()
    found = {member.name.removeprefix("./"): member for member in members}
    assert len(found) == len(members)
    return found


def opened(archive):
    """TarInfo by path, and the bytes of the files by path."""
    members = members_of(archive)
    return members, {path: archive.extractfile(member).read() for path, member in members.items() if member.isfile()}


@functools.cache
def unpacked_tarball(name):
    with tarfile.open(tarball(name)) as archive:
        return opened(archive)


def is_dynamic(content):
    return content[:4] == b"\x7fELF"


class Packed(unittest.TestCase):
    def check_whose(self, members):
        """Everything is readable by all, owned by root, with the given time."""
        for name, member in members.items():
            executable = member.isdir() or re.search(r"/(bin|with-glibc)/|/ld-linux[^/]*$", name)
            self.assertEqual(stat.S_IMODE(member.mode), 0o755 if executable else 0o644, name)
            self.assertEqual((member.uid, member.gid, member.mtime), (0, 0, PACKED_AT), name)
            self.assertTrue(member.isfile() or member.isdir(), name)


class Tarballs(Packed):
    def unpack(self, folder, name):
        """Name of the folder in a tarball."""
        release.run("tar", "-xzf", tarball(name), "-C", folder, "--no-same-owner")
        return pathlib.Path(folder) / FOLDER.format(version=version())

    def contents(self, name):
        members, files = unpacked_tarball(name)
        self.check_whose(members)
        top = FOLDER.format(version=version())
        self.assertEqual({path.split("/")[0] for path in members}, {top})
        return {path.removeprefix(top + "/"): content for path, content in files.items()}

    def check(self, name, own_documents, shared):
        files = self.contents(name)
        documents = f"share/doc/{name}/"
        listed = {"bin/" + name, "with-glibc/" + name, f"share/man/man1/{name}.1", documents + "LIBRARIES.txt"} | shared
        listed |= {documents + document for document in own_documents}
        rest = set(files) - listed
        self.assertLessEqual(listed, set(files))

        table = [line.split("\t") for line in files[documents + "LIBRARIES.txt"].decode().splitlines() if "\t" in line]
        self.assertEqual(table[0], ["library", "package", "version", "source package", "source version"])
        libraries, packages = {row[0] for row in table[1:]}, {row[1] for row in table[1:]}
        self.assertNotIn("", {cell for row in table for cell in row})
        carried = {path for path in rest if path.startswith("lib/")}
        self.assertEqual(carried, {"lib/" + library for library in libraries})
        licences = {path for path in rest if path.startswith(documents + "licences/")}
        self.assertEqual(rest, carried | licences)
        self.assertLessEqual({documents + "licences/" + package for package in packages}, licences)
        self.assertIn(documents + "licences/libeigen3-dev", licences)
        self.assertIn(documents + "licences/common-licenses/LGPL-3", licences)
        return files, libraries

    def test_vrda(self):
        files, libraries = self.check("vrda", ("README.md", "LICENSE", "CHANGELOG.md"), release.shared_files())
        self.assertLess({"libstdc++.so.6", "libgcc_s.so.1", "libz.so.1", "libassimp.so.5"}, libraries)
        self.assertFalse({library for library in libraries if re.match(r"lib(c|m|pthread|dl|rt|resolv)\.so", library)})
        self.assertLess({"glibc/libc.so.6", "glibc/libm.so.6", "glibc/ld-linux-x86-64.so.2"}, libraries)
        self.assertFalse({library for library in libraries if "LLVM" in library or "Mesa" in library})
        for path, content in files.items():
            self.assertNotIn(str(release.SOURCE).encode(), content, path)

    def test_player(self):
        _, libraries = self.check("vrda-player", ("LICENSE",), release.PLAYER_FILES)
        self.assertLess({"libOSMesa.so.8", "libstdc++.so.6"}, libraries)

    def test_both_unpack_into_one_folder_without_conflicting_files(self):
        vrda, player = self.contents("vrda"), self.contents("vrda-player")
        both = set(vrda) & set(player)
        self.assertIn("lib/libstdc++.so.6", both)
        self.assertEqual({path for path in both if vrda[path] != player[path]}, set())

    def test_libraries_are_debians_own_bytes(self):
        files = self.contents("vrda")
        for path in ("lib/libstdc++.so.6", "lib/libhdf5_serial.so.103"):
            self.assertEqual(files[path], (pathlib.Path("/usr/lib/x86_64-linux-gnu") / path[4:]).read_bytes(), path)

    def test_it_runs_where_modules_put_other_libraries_before_its_own(self):
        with tempfile.TemporaryDirectory() as folder:
            program = self.unpack(folder, "vrda") / "bin/vrda"
            modules = pathlib.Path(folder, "modules")
            modules.mkdir()
            # One required by vrda and one required only by HDF5; neither can be loaded.
            for name in ("libhdf5_serial.so.103", "libcurl.so.4"):
                (modules / name).write_bytes(b"")
            environment = {"LD_LIBRARY_PATH": str(modules)}
            self.assertEqual(release.run(program, "--version", env=environment), f"vrda {version()}\n")
            with self.assertRaisesRegex(AssertionError, "file too short"):
                release.run(release.BUILD / "vrda", "--version", env=environment)  # without its own libraries

    def test_with_its_own_glibc_it_gives_the_same_bytes_and_finds_the_player(self):
        with tempfile.TemporaryDirectory(prefix="vrda with glibc ") as folder:
            self.unpack(folder, "vrda")
            own, linked, model = self.unpack(folder, "vrda-player"), pathlib.Path(folder, "vrda"), pathlib.Path(folder, "knee.h5")
            linked.symlink_to(own / "with-glibc/vrda")
            release.run(linked, "run", own / "share/vrda/jobs/knee-generic.toml", *release.COARSE, "-o", model)
            self.assertEqual(release.sha256(model), release.coarse_knee(folder))
            release.run(linked, "report", model, "-o", f"{folder}/report")
            stills, note = release.stills_of(f"{folder}/report/index.html")
            self.assertIsNone(note)
            self.assertGreater(len(stills), 4)
            for name in release.TARBALLS:
                shown = subprocess.run([own / "with-glibc" / name, "--version"], capture_output=True, text=True, check=True,
                                       env=dict(os.environ, LD_DEBUG="libs"))
                # The launcher's shell comes first. From /lib only the name of the included loader may appear.
                by_carried_loader = "OWN/lib/" + shown.stderr.replace(str(own), "OWN").partition("OWN/lib/")[2]
                loaded = re.findall(r"calling init: (\S.*)", by_carried_loader)
                self.assertIn("OWN/lib/glibc/libc.so.6", loaded)
                self.assertEqual([path for path in loaded if not path.startswith("OWN/") and "/ld-linux" not in path], [])

    def test_with_its_own_glibc_the_tasks_of_a_submission_have_it_too(self):
        with tempfile.TemporaryDirectory(prefix="vrda tasks ") as folder:
            launcher = self.unpack(folder, "vrda") / "with-glibc/vrda"
            release.run(launcher, "submit", release.SOURCE / "jobs/knee-generic.toml", *release.COARSE[:-2], "--shards", "2", "--local",
                        "-o", f"{folder}/made")
            (model,) = pathlib.Path(folder, "made").rglob("*.h5")
            self.assertEqual(release.sha256(model), release.coarse_knee(folder))
            self.assertEqual(json.loads(pathlib.Path(folder, "made/submission.json").read_text())["program"], str(launcher))

    def test_the_documented_glibc_is_the_newest_required(self):
        files = self.contents("vrda")
        named = re.search(r"GLIBC (2\.\d+) or later", files["share/doc/vrda/LIBRARIES.txt"].decode()).group(1)
        required = {int(minor) for path, content in files.items() if is_dynamic(content) and "glibc/" not in path
                    for minor in re.findall(rb"GLIBC_2\.(\d+)\0", content)}
        self.assertEqual(named, f"2.{max(required)}")


class Debian(Packed):
    def field(self, name, field):
        return release.run("dpkg-deb", "--field", debian(name), field).strip()

    def contents(self, name):
        raw = subprocess.run(["dpkg-deb", "--fsys-tarfile", debian(name)], capture_output=True, check=True).stdout
        with tarfile.open(fileobj=io.BytesIO(raw)) as archive:
            members, files = opened(archive)
        self.check_whose(members)
        return files

    def check(self, name, documents, shared):
        files = self.contents(name)
        listed = {f"usr/bin/{name}", f"usr/share/man/man1/{name}.1.gz"} | {"usr/" + path for path in shared}
        listed |= {f"usr/share/doc/{name}/{document}" for document in ("copyright", "changelog.gz", *documents)}
        self.assertEqual(set(files), listed)
        self.assertNotIn(b"$ORIGIN", files[f"usr/bin/{name}"])
        changelog = gzip.decompress(files[f"usr/share/doc/{name}/changelog.gz"]).decode()
        day = time.strftime("%a, %d %b %Y %H:%M:%S +0000", time.gmtime(PACKED_AT))
        self.assertTrue(changelog.startswith(f"vrda ({version()}) "), changelog)
        self.assertTrue(changelog.endswith(f"{self.field(name, 'Maintainer')}  {day}\n"), changelog)
        copyright_file = files[f"usr/share/doc/{name}/copyright"].decode()
        self.assertIn((release.SOURCE / "LICENSE").read_text(), copyright_file)
        self.assertIn("libeigen3-dev", copyright_file)

    def test_vrda(self):
        self.check("vrda", ("README.md", "CHANGELOG.md"), release.shared_files())
        depends = self.field("vrda", "Depends")
        for package in ("libassimp5", "libc6 (>=", "libhdf5-103-1", "libstdc++6 (>="):
            self.assertIn(package, depends)
        self.assertNotIn("mesa", depends)
        self.assertEqual(self.field("vrda", "Section"), "science")
        self.assertEqual(self.field("vrda", "Suggests"), "vrda-player")
        self.assertTrue(self.field("vrda", "Description").startswith("joint motion from the surfaces of bones\n"))

    def test_player(self):
        self.check("vrda-player", (), release.PLAYER_FILES)
        self.assertIn("libosmesa6", self.field("vrda-player", "Depends"))

    @unittest.skipUnless("vrda-webcam" in release.PROGRAMS, "a build without OpenCV")
    def test_webcam(self):
        self.check("vrda-webcam", (), set())
        depends = self.field("vrda-webcam", "Depends")
        self.assertIn("libopencv-contrib", depends)
        self.assertNotIn("libopencv", self.field("vrda-player", "Depends"))
        self.assertEqual(self.field("vrda-webcam", "Suggests"), "vrda-player")

    @unittest.skipUnless(release.PYTHON, "a build without the Python module")
    def test_python(self):
        name, documents = "python3-vrda", "usr/share/doc/python3-vrda/"
        files = self.contents(name)
        self.assertEqual(set(files), {"usr/" + path for path in release.PYTHON_FILES} | {documents + "copyright", documents + "changelog.gz"})
        self.assertIn("pybind11-dev", files[documents + "copyright"].decode())
        depends = self.field(name, "Depends")
        for package in ("python3 (>= 3.11)", "python3 (<< 3.12)", "python3-numpy", "libassimp5", "libhdf5-103-1"):
            self.assertIn(package, depends)
        self.assertIn("python3-xarray", self.field(name, "Recommends"))
        self.assertEqual(self.field(name, "Section"), "python")
        with tempfile.TemporaryDirectory() as folder:
            release.run("dpkg-deb", "--extract", debian(name), folder)
            environment = dict(os.environ, PYTHONPATH=f"{folder}/usr/lib/python3/dist-packages", PYTHONDONTWRITEBYTECODE="1")
            self.assertEqual(release.run("/usr/bin/python3", "-c", "import vrda; print(vrda.__version__)", env=environment).strip(), version())


class Refusals(unittest.TestCase):
    """No tarball is made if a required library cannot be included."""

    def setUp(self):
        self.base = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        (self.base / "stage/bin").mkdir(parents=True)
        (self.base / "f.c").write_text("int f(void) { return 0; }\n")
        (self.base / "main.c").write_text("int f(void); int main(void) { return f(); }\n")
        library = self.base / "libforeign.so.1"
        release.run("gcc", "-shared", "-fPIC", f"-Wl,-soname,{library.name}", self.base / "f.c", "-o", library)
        release.run("gcc", self.base / "main.c", library, "-o", self.base / "stage/bin/vrda")

    def refused(self, reason, **variables):
        finish = release.SOURCE / "scripts/finish_package"
        tarball_ = self.base / "vrda.tar.gz"
        done = subprocess.run([finish, "tarball", "vrda", "1", self.base / "stage", tarball_, "vrda-1"], capture_output=True, text=True,
                              env=dict(os.environ, **variables), stdin=subprocess.DEVNULL, check=False)
        self.assertEqual(done.returncode, 1)
        self.assertIn(reason, done.stderr)
        self.assertFalse(tarball_.exists())

    def test_a_library_that_is_not_there(self):
        self.refused("found missing shared libraries")

    def test_a_library_of_no_debian_package(self):
        self.refused(f"found {self.base}/libforeign.so.1 outside of any Debian package", LD_LIBRARY_PATH=str(self.base))


class Again(unittest.TestCase):
    def packed_again(self, generator, file, umask):
        with tempfile.TemporaryDirectory(prefix="vrda pack ") as folder:
            environment = dict(os.environ, SOURCE_DATE_EPOCH=str(PACKED_AT), TZ="Asia/Tokyo", LC_ALL="C.UTF-8")
            release.run("cpack", "-G", generator, "--config", release.BUILD / "CPackConfig.cmake", "-B", folder,
                        "-D", "CPACK_COMPONENTS_ALL=pipeline", env=environment, umask=umask)
            return release.sha256(pathlib.Path(folder) / file.name)

    def test_a_debian_package_packed_again_elsewhere_is_the_same_bytes(self):
        self.assertEqual(self.packed_again("DEB", debian("vrda"), 0o022), release.sha256(debian("vrda")))

    def test_a_tarball_packed_again_by_one_who_hides_files_is_the_same_bytes(self):
        self.assertEqual(self.packed_again("External", tarball("vrda"), 0o077), release.sha256(tarball("vrda")))


if __name__ == "__main__":
    unittest.main()
