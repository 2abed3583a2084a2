#!/usr/bin/python3
"""Failures of a submission on a cluster; after each, the motion model has the bytes of a plain run.

usage: scenarios_test.py VRDA FAULT_SHIM [CLASS]...
Each class is a separate CTest test on its own cluster, since they mostly wait.
"""
import os
import pathlib
import pwd
import re
import shlex
import shutil
import sys
import time
import unittest

import cluster

VRDA, SHIM = (pathlib.Path(word).resolve() for word in sys.argv[1:3])
JOB = pathlib.Path(__file__).resolve().parents[2] / "jobs/knee-generic.toml"
SHARDS = 8
ONCE = ("--set", "solver.equilibrium.restarts=0")  # half of the time
GRID = ("--set", "grid.flexion.step=5", "--set", "grid.varus.step=2", *ONCE)  # 19 rows, so two or three per shard, of 11 cells
SOME_WRITES = 5  # well inside a shard
SLOTS = 6  # three nodes of two processors

CAMPAIGN = """[campaign]
title = "Two grids"

[[campaign.subject]]
name = "generic"
job = "{job}"

[[campaign.resolution]]
name = "coarse"
set = {{ grid = {{ flexion = {{ step = 15 }}, varus = {{ step = 5 }} }}, solver.equilibrium.restarts = 0 }}

[[campaign.resolution]]
name = "fine"
set = {{ grid = {{ flexion = {{ step = 10 }}, varus = {{ step = 2 }} }}, solver.equilibrium.restarts = 0 }}
"""
CASES = {"generic_coarse": ("--set", "grid.flexion.step=15", "--set", "grid.varus.step=5", *ONCE),
         "generic_fine": ("--set", "grid.flexion.step=10", "--set", "grid.varus.step=2", *ONCE)}


def setUpModule():
    global machine, programs
    unittest.addModuleCleanup(assert_nothing_left)
    machine = unittest.enterModuleContext(cluster.Cluster())
    # Copies in a folder that any user may read, like a cluster's shared folder.
    programs = machine.work / "programs"
    programs.mkdir()
    for each in (VRDA, SHIM, JOB):
        shutil.copy(each, programs)


def assert_nothing_left():
    """Checks all scenarios once the cluster has ended."""
    left = cluster.processes_using(machine.folder)
    if left or machine.folder.exists():
        raise AssertionError(f"left of {machine.folder}: {left}")


class Submission:
    """One folder of `vrda submit`, with its commands and queries."""

    def __init__(self, name, job=None, grid=GRID, shards=SHARDS, prefix=()):
        self.job, self.grid, self.shards, self.prefix = job or programs / JOB.name, grid, shards, prefix
        self.folder = machine.work / name / "out put's"  # scripts must work in any folder
        self.gate = machine.work / name / "gate"
        (machine.work / name).mkdir()
        (machine.work / name).chmod(0o777)
        self.model = self.folder / f"{JOB.stem}.h5"

    def vrda(self, *words, timeout=120, **variables):
        return machine.run(programs / VRDA.name, *words, prefix=self.prefix, timeout=timeout, **variables)

    def submit(self, time=10, partition="batch", options=(), **variables):
        return self.vrda("submit", self.job, "-o", self.folder, "--shards", self.shards, "--partition", partition, "--time", time,
                         "--mem", "200M", *options, *self.grid, **variables)

    def fault(self, do, journal, at=SOME_WRITES):
        """Environment that injects a fault into a write of a journal, in every process that reaches it."""
        return {"LD_PRELOAD": programs / SHIM.name, "ASAN_OPTIONS": "verify_asan_link_order=0",  # the shim is not a sanitizer
                "VRDA_FAULT_FILE": journal, "VRDA_FAULT_CALL": "write", "VRDA_FAULT_AT": at,
                "VRDA_FAULT_DO": do, "VRDA_FAULT_GATE": self.gate}

    def held(self):
        return pathlib.Path(f"{self.gate}.held").exists()

    def open(self):
        self.gate.touch()

    def journal(self, shard):
        return pathlib.Path(f"{self.model}.shard-{shard}-of-{SHARDS}.journal")

    def journals(self):
        return sorted(self.folder.glob("*.journal"))

    def begun(self):
        """Shards whose journal is not empty."""
        return [shard for shard in range(1, SHARDS + 1) if self.journal(shard).exists() and self.journal(shard).stat().st_size > 0]

    def status(self):
        done = self.vrda("status", self.folder, "--json")
        if done.returncode != 0:
            raise AssertionError(f"vrda status ended with {done.returncode}: {done.stderr}")
        return cluster.read_json(done.stdout)

    def tasks(self):
        """The tasks of `vrda status` by kind, shards by number."""
        (case,) = self.status()["cases"]
        return {task["shard"] or task["kind"]: task for task in case["tasks"]}

    def states(self):
        return {name: task["state"] for name, task in self.tasks().items()}

    def restarts(self):
        """Number of Slurm restarts of each shard, from its state file."""
        states = {shard: self.folder / "tasks" / f"{JOB.stem}.shard-{shard}-of-{SHARDS}.json" for shard in range(1, SHARDS + 1)}
        return {shard: cluster.read_json(path.read_text())["restarts"] for shard, path in states.items()}

    def logs(self):
        return "\n".join(f"--- {path}\n{cluster.tail(path)}" for path in sorted((self.folder / "logs").glob("*")))


