"""Jobs from OpenSim models: one written here from the real knee jam-smith2019, with its bodies' frames moved and turned, must be
the job knee-jam-smith2019-ligaments; one exported by vrda must have the motion of the job that it came from.

usage: osim_job_test.py VRDA [TEST]
"""
import csv
import io
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
import unittest

import numpy

VRDA = sys.argv[1]
ROOT = pathlib.Path(__file__).resolve().parents[2]
DATA = pathlib.Path(os.environ.get("VRDA_DATA") or ROOT / "../shared/data")
FIBRE_MM, POSE = 1e-6, 0.01  # that the issue promises: mm, mm and degrees
CENTRE_M = numpy.array([0.0001, 0.0022, 0.0013])  # origin of the job, in m
COORDINATES = ["flexion_deg", "varus_deg", "internal_deg", "anterior_mm", "proximal_mm", "lateral_mm"]


def run(*words):
    done = subprocess.run([VRDA, *map(str, words)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def poses(job, folder, *more):
    """The six coordinates of the solved poses over flexion, then those of the kneecap, if there is one."""
    run("run", job, "-o", folder / "knee.h5", "--replace", "-q", "--progress", "none", *more)
    run("export", folder / "knee.h5", "--to", "csv", "--set", "raw", "-o", folder / "knee.csv", "-q")
    rows = list(csv.DictReader(io.StringIO((folder / "knee.csv").read_text(encoding="utf-8"))))
    names = COORDINATES + [name for name in rows[0] if name.startswith("follower_")]
    return numpy.array([[float(row[name]) for name in names] for row in rows])


def turn(x, y, z):
    """Rx Ry Rz, as OpenSim's orientations."""
    def about(k, angle):
        K = numpy.cross(numpy.eye(3), numpy.eye(3)[k])
        return numpy.eye(3) + numpy.sin(angle) * K + (1 - numpy.cos(angle)) * K @ K
    return about(0, x) @ about(1, y) @ about(2, z)


def angles(R):
    return numpy.array([numpy.arctan2(-R[1, 2], R[2, 2]), numpy.arcsin(R[0, 2]), numpy.arctan2(-R[0, 1], R[0, 0])])


def text(values):
    return " ".join(repr(float(value)) for value in values)


def element(tag, content="", name=None):
    return f"<{tag}" + (f' name="{name}"' if name else "") + f">{content}</{tag}>"


class Model:
    """jam-smith2019 as an OpenSim 4 model; the tibia's own frame is at R, t (m) of the meshes' frame."""
    bodies = {"femur": "femur_distal_r", "tibia": "tibia_proximal_r"}

    def __init__(self, R=numpy.eye(3), t=numpy.zeros(3)):
        self.frame = {"femur": (numpy.eye(3), numpy.zeros(3)), "tibia": (numpy.array(R), numpy.array(t))}
        folder = DATA / "knees/jam-smith2019"
        lines = (line for line in (folder / "ligaments.csv").read_text(encoding="utf-8").splitlines() if not line.startswith("#"))
        self.fibres = list(csv.DictReader(lines))
        self.wraps = json.loads((folder / "wraps.json").read_text(encoding="utf-8"))

    def point(self, body, p_m):
        R, t = self.frame[body]
        return text(R.T @ (numpy.asarray(p_m) - t))

    def pose(self, body, R_of_meshes, p_m, orientation):
        R, _ = self.frame[body]
        return element("translation", self.point(body, p_m)) + element(orientation, text(angles(R.T @ R_of_meshes)))

    def body(self, key, meshes):
        geometry = "".join(element("Mesh", element("socket_frame", "..") + element("mesh_file", mesh + ".stl"), mesh) for mesh in meshes)
        placed = element("PhysicalOffsetFrame", element("attached_geometry", geometry) + element("socket_parent", "..") +
                         self.pose(key, numpy.eye(3), numpy.zeros(3), "orientation"), "of_meshes")
        wraps = "".join(self.wrap(key, wrap) for wrap in self.wraps if wrap["body"] == self.bodies[key])
        return element("Body", element("components", placed) + element("WrapObjectSet", element("objects", wraps), "wrapobjectset"), self.bodies[key])

    def wrap(self, key, wrap):
        numbers = {name: numpy.array(wrap[name].split(), float) for name in ("xyz_body_rotation", "translation")}
        size = "".join(element(name, wrap[name]) for name in ("quadrant", "radius", "length", "dimensions") if name in wrap)
        return element(wrap["type"], self.pose(key, turn(*numbers["xyz_body_rotation"]), numbers["translation"], "xyz_body_rotation") + size, wrap["name"])

    def path(self, points, wrap=""):
        listed = "".join(element("PathPoint", element("socket_parent_frame", f"/bodyset/{body}") + element("location", location), f"p{k}")
                         for k, (body, location) in enumerate(points))
        used = element("PathWrapSet", element("objects", element("PathWrap", element("wrap_object", wrap), "w"))) if wrap else ""
        return element("GeometryPath", element("PathPointSet", element("objects", listed)) + used, "geometrypath")

    def fibre(self, row):
        points = [(self.bodies[key], self.point(key, [1e-3 * float(row[f"{key}_{axis}_mm"]) for axis in "xyz"])) for key in self.bodies]
        return element("Blankevoort1991Ligament", self.path(points, row["wrap"]) + element("linear_stiffness", row["stiffness_n_per_strain"]) +
                       element("slack_length", repr(1e-3 * float(row["slack_length_mm"]))), row["name"])

    def joint(self):
        names = ["knee_flex_r", "knee_add_r", "knee_rot_r", "knee_tx_r", "knee_ty_r", "knee_tz_r"]
        axes = ["0 0 -1", "1 0 0", "0 1 0", "1 0 0", "0 1 0", "0 0 1"]
        coordinates = "".join(element("Coordinate", element("default_value", value) + element("range", "0 2.1"), name)
                              for name, value in zip(names, ("0", "-0.0174", "0", "0.002", "-0.003", "0")))
        transform = "".join(element("TransformAxis", element("coordinates", name) + element("axis", axis) +
                                    element("LinearFunction", element("coefficients", "1 0"), "function"), f"{kind}{k}")
                            for name, axis, (kind, k) in zip(names, axes, ((kind, k) for kind in ("rotation", "translation") for k in (1, 2, 3))))
        frames = "".join(element("PhysicalOffsetFrame", element("socket_parent", f"/bodyset/{body}") + self.pose(key, numpy.eye(3), CENTRE_M, "orientation"), f"{key}_offset")
                         for key, body in self.bodies.items())
        return element("CustomJoint", element("socket_parent_frame", "femur_offset") + element("socket_child_frame", "tibia_offset") +
                       element("coordinates", coordinates) + element("frames", frames) + element("SpatialTransform", transform), "knee_r")

    def write(self, folder, forces="", more_bodies="", more_joints=""):
        (folder / "Geometry").mkdir(parents=True)
        parts = {"femur": ["femur_cartilage"], "tibia": ["tibia_cartilage", "tibia_bone", "meniscus_medial", "meniscus_lateral"]}
        for mesh in sum(parts.values(), []):
            shutil.copyfile(DATA / f"knees/jam-smith2019/{mesh}.stl", folder / f"Geometry/{mesh}.stl")
        bodies = "".join(self.body(key, meshes) for key, meshes in parts.items()) + element("Body", "", "pelvis") + more_bodies
        hip = element("PinJoint", element("socket_parent_frame", "/bodyset/pelvis") + element("socket_child_frame", "/bodyset/femur_distal_r"), "hip_r")
        content = (element("BodySet", element("objects", bodies), "bodyset") + element("JointSet", element("objects", hip + self.joint() + more_joints), "jointset") +
                   element("ForceSet", element("objects", "".join(map(self.fibre, self.fibres)) + forces), "forceset"))
        (folder / "knee.osim").write_text(f'<OpenSimDocument Version="40000"><Model name="jam">{content}</Model></OpenSimDocument>', encoding="utf-8")
        return folder / "knee.osim"


def fibres_of(file):
    with open(file, encoding="utf-8") as lines:
        rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    columns = [name for name in rows[0] if name.endswith("_mm")] + [next(name for name in rows[0] if name.startswith("stiffness"))]
    return [(row["name"], row["wrap"]) for row in rows], numpy.array([[float(row[name] or "nan") for name in columns] for row in rows])


@unittest.skipUnless((DATA / "knees").is_dir(), "real knees not found: set VRDA_DATA to the folder that contains `knees`")
class RealKnee(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory(prefix="vrda-osim-job-")
        self.addCleanup(holder.cleanup)
        self.folder = pathlib.Path(holder.name)

    def test_it_is_the_job_of_the_repository(self):
        for name, model in (("plain", Model()), ("turned", Model(turn(0.3, -0.2, 0.5), [0.02, -0.05, 0.01]))):
            run("convert", "osim", model.write(self.folder / name), "--joint", "knee_r", "-o", self.folder / name / "job")
            with self.subTest(name):
                names, found = fibres_of(self.folder / name / "job/ligaments.csv")
                wanted_names, wanted = fibres_of(DATA / "knees/jam-smith2019/ligaments.csv")
                self.assertEqual(names, wanted_names)
                numpy.testing.assert_allclose(found, wanted, atol=FIBRE_MM)
        step = ("--set", "grid.flexion.step=15")
        wanted = poses(ROOT / "jobs/knee-jam-smith2019-ligaments.toml", self.folder, "--data", DATA, *step)
        for name in ("plain", "turned"):
            with self.subTest(name):
                numpy.testing.assert_allclose(poses(self.folder / name / "job/knee.toml", self.folder / name, *step), wanted, atol=POSE)
        self.assertEqual(tomllib.loads((self.folder / "plain/job/knee.toml").read_text(encoding="utf-8"))["opensim"],
                         {"flexion": "knee_flex_r", "internal": "knee_rot_r", "tx": "knee_tx_r", "ty": "knee_ty_r", "tz": "knee_tz_r", "varus": "knee_add_r"})
        run("export", self.folder / "plain/knee.h5", "--to", "sto", "-o", self.folder / "knee.sto", "--coordinate", "tx=own")
        header = (self.folder / "knee.sto").read_text(encoding="utf-8").split("endheader\n")[1].splitlines()[0].split()
        self.assertEqual(header, ["time", "knee_flex_r", "knee_add_r", "knee_rot_r", "own", "knee_ty_r", "knee_tz_r"])

    def test_muscles_and_what_is_left_out(self):
        model = Model()
        muscle = element("Thelen2003Muscle", model.path([("pelvis", "0 0.4 0"), ("tibia_proximal_r", "0.01 -0.06 0.002")]) +
                         element("max_isometric_force", "1000"), "biceps")
        three = element("Blankevoort1991Ligament", model.path([("femur_distal_r", "0 0 0"), ("femur_distal_r", "0 0.01 0"), ("tibia_proximal_r", "0 0 0")]) +
                        element("linear_stiffness", "1") + element("slack_length", "1"), "bent")
        file = model.write(self.folder / "m", muscle + three + element("CoordinateActuator", "", "motor"))
        report = json.loads(run("convert", "osim", file, "--joint", "knee_r", "-o", self.folder / "a", "--json"))
        self.assertEqual(report["left_out"], ["bodies on other joints: pelvis; --followers NAME takes one", "ligament /forceset/bent: 3 points, a fibre has two", "1 CoordinateActuator",
                                              "1 muscles across the joint: --muscles SHARE takes them as lines"])
        run("convert", "osim", file, "--joint", "knee_r", "-o", self.folder / "b", "--muscles", "0.2")
        (line,) = tomllib.loads((self.folder / "b/knee.toml").read_text(encoding="utf-8"))["push"]["line"]
        self.assertEqual((line["name"], line["tension_n"]), ("biceps", 200))
        numpy.testing.assert_allclose(line["reference_mm"], [[0, 400, 0] - 1e3 * CENTRE_M], atol=1e-9)
        numpy.testing.assert_allclose(line["moving_mm"], [[10, -60, 2] - 1e3 * CENTRE_M], atol=1e-9)

    def test_bodies_that_follow(self):
        # Two of this knee, one of the other knee, one on a joint that the knee does not move; forces of other joints.
        model = Model()

        def body(name, parent, translation_mm, size):
            mesh = element("Mesh", element("socket_frame", "..") + element("mesh_file", "patella_cartilage.stl") + element("scale_factors", text([size] * 3)), name)
            frame = element("PhysicalOffsetFrame", element("socket_parent", f"/bodyset/{parent}") + element("translation", text(1e-3 * numpy.array(translation_mm))), "at")
            joint = element("PinJoint", element("socket_parent_frame", "at") + element("socket_child_frame", f"/bodyset/{name}") + element("frames", frame), f"{name}_joint")
            return element("Body", element("attached_geometry", mesh), name), joint

        def fibre(name, one, other, kind="Blankevoort1991Ligament", wrap=""):
            at = {"femur_distal_r": "0.01 0 0.03", "tibia_proximal_r": "0.02 -0.03 0.01", "fabella_r": "0.016 0.0015 0.0012"}
            return element(kind, model.path([(end, at.get(end, "0.053 0.005 0.004")) for end in (one, other)], wrap) + element("linear_stiffness", "100") +
                           element("slack_length", "0.02"), name)

        bodies = [body("patella_r", "femur_distal_r", [0, 0, 0], 1e-3), body("femur_l", "pelvis", [0, 0, -200], 1e-3), body("patella_l", "femur_l", [0, 0, 0], 1e-3),
                  body("fabella_r", "femur_distal_r", [-60, 10, 15], 3e-4), body("fibula_r", "tibia_proximal_r", [-90, -60, 30], 1e-3)]
        forces = [fibre("PT1", "tibia_proximal_r", "patella_r", wrap=model.wraps[0]["name"]), fibre("quad", "pelvis", "patella_r", "Thelen2003Muscle"), fibre("FFL1", "fabella_r", "tibia_proximal_r"),
                  fibre("FFL2", "fabella_r", "femur_distal_r"), fibre("link1", "patella_r", "fabella_r"), fibre("LCL9", "femur_distal_r", "fibula_r"),
                  fibre("PT1_l", "femur_l", "patella_l"), fibre("vastus_l", "femur_l", "patella_l", "Thelen2003Muscle"), fibre("psoas", "pelvis", "femur_l", "PathActuator")]
        file = model.write(self.folder / "m", "".join(forces), "".join(one for one, _ in bodies), "".join(joint for _, joint in bodies))
        command = ("convert", "osim", file, "--joint", "knee_r", "--geometry", DATA / "patella/jam-smith2019", "--json")
        report = json.loads(run(*command, "-o", self.folder / "job"))
        self.assertEqual(report["left_out"], ["bodies on other joints: pelvis, fibula_r; --followers NAME takes one", f"wrap {model.wraps[0]['name']} of /forceset/PT1: on a third body",
                                              "ligament /forceset/LCL9: an end on a further body",
                                              "3 ligaments and muscles of other joints: PT1_l, vastus_l, psoas"])
        patella, fabella = tomllib.loads((self.folder / "job/knee.toml").read_text(encoding="utf-8"))["follower"]
        self.assertEqual((patella["name"], fabella["name"], fabella["of"], "direction" in patella, "direction" in fabella), ("patella", "fabella_r", "reference", True, False))
        self.assertGreater(fabella["push"]["delta"][0], 0.5)  # in front of it is the condyle
        numpy.testing.assert_allclose(fabella["centre_mm"], [-60, 10, 15], atol=1e-9)
        self.assertEqual([name for name, _ in fibres_of(self.folder / "job/patella_fibres.csv")[0]], ["PT1", "quad"])
        self.assertEqual([name for name, _ in fibres_of(self.folder / "job/fabella_r_fibres.csv")[0]], ["FFL1", "FFL2", "link1"])
        run("check", self.folder / "job/knee.toml")
        # Bodies of the user's choice: one on the tibia touches that. Last, bodies without fibres or meshes.
        report = json.loads(run(*command, "-o", self.folder / "chosen", "--followers", "fibula_r", "patella_r"))
        self.assertIn("bodies on other joints: pelvis, fabella_r; --followers NAME takes one", report["left_out"])
        patella, fibula = tomllib.loads((self.folder / "chosen/knee.toml").read_text(encoding="utf-8"))["follower"]
        self.assertEqual((patella["name"], fibula["name"], fibula["of"], "contact" in fibula["component"][0]), ("patella", "fibula_r", "moving", False))
        run("check", self.folder / "chosen/knee.toml")
        content = file.read_text(encoding="utf-8")
        without = re.sub(r"<Blankevoort.*?</Blankevoort1991Ligament>", lambda m: m[0].replace("/bodyset/patella_r<", "/bodyset/femur_distal_r<"), content)
        file.write_text(without, encoding="utf-8")  # its muscle remains
        report = json.loads(run(*command, "-o", self.folder / "unheld"))
        self.assertIn("patella_r: no ligament holds it, and a coordinate coupled to the joint is not taken over", report["left_out"])
        (fabella,) = tomllib.loads((self.folder / "unheld/knee.toml").read_text(encoding="utf-8"))["follower"]
        self.assertEqual(fabella["name"], "fabella_r")
        file.write_text(re.sub(r'<Mesh name="(patella|fabella)_r">.*?</Mesh>', "", content), encoding="utf-8")
        report = json.loads(run(*command, "-o", self.folder / "bare"))
        self.assertIn("fabella_r: no mesh", report["left_out"])
        self.assertNotIn("follower", tomllib.loads((self.folder / "bare/knee.toml").read_text(encoding="utf-8")))


class RoundTrip(unittest.TestCase):
    def test_an_exported_model_has_the_same_motion(self):
        with tempfile.TemporaryDirectory(prefix="vrda-osim-job-") as name:
            folder = pathlib.Path(name)
            step = ("--set", "grid.flexion={from=0,to=90,step=30}")
            for side in ("right", "left"):
                wanted = poses(ROOT / "jobs/knee-generic.toml", folder, "--set", f"side={side}", "--set", 'grid.varus="free"', *step)
                self.assertEqual((wanted.shape[1], numpy.isfinite(wanted).all()), (2 * len(COORDINATES), True))
                run("export", folder / "knee.h5", "--to", "osim", "-o", folder / f"{side}.osim", "-q")
                run("convert", "osim", folder / f"{side}.osim", "--joint", "knee", "-o", folder / side, "--drawn", "femur_shaft", "tibia_shaft", "fibula",
                    "--muscles", "1")
                with self.subTest(side):
                    numpy.testing.assert_allclose(poses(folder / side / "knee.toml", folder, *step), wanted, atol=POSE)
                # Without --muscles the kneecap has its lines all the same, here with the same 30 N.
                run("convert", "osim", folder / f"{side}.osim", "--joint", "knee", "-o", folder / side, "--replace", "--drawn", "femur_shaft", "tibia_shaft", "fibula")
                with self.subTest(side, muscles=False):
                    numpy.testing.assert_allclose(poses(folder / side / "knee.toml", folder, *step), wanted, atol=POSE)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[2:], verbosity=2)
