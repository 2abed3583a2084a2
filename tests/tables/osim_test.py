"""Reads the OpenSim model of vrda export as OpenSim documents its elements, without OpenSim, and compares it with the
motion model: poses of the joint at and between the knots, limits, meshes, lengths and tensions of the fibres.

usage: osim_test.py VRDA
"""
import csv
import io
import pathlib
import struct
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree

import h5py
import numpy

VRDA = sys.argv[1]
ROOT = pathlib.Path(__file__).resolve().parents[2]
M, RAD = 1e-6, 1e-6  # agreement that issue and schema promise
SINGLE_M = 1e-7  # single precision of coordinates within 0.2 m


def run(*words):
    done = subprocess.run([VRDA, *map(str, words)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done


class Spline:
    """Cubic spline through all points; the third derivative at an end is that of the cubic through its four points
    (Forsythe, Malcolm and Moler 1977, which OpenSim's SimmSpline cites). A dense system instead of its elimination."""

    def __init__(self, x, y):
        n, h = len(x), numpy.diff(x)
        slope = numpy.diff(y) / h
        A, b = numpy.zeros((n, n)), numpy.zeros(n)
        for i in range(1, n - 1):
            A[i, i - 1:i + 2] = h[i - 1], 2 * (h[i - 1] + h[i]), h[i]
            b[i] = slope[i] - slope[i - 1]
        if n > 3:
            third = [numpy.polyfit(x[part] - x[part].mean(), y[part], 3)[0] for part in (slice(0, 4), slice(n - 4, n))]
            A[0, :2], b[0] = (-1 / h[0], 1 / h[0]), third[0]
            A[-1, -2:], b[-1] = (-1 / h[-1], 1 / h[-1]), third[1]
        else:
            A[0, 0] = A[-1, -1] = 1
        self.x, self.y, self.h, self.slope, self.c = x, y, h, slope, numpy.linalg.solve(A, b)

    def __call__(self, at):
        i = int(numpy.clip(numpy.searchsorted(self.x, at) - 1, 0, len(self.h) - 1))
        t, h, c = at - self.x[i], self.h[i], self.c
        first = self.slope[i] - h * (c[i + 1] + 2 * c[i])
        return self.y[i] + t * (first + t * (3 * c[i] + t * (c[i + 1] - c[i]) / h))


def polynomial(element):
    """OpenSim's MultivariatePolynomialFunction: exponents (i, j) of the two variables by ascending i, then j, i + j <= order."""
    order, c = int(element.find("order").text), floats(element, "coefficients")
    assert element.find("dimension").text == "2"
    exponents = [(i, j) for i in range(order + 1) for j in range(order + 1 - i)]
    assert len(exponents) == len(c)
    return lambda q: sum(value * q[0]**i * q[1]**j for value, (i, j) in zip(c, exponents))


def floats(element, name):
    return numpy.array([float(word) for word in element.find(name).text.split()])


def turn(axis, angle):
    """Rotation about a unit axis (Rodrigues)."""
    K = numpy.cross(numpy.eye(3), axis)
    return numpy.eye(3) + numpy.sin(angle) * K + (1 - numpy.cos(angle)) * K @ K


class Joint:
    """A CustomJoint: body-fixed rotations, translations along the parent frame's axes, offset frames on both bodies."""

    def __init__(self, element):
        self.offset = [floats(frame, "translation") for frame in element.iter("PhysicalOffsetFrame")]
        assert all((floats(frame, "orientation") == 0).all() for frame in element.iter("PhysicalOffsetFrame"))
        coordinates = element.findall("coordinates/Coordinate")
        self.names, self.range = [one.get("name") for one in coordinates], [floats(one, "range") for one in coordinates]
        self.axes = []
        for axis in element.find("SpatialTransform"):
            indices = [self.names.index(name) for name in axis.find("coordinates").text.split()]
            self.axes.append((axis.get("name"), floats(axis, "axis"), self.function(axis, indices)))
        assert [name for name, _, _ in self.axes] == [f"{kind}{k}" for kind in ("rotation", "translation") for k in (1, 2, 3)]

    @staticmethod
    def function(axis, indices):
        """Of the joint's coordinates; those of a spline and a line depend on one."""
        if axis.find("MultivariatePolynomialFunction") is not None:
            assert indices == [0, 1]
            return polynomial(axis.find("MultivariatePolynomialFunction"))
        (k,) = indices
        spline, line = axis.find("SimmSpline"), axis.find("LinearFunction")
        value = numpy.poly1d(floats(line, "coefficients")) if spline is None else Spline(floats(spline, "x"), floats(spline, "y"))
        return lambda q: value(q[k])

    def pose(self, q):
        """R and t (m) from the child's body to the parent's, at one or two coordinates."""
        q = numpy.atleast_1d(q)
        assert len(q) == len(self.names)
        R, d = numpy.eye(3), numpy.zeros(3)
        for name, axis, value in self.axes:
            if name.startswith("rotation"):
                R = R @ turn(axis, value(q))
            else:
                d = d + axis * value(q)
        return R, self.offset[0] + d - R @ self.offset[1]


def exported_rows(model, flexions, *more):
    with tempfile.TemporaryDirectory() as folder:
        table = pathlib.Path(folder) / "poses.csv"
        run("export", model, "--to", "csv", "-o", table, "--flexion", flexions, *more)
        return list(csv.DictReader(io.StringIO(table.read_text(encoding="utf-8"))))


def row_pose(row, side):
    z, x, y = (numpy.radians(float(row[key])) for key in ("flexion_deg", "varus_deg", "internal_deg"))
    sign = -1 if side == "left" else 1
    R = turn(numpy.array([0, 0, -1.0]), z) @ turn(numpy.array([sign, 0, 0.0]), x) @ turn(numpy.array([0, sign, 0.0]), y)
    # Grood-Suntay translations of the centre (schemas/clinical.md), of the mirror image of a left joint.
    mirror, centre = numpy.diag([1.0, 1.0, sign]), 1e-3 * numpy.array([float(row[f"centre_{axis}_mm"]) for axis in "xyz"])
    anterior, proximal, lateral = (1e-3 * float(row[f"{name}_mm"]) for name in ("anterior", "proximal", "lateral"))
    e1, e3 = numpy.array([0, 0, 1.0]), (mirror @ R @ mirror)[:, 1]
    e2 = numpy.cross(e3, e1) / numpy.linalg.norm(numpy.cross(e3, e1))
    d = anterior * e2 + ((lateral - proximal * e3[2]) * e1 + (proximal - lateral * e3[2]) * e3) / (1 - e3[2]**2)
    return z, R, mirror @ d + centre - R @ centre


class Osim(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory(prefix="vrda-osim-")
        cls.root = pathlib.Path(cls.folder.name)
        cls.model = {}
        for side in ("right", "left"):
            cls.model[side] = cls.root / f"{side}.h5"
            run("run", ROOT / "jobs/knee-generic.toml", "-o", cls.model[side], "--set", f"side={side}", "--set", 'grid.varus="free"',
                "--set", "grid.flexion={from=0,to=90,step=5}", "--set", "solver.equilibrium.restarts=0", "-q", "--progress", "none")

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def exported(self, side, *more):
        output = self.root / "out" / f"{side}.osim"
        run("export", self.model[side], "--to", "osim", "-o", output, *more)
        return output, xml.etree.ElementTree.parse(output).getroot()

    def test_the_joint_has_the_poses_of_the_motion_model(self):
        for side, chosen, sign in (("right", "two_sided", 1), ("left", "two_sided", 1), ("right", "degree_6", 1), ("left", "degree_6", -1)):
            _, root = self.exported(side, "--set", chosen, "--coordinate", "flexion=" + "-" * (sign < 0) + "knee_angle")
            joint = Joint(root.find("Model/JointSet/objects/CustomJoint"))
            self.assertEqual(joint.names, ["knee_angle"])
            numpy.testing.assert_allclose(joint.range, [numpy.radians([0, 90] if sign > 0 else [-90, 0])], atol=1e-12)
            rows = exported_rows(self.model[side], "0:90:1.25", "--set", chosen)
            self.assertEqual(len(rows), 73)
            for row in rows:
                q, R, t = row_pose(row, side)
                found_R, found_t = joint.pose(sign * q)
                numpy.testing.assert_allclose(found_R, R, atol=RAD)
                numpy.testing.assert_allclose(found_t, t, atol=M)

    def test_a_follower_is_a_joint_of_a_coupled_coordinate(self):
        for side, sign in (("right", 1), ("left", -1)):
            _, root = self.exported(side, "--coordinate", "flexion=" + "-" * (sign < 0) + "knee_angle")
            (element,) = [one for one in root.findall("Model/JointSet/objects/CustomJoint") if one.get("name") == "patella_joint"]
            joint, coupling = Joint(element), root.find("Model/ConstraintSet/objects/CoordinateCouplerConstraint")
            self.assertEqual(joint.names, [coupling.find("dependent_coordinate_name").text])
            self.assertEqual(coupling.find("independent_coordinate_names").text, "knee_angle")
            numpy.testing.assert_allclose(floats(coupling.find("coupled_coordinates_function/LinearFunction"), "coefficients"), [1, 0])
            with h5py.File(self.model[side]) as model:
                centre = 1e-3 * model["followers/patella"].attrs["centre_mm"]
            for row in exported_rows(self.model[side], "0:90:2.5"):
                flexion, rotation, tilt = (numpy.radians(float(row[f"follower_patella_{name}_deg"])) for name in ("flexion", "rotation", "tilt"))
                side_sign = -1 if side == "left" else 1
                wanted = turn(numpy.array([0, 0, -1.0]), flexion) @ turn(numpy.array([side_sign, 0, 0.0]), rotation) @ turn(numpy.array([0, side_sign, 0.0]), tilt)
                moved = 1e-3 * numpy.array([float(row[f"follower_patella_{name}_mm"]) for name in ("anterior", "proximal", "lateral")])
                moved[2] *= side_sign
                found_R, found_t = joint.pose(sign * numpy.radians(float(row["flexion_deg"])))
                numpy.testing.assert_allclose(found_R, wanted, atol=RAD)
                numpy.testing.assert_allclose(found_R @ centre + found_t - centre, moved, atol=M)

    def test_between_knots_of_a_smooth_set(self):
        _, root = self.exported("right", "--set", "degree_6")
        joint = Joint(root.find("Model/JointSet/objects/CustomJoint"))
        for row in exported_rows(self.model["right"], "0.3:89.9:0.7", "--set", "degree_6"):
            q, R, t = row_pose(row, "right")
            found_R, found_t = joint.pose(q)
            numpy.testing.assert_allclose(found_R, R, atol=RAD)
            numpy.testing.assert_allclose(found_t, t, atol=M)

    def test_flexion_and_varus_drive_a_joint_of_polynomials(self):
        for side, sign in (("right", "+"), ("left", "-")):
            grid = self.root / f"grid_{side}.h5"
            run("run", ROOT / "jobs/knee-generic.toml", "-o", grid, "--set", f"side={side}", "--set", "grid.flexion={from=0,to=90,step=10}",
                "--set", "grid.varus={from=-6,to=6,step=2}", "--set", "solver.equilibrium.restarts=0", "--set", "smooth.degrees=[4]", "-q", "--progress", "none")
            output = self.root / f"grid_{side}.osim"
            run("export", grid, "--to", "osim", "-o", output, "--varus", "driven", "--joint-only", "--coordinate", f"varus={sign}knee_varus",
                "--coordinate", f"flexion={sign}knee_flex")
            joint = Joint(xml.etree.ElementTree.parse(output).getroot())
            self.assertEqual(joint.names, ["knee_flex", "knee_varus"])
            numpy.testing.assert_allclose(joint.range, numpy.radians([[0, 90] if sign == "+" else [-90, 0], [-6, 6]]), atol=1e-12)
            for varus in (-6, -3.3, 0, 2, 5.9):
                for row in exported_rows(grid, "0:90:4.5", "--set", "degree_4", "--varus", varus):
                    z, R, t = row_pose(row, side)
                    found_R, found_t = joint.pose(float(sign + "1") * numpy.array([z, numpy.radians(varus)]))
                    numpy.testing.assert_allclose(found_R, R, atol=RAD)
                    numpy.testing.assert_allclose(found_t, t, atol=M)
        for more, reason in ((("--set", "raw"), "smooth"), (("--set", "two_sided"), "flexion only"), (("--flexion", "0:90:5"), "driven")):
            done = subprocess.run([VRDA, "export", grid, "--to", "osim", "-o", output, "--varus", "driven", *more], capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode, 2)
            self.assertIn(reason, done.stderr)

    def test_fibres_have_the_model_s_lengths_and_tensions(self):
        _, root = self.exported("right", "--set", "raw", "--flexion", "0:90:5")
        joint = Joint(root.find("Model/JointSet/objects/CustomJoint"))
        fibres = root.findall("Model/ForceSet/objects/Blankevoort1991Ligament")
        with h5py.File(self.model["right"]) as model:
            ligaments, own = model["ligaments"], model["followers/patella/ligaments"]
            lines = root.findall("Model/ForceSet/objects/PathActuator")
            self.assertEqual(len(fibres) + len(lines), len(ligaments["name"]) + len(own["name"]))
            self.assertAlmostEqual(sum(floats(line, "optimal_force")[0] for line in lines), 30, delta=1e-9)
            fibres = fibres[:len(ligaments["name"])]
            for i in (0, 9, 18):
                R, t = joint.pose(numpy.radians(5.0 * i))
                for k, fibre in enumerate(fibres):
                    points = [floats(point, "location") for point in fibre.iter("PathPoint")]
                    self.assertEqual([point.find("socket_parent_frame").text for point in fibre.iter("PathPoint")],
                                     [f"/bodyset/{body.get('name')}" for body in root.iter("Body")][:2])
                    slack, k_n, end = (floats(fibre, name)[0] for name in ("slack_length", "linear_stiffness", "transition_strain"))
                    if ligaments["is_wrapped"][i, 0, k]:
                        continue
                    length = numpy.linalg.norm(points[0] - (R @ points[1] + t))
                    self.assertAlmostEqual(length, 1e-3 * ligaments["length"][i, 0, k], delta=M)
                    strain = length / slack - 1
                    tension = 0 if strain < 0 else k_n * strain**2 / (2 * end) if strain < end else k_n * (strain - end / 2)
                    # A micrometre of a fibre of 20 mm is a strain of 5e-5.
                    self.assertAlmostEqual(tension, ligaments["tension"][i, 0, k], delta=5e-5 * k_n)

    def test_meshes_are_those_of_the_model_in_metres(self):
        output, root = self.exported("right")
        with h5py.File(self.model["right"]) as model:
            for body, key in zip(root.iter("Body"), ("reference", "moving")):
                group, points = model["bodies"][key], []
                for mesh in body.iter("mesh_file"):
                    raw = (output.parent / "Geometry" / mesh.text).read_bytes()
                    n, = struct.unpack_from("<I", raw, 80)
                    points.append(numpy.frombuffer(raw, numpy.dtype([("n", "<3f4"), ("p", "<9f4"), ("a", "<u2")]), n, 84)["p"].reshape(-1, 3))
                parts = [group["vertices"][:]] + ([group["visual/vertices"][:]] if "visual" in group else [])
                found, wanted = numpy.concatenate(points), 1e-3 * numpy.concatenate(parts)
                numpy.testing.assert_allclose([found.min(0), found.max(0)], [wanted.min(0), wanted.max(0)], atol=SINGLE_M)

    def test_the_joint_alone_is_the_model_s(self):
        _, root = self.exported("right", "--coordinate", "flexion=knee_angle_r")
        output = self.root / "joint.osim"
        run("export", self.model["right"], "--to", "osim", "-o", output, "--joint-only", "--coordinate", "flexion=knee_angle_r")
        alone = xml.etree.ElementTree.parse(output).getroot()
        self.assertEqual(alone.tag, "CustomJoint")
        self.assertEqual([e.text.strip() for e in alone.iter() if e.text], [e.text.strip() for e in root.find("Model/JointSet/objects/CustomJoint").iter() if e.text])
        self.assertEqual(Joint(alone).names, ["knee_angle_r"])
        self.assertFalse((self.root / "Geometry").exists())


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
