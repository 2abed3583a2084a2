"""vrda prepare of hips, ankles and subtalar joints: the frame follows turned, mirrored, resized and cut bones; the jobs are
solved to plausible motions.

usage: joint_frame_test.py VRDA [TEST]
"""
import csv
import io
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import numpy

VRDA = sys.argv[1]
ROOT = pathlib.Path(__file__).resolve().parents[2]
DATA = pathlib.Path(os.environ.get("VRDA_DATA") or ROOT / "../shared/data")
FRAME_DEG, FRAME_MM = 0.3, 0.3  # that the issue promises
BONES = {"hip": ("pelvis", "femur"), "ankle": ("tibia", "talus"), "subtalar": ("talus", "calcaneus")}
FEET = ("01", "04", "06", "08")
STL = numpy.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("rest", "<u2")])
# Which triangles a shorter scan would not have, by their centres in the files' own axes: nothing that faces the other bone.
CUT = {"hip": (lambda p: p[:, 1] > 27, lambda p: numpy.linalg.norm(p, axis=1) > 46),
       "ankle": (lambda p: p[:, 1] > 28, lambda p: p[:, 1] < -8),
       "subtalar": (lambda p: p[:, 0] > 36, lambda p: p[:, 0] < -45)}
TURN = numpy.array([[-2, 2, 1], [1, 2, -2], [-2, -1, -2]]) / 3
if numpy.linalg.det(TURN) < 0:
    TURN = -TURN
MIRROR = TURN @ numpy.diag([1, -1, 1])
SHIFT_MM = numpy.array([120.0, -340.0, 610.0])
# Name, matrix, unit of the files in mm, whether cut.
CHANGES = (("larger, in cm", 1.15 * TURN, 10, False), ("mirrored and cut", MIRROR, 1, True),
           ("smaller, in m", 0.85 * TURN, 1000, False))


def triangles(file):
    return numpy.fromfile(file, STL, offset=84)["corners"].astype(float)


def write(file, corners):
    rows = numpy.zeros(len(corners), STL)
    rows["corners"] = corners
    file.write_bytes(bytes(80) + numpy.uint32(len(rows)).tobytes() + rows.tobytes())


def box(least, most, n=12):
    """A box whose faces have n x n squares."""
    u = numpy.linspace(0, 1, n + 1)
    rows = []
    for axis in range(3):
        for end in (0, 1):
            i, j = ((axis + 1) % 3, (axis + 2) % 3) if end else ((axis + 2) % 3, (axis + 1) % 3)
            p = numpy.zeros((n + 1, n + 1, 3))
            p[..., axis], p[..., i], p[..., j] = end, u[:, None], u[None, :]
            a, b, c, d = p[:-1, :-1], p[1:, :-1], p[1:, 1:], p[:-1, 1:]
            rows += [numpy.stack([a, b, c], axis=2).reshape(-1, 3, 3), numpy.stack([a, c, d], axis=2).reshape(-1, 3, 3)]
    return least + numpy.concatenate(rows) * (most - least)


def vrda(*words, code=0):
    done = subprocess.run([VRDA, *map(str, words)], capture_output=True, text=True, check=False)
    assert done.returncode == code, done.stderr
    return done


def prepare(joint, meshes, folder, *more):
    words = [word for bone, mesh in zip(BONES[joint], meshes) for word in (f"--{bone}", mesh)]
    return json.loads(vrda("prepare", "--joint", joint, *words, "-o", folder, "--replace", "--json", *more).stdout)


def axes(report):
    """X_anatomical_file without the unit, and the centre in the file."""
    X = numpy.array(report[BONES[report["joint"]][0]]["anatomical_from_file"])[:3]
    return X[:, :3] / numpy.cbrt(numpy.linalg.det(X[:, :3])), numpy.array(report["centre"])


def angle_deg(R):
    return numpy.degrees(numpy.arccos(numpy.clip((numpy.trace(R) - 1) / 2, -1, 1)))


