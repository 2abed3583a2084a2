"""A checkout with the real scripts in a folder with spaces, with fake cmake, apt, dpkg and sudo."""
import os
import pathlib
import shutil
import subprocess
import tempfile

SCRIPTS = pathlib.Path(__file__).parents[2] / "scripts"
REAL_TOOLS = ("awk", "basename", "bash", "cat", "comm", "cp", "cut", "dirname", "env", "grep", "head", "mkdir", "mv", "nproc", "paste",
              "printf", "realpath", "rm", "sed", "sha256sum", "sort", "stat", "tail", "touch", "tr")


class FakeMachine:
    """A context manager. `calls()` returns the calls of the fake programs, in order."""

    def __enter__(self):
        self.folder = tempfile.TemporaryDirectory()
        base = pathlib.Path(self.folder.name)
        self.checkout, self.bin, self.log = base / "a check out", base / "bin", base / "calls"
        (self.checkout / "scripts").mkdir(parents=True)
        for name in ("steps.sh", "setup", "quickstart", "package"):
            shutil.copy(SCRIPTS / name, self.checkout / "scripts")
        self.write("scripts/packages.txt", "# list\n[programs]\nalpha\nbeta\n[tests]\n# more\ngamma\n[package]\ndelta\n")
        self.bin.mkdir()
        for tool in REAL_TOOLS:
            (self.bin / tool).symlink_to(shutil.which(tool, path="/usr/bin:/bin"))
        self.fake("id", "echo 0")
        self.installed("alpha", "beta", "gamma")
        self.fake("apt-get", ":")
        return self

    def __exit__(self, *_):
        self.folder.cleanup()

    def write(self, name, text):
        path = self.checkout / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
        return path

    def fake(self, name, body):
        """Creates a program that logs its call and then runs `body` (bash)."""
        path = self.bin / name
        path.write_text(f'#!{self.bin}/bash\nprintf "%s\\n" "{name} $*" >>"{self.log}"\n{body}\n')
        path.chmod(0o755)

    def installed(self, *names):
        lines = "\\n".join(f"installed {name}" for name in names)
        # The real exit code if a package is unknown.
        self.fake("dpkg-query", f"printf '{lines}\\nnot-installed zeta\\n'; exit 1")

    def calls(self, name=""):
        lines = self.log.read_text().splitlines() if self.log.exists() else []
        return [line for line in lines if line.startswith(name)]

    def run(self, script, *arguments, cwd="/"):
        """Runs the script from `cwd` without a terminal."""
        environment = {"PATH": str(self.bin), "HOME": os.environ.get("HOME", "/")}
        return subprocess.run([self.checkout / "scripts" / script, *arguments], capture_output=True, text=True, cwd=cwd,
                              env=environment, stdin=subprocess.DEVNULL, timeout=60, check=False)
