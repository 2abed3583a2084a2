"""scripts/results: what makes a page of results/ stale.

usage: results_test.py VRDA
"""
import json
import pathlib
import shutil
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
import result_pages as results  # noqa: E402

VRDA = sys.argv.pop(1)
PAGE = "thesis"


class Results(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.today = results.Today(VRDA)

    def stale_with(self, change, name=PAGE):
        """What is reported of a page after `change(record, page's path)` in a copy."""
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            page, record = root / results.PAGES[name].path, results.record_path(name, root)
            for path, original in ((page, ROOT / results.PAGES[name].path), (record, results.record_path(name))):
                path.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(original, path)
            found = json.loads(record.read_text())
            change(found, page)
            record.write_text(json.dumps(found))
            return results.stale(name, self.today, root)

    def test_a_changed_page_is_reported(self):
        found = self.stale_with(lambda record, page: page.write_text(page.read_text().replace("stability-search", "stability-search 0")))
        self.assertEqual(len(found), 1)
        self.assertIn("scripts/results --render", found[0])

    def test_a_record_of_another_solver_is_reported(self):
        def change(record, _):
            next(iter(record["runs"].values()))["solver"] = "stability-search 0"
        self.assertTrue(any("solver: found stability-search 0, wanted stability-search" in line for line in self.stale_with(change)))

    def test_a_record_of_another_job_is_reported(self):
        def change(record, _):
            next(iter(record["runs"].values()))["job"] = "0"
        self.assertTrue(any("found 0, wanted " in line for line in self.stale_with(change)))

    def test_a_changed_number_is_reported(self):
        def change(record, _):
            record["numbers"]["3"]["length_mm"] += 5.0
        self.assertEqual(len(self.stale_with(change)), 1)

    def test_a_missing_run_is_reported(self):
        self.assertTrue(any("scripts/result_pages.py" in line for line in self.stale_with(lambda record, _: record["runs"].popitem())))

    def test_a_long_page_may_be_stale_if_it_says_so(self):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            page = root / results.PAGES["benchmarks"].path
            page.parent.mkdir(parents=True)
            page.write_text("# Benchmarks\n\n- rows\n")
            self.assertIn("results/records/benchmarks.json", results.stale("benchmarks", self.today, root)[0])
            page.write_text(f"# Benchmarks\n\n{results.STALE} measured with an older solver\n")
            self.assertEqual(results.stale("benchmarks", self.today, root), [])

    def test_comments_of_a_job_do_not_count_and_values_do(self):
        with tempfile.TemporaryDirectory() as folder:
            hashes = []
            follower = "a = 1\n[[follower]]\nname = \"f\"\n[[follower.direction]]\nk = 1\n"
            job = pathlib.Path(folder, "job.toml")
            for text in ("a = 1", "# why\na = 1  # so", "a = 2", f"{follower}[b]\n"):
                job.write_text(text)
                hashes.append(results.job_hash(results.Run(job)))
            whole = results.job_hash(results.Run(job, with_followers=True))
            job.write_text("a = 1\n[b]\n")
            self.assertEqual(results.job_hash(results.Run(job)), hashes[3])
        self.assertEqual(hashes[0], hashes[1])
        self.assertNotEqual(hashes[0], hashes[2])
        self.assertNotEqual(whole, hashes[3])


if __name__ == "__main__":
    unittest.main()
