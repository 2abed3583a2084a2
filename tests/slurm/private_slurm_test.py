#!/usr/bin/python3
"""Tests of the private cluster: jobs run, a node crashes and returns, and nothing is left after any kind of end."""
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time
import unittest

import cluster
import private_slurm

# Records each start and the node, then waits for the gate.
JOB = """#!/bin/bash
#SBATCH --open-mode=append --output=%a.log --mem=50M
echo "start ${SLURM_RESTART_COUNT:-0} $SLURMD_NODENAME"
until [ -e gate ]; do sleep 0.1; done
echo end
"""


class PrivateSlurm(unittest.TestCase):
    def submit(self, machine, *options):
        script = machine.work / "job.sh"
        script.write_text(JOB)
        done = machine.run("sbatch", "--parsable", *options, script)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return done.stdout.strip()

    def started(self, machine, tasks):
        return [task for task in tasks if "start" in cluster.tail(machine.work / f"{task}.log")]

    def assert_gone(self, machine):
        self.assertEqual((cluster.processes_using(machine.folder), machine.folder.exists()), ([], False))

    def test_an_array_survives_the_crash_of_a_node_and_a_new_controller(self):
        with cluster.Cluster() as machine:
            self.submit(machine, "--array=0-5")
            machine.wait_until("six tasks started", lambda: len(self.started(machine, range(6))) == 6)
            lost = [task for task in range(6) if "n2" in (machine.work / f"{task}.log").read_text()]
            self.assertEqual(len(lost), 2)
            killed = machine.ask("kill-node", "n2").split()[1:]
            self.assertGreaterEqual(len(killed), 1 + 3 * len(lost))  # slurmd; per task a step, the script, its sleep
            self.assertFalse(set(map(int, killed)) & set(private_slurm.parents()))
            machine.ask("stop-controller")
            machine.ask("start-controller")
            self.assertEqual(len(machine.wait_until("the controller answers", machine.jobs)), 6)
            machine.wait_until("the node is down", lambda: machine.node_states()["n2"].startswith("down"))
            (machine.work / "gate").touch()
            machine.ask("start-node", "n2")
            machine.wait_until("every task ended", lambda: not machine.jobs())
            for task in range(6):
                lines = (machine.work / f"{task}.log").read_text().splitlines()
                self.assertEqual([line.split()[0] for line in lines], ["start"] * (2 if task in lost else 1) + ["end"], task)
            machine.clean()
        self.assert_gone(machine)

    def test_an_urgent_job_takes_the_place_of_another_which_comes_again(self):
        with cluster.Cluster(nodes=1, cpus=1) as machine:
            self.submit(machine, "--array=0")
            machine.wait_until("the first started", lambda: self.started(machine, [0]))
            self.submit(machine, "--array=1", "--partition=urgent")
            machine.wait_until("the urgent started", lambda: self.started(machine, [1]))
            self.assertIn("PENDING", machine.jobs().values())
            (machine.work / "gate").touch()
            machine.wait_until("both ended", lambda: not machine.jobs())
            self.assertEqual((machine.work / "0.log").read_text().split("\n")[-3:], ["start 1 n1", "end", ""])
            self.assertEqual((machine.work / "1.log").read_text(), "start 0 n1\nend\n")
        self.assert_gone(machine)

    def test_it_ends_with_the_program_that_is_tied_to_it(self):
        """Killed, with a running job that has left its session and ignores signals."""
        with tempfile.TemporaryDirectory(prefix="vrda-slurm-") as folder:
            place = pathlib.Path(folder) / "cluster"
            holder = subprocess.Popen(["sleep", "600"], stdout=subprocess.PIPE)
            with holder.stdout as tie:
                private = [sys.executable, cluster.PROGRAM, "start", place, "--tied", "--nodes", "1"]
                # The pipe's only writer is the sleeping program.
                self.assertEqual(subprocess.run(private, stdin=tie, check=False).returncode, 0)
            job = f"trap '' TERM HUP; touch {folder}/up; setsid nohup sleep 600 & sleep 600"
            subprocess.run(["sbatch", "--output=/dev/null", "--wrap", job], env=private_slurm.environment(place),
                           stdout=subprocess.DEVNULL, check=True)
            for _ in range(200):
                if (pathlib.Path(folder) / "up").exists():
                    break
                time.sleep(0.1)
            self.assertGreater(len(cluster.processes_using(place)), 5)  # three daemons, a step, a script, two sleeps
            holder.send_signal(signal.SIGKILL)
            holder.wait()
            for _ in range(200):
                if not place.exists() and not cluster.processes_using(place):
                    break
                time.sleep(0.1)
            self.assertEqual((cluster.processes_using(place), place.exists()), ([], False))

    @unittest.skipIf(os.getuid() != 0, "only root becomes another user; others test this as they are")
    def test_it_belongs_to_an_ordinary_user(self):
        with cluster.Cluster(nodes=1, user="nobody") as machine:
            (machine.work / "gate").touch()
            done = machine.run("sbatch", "--wait", "--output=%j.log", "--wrap", "id -un", prefix=cluster.as_user("nobody"))
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            self.assertEqual((machine.work / "1.log").read_text(), "nobody\n")
        self.assert_gone(machine)

    def test_what_it_cannot_do_is_said_in_one_line(self):
        def said(*words):
            done = subprocess.run([sys.executable, cluster.PROGRAM, *words], capture_output=True, text=True, check=False)
            self.assertEqual((done.returncode, done.stdout, done.stderr.count("\n")), (1, "", 1))
            return done.stderr

        with cluster.Cluster(nodes=1) as machine:
            self.assertRegex(said("kill-node", machine.folder, "n7"), r"'n7'.*\['n1'\]")
            self.assertIn("['n1']", said("start-node", machine.folder, "n1"))
            self.assertIn("wanted an empty one", said("start", machine.folder))
        self.assertIn("no cluster answers here", said("stop", machine.folder))
        self.assertIn("wanted at most", said("start", "/tmp/" + "long" * 20))


if __name__ == "__main__":
    cluster.skip_without_slurm("slurm.PrivateSlurm")
    unittest.main(verbosity=2)
