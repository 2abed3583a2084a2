"""A checkout with the real scripts in a folder with spaces, on a machine whose cmake, apt, dpkg and sudo are made up."""
import os
import pathlib
import shutil
import subprocess
import tempfile

SCRIPTS = pathlib.Path(__file__).parents[2] / "scripts"
REAL_TOOLS = ("awk", "basename", "bash", "cat", "comm", "cp", "cut", "dirname", "env", "grep", "head", "mkdir", "mv", "nproc", "paste",
              "printf", "realpath", "rm", "sed", "sha256sum", "sort", "stat", "tail", "touch", "tr")


class FakeMachine:
    """Use in a `with`. `calls()` is what the made-up programs were asked, in order."""

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
        """A program that notes its call and then does `body` (bash)."""
        path = self.bin / name
        path.write_text(f'#!{self.bin}/bash\nprintf "%s\\n" "{name} $*" >>"{self.log}"\n{body}\n')
        path.chmod(0o755)

    def installed(self, *names):
        lines = "\\n".join(f"installed {name}" for name in names)
        # The real one's exit code where it does not know one of the packages.
        self.fake("dpkg-query", f"printf '{lines}\\nnot-installed zeta\\n'; exit 1")

    def calls(self, name=""):
        lines = self.log.read_text().splitlines() if self.log.exists() else []
        return [line for line in lines if line.startswith(name)]

    def run(self, script, *arguments, cwd="/"):
        """The finished script, called from `cwd` with no terminal."""
        environment = {"PATH": str(self.bin), "HOME": os.environ.get("HOME", "/")}
        return subprocess.run([self.checkout / "scripts" / script, *arguments], capture_output=True, text=True, cwd=cwd,
                              env=environment, stdin=subprocess.DEVNULL, timeout=60, check=False)
