"""scripts/pages/benchmarks.py on Google Benchmark's JSON."""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

SCRIPT = pathlib.Path(__file__).parents[2] / "scripts" / "pages" / "benchmarks.py"


def run(name, time_ns, **more):
    """One entry in the form of Google Benchmark."""
    return {"name": name, "run_name": name, "run_type": "iteration", "repetitions": 1, "threads": 1, "iterations": 10,
            "real_time": time_ns, "cpu_time": time_ns, "time_unit": "ns", **more}


class BenchPage(unittest.TestCase):
    def table(self, *runs):
        """Completed process for a file with these runs and a context with the host name."""
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder, "benchmarks.json")
            path.write_text(json.dumps({"context": {"host_name": "secret-host"}, "benchmarks": list(runs)}))
            return subprocess.run([sys.executable, SCRIPT, path], capture_output=True, text=True)

    def test_rooms_rows_and_counters(self):
        done = self.table(run("solve/step/generic", 2.5e6, steps_per_second=12345.6, contact_share=0.25),
                          run("solve/step/jam/real_time", 0.5e9, steps_per_second=0.04567),
                          run("contact/query/generic", 130e3, items_per_second=7690.0))
        self.assertEqual(done.returncode, 0, done.stderr)
        lines = done.stdout.splitlines()
        for wanted in ("## solve", "| benchmark | case | time | steps/s | contact share |",
                       "| step | generic | 2.5 ms | 12,300 | 25.0 % |", "| step | jam | 500 ms | 0.0457 |  |",
                       "## contact", "| benchmark | case | time | items/s |", "| query | generic | 130 us | 7,690 |"):
            self.assertIn(wanted, lines)
        self.assertNotIn("secret-host", done.stdout)
        self.assertRegex(done.stdout, r"Machine: \d+ cores?, ")

    def test_of_repetitions_the_median_counts(self):
        repeated = [run("a/b/c", t, repetitions=3) for t in (1.0, 9.0, 2.0)]
        median = run("a/b/c", 2.0, repetitions=3, run_type="aggregate", aggregate_name="median")
        mean = run("a/b/c", 4.0, repetitions=3, run_type="aggregate", aggregate_name="mean")
        done = self.table(*repeated, mean, median)
        self.assertEqual(done.stdout.count("| b | c |"), 1)
        self.assertIn("| b | c | 2 ns |", done.stdout)
        self.assertIn("median of 3 measurements", done.stdout)

    def test_the_power_of_a_scaling(self):
        # time = triangles^(1/2) exactly
        done = self.table(*(run(f"scaling/step/x {n}", 1e3 * n, triangles=float(n * n)) for n in (1, 3, 10)))
        self.assertIn("to the power 0.50 (least squares of the logarithms; 0.50 from the first", done.stdout)

    def test_the_powers_of_growth_are_of_time_and_memory_by_size(self):
        # time = triangles^(1/2), memory = triangles; of attitudes there is one
        done = self.table(*(run(f"growth/triangles/{n}", 1e3 * n, triangles=float(n * n), attitudes=7.0, **{"peak memory, MB": 5.0 * n * n})
                            for n in (1, 3, 10)),
                          run("growth/attitudes/7", 1.0, triangles=1.0, attitudes=7.0, **{"peak memory, MB": 5.0}))
        self.assertEqual(done.stdout.count("to the power"), 2, done.stderr)
        self.assertIn("With triangles, time grows to the power 0.50, memory to the power 1.00 (least", done.stdout)

    def test_one_size_has_no_power(self):
        done = self.table(run("scaling/step/generic", 1.0, triangles=4666.0), run("solve/step/generic", 1.0, triangles=4.0))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertNotIn("to the power", done.stdout)

    def test_an_error_is_named(self):
        done = self.table(run("a/b/c", 1.0), run("a/b/d", 0.0, error_occurred=True, error_message="no such knee"))
        self.assertEqual((done.returncode, done.stdout), (1, ""))
        self.assertRegex(done.stderr, r"\ba/b/d\b.*\bno such knee\b")

    def test_no_benchmark_is_an_error(self):
        done = self.table()
        self.assertEqual((done.returncode, done.stdout), (1, ""))
        self.assertEqual(len(done.stderr.splitlines()), 1)


if __name__ == "__main__":
    unittest.main()
