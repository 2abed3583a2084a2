"""Poses in the frame of a scan: the exported femur is where its file is, the tibia where the pose has it, for a job in the scan's
frame and for one with [scan]; markups have the attachments and the contacts of the motion model.

usage: scan_files_test.py VRDA
"""
import csv
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

import h5py
import numpy

VRDA = sys.argv[1]
SINGLE_MM = 1e-3  # single precision of coordinates up to 1,000 mm, written twice
TO_SCAN = numpy.array([[0, 0, -1.0], [-1, 0, 0], [0, 1, 0]])  # from anterior, proximal, right to left, posterior, superior
COLUMNS = {"femur": "reference", "tibia": "moving"}
OFFSET_MM = numpy.array([100.0, -50, 700])
FACET = numpy.dtype([("normal", "<3f4"), ("vertices", "<9f4"), ("attribute", "<u2")])


def run(*words):
    done = subprocess.run([VRDA, *map(str, words)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def read_stl(file):
    raw = file.read_bytes()
    return raw[:80], numpy.frombuffer(raw, FACET, offset=84)["vertices"].reshape(-1, 3).astype(float)


def write_stl(file, vertices):
    facets = numpy.zeros(len(vertices) // 3, FACET)
    facets["vertices"] = vertices.reshape(-1, 9)
    file.write_bytes(b"SPACE=LPS".ljust(80) + numpy.uint32(len(facets)).tobytes() + facets.tobytes())


def extent(points):
    return numpy.concatenate([points.min(0), points.max(0), points.mean(0)])


class Scan(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.holder = tempfile.TemporaryDirectory(prefix="vrda-scan-")
        cls.addClassCleanup(cls.holder.cleanup)
        cls.folder = pathlib.Path(cls.holder.name)
        run("shape", "knee", "resolution=0.5", "--ligaments", "-o", cls.folder / "canonical")
        (cls.folder / "scan").mkdir()
        for part in ("femur", "tibia"):
            write_stl(cls.folder / f"scan/{part}.stl", read_stl(cls.folder / f"canonical/{part}.stl")[1] @ TO_SCAN.T + OFFSET_MM)
        table = [line for line in (cls.folder / "canonical/ligaments.csv").read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
        rows = list(csv.DictReader(table))
        cls.ends = {}
        for end in ("femur", "tibia"):
            cls.ends[end] = numpy.array([[float(row[f"{COLUMNS[end]}_{axis}_mm"]) for axis in "xyz"] for row in rows])
            for row, at in zip(rows, cls.ends[end] @ TO_SCAN.T + OFFSET_MM):
                row.update({f"{COLUMNS[end]}_{axis}_mm": repr(float(value)) for axis, value in zip("xyz", at)})
        cls.names = [row["name"] for row in rows]
        with open(cls.folder / "scan/ligaments.csv", "w", encoding="utf-8") as out:
            writer = csv.DictWriter(out, rows[0].keys())
            writer.writeheader()
            writer.writerows(rows)

    def solved(self, files, *tables):
        job = "\n".join((*tables, '[reference]\nname = "femur"\n[[reference.component]]\nname = "femur"', f'file = "{files}/femur.stl"',
                         '[moving]\nname = "tibia"\n[[moving.component]]\nname = "tibia"', f'file = "{files}/tibia.stl"',
                         f'[ligaments]\nfibres = "{files}/ligaments.csv"', '[grid]\nflexion = { from = 0, to = 60, step = 30 }\nvarus = "free"\n'))
        (self.folder / "knee.toml").write_text(job, encoding="utf-8")
        model = self.folder / f"{files}.h5"
        run("run", self.folder / "knee.toml", "-o", model, "-q", "--progress", "none")
        run("export", model, "--to", "stl", "--pose", "flexion=30", "-o", self.folder / "at.stl", "-q")
        run("export", model, "--to", "mrk", "--pose", "flexion=30", "-o", self.folder / "at.mrk.json", "-q")
        return model

    def expect_in_scan(self, model, scan_of_canonical, unit_mm, space):
        with h5py.File(model) as file:
            X = file["X_reference_moving"][1, 0]
            R, t = X[:3, :3], X[:3, 3]
        header, femur = read_stl(self.folder / "at_femur.stl")
        self.assertIn(f"SPACE={space}".encode(), header)
        canonical = {part: read_stl(self.folder / f"canonical/{part}.stl")[1] for part in ("femur", "tibia")}
        numpy.testing.assert_allclose(extent(femur), extent(scan_of_canonical(canonical["femur"]) / unit_mm), atol=SINGLE_MM)
        tibia = read_stl(self.folder / "at_tibia.stl")[1]
        moved = lambda p: scan_of_canonical(self.from_files(self.to_files(p) @ R.T + t))
        numpy.testing.assert_allclose(extent(tibia), extent(moved(canonical["tibia"]) / unit_mm), atol=SINGLE_MM)
        markups = {one["name"]: one for one in json.loads((self.folder / "at.mrk.json").read_text(encoding="utf-8"))["markups"]}
        self.assertEqual(list(markups), ["flexion axis", "rotation axis", "attachments", "contacts"])
        self.assertEqual({one["coordinateSystem"] for one in markups.values()}, {space})
        points = {name: numpy.array([point["position"] for point in one["controlPoints"]]) for name, one in markups.items()}
        self.assertEqual([point["label"] for point in markups["attachments"]["controlPoints"]], [name for name in self.names for _ in "ab"])
        numpy.testing.assert_allclose(points["attachments"][0::2], scan_of_canonical(self.ends["femur"]), atol=SINGLE_MM)
        numpy.testing.assert_allclose(points["attachments"][1::2], moved(self.ends["tibia"]), atol=SINGLE_MM)
        # Contacts lie on both surfaces: no further from a vertex of either than the longest edge.
        for surface in (femur, tibia):
            distance = [numpy.linalg.norm(surface * unit_mm - at, axis=1).min() for at in points["contacts"]]
            self.assertLess(max(distance), 8.0)
        self.assertGreaterEqual(len(points["contacts"]), 2)


class InScan(Scan):
    def test_a_job_in_the_frame_of_the_scan(self):
        # The model's canonical coordinates are those of the files, permuted.
        self.to_files = lambda p: p + OFFSET_MM @ TO_SCAN
        self.from_files = lambda p: p - OFFSET_MM @ TO_SCAN
        model = self.solved("scan", "[frame]\nanterior = \"-Y\"\nproximal = \"+Z\"\nright = \"-X\"", "origin = [100, -50, 700]", '[scan]\nspace = "RAS"')
        self.expect_in_scan(model, lambda p: p @ TO_SCAN.T + OFFSET_MM, 1.0, "RAS")

    def test_a_prepared_job(self):
        self.to_files = self.from_files = lambda p: p
        rows = [list(row) + [float(value)] for row, value in zip(TO_SCAN.tolist(), OFFSET_MM)]
        model = self.solved("canonical", f'[scan]\nspace = "LPS"\nunit = "cm"\nX_scan_reference = {rows}')
        self.expect_in_scan(model, lambda p: p @ TO_SCAN.T + OFFSET_MM, 10.0, "LPS")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], defaultTest="InScan", verbosity=2)
