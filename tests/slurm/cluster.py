"""A private Slurm cluster for a test, as a context manager."""
import hashlib
import json
import os
import pathlib
import pwd
import re
import shutil
import subprocess
import sys
import tempfile
import time

import private_slurm

SKIPPED = 77  # ctest's SKIP_RETURN_CODE for these tests
PROGRAM = pathlib.Path(private_slurm.__file__)


def skip_without_slurm(name):
    """Exits as skipped, with the reason, if Slurm is not installed or does not start."""
    reason = ""
    if missing := private_slurm.missing_programs():
        reason = f"found no {', '.join(missing)}; wanted the packages slurm-wlm and munge"
    else:
        try:
            with Cluster(nodes=1):
                pass
        except private_slurm.ClusterError as error:
            reason = str(error)
    if reason:
        print(f"skipped: {name}: {reason}")
        sys.exit(SKIPPED)


def as_user(name):
    """Command prefix to run a command as this user; requires root."""
    user = pwd.getpwnam(name)
    return ["setpriv", f"--reuid={user.pw_uid}", f"--regid={user.pw_gid}", "--clear-groups", "--"]


def sha256(path):
    return hashlib.sha256(pathlib.Path(path).read_bytes()).hexdigest()


def processes_using(folder):
    """Live processes that use a folder, with their command lines: none may be left of a cluster."""
    found, word = [], str(folder)
    for process in private_slurm.parents():
        base = pathlib.Path("/proc", str(process))
        try:
            texts = [(base / "cmdline").read_text(errors="replace"), (base / "environ").read_text(errors="replace"),
                     os.readlink(base / "cwd"), *private_slurm.open_files(process)]
        except OSError:
            continue  # it has ended, or is a kernel thread
        if process != os.getpid() and any(word in text for text in texts):
            found.append(f"{process}: {texts[0].replace(chr(0), ' ')[:200]}")
    return found


class Cluster:
    """Three nodes of two processors, partitions `batch` and `urgent`. Ends with this process in any case."""

    def __init__(self, nodes=3, cpus=2, user=None):
        self.nodes, self.cpus, self.user = nodes, cpus, user

    def __enter__(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="vrda-slurm-"))
        self.work = self.folder / "work"  # removed with the cluster
        if self.user:
            shutil.chown(self.folder, self.user)
        reader, self.tie = os.pipe()
        try:
            with open(reader, "rb") as end:
                words = [*(as_user(self.user) if self.user else []), sys.executable, PROGRAM, "start", self.folder, "--tied",
                         "--nodes", str(self.nodes), "--cpus", str(self.cpus)]
                begun = subprocess.run(words, stdin=end, capture_output=True, text=True, check=False)
            if begun.returncode != 0:
                raise private_slurm.ClusterError(begun.stderr.strip())
            self.work.mkdir()
            self.work.chmod(0o777)  # other users' jobs also write there
        except BaseException:
            self.end()
            raise
        return self

    def __exit__(self, *_):
        try:
            private_slurm.stop(self.folder)
        finally:
            self.end()

    def end(self):
        os.close(self.tie)
        shutil.rmtree(self.folder, ignore_errors=True)  # remaining files that the cluster's user may not remove

    def environment(self, **more):
        return {**private_slurm.environment(self.folder), **{name: str(value) for name, value in more.items()}}

    def run(self, *command, prefix=(), cwd=None, timeout=60, **variables):
        """Runs a command with the cluster's variables and these in its environment."""
        return subprocess.run([*prefix, *map(str, command)], env=self.environment(**variables), cwd=cwd or self.work, text=True,
                              capture_output=True, stdin=subprocess.DEVNULL, timeout=timeout, check=False)

    def ask(self, *words):
        return private_slurm.ask(self.folder, *words)

    def jobs(self, *options):
        """squeue's jobs: {"12_3": "RUNNING"}, with one entry per pending array task."""
        listed = self.run("squeue", "-h", "-r", "-o", "%i %T", *options)
        return dict(line.split() for line in listed.stdout.splitlines())

    def node_states(self):
        listed = self.run("sinfo", "-h", "-N", "-p", "batch", "-o", "%N %t")
        return dict(line.split() for line in listed.stdout.splitlines())

    def signalled_jobs(self):
        """Ids of the jobs whose script received SIGTERM, from the nodes' logs: the controller's log records the request, not
        the delivery. On a slow node a task that ends by itself may also receive one."""
        logs = (log.read_text() for log in (self.folder / "log").glob("n*"))
        return {job for text in logs for job in re.findall(r"(?i)sent signal 15 to (?:pid \d+ )?StepId=(\d+)\.batch", text)}

    def wait_until(self, what, condition, timeout=60, show=lambda: ""):
        """Returns the condition's value once it is true; on timeout fails and shows state, queue and logs."""
        deadline = time.monotonic() + timeout
        while not (value := condition()):
            if time.monotonic() > deadline:
                raise AssertionError(f"not within {timeout} s: {what}\n{show()}\n{self.snapshot()}")
            time.sleep(0.3)
        return value

    def snapshot(self):
        queue = self.run("squeue", "-o", "%i %j %P %T %r %N %M %l").stdout
        nodes = self.run("sinfo", "-N", "-p", "batch", "-o", "%N %T %E").stdout
        return f"--- squeue\n{queue}--- sinfo\n{nodes}{private_slurm.tails(self.folder)}"

    def clean(self):
        """Resets for the next test: no job, every node up and idle."""
        self.run("scancel", "--full", "--user", "root" if os.getuid() == 0 else str(os.getuid()))
        self.run("scancel", "--state=PENDING", "--partition=batch,urgent")
        for node in self.ask("missing").split():
            self.ask("start-node", node)
        self.wait_until("every job ended", lambda: not self.jobs())
        self.wait_until("every node idle", lambda: set(self.node_states().values()) == {"idle"})


def tail(path, lines=30):
    """The end of a text file, or a note that it is missing."""
    try:
        return "\n".join(pathlib.Path(path).read_text(errors="replace").splitlines()[-lines:])
    except OSError as error:
        return str(error)


def read_json(text):
    """Parses JSON; the error message contains the text."""
    try:
        return json.loads(text)
    except json.JSONDecodeError as error:
        raise AssertionError(f"not JSON: {error}\n{text}") from None
