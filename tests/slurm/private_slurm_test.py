#!/usr/bin/python3
"""Tests of the private cluster: nothing is left after any kind of end. scenarios_test.py has crashes of its nodes and urgent jobs."""
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


class PrivateSlurm(unittest.TestCase):
    def assert_gone(self, machine):
        self.assertEqual((cluster.processes_using(machine.folder), machine.folder.exists()), ([], False))

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