class Scenario(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.plain = cls.plain_run(GRID)

    @classmethod
    def plain_run(cls, grid):
        """SHA-256 of the model of a run in one process."""
        path = machine.work / f"plain-{len(list(machine.work.glob('plain-*')))}" / f"{JOB.stem}.h5"
        done = machine.run(programs / VRDA.name, "run", programs / JOB.name, "-o", path, "--progress", "none", *grid)
        if done.returncode != 0:
            raise AssertionError(f"the plain run ended with {done.returncode}: {done.stderr}")
        return cluster.sha256(path)

    def setUp(self):
        begin = time.monotonic()
        self.addCleanup(lambda: print(f"{time.monotonic() - begin:.0f} s ", end="", file=sys.stderr))
        self.addCleanup(machine.clean)
        self.name = self.id().rpartition(".")[2]

    def submission(self, name="", **options):
        made = Submission(self.name + name, **options)
        self.addCleanup(made.open)
        return made

    def submit(self, made, **options):
        done = made.submit(**options)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def wait(self, made, what, condition, timeout=60):
        return machine.wait_until(what, condition, timeout, show=made.logs)

    def wait_for_all(self, made):
        self.wait(made, "no job left", lambda: not machine.jobs(), 120)

    def assert_done(self, made, sha=None):
        """The queue is empty, and the model exists and equals that of a plain run."""
        self.wait_for_all(made)
        self.assertTrue(made.model.exists(), made.logs())
        self.assertEqual(cluster.sha256(made.model), sha or self.plain, made.logs())
        self.assert_no_step_twice(made)
        # Journals and auxiliary files have been removed.
        left = sorted(path.name for path in made.folder.iterdir())
        self.assertEqual(left, [made.model.name, f"{made.model.name}.run.json", "logs", "scripts", "submission.json", "submission.lock",
                                "submitted.jsonl", "tasks"])
        self.assertIn("nothing is missing", made.vrda("resume", made.folder).stderr)

    def assert_no_step_twice(self, made):
        """No attitude is in two journals: nothing was solved twice."""
        for log in (made.folder / "logs").iterdir():
            self.assertNotIn("in more than one journal", log.read_text(errors="replace"), log)

    def hold_all(self, made, **options):
        """One shard per processor runs, and none can end before the gate is open."""
        self.submit(made, **options, **made.fault("hold", "-of-8.journal"))
        self.wait(made, "a shard on every processor", lambda: len(made.begun()) == SLOTS and made.held())

    def shards_on(self, node):
        return [int(task.partition("_")[2]) for task, where in self.running().items() if where == node]

    def assert_merge_names(self, made, what):
        merged = made.vrda("merge", *made.journals(), "-o", made.folder / "by-hand.h5")
        self.assertEqual((merged.returncode, merged.stdout, merged.stderr.count("\n")), (2, "", 1))
        self.assertIn(what, merged.stderr)

    def resume(self, made, said):
        """Submits only the missing tasks; a second resume submits nothing."""
        done = made.vrda("resume", made.folder)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stdout, said)
        again = made.vrda("resume", made.folder)
        self.assertEqual((again.returncode, again.stdout), (0, ""))
        self.assertIn("nothing is missing", again.stderr)

    def running(self):
        """Running array tasks: {"12_3": "n1"}."""
        listed = machine.run("squeue", "-h", "-r", "-t", "RUNNING", "-o", "%i %N").stdout
        return dict(line.split() for line in listed.splitlines() if "_" in line.split()[0])