class Joints(unittest.TestCase):
    def setUp(self):
        held = tempfile.TemporaryDirectory(prefix="vrda-joint-frame-")
        self.addCleanup(held.cleanup)
        self.folder = pathlib.Path(held.name)

    def generic(self, joint):
        vrda("shape", joint, "-o", self.folder / joint, "-q")
        parts = {"hip": ("socket", "head"), "ankle": ("tibia", "talus")}[joint]
        return [self.folder / joint / f"{part}.stl" for part in parts]

    def follow(self, joint, meshes, has_side, changes=CHANGES):
        """The frame of the meshes goes with them. `has_side`: the bones show their side."""
        known = [] if has_side else ["--side", "right"]
        report = prepare(joint, meshes, self.folder / "out", *known)
        A, centre = axes(report)
        for name, M, unit_mm, is_cut in changes:
            with self.subTest(name):
                is_mirrored = numpy.linalg.det(M) < 0
                changed = []
                for mesh, gone in zip(meshes, CUT[joint]):
                    corners = triangles(mesh)
                    if is_cut:
                        corners = corners[~gone(corners.mean(axis=1))]
                    changed.append(self.folder / f"changed-{len(changed)}.stl")
                    write(changed[-1], (corners @ M.T + SHIFT_MM) / unit_mm)
                side = report["side"] if not is_mirrored else {"right": "left", "left": "right"}[report["side"]]
                found = prepare(joint, changed, self.folder / "out", *([] if has_side else ["--side", side]))
                self.assertEqual((found["side"], found["unit"]), (side, {1: "mm", 10: "cm", 1000: "m"}[unit_mm]))
                B, new_centre = axes(found)
                flip = numpy.diag([1, 1, -1 if is_mirrored else 1])
                R = flip @ A @ (M / numpy.abs(numpy.cbrt(numpy.linalg.det(M)))).T
                self.assertLess(angle_deg(R @ B.T), FRAME_DEG)
                self.assertLess(numpy.linalg.norm(M @ centre + SHIFT_MM - unit_mm * new_centre), FRAME_MM)
        return report

    def poses(self, joint):
        """The prepared joint, solved: six coordinates, and how many attitudes are solved."""
        job, model, table = (self.folder / "out" / f"{joint}.{end}" for end in ("toml", "h5", "csv"))
        vrda("run", job, "-o", model, "-q", "--progress", "none", "--replace")
        vrda("export", model, "--to", "csv", "--set", "raw", "-o", table, "-q")
        rows = list(csv.DictReader(io.StringIO(table.read_text(encoding="utf-8"))))
        names = ("flexion_deg", "varus_deg", "internal_deg", "anterior_mm", "proximal_mm", "lateral_mm")
        return numpy.array([[float(row[name]) for name in names] for row in rows])

    def test_the_generated_hip(self):
        meshes = self.generic("hip")
        self.follow("hip", meshes, has_side=False)
        report = prepare("hip", meshes, self.folder / "out")
        self.assertIn("these bones do not show it", " ".join(report["warnings"]))
        self.assertLess(numpy.linalg.norm(report["centre"]), 0.1)  # facets of 2.4 mm are 0.03 mm inside the sphere
        q = self.poses("hip")
        self.assertEqual(len(q), 13)  # beyond, its thick neck meets the rim
        self.assertLess(numpy.linalg.norm(q[:, 3:], axis=1).max(), 0.6)  # clearance 0.5 mm and facets

    def test_the_generated_ankle(self):
        meshes = self.generic("ankle")
        report = self.follow("ankle", meshes, has_side=False)
        A, centre = axes(report)
        self.assertGreater(A[2, 2], numpy.cos(numpy.radians(FRAME_DEG)))  # Z is the axis of revolution
        self.assertLess(numpy.linalg.norm(centre), FRAME_MM)
        prepare("ankle", meshes, self.folder / "out", "--side", "right")
        q = self.poses("ankle")
        self.assertEqual(len(q), 13)
        self.assertLess(numpy.abs(q[:, 1:3]).max(), 3.0)   # it turns about the trochlea: no more than facets allow
        self.assertLess(numpy.linalg.norm(q[:, 3:], axis=1).max(), 1.0)

    @unittest.skipUnless((DATA / "subtalar").is_dir(), "no subtalar joints: set VRDA_DATA")
    def test_four_feet(self):
        for n, foot in enumerate(FEET):
            source = DATA / "subtalar" / foot
            with self.subTest(foot=foot):
                report = self.follow("subtalar", [source / "talus.stl", source / "calcaneus.stl"], has_side=True,
                                     changes=CHANGES[n % 2 :: 2])
                known = json.loads((source / "dataset.json").read_text(encoding="utf-8"))
                self.assertEqual(report["side"], known["side"])
                A, _ = axes(report)
                self.assertLess(angle_deg(A), 15.0)  # its files are along the calcaneus, which varies so much
                prepare("subtalar", [source / "talus.stl", source / "calcaneus.stl"], self.folder / "out")
                q = self.poses("subtalar")
                self.assertEqual(len(q), 21)
                self.assertLess(numpy.linalg.norm(q[:, 3:], axis=1).max(), 8.0)  # facets of 30 mm; one foot slides at 10 degrees

    @unittest.skipUnless((DATA / "subtalar").is_dir(), "no tali: set VRDA_DATA")
    def test_the_trochlea_of_real_tali(self):
        """The axis is that of the talus, however the foot of the scan is pointed and however near the bones are."""
        for foot in FEET[:3]:  # the trochlea of the last is worn, beside a replaced ankle
            talus = DATA / "subtalar" / foot / "talus.stl"
            top = triangles(talus)[..., 1].max()
            side = json.loads((talus.parent / "dataset.json").read_text(encoding="utf-8"))["side"]
            found = []
            for pointed_deg, gap_mm in ((0, 0.05), (-20, 2), (20, 4)):
                c, s = numpy.cos(numpy.radians(pointed_deg)), numpy.sin(numpy.radians(pointed_deg))
                plafond = box(numpy.array([-14.0, top + gap_mm, -14.0]), numpy.array([16.0, top + gap_mm + 40, 14.0]))
                tibia = self.folder / "plafond.stl"
                write(tibia, (plafond - [0, top, 0]) @ numpy.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]) + [0, top, 0])
                report = prepare("ankle", [tibia, talus], self.folder / "out", "--side", side)
                A, _ = axes(report)
                found.append(A[2])
                self.assertTrue(16 < report["radius_mm"] < 25, report["radius_mm"])  # of adults: 18 to 24
            for other in found[1:]:
                with self.subTest(foot=foot):
                    self.assertLess(numpy.degrees(numpy.arccos(min(1.0, abs(found[0] @ other)))), 2.5)  # its ends, in cut or not


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[2:], verbosity=2)
