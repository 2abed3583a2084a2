#!/usr/bin/python3
"""A private Slurm cluster on this host's loopback: munged, slurmctld and a few slurmd, everything below one folder.

usage: private_slurm.py start DIR [--nodes N] [--cpus C] [--tied]
       private_slurm.py stop | stop-controller | start-controller DIR
       private_slurm.py kill-node | start-node | freeze-node | thaw-node DIR nX
start returns when every node is idle; then SLURM_CONF=DIR/slurm.conf points Slurm's commands here. DIR must not
exist or be empty, and is removed by stop. --tied: the cluster ends when start's standard input is closed, as a
pipe is when its writer ends. A frozen node seems dead, but its tasks continue. Partitions: batch
(default) and urgent, which preempts batch by requeue. Works as root and as an ordinary user; needs no systemd,
cgroups or accounting storage.
exit: 0 done, 1 failed (reason printed), 2 usage
"""
import argparse
import ctypes
import os
import pathlib
import selectors
import shutil
import signal
import socket
import subprocess
import sys
import time
import traceback

LONGEST_DIR = 64  # Slurm's and our socket paths below it stay under the 107 characters of a Unix socket's address
START_S = 30  # a start takes 2 s; the limit allows for slower machines
PR_SET_PDEATHSIG, PR_SET_CHILD_SUBREAPER = 1, 36
SBIN = os.pathsep.join((os.environ.get("PATH", ""), "/usr/sbin", "/sbin"))

CONFIGURATION = """\
ClusterName=private
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={port}
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
CredType=cred/munge
# A requeued job waits until its old credential has expired: 120 s by default, at least 5.
AuthInfo=socket={folder}/munge/socket,cred_expire=5
CommunicationParameters=NoCtldInAddrAny,NoInAddrAny
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/%n
SlurmctldPidFile={folder}/state/pid
SlurmdPidFile={folder}/%n/pid
SlurmctldLogFile={folder}/log/slurmctld
SlurmdLogFile={folder}/log/%n
SlurmctldDebug=verbose
SlurmdDebug=verbose
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SwitchType=switch/none
MpiDefault=none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
JobCompType=jobcomp/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU_Memory
SchedulerType=sched/backfill
SchedulerParameters=sched_interval=1,bf_interval=1,batch_sched_delay=0,sched_min_interval=0
PreemptType=preempt/partition_prio
PreemptMode=REQUEUE
JobRequeue=1
KillWait=5
SlurmdTimeout=6
SlurmctldTimeout=10
MessageTimeout=10
ReturnToService=2
MinJobAge=10
SlurmdParameters=config_overrides
MaxArraySize=10001
"""
PARTITIONS = """\
PartitionName=batch Nodes=ALL Default=YES MaxTime=INFINITE DefaultTime=10 PriorityTier=1 GraceTime=2
PartitionName=urgent Nodes=ALL MaxTime=INFINITE DefaultTime=10 PriorityTier=10 PreemptMode=OFF
"""


class ClusterError(Exception):
    """An error of the cluster; the text is the reason."""


def missing_programs():
    """The Slurm and munge programs that are not installed."""
    wanted = ("munged", "slurmctld", "slurmd", "sbatch", "squeue", "sinfo", "scontrol", "scancel")
    return [name for name in wanted if shutil.which(name, path=SBIN) is None]