class Submissions(Scenario):
    def test_an_array_of_eight_on_three_nodes(self):
        """By an ordinary user."""
        is_root = os.getuid() == 0
        user = "nobody" if is_root else pwd.getpwuid(os.getuid()).pw_name
        made = self.submission(prefix=cluster.as_user(user) if is_root else ())
        self.assertRegex(self.submit(made), r"^spine \d+, shards \d+_\[1-8\], merge \d+\n$")
        self.assert_done(made)
        self.assertEqual(made.model.owner(), user)
        self.assertEqual(set(made.states().values()), {"done"})
        self.assertEqual(set(made.restarts().values()), {0})

    def test_a_shard_that_fails_is_named_and_alone_made_again(self):
        made = self.submission()
        self.submit(made, **made.fault("eio", "shard-3-of-8.journal"))
        self.wait_for_all(made)
        self.assertFalse(made.model.exists())
        tasks = made.tasks()
        self.assertEqual({name: task["state"] for name, task in tasks.items()},
                         {"spine": "done", **{shard: "done" for shard in range(1, SHARDS + 1)}, 3: "failed", "merge": "failed"})
        self.assertRegex(tasks[3]["reason"], "shard-3-of-8.journal.*Input/output error")
        self.assert_merge_names(made, "at flexion 10, 50 and 90")  # rows 2, 10 and 18 of 5 degrees
        self.resume(made, r"^shards \d+_\[3\], merge \d+\n$")
        self.assert_done(made)

    def test_a_shard_that_is_killed_says_so_and_goes_on_when_resumed(self):
        """As when the system is out of memory."""
        made = self.submission()
        self.submit(made, **made.fault("kill", "shard-3-of-8.journal"))
        self.wait_for_all(made)
        self.assertFalse(made.model.exists())
        shard = made.tasks()[3]
        self.assertEqual(shard["state"], "failed")
        self.assertRegex(shard["reason"], "(?i)signal 9|killed")
        self.assertTrue(0 < shard["done"] < SOME_WRITES, shard)
        self.resume(made, r"^shards \d+_\[3\], merge \d+\n$")
        self.assert_done(made)

    def test_a_journal_that_is_gone_is_named_and_made_again(self):
        made = self.submission()
        self.submit(made, **made.fault("hold", f"shard-{SHARDS}-of-{SHARDS}.journal"))
        self.wait(made, "all others done", lambda: list(made.states().values()).count("done") == SHARDS)
        made.journal(5).unlink()
        made.open()
        self.wait_for_all(made)
        self.assertFalse(made.model.exists())
        tasks = made.tasks()
        self.assertEqual((tasks[5]["state"], tasks["merge"]["state"]), ("lost", "failed"))
        self.assertIn("no journal of shard 5 of 8", tasks["merge"]["reason"])
        self.assert_merge_names(made, "no journal of shard 5 of 8")
        self.resume(made, r"^shards \d+_\[5\], merge \d+\n$")
        self.assert_done(made)

    def test_cancelled_is_cancelled_until_resumed(self):
        made = self.submission()
        self.hold_all(made)
        running = set(machine.run("squeue", "-h", "-r", "-t", "RUNNING", "-o", "%A").stdout.split())
        machine.run("scancel", *{job.partition("_")[0] for job in machine.jobs()})
        self.wait(made, "all have received SIGTERM", lambda: running <= machine.signalled_jobs())
        made.open()
        self.wait_for_all(made)
        self.assertFalse(made.model.exists())
        self.resume(made, r"^shards \d+_\[1-8\], merge \d+\n$")
        self.assert_done(made)

    def test_two_submissions_at_once(self):
        other_grid = (*GRID, "--set", "grid.varus.step=4")
        one, other = self.submission("-one"), self.submission("-other", grid=other_grid)
        self.submit(one)
        self.submit(other)
        again = one.submit()
        self.assertEqual((again.returncode, again.stdout, again.stderr.count("\n")), (2, "", 1))
        self.assertIn("vrda resume", again.stderr)
        self.assert_done(one)
        self.assert_done(other, self.plain_run(other_grid))

    def test_no_more_at_once_than_requested(self):
        made = self.submission()
        self.submit(made, options=["--max-parallel", 2, "--extra=--comment=few"], **made.fault("hold", "-of-8.journal"))
        self.wait(made, "two shards run", lambda: len(made.begun()) == 2)
        limited = lambda: [shard for shard, task in made.tasks().items() if "JobArrayTaskLimit" in task["reason"]]
        self.wait(made, "and no more", limited)
        self.assertEqual(len(self.running()), 2)
        self.assertIn("Comment=few", machine.run("scontrol", "show", "job", next(iter(self.running()))).stdout)
        made.open()
        self.assert_done(made)

    def test_a_job_that_cannot_be(self):
        made = self.submission()
        done = made.submit(partition="nowhere")
        self.assertEqual((done.returncode, done.stdout, done.stderr.count("\n")), (2, "", 1))
        self.assertRegex(done.stderr, "(?i)partition")
        self.assertEqual(machine.jobs(), {})
        self.submit(made)  # the failed job does not interfere
        self.assert_done(made)

    def test_a_submission_from_within_an_array(self):
        """Its jobs do not inherit that task or its restarts, although sbatch propagates all variables."""
        made = self.submission(shards=3)
        words = ["submit", made.job, "-o", made.folder, "--shards", 3, "--partition", "batch", "--time", 10, "--mem", "200M", *made.grid]
        script = "export SLURM_RESTART_COUNT=1; exec " + shlex.join(map(str, [programs / VRDA.name, *words]))
        submitted = machine.run("sbatch", "--array=1", "--output=/dev/null", "--mem=50M", "--wrap", script)
        self.assertEqual((submitted.returncode, submitted.stderr), (0, ""))
        self.assert_done(made)
        for kind in ("spine", "merge"):
            state = cluster.read_json((made.folder / "tasks" / f"{JOB.stem}.{kind}.json").read_text())
            self.assertRegex(state["slurm_job"], r"^\d+$")
            self.assertEqual(state["restarts"], 0)

    def test_local_processes_within_a_job(self):
        """They are not Slurm tasks, although Slurm's variables are in the environment."""
        made = self.submission(shards=3)
        local = ["submit", "--local", "--workers", 2, "--shards", 3, made.job, "-o", made.folder, *made.grid]
        script = "exec " + shlex.join(map(str, [programs / VRDA.name, *local]))
        self.assertEqual(machine.run("sbatch", "--output=/dev/null", "--cpus-per-task=2", "--wrap", script,
                                     **made.fault("hold", "shard-2-of-3.journal")).returncode, 0)
        self.wait(made, "shard 2 is held", made.held)
        self.assertEqual((made.states()[2], made.states()["merge"]), ("running", "waiting"))
        machine.run("scancel", "--batch", "--signal=TERM", *machine.jobs())
        made.open()
        self.wait_for_all(made)
        self.assertEqual(made.states()[2], "interrupted")
        self.assertEqual(made.vrda("resume", made.folder, "--local").returncode, 0)
        self.assertEqual(cluster.sha256(made.model), self.plain)
        self.assert_no_step_twice(made)


