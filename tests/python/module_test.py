"""The package vrda: jobs, runs, single attitudes, motion models, errors. usage: module_test.py VRDA"""
import collections
import gc
import hashlib
import json
import logging
import os
import pathlib
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import weakref

import numpy as np

import vrda
from support import COARSE, KNEE, VRDA


def program(*words):
    return subprocess.run([VRDA, *map(str, words)], capture_output=True, text=True, check=True).stdout


class Model(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(cls.enterClassContext(tempfile.TemporaryDirectory(prefix="vrda-python-")))
        cls.seen = []
        cls.file = vrda.Job(KNEE, set=COARSE).run(cls.folder / "knee.h5", progress=lambda *counts: cls.seen.append(counts))

    def test_a_run_gives_the_bytes_of_the_program(self):
        other = self.folder / "other.h5"
        program("run", KNEE, "-o", other, "--set", "grid.flexion={from=0,to=90,step=15}", "--set", 'grid.varus="free"', "--set", "solver.equilibrium.restarts=0", "-q", "--progress", "none")
        self.assertEqual(*(hashlib.sha256(file.read_bytes()).hexdigest() for file in (self.file, other)))

    def test_progress_rises_to_all_attitudes(self):
        self.assertEqual(self.seen[-1], (7, 7))
        self.assertEqual(sorted(self.seen), self.seen)

    def test_a_finished_run_is_not_solved_again(self):
        before = self.file.stat().st_mtime_ns
        self.assertEqual(vrda.Job(KNEE, set=COARSE).run(self.file), self.file)
        self.assertEqual(self.file.stat().st_mtime_ns, before)

    def test_no_lock_goes_on_without_locks(self):
        """The shim of tests/faults makes flock fail."""
        act = f"print(vrda.Job({str(KNEE)!r}, set={COARSE!r}).run({str(self.folder / 'unlocked.h5')!r}))"
        missing = {"LD_PRELOAD": os.environ["VRDA_FAULT_SHIM"], "VRDA_FAULT_FILE": "unlocked", "VRDA_FAULT_CALL": "lock", "VRDA_FAULT_AT": "1+", "VRDA_FAULT_DO": "enolck"}
        run = [subprocess.run([sys.executable, "-c", f"import vrda; {first}{act}"], env={**os.environ, **missing}, capture_output=True, text=True, check=False)
               for first in ("", "vrda.no_lock(); ")]
        self.assertIn("--no-lock goes on without a lock", run[0].stderr)
        self.assertEqual(run[1].returncode, 0, run[1].stderr)
        self.assertIn("warning: --no-lock: found", program("info", self.folder / "unlocked.h5"))

    def test_open_selects_by_angle_in_root_and_clinical(self):
        with vrda.open(self.file) as knee:
            self.assertEqual(list(knee.coords), ["flexion", "varus"])
            self.assertEqual(knee.internal_rotation.attrs["units"], "degree")
            for name in ("theta", "internal_rotation", "anterior"):
                self.assertTrue(np.isfinite(knee[name].sel(flexion=45, varus=0)), name)
            whole = knee.internal_rotation.values
        with vrda.open(self.file, group="clinical") as clinical:
            np.testing.assert_array_equal(clinical.internal_rotation.sel(flexion=45), whole[3])
            self.assertEqual(list(clinical.coords), ["flexion", "varus"])

    def test_other_readers_of_one_group_find_its_coordinates(self):
        import xarray
        for engine in ("netcdf4", "h5netcdf"):
            for group in ("clinical", "zero_varus", "equilibrium", "ligaments", "equilibrium/spine"):
                with self.subTest(engine=engine, group=group), xarray.open_dataset(self.file, engine=engine, group=group) as one:
                    self.assertEqual(float(one.isel(flexion=3).flexion), 45.0)

    def test_a_joint_solved_alone_has_the_poses_of_the_run(self):
        joint = vrda.Job(KNEE, set=COARSE).joint()
        with vrda.open(self.file) as knee:
            solved = joint.solve(flexion=knee.flexion.values, seed=knee.X_reference_moving.values[0, 0])
            self.assertEqual(set(solved.status), {"stable"})
            # Both are equilibria of the solver's tolerance, 1e-4 mm; the path there differs.
            np.testing.assert_allclose(solved.X_reference_moving, knee.X_reference_moving.values[:, 0], atol=0.02)
            np.testing.assert_allclose(solved.internal, knee.internal_rotation.values[:, 0], atol=0.05)
        patella = solved.followers["patella"]
        with vrda.open(self.file, group="followers/patella") as followed:
            self.assertEqual(set(patella.status), {"stable"})
            # Its own starts differ too: a flexion of a patella is determined to a tenth of a degree.
            np.testing.assert_allclose(patella.flexion, followed.flexion_angle.values[:, 0], atol=0.2)
            np.testing.assert_allclose(patella.proximal, followed.proximal.values[:, 0], atol=0.1)
            np.testing.assert_allclose(patella.X_of_follower, followed.X_of_follower.values[:, 0], atol=0.5)
        self.assertEqual(joint.followers, ["patella"])
        self.assertEqual(patella.tension.shape, (7, len(joint.follower_fibres("patella"))))
        self.assertEqual(joint.follower_vertices("patella").shape[1], 3)
        with self.assertRaisesRegex(vrda.InputError, "patela.*wanted one of patella"):
            joint.follower_triangles("patela")

    def test_smooth_compare_and_export_do_what_the_commands_do(self):
        copy = self.folder / "copy.h5"
        copy.write_bytes(self.file.read_bytes())
        smoothed = vrda.smooth(copy, degree=3)
        self.assertEqual(smoothed, json.loads(program("smooth", copy, "--degree", 3, "--json", "-q")))
        compared = vrda.compare(copy, degrees=[2, 3], refine=0)
        printed = json.loads(program("compare", copy, "--degrees", "2,3", "--refine", 0, "--json", "-q"))
        self.assertEqual(compared, {key: printed[key] for key in compared})
        files = vrda.export(copy, self.folder / "knee.mot", set="degree_3", coordinates={"flexion": "knee_angle_r"}, degrees=True)
        program("export", copy, "--to", "mot", "-o", self.folder / "printed.mot", "--set", "degree_3", "--coordinate", "flexion=knee_angle_r", "--degrees", "-q")
        self.assertEqual(files[0].read_text(), (self.folder / "printed.mot").read_text())
        self.assertEqual(vrda.validate(copy), [])

    def test_a_changed_file_is_refused(self):
        changed = self.folder / "changed.h5"
        raw = bytearray(self.file.read_bytes())
        raw[len(raw) // 2] ^= 1
        changed.write_bytes(raw)
        with self.assertRaises(vrda.InputError) as refusal:
            vrda.open(changed)
        self.assertEqual(refusal.exception.file, str(changed))


Mesh = collections.namedtuple("Mesh", "vertices faces")  # what trimesh's have


class TrackedArray(np.ndarray):
    """As trimesh's: a subclass of NumPy's, faces are int64, and both may be read only."""


def mesh_of(file):
    facets = np.fromfile(file, dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("rest", "<u2")], offset=84)
    vertices, rows = np.unique(facets["corners"].reshape(-1, 3), axis=0, return_inverse=True)
    vertices, rows = (np.array(a).view(TrackedArray) for a in (vertices, rows.reshape(-1, 3).astype(np.int64)))
    vertices.flags.writeable = rows.flags.writeable = False
    return Mesh(vertices, rows)


class Prepare(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(cls.enterClassContext(tempfile.TemporaryDirectory(prefix="python-prepare-")))
        program("shape", "knee-template", "-o", cls.folder / "scan")
        cls.meshes = {bone: mesh_of(cls.folder / f"scan/{bone}.stl") for bone in ("femur", "tibia", "fibula")}

    def test_meshes_in_memory_give_the_job_of_their_files(self):
        files = {bone: self.folder / f"scan/{bone}.stl" for bone in self.meshes}
        with self.assertLogs("vrda", logging.WARNING) as logs:
            made = vrda.prepare(self.folder / "mesh", **self.meshes, no_ligaments=True)
        vrda.prepare(self.folder / "file", femur=files["femur"], tibia=files["tibia"], fibula=files["fibula"], no_ligaments=True)
        self.assertEqual(made.file, self.folder / "mesh/knee.toml")
        self.assertTrue(any("no menisci given" in line for line in logs.output))
        for name in ("femur.stl", "tibia.stl", "fibula.stl"):  # order of the triangles and of the vertices differs from the file's
            one, other = (np.sort(mesh_of(self.folder / kind / name).vertices, axis=None) for kind in ("mesh", "file"))
            np.testing.assert_allclose(one, other, atol=1e-4)  # float32 of STL, and the fit's rounding

    def test_refusals_name_the_argument(self):
        femur, tibia = self.meshes["femur"], self.meshes["tibia"]
        for given, field in (({"femur": 3.5, "tibia": tibia}, "--femur"), ({"femur": object(), "tibia": tibia}, "femur.vertices"),
                             ({"femur": Mesh(femur.vertices[:, :2], femur.faces), "tibia": tibia}, "femur.vertices"),
                             ({"femur": femur, "tibia": Mesh(tibia.vertices, 1.0 * tibia.faces)}, "tibia.faces"),
                             ({"femur": femur, "tibia": Mesh(tibia.vertices, tibia.faces + 1)}, "tibia: face"),
                             ({"femur": femur, "tibia": tibia, "side": "top"}, "--side"), ({"femur": femur, "tibia": tibia, "sides": "left"}, "--sides")):
            with self.subTest(field=field), self.assertRaises(vrda.InputError) as refusal:
                vrda.prepare(self.folder / "refused", **given)
            text = str(refusal.exception)
            self.assertIn(field, text)
            self.assertRegex(text, "found .*, wanted ")
            self.assertFalse((self.folder / "refused").exists())
        with self.assertRaises(vrda.InputError) as refusal:
            vrda.prepare(self.folder / "refused", femur=femur, tibia=Mesh(femur.vertices, femur.faces))
        self.assertNotIn(".ply", str(refusal.exception))
        self.assertNotIn("/tmp/vrda-", str(refusal.exception))

    def test_a_score_is_that_of_the_program(self):
        files = [vrda.Job(KNEE, set={**COARSE, "push.force_n": force_n}).run(self.folder / f"{force_n}.h5") for force_n in (20, 200)]
        self.assertEqual(vrda.score(files[0], files[1], align="constant"),
                         json.loads(program("score", files[0], "--against", files[1], "--align", "constant", "--json", "-q")))
        with self.assertRaisesRegex(vrda.InputError, "absent.csv"):
            vrda.score(files[0], "absent.csv")


class Joint(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.joint = vrda.Joint(KNEE)
        cls.passive = cls.joint.solve(flexion=range(0, 31, 5))

    def test_shapes_units_and_names(self):
        solved = self.passive
        self.assertEqual(len(solved), 7)
        np.testing.assert_allclose(solved.flexion, np.arange(0, 31, 5), atol=1e-9)
        self.assertEqual(solved.X_reference_moving.shape, (7, 4, 4))
        self.assertEqual(solved.tension.shape, (7, len(self.joint.fibres)))
        self.assertEqual(solved.status.tolist(), ["stable"] * 7)
        self.assertTrue((solved.tension[solved.strain < 0] == 0).all())
        # One push of 20 N along Delta, fibres that pull more: the contacts carry both.
        self.assertTrue((solved.force_medial + solved.force_lateral > 20).all())

    def test_rows_are_an_xarray_data_set_too(self):
        rows = self.joint.dataset(self.passive)
        np.testing.assert_array_equal(rows.tension.sel(fibre=self.joint.fibres[3], row=2), self.passive.tension[2, 3])
        np.testing.assert_array_equal(rows.X_reference_moving, self.passive.X_reference_moving)
        self.assertEqual(set(rows.coords), {"flexion", "varus", "fibre"})
        self.assertIn("degrees", rows.internal.long_name)
        kneecap = self.joint.dataset(self.passive, follower="patella")
        np.testing.assert_array_equal(kneecap.tilt, self.passive.followers["patella"].tilt)

    def test_a_pull_moves_the_tibia_along_it(self):
        force_n = np.array([-50.0, 0.0, 50.0])
        drawer = self.joint.solve(flexion=30, loads={"lateral_force_n": np.stack([force_n, 0 * force_n], axis=1)}, seed=self.passive)
        self.assertEqual(set(drawer.status), {"stable"})
        self.assertTrue((np.diff(drawer.anterior) > 0.1).all(), drawer.anterior)
        turned = self.joint.solve(flexion=30, loads={"moment_nmm": [-500, 500]}, seed=self.passive)
        self.assertGreater(np.diff(turned.internal)[0], 1.0)
        bent = self.joint.solve(flexion=30, loads={"varus_moment_nmm": [-1000, 1000]}, seed=self.passive)
        self.assertGreater(np.diff(bent.varus)[0], 0.0)

    def test_no_load_is_the_job_s(self):
        printed = self.joint.solve(flexion=30, loads={"lateral_force_n": [0, 0], "moment_nmm": 0.0}, seed=self.passive)
        silent = self.joint.solve(flexion=[30], seed=self.passive.X_reference_moving[-1])
        np.testing.assert_array_equal(printed.X_reference_moving, silent.X_reference_moving)

    def test_a_given_varus_is_held(self):
        held = self.joint.solve(flexion=30, varus=[-1.0, 1.0], seed=self.passive)
        np.testing.assert_allclose(held.varus, [-1, 1], atol=1e-9)
        self.assertTrue((held.varus_moment != 0).all())

    def test_unsolved_rows_are_named_and_have_no_numbers(self):
        far = self.passive.X_reference_moving[0].copy()
        far[0, 3] += 500.0  # beside the femur, nothing is above
        lost = self.joint.solve(flexion=0, seed=far)
        self.assertNotEqual(lost.status[0], "stable")
        self.assertTrue(np.isnan(lost.X_reference_moving).all() and np.isnan(lost.tension).all())
        self.assertNotEqual(lost.status_code[0], 0)

    def test_arrays_are_read_only_views_that_keep_their_owner(self):
        for array in (self.joint.moving_vertices, self.joint.reference_triangles, self.passive.internal):
            self.assertFalse(array.flags.owndata)
            with self.assertRaises(ValueError):
                array[...] = 0
        self.assertTrue(np.shares_memory(self.joint.moving_vertices, self.joint.moving_vertices))
        joint = vrda.Joint(KNEE)
        vertices, rows = joint.moving_vertices, joint.solve(0).internal
        copies, owner = (vertices.copy(), rows.copy()), weakref.ref(joint)
        del joint
        gc.collect()
        self.assertIsNone(owner())
        np.testing.assert_array_equal(vertices, copies[0])
        np.testing.assert_array_equal(rows, copies[1])
        self.assertLess(self.joint.moving_triangles.max(), len(self.joint.moving_vertices))

    def test_other_threads_run_while_it_solves(self):
        stamps, is_done = [], threading.Event()

        def count():
            while not is_done.is_set():
                stamps.append(time.monotonic())
                time.sleep(0.002)

        counter = threading.Thread(target=count)
        counter.start()
        begin = time.monotonic()
        self.joint.solve(flexion=np.linspace(0, 90, 400))
        end = time.monotonic()
        is_done.set()
        counter.join()
        during = [stamp for stamp in stamps if begin < stamp < end]
        # A held lock would give none between the checks of signals of a row.
        self.assertGreater(len(during), 5)
        self.assertLess(max(np.diff([begin, *during, end])), 0.5 * (end - begin))

    def test_two_threads_share_a_joint(self):
        results = {}
        threads = [threading.Thread(target=lambda k=k: results.update({k: self.joint.solve(flexion=range(0, 31, 5))})) for k in (0, 1)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        for k in (0, 1):
            np.testing.assert_array_equal(results[k].X_reference_moving, self.passive.X_reference_moving)


class Errors(unittest.TestCase):
    def refused(self, act, **wanted):
        with self.assertRaises(vrda.InputError) as refusal:
            act()
        for name, value in wanted.items():
            self.assertIn(value, getattr(refusal.exception, name), name)
        for part in (refusal.exception.found, refusal.exception.wanted):
            self.assertIn(part, str(refusal.exception))
        return refusal.exception

    def test_they_carry_file_field_found_and_wanted(self):
        self.refused(lambda: vrda.Job(KNEE, set={"grid.flexionn": 1}), field="grid.flexionn", wanted="flexion")
        self.refused(lambda: vrda.Job("absent.toml"), file="absent.toml")
        self.refused(lambda: vrda.Job(KNEE, set={"side": "top"}), field="side", found="top")
        self.refused(lambda: vrda.Job(KNEE).run("x" * 300 + ".h5"), file="x" * 300, found="too long")
        self.assertIsInstance(self.refused(lambda: vrda.open("absent.h5"), file="absent.h5"), ValueError)

    def test_arguments_are_named(self):
        joint = vrda.Joint(KNEE)
        for act, field in ((lambda: joint.solve([]), "flexion"), (lambda: joint.solve(float("nan")), "flexion"),
                           (lambda: joint.solve(0, varus=95), "varus"), (lambda: joint.solve([0, 1], varus=[0, 1, 2]), "varus"),
                           (lambda: joint.solve(0, loads={"force_n": -1}), "loads.force_n"),
                           (lambda: joint.solve(0, loads={"force": 1}), "loads.force"),
                           (lambda: joint.solve(0, loads={"lateral_force_n": 1}), "lateral_force_n"),
                           (lambda: joint.solve(0, seed=np.ones((4, 4))), "seed"), (lambda: joint.solve(0, seed=np.eye(3)), "seed")):
            with self.subTest(field=field):
                self.refused(act, file="Joint.solve", field=field)

    def test_a_search_has_no_loads_and_no_free_varus(self):
        joint = vrda.Joint(KNEE.with_name("knee-generic-contact.toml"))
        self.refused(lambda: joint.solve(0), field="varus")
        self.refused(lambda: joint.solve(0, varus=0, loads={"moment_nmm": 1}), field="loads.moment_nmm")
        self.assertEqual(joint.solve(0, varus=0).status[0], "stable")

    def test_a_scaled_job_is_refused(self):
        self.refused(lambda: vrda.Job(KNEE, set={"scaling.factor": 0.9}).joint(), field="scaling")

    def test_messages_go_to_the_logger(self):
        with tempfile.TemporaryDirectory() as folder, self.assertLogs("vrda", logging.INFO) as logs:
            vrda.Job(KNEE, set=COARSE).run(pathlib.Path(folder) / "knee.h5")
        self.assertTrue(any("7 attitudes" in line for line in logs.output), logs.output)

    def test_check_is_that_of_the_program(self):
        self.assertEqual(vrda.check(KNEE), json.loads(program("check", KNEE, "--json", "-q")))

    def test_the_version_is_the_program_s(self):
        self.assertEqual(f"vrda {vrda.__version__}", program("--version").strip())


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