def environment(folder):
    """Environment of Slurm commands for this cluster."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("SLURM", "SBATCH", "SQUEUE", "LD_PRELOAD"))}
    return {**kept, "PATH": SBIN, "SLURM_CONF": str(folder / "slurm.conf")}


def parents():
    """Parent of every live process of this host, without zombies."""
    found = {}
    for entry in os.listdir("/proc"):
        if entry.isdigit():
            try:
                state, parent = pathlib.Path("/proc", entry, "stat").read_text().rpartition(")")[2].split()[:2]
            except OSError:
                continue  # it has ended meanwhile
            if state not in "ZX":
                found[int(entry)] = int(parent)
    return found


def descendants(ancestor):
    """Live descendants of `ancestor`."""
    of_process, found, fresh = parents(), [], [ancestor]
    while fresh:
        fresh = [process for process, parent in of_process.items() if parent in fresh]
        found += fresh
    return found


def signal_to(process, how):
    try:
        os.kill(process, how)
    except ProcessLookupError:
        pass


def free_ports(count):
    """The first of `count` consecutive unused ports, below the ephemeral ports."""
    start = 20000 + os.getpid() * 16 % 10000
    for first in range(start, start + 2000, count):
        sockets = []
        try:
            for port in range(first, first + count):
                sockets.append(socket.socket())
                sockets[-1].bind(("127.0.0.1", port))
            return first
        except OSError:
            continue
        finally:
            for each in sockets:
                each.close()
    raise ClusterError(f"found no {count} free ports from {start}")


class Keeper:
    """Parent of the daemons and subreaper of their orphans, so its descendants are the cluster."""

    def __init__(self, folder, nodes, cpus):
        self.folder, self.cpus = folder, cpus
        self.nodes = [f"n{k}" for k in range(1, nodes + 1)]
        self.daemons = {}  # name -> process

    def write_configuration(self):
        # Jobs of other users read the configuration and reach munge's socket.
        for path in (self.folder, *(self.folder / name for name in ("munge", "state", "log", *self.nodes))):
            path.mkdir(exist_ok=True)
            path.chmod(0o755)
        host, port = socket.gethostname().split(".")[0], free_ports(len(self.nodes) + 1)
        user = subprocess.run(["id", "-un"], capture_output=True, text=True, check=False).stdout.strip() or str(os.getuid())
        text = CONFIGURATION.format(host=host, port=port, user=user, folder=self.folder)
        for k, node in enumerate(self.nodes, 1):
            text += f"NodeName={node} NodeHostname={host} NodeAddr=127.0.0.1 Port={port + k} CPUs={self.cpus} RealMemory=2000\n"
        (self.folder / "slurm.conf").write_text(text + PARTITIONS)
        (self.folder / "cgroup.conf").write_text("CgroupPlugin=cgroup/v1\n")  # read even if no plugin uses it

    def launch(self, name, *command):
        def tie():
            ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)

        with open(self.folder / "log" / f"{name}.err", "ab") as errors:
            started = subprocess.Popen(command, env=environment(self.folder), cwd=self.folder, stdin=subprocess.DEVNULL,
                                       stdout=errors, stderr=errors, preexec_fn=tie, start_new_session=True)
        self.daemons[name] = started.pid

    def start_munge(self):
        folder = self.folder / "munge"
        key = folder / "key"
        key.touch(mode=0o600)
        key.write_bytes(os.urandom(128))
        # --force: the folder's parents may be writable by others, as /tmp is.
        self.launch("munged", "munged", "--foreground", "--force", "--num-threads=2", "--origin=127.0.0.1", f"--key-file={key}",
                    f"--socket={folder}/socket", f"--pid-file={folder}/pid", f"--log-file={folder}/log", f"--seed-file={folder}/seed")

    def start_controller(self):
        self.launch("slurmctld", "slurmctld", "-D")

    def start_node(self, node, booted=False):
        if node not in self.nodes or node in self.daemons:
            raise ClusterError(f"found node '{node}', wanted one of {self.nodes} that is down")
        self.launch(node, "slurmd", "-D", "-N", node, *(["-b"] if booted else []))

    def kill_node(self, node):
        """Simulates a power failure: slurmd first, so that it starts nothing more, then its steps and their children."""
        if node not in self.nodes or node not in self.daemons:
            raise ClusterError(f"found node '{node}', wanted one of {self.nodes} that is up")
        signal_to(self.daemons[node], signal.SIGSTOP)
        killed, fresh = [], [self.daemons[node], *descendants(self.daemons[node])]
        while fresh:
            for process in fresh:
                signal_to(process, signal.SIGKILL)
            killed += fresh
            self.reap()
            steps = self.steps(node)
            fresh = steps + [process for step in steps for process in descendants(step)]
        self.wait_for_end(node, 5)
        return killed

    def steps(self, node):
        """Orphans of a node: steps, which keep the node's log open, and detached processes of jobs."""
        log, name = str(self.folder / "log" / node), f"SLURMD_NODENAME={node}"
        adopted = [process for process, parent in parents().items() if parent == os.getpid()]
        return [process for process in adopted if process not in self.daemons.values()
                and (log in open_files(process) or name in variables(process))]

    def stop(self, name):
        signal_to(self.daemons[name], signal.SIGTERM)
        self.wait_for_end(name, 20)

    def wait_for_end(self, name, limit_s):
        deadline = time.monotonic() + limit_s
        while name in self.daemons:
            if time.monotonic() > deadline:
                raise ClusterError(f"{name} did not end within {limit_s} s")
            time.sleep(0.02)
            self.reap()

    def wait_for(self, path):
        deadline = time.monotonic() + START_S
        while not path.exists() and time.monotonic() < deadline:
            time.sleep(0.01)

    def reap(self):
        """Reaps ended children; false once there is no child left."""
        try:
            while (process := os.waitpid(-1, os.WNOHANG)[0]) > 0:
                self.daemons = {name: pid for name, pid in self.daemons.items() if pid != process}
        except ChildProcessError:
            return False
        return True

    def end_all(self):
        """Kills everything; a clean shutdown is not needed, since Slurm's state is removed anyway."""
        while self.reap():
            for process in descendants(os.getpid()):
                signal_to(process, signal.SIGKILL)
            time.sleep(0.01)
        shutil.rmtree(self.folder, ignore_errors=True)

    def answer(self, words):
        match words:
            case ["kill-node", node]:
                return "killed " + " ".join(map(str, self.kill_node(node)))
            case ["start-node", node]:
                self.start_node(node, booted=True)
            case ["freeze-node", node] if node in self.daemons:
                signal_to(self.daemons[node], signal.SIGSTOP)
            case ["thaw-node", node] if node in self.daemons:
                signal_to(self.daemons[node], signal.SIGCONT)
            case ["stop-controller"] if "slurmctld" in self.daemons:
                self.stop("slurmctld")
            case ["start-controller"] if "slurmctld" not in self.daemons:
                self.start_controller()
            case ["missing"]:
                return " ".join(name for name in ("munged", "slurmctld", *self.nodes) if name not in self.daemons)
            case _:
                raise ClusterError(f"found request '{' '.join(words)}', which does not match the running daemons: {', '.join(self.daemons)}")
        return ""

    def serve(self, listener, tie):
        """Answers requests until a stop request, or until the other end of `tie` is closed."""
        watched = selectors.DefaultSelector()
        watched.register(listener, selectors.EVENT_READ)
        if tie is not None:
            watched.register(tie, selectors.EVENT_READ)
        while True:
            for key, _ in watched.select(timeout=0.2):
                if key.fileobj is tie:
                    if not os.read(tie, 1):
                        return None
                    continue
                client = listener.accept()[0]
                words = client.makefile().readline().split()
                if words == ["stop"]:
                    return client
                with client:
                    client.sendall(self.reply(words).encode())
            self.reap()

    def reply(self, words):
        try:
            return "ok " + self.answer(words)
        except ClusterError as error:
            return f"error {error}"