class LostNodes(Scenario):
    def test_a_node_crashes_with_its_tasks_and_returns(self):
        made = self.submission()
        self.hold_all(made)
        lost = self.shards_on("n2")
        self.assertEqual(len(lost), 2)
        machine.ask("kill-node", "n2")
        made.open()
        self.wait(made, "the node is seen dead", lambda: machine.node_states()["n2"].startswith("down"))
        machine.ask("start-node", "n2")
        self.assert_done(made)
        self.assertEqual(made.restarts(), {shard: int(shard in lost) for shard in range(1, SHARDS + 1)})

    def test_a_node_crashes_under_the_spine(self):
        made = self.submission()
        self.submit(made, **made.fault("hold", "spine.journal"))
        self.wait(made, "the spine is held", made.held)
        (node,) = machine.run("squeue", "-h", "-t", "RUNNING", "-o", "%N").stdout.split()
        machine.ask("kill-node", node)
        made.open()
        self.assert_done(made)
        spine = cluster.read_json((made.folder / "tasks" / f"{JOB.stem}.spine.json").read_text())
        self.assertEqual((spine["state"], spine["restarts"]), ("done", 1))

    def test_a_node_only_seems_dead(self):
        """Its tasks continue in parallel with their replacements until it returns and is reported to end them."""
        made = self.submission()
        self.submit(made, **made.fault("hold", "shard-4-of-8.journal"))
        self.wait(made, "it is alone and held", lambda: made.held() and len(self.running()) == 1 and len(made.begun()) == SHARDS)
        (node,) = self.running().values()
        machine.ask("freeze-node", node)
        self.addCleanup(machine.ask, "thaw-node", node)
        before = made.journal(4).read_bytes()
        self.wait(made, "it is begun elsewhere", lambda: set(self.running().values()) - {node})
        self.wait(made, "the second waits for the first", lambda: "waiting for the run that writes" in made.logs())
        self.assertEqual(made.journal(4).read_bytes(), before)
        made.open()
        machine.ask("thaw-node", node)
        self.assert_done(made)
        self.assertEqual(made.restarts()[4], 1)

    def test_nodes_that_cannot_begin_a_task(self):
        """Slurm holds such a task indefinitely."""
        spools = [machine.folder / node for node in ("n1", "n2", "n3")]
        for spool in spools:
            spool.rename(f"{spool}.kept")
            spool.touch()  # no folder for the script

        def mend():
            for spool in spools:
                if spool.is_file():
                    spool.unlink()
                    pathlib.Path(f"{spool}.kept").rename(spool)

        self.addCleanup(mend)
        made = self.submission()
        self.submit(made)
        self.wait(made, "the spine is held", lambda: "vrda resume releases it" in made.tasks()["spine"]["reason"])
        mend()
        resumed = made.vrda("resume", made.folder)
        self.assertEqual((resumed.returncode, resumed.stdout), (0, ""))
        self.assertRegex(resumed.stderr, r"^\d+ is released: .*\nnothing is missing: 10 tasks are queued or running\n$")
        self.assert_done(made)

    def test_two_campaigns_at_once(self):
        """Whole cases and shards of cases on one cluster; a node crashes."""
        job = machine.work / "sizes.toml"
        job.write_text(CAMPAIGN.format(job=programs / JOB.name))
        whole, cut = (self.submission(f"-{shards}", job=job, grid=(), shards=shards) for shards in (1, 3))
        self.assertRegex(self.submit(whole), r"^cases \d+_\[1-2\], index \d+\n$")
        self.submit(cut, **cut.fault("hold", "shard-2-of-3.journal"))
        self.wait(cut, "a shard is held", cut.held)
        machine.ask("kill-node", next(iter(self.running().values())))
        cut.open()
        self.wait_for_all(cut)
        for name, grid in CASES.items():
            plain = self.plain_run(grid)
            models = [made.folder / name / f"{name}.h5" for made in (whole, cut)]
            self.assertEqual([cluster.sha256(model) for model in models], [plain] * 2, cut.logs())
        for name in ("index.csv", "index.h5"):
            self.assertEqual(cluster.sha256(whole.folder / name), cluster.sha256(cut.folder / name))
        self.assert_no_step_twice(cut)
        self.assertEqual([case["state"] for case in cut.status()["cases"]], ["done"] * 2)