def open_files(process):
    folder = pathlib.Path("/proc", str(process), "fd")
    try:
        return [os.readlink(entry) for entry in folder.iterdir()]
    except OSError:
        return []  # it has ended meanwhile


def variables(process):
    try:
        return pathlib.Path("/proc", str(process), "environ").read_text(errors="replace").split("\0")
    except OSError:
        return []  # it has ended meanwhile


def ask(folder, *words, limit_s=60):
    """One request to the keeper of `folder`; returns its answer."""
    with socket.socket(socket.AF_UNIX) as line:
        line.settimeout(limit_s)
        try:
            line.connect(str(folder / "control"))
            line.sendall((" ".join(words) + "\n").encode())
            reply = line.makefile().read()
        except OSError as error:
            raise ClusterError(f"{folder}: no cluster answers here: {error}") from None
    word, _, text = reply.partition(" ")
    if word != "ok":
        raise ClusterError(text or f"{folder}: the cluster ended before it answered")
    return text


def stop(folder):
    """Returns when all processes have ended, including the keeper."""
    keeper = int(ask(folder, "stop"))
    while keeper in parents():
        time.sleep(0.01)


def idle_nodes(folder):
    listed = subprocess.run(["sinfo", "-h", "-N", "-p", "batch", "-o", "%N %t"], env=environment(folder), capture_output=True,
                           text=True, check=False)
    return [line.split()[0] for line in listed.stdout.splitlines() if line.split()[1:] == ["idle"]]


def tails(folder, characters=2000):
    """The ends of the daemons' logs."""
    paths = [folder / "keeper", *sorted((folder / "log").iterdir())]
    return "".join(f"\n--- {path.name}\n{path.read_text(errors='replace')[-characters:]}" for path in paths)


def keep(folder, nodes, cpus, tie):
    """Main function of the keeper, in its own process and session."""
    os.setsid()
    ctypes.CDLL(None).prctl(PR_SET_CHILD_SUBREAPER, 1)
    for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP):
        signal.signal(number, lambda *_: sys.exit(0))
    keeper, client = Keeper(folder, nodes, cpus), None
    try:
        keeper.write_configuration()
        listener = socket.socket(socket.AF_UNIX)
        listener.bind(str(folder / "control"))
        listener.listen()
        keeper.start_munge()
        keeper.wait_for(folder / "munge" / "socket")
        keeper.start_controller()
        for node in keeper.nodes:
            keeper.start_node(node)
        client = keeper.serve(listener, tie)
    finally:
        for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP):
            signal.signal(number, signal.SIG_IGN)  # the clean-up must not be interrupted
        keeper.end_all()
        if client is not None:
            client.sendall(f"ok {os.getpid()}".encode())


def detach(folder, work):
    """Runs `work` in a grandchild, so that it survives the end of this process and its children."""
    child = os.fork()
    if child:
        os.waitpid(child, 0)
        return
    if os.fork():
        os._exit(0)
    try:
        # Close the output, which the caller may read to its end.
        sys.stdout.flush()
        log = os.open(folder / "keeper", os.O_WRONLY | os.O_CREAT, 0o644)
        for descriptor in (1, 2):
            os.dup2(log, descriptor)
        work()
    except SystemExit:
        pass
    except BaseException:
        traceback.print_exc()
    finally:
        os._exit(0)


def start(folder, nodes=3, cpus=2, tied=False):
    """Returns when every node is idle."""
    if missing := missing_programs():
        raise ClusterError(f"found no {', '.join(missing)}; wanted the packages slurm-wlm and munge")
    if len(str(folder)) > LONGEST_DIR:
        raise ClusterError(f"{folder}: found {len(str(folder))} characters, wanted at most {LONGEST_DIR}")
    folder.mkdir(exist_ok=True)
    if any(folder.iterdir()):
        raise ClusterError(f"{folder}: found a folder that is not empty, wanted an empty one")
    detach(folder, lambda: keep(folder, nodes, cpus, 0 if tied else None))
    deadline = time.monotonic() + START_S
    while time.monotonic() < deadline:
        time.sleep(0.1)
        if (folder / "control").exists() and len(idle_nodes(folder)) == nodes:
            return
    words = ask(folder, "missing") or "none"
    logs = tails(folder)
    stop(folder)
    raise ClusterError(f"{folder}: not every node idle after {START_S} s; daemons that ended: {words}{logs}")


def main(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command", choices=("start", "stop", "stop-controller", "start-controller", "kill-node", "start-node",
                                            "freeze-node", "thaw-node"))
    parser.add_argument("folder", metavar="DIR", type=lambda text: pathlib.Path(text).absolute())
    parser.add_argument("node", nargs="*", metavar="nX")
    parser.add_argument("--nodes", type=int, default=3)
    parser.add_argument("--cpus", type=int, default=2)
    parser.add_argument("--tied", action="store_true")
    given = parser.parse_args(arguments)
    try:
        if given.command == "start":
            start(given.folder, given.nodes, given.cpus, given.tied)
        elif given.command == "stop":
            stop(given.folder)
        else:
            if answer := ask(given.folder, given.command, *given.node):
                print(answer)
    except ClusterError as error:
        print(f"private_slurm: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