class Interruptions(Scenario):
    def test_the_last_task_reaches_its_time_limit(self):
        """The last task has the array's job number; no other task may restart with it."""
        made = self.submission()
        said = self.submit(made, time=2, **made.fault("hold", f"shard-{SHARDS}-of-{SHARDS}.journal"))
        self.wait(made, "it is held", made.held)
        (array,) = re.findall(r"shards (\d+)_", said)
        self.wait(made, "it has received SIGTERM", lambda: array in machine.signalled_jobs(), 150)
        made.open()
        self.assert_done(made)
        self.assertEqual(made.restarts(), {shard: int(shard == SHARDS) for shard in range(1, SHARDS + 1)})

    def test_urgent_jobs_take_every_place(self):
        made = self.submission()
        self.hold_all(made)
        gate = machine.work / self.name / "urgent"
        self.addCleanup(gate.touch)
        submitted = machine.run("sbatch", "--partition=urgent", f"--array=1-{SLOTS}", "--mem=50M", "--output=/dev/null", "--wrap",
                            f"until [ -e {gate} ]; do sleep 0.1; done")
        self.assertEqual((submitted.returncode, submitted.stderr), (0, ""))
        urgent = submitted.stdout.split()[-1]
        self.wait(made, "the urgent run", lambda: [task.partition("_")[0] for task in self.running()] == [urgent] * SLOTS, 150)
        made.open()
        gate.touch()
        self.assert_done(made)
        self.assertEqual(sum(made.restarts().values()), SLOTS)

    def test_the_controller_is_away_while_tasks_end(self):
        made = self.submission()
        self.hold_all(made)
        (first, *_) = self.shards_on("n1")
        machine.ask("stop-controller")
        made.open()
        state = made.folder / "tasks" / f"{JOB.stem}.shard-{first}-of-{SHARDS}.json"
        self.wait(made, "a shard ends", lambda: cluster.read_json(state.read_text())["state"] == "done")
        status = made.status()
        self.assertNotEqual(status["remark"], "")  # the failed query of Slurm is reported
        machine.ask("start-controller")
        self.assert_done(made)


if __name__ == "__main__":
    cluster.skip_without_slurm("slurm.Scenarios")
    unittest.main(argv=sys.argv[:1] + sys.argv[3:], verbosity=2)
