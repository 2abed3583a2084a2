#!/usr/bin/python3
"""The player's page in augmented and virtual reality, emulated in headless Chromium; accessibility; USDZ.

usage: xr_in_browser.py VRDA PAGE CHROMIUM JOB PACKAGES [PICTURES]
PACKAGES: player/web/node_modules, with the packages of the tests; PICTURES: folder for screenshots.
"""
import base64
import io
import json
import pathlib
import re
import sys
import tempfile
import unittest
import zipfile

import h5py
import numpy
from PIL import Image

from headset import Headset, quaternion_of
from web_scenes import Page, make_models

VRDA, PAGE, CHROMIUM, JOB, PACKAGES = sys.argv[1:6]
KEPT = pathlib.Path(sys.argv[6]) if len(sys.argv) > 6 else None
# Required accuracy of a placement, and of poses of single precision at distances of metres.
PLACEMENT_MM, SINGLE_MM = 0.1, 0.01
SEED = 3


def rotation(generator):
    Q, R = numpy.linalg.qr(generator.normal(size=(3, 3)))
    Q *= numpy.sign(numpy.diag(R))
    return Q if numpy.linalg.det(Q) > 0 else Q[:, ::-1]


def closed_form(model, touched):
    """Scale of the distances of all pairs, then Umeyama's rotation (no scale) by singular values: as calibration/fiducial_fit."""
    a, b = numpy.triu_indices(len(model), 1)
    lengths = [numpy.linalg.norm(p[a] - p[b], axis=1) for p in (model, touched)]
    scale = lengths[0] @ lengths[1] / (lengths[0] @ lengths[0])
    m, t = scale * model, touched
    U, _, Vt = numpy.linalg.svd((t - t.mean(0)).T @ (m - m.mean(0)))
    R = U @ numpy.diag([1, 1, numpy.linalg.det(U @ Vt)]) @ Vt
    shift = t.mean(0) - R @ m.mean(0)
    return scale, R, shift, numpy.sqrt(((m @ R.T + shift - t) ** 2).sum(1).mean())


class Reality(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        if KEPT:
            KEPT.mkdir(parents=True, exist_ok=True)
        cls.folder = tempfile.TemporaryDirectory(prefix="vrda-xr-test-")
        cls.models = make_models(VRDA, JOB, pathlib.Path(cls.folder.name), ("grid", "left"))

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def opened(self, page, model="grid", mode="immersive-ar", is_seen=False):
        # Small, since the room is drawn without a graphics card.
        width, height = (1200, 900) if KEPT else (320, 240)
        page.visit(f"file://{PAGE}", width=width, height=height)
        self.assertEqual(page.give(self.models[model]), "")
        if not (is_seen or KEPT):
            page.hide_joint()
        page.start(mode)
        self.assertTrue(page.state()["isPresenting"], page.text("message"))

    def keep(self, page, name):
        """The screenshot as an array."""
        png = base64.b64decode(page.browser.call("Page.captureScreenshot", format="png")["data"])
        if KEPT:
            (KEPT / f"{name}.png").write_bytes(png)
        return numpy.asarray(Image.open(io.BytesIO(png)).convert("RGB")).astype(int)

    def is_quiet(self, page):
        self.assertEqual(page.browser.said, [])
        self.assertEqual([a for a in page.browser.requests if not a.startswith(("file:", "data:", "blob:", "about:"))], [])

    def drawn(self, page):
        """The matrix by which the joint is drawn, with mm on both sides."""
        matrix = numpy.array(page.state()["drawn"]).reshape(4, 4).T
        matrix[:3, :3] *= 1000
        matrix[:3, 3] *= 1000
        return matrix

    def vertices(self, page, model="grid", patella=False):
        """All vertices of both bodies (and of the patella) at the pose shown, mm from the rotation centre in the reference's axes."""
        with h5py.File(self.models[model]) as file:
            centre, X = numpy.array(file.attrs["rotation_centre_mm"]), numpy.array(page.shown()["X_reference_moving"]).reshape(4, 4)
            parts = {body: numpy.vstack([file[f"/bodies/{body}{part}/vertices"][()] for part in ("", "/visual") if f"/bodies/{body}{part}" in file]) for body in ("reference", "moving")}
            follower = file["/followers/patella/body/vertices"][()]
        placed = [parts["reference"], parts["moving"] @ X[:3, :3].T + X[:3, 3]]
        if patella:
            X = numpy.array(page.shown()["followers"][0]).reshape(4, 4)
            placed.append(follower @ X[:3, :3].T + X[:3, 3])
        return numpy.vstack(placed) - centre

    def put_points(self, page):
        """Starts to touch; returns the points, mm from the rotation centre in the reference's axes, at the pose shown."""
        page.use("touch")
        points = page.state()["points"]
        X = numpy.array(page.shown()["X_reference_moving"]).reshape(4, 4)
        with h5py.File(self.models["grid"]) as file:
            centre = numpy.array(file.attrs["rotation_centre_mm"])
        model = numpy.array([p["point"] for p in points])
        is_moving = numpy.array([p["body"] == "moving" for p in points])
        model[is_moving] = (model[is_moving] + centre) @ X[:3, :3].T + X[:3, 3] - centre
        return points, model

    def test_ar_by_hit_test_slider_and_leaving(self):
        with Headset(CHROMIUM, PACKAGES) as page:
            self.opened(page, is_seen=True)
            self.assertIsNone(page.state()["placement"])
            page.aim((0.3, 0.75, -0.9))
            page.frames(3)  # the emulated hit test is late by one or two
            hit = numpy.array(page.state()["hit"]).reshape(4, 4).T[:3, 3] * 1000
            self.keep(page, "ar-reticle")
            page.press()
            drawn, all_vertices = self.drawn(page), self.vertices(page)
            placed = all_vertices @ drawn[:3, :3].T + drawn[:3, 3]
            # Of the model's size, upright, the lowest point as high as the surface, the centre above the place.
            numpy.testing.assert_allclose(drawn[:3, :3] @ drawn[:3, :3].T, numpy.eye(3), atol=1e-6)
            self.assertAlmostEqual(numpy.linalg.det(drawn[:3, :3]), 1, delta=1e-6)
            numpy.testing.assert_allclose(drawn[:3, 1], (0, 1, 0), atol=1e-6)
            self.assertAlmostEqual(placed[:, 1].min(), hit[1], delta=PLACEMENT_MM)
            numpy.testing.assert_allclose(drawn[[0, 2], 3], hit[[0, 2]], atol=PLACEMENT_MM)
            self.assertIn("Placed on the surface", page.state()["instruction"])
            straight = self.keep(page, "ar-placed")
            # The slider, pressed and drawn along.
            page.aim_at_panel(0.5)
            page.trigger(True)
            self.assertAlmostEqual(page.shown()["flexion"], 45, delta=0.1)
            page.aim_at_panel(0.8)
            self.assertAlmostEqual(page.shown()["flexion"], 72, delta=0.1)
            page.trigger(False)
            page.aim_at_panel(0.2)
            self.assertAlmostEqual(page.shown()["flexion"], 72, delta=0.1)
            bent = self.keep(page, "ar-bent")
            self.assertGreater((numpy.abs(bent - straight).sum(axis=2) > 60).mean(), 0.002)
            self.assertEqual(page.browser.value("document.documentElement.dataset.space"), "on")
            self.structures_in_space(page)
            page.use("leave")
            page.browser.wait("!window.vrda.xr.state().isPresenting")
            # The page goes on where the session ended.
            page.settle()
            self.assertIn("flexion 72.0°", page.text("shown"))
            page.set("flexion", 30)
            self.assertIn("flexion 30.0°", page.text("shown"))
            self.keep(page, "after-leaving")
            self.is_quiet(page)

    def structures_in_space(self, page):
        """The list, opacity, labels and card in the panel, and a structure that is pointed at."""
        look = lambda: next(one for one in page.browser.value("window.vrda.structures()") if one["id"] == page.browser.value("window.vrda.state().highlighted"))  # noqa: E731
        page.use("structures")
        first = look()
        self.assertEqual(json.loads(page.state()["drawnPanel"])[0], first["name"])
        page.use("previous")  # from the first one around the list, past the layers of contact
        for _ in range(3):
            page.use("previous")
        bundle = look()
        self.assertIn("ligaments/", bundle["id"])
        title, does, reading = json.loads(page.state()["drawnPanel"])[:3]
        self.assertEqual(title, bundle["name"])
        self.assertTrue(does)
        self.assertRegex(reading, "^(Strain|Slack|Pulls with) .* (72°|every angle)")
        before = self.keep(page, "ar-structures")
        page.use("labels")
        self.assertTrue(page.browser.value("document.getElementById('named').checked"))
        self.assertGreater((numpy.abs(self.keep(page, "ar-labels") - before).sum(axis=2) > 60).mean(), 0.001)
        page.use("labels")
        # At the joint: the first structure along the ray.
        drawn = self.drawn(page)
        page.aim(drawn[:3, 3] / 1000)
        page.press()
        pointed = look()
        self.assertIn("/", pointed["id"])
        self.assertNotIn("layers/", pointed["id"])
        self.assertNotEqual(pointed["id"], bundle["id"])
        self.assertAlmostEqual(page.shown()["flexion"], 72, delta=0.1)
        page.aim_at_panel(0.3)
        page.press()
        self.assertAlmostEqual(look()["opacity"], 0.3, delta=0.01)
        page.use("isolate")
        self.assertEqual([one["id"] for one in page.browser.value("window.vrda.structures()") if one["visible"]], [pointed["id"]])
        page.use("shown")
        self.assertFalse(look()["visible"])
        page.use("isolate")  # all again
        self.assertTrue(look()["visible"])
        page.use("back")
        self.assertNotIn("highlighted", page.browser.value("window.vrda.state()"))

    def test_landmarks_place_as_the_closed_form(self):
        generator = numpy.random.default_rng(SEED)
        with Headset(CHROMIUM, PACKAGES) as page:
            self.opened(page)
            for n, noise in ((6, 2.0), (3, 1.0)):
                with self.subTest(points=n, noise=noise):
                    points, model = self.put_points(page)
                    self.assertEqual(len(points), 6)
                    R, scale, shift = rotation(generator), 1.0 + 0.1 * generator.random(), numpy.array((200.0, 900.0, -500.0))
                    touched = scale * model @ R.T + shift + generator.normal(scale=noise, size=model.shape)
                    order = range(6) if n == 6 else (0, 1, 3)
                    for k in range(6):
                        if k in order:
                            self.assertIn(points[k]["name"], page.state()["instruction"])
                            page.touch(touched[k])
                        elif page.state()["task"] == "touch" and len(page.state()["touches"]) < n:
                            page.use("skip")
                    if n == 3:
                        page.use("fit")
                    own = list(order)
                    wanted_scale, wanted_R, wanted_shift, wanted_rms = closed_form(model[own], touched[own])
                    drawn = self.drawn(page)
                    # At the points and 200 mm beyond them.
                    for far in (1, 4):
                        found = far * model @ drawn[:3, :3].T + drawn[:3, 3]
                        wanted = wanted_scale * far * model @ wanted_R.T + wanted_shift
                        self.assertLess(numpy.linalg.norm(found - wanted, axis=1).max(), PLACEMENT_MM)
                    state = page.state()
                    self.assertAlmostEqual(state["fit"]["rms"], wanted_rms, delta=SINGLE_MM)
                    self.assertIn(f"Placed by {n} points to {wanted_rms:.1f} mm (rms), size {100 * wanted_scale:.0f} %", state["note"])
            self.is_quiet(page)

    def test_points_that_contradict_are_refused(self):
        with Headset(CHROMIUM, PACKAGES) as page:
            self.opened(page, mode="immersive-vr")
            page.frames()
            before = self.drawn(page)
            _, model = self.put_points(page)
            shift = numpy.array((0.0, 1000.0, -500.0))
            self.keep(page, "vr-touch")
            # A guess of the device is no touch.
            page.browser.value("window.isGuess = true")
            page.touch(model[0] + shift)
            self.assertEqual(page.state()["touches"], [])
            self.assertIn("not tracked", page.state()["note"])
            page.browser.value("window.isGuess = false")
            page.touch(model[0])
            page.use("undo")
            self.assertEqual((page.state()["touches"], page.state()["next"]), ([], 0))
            far = numpy.where(numpy.arange(6)[:, None] == 4, 25.0, 0.0) * (0, 1, 0)
            for touched, said in ((model * (1, 1, -1), "other side"), (model + far, "touch it again"), (3 * model, "times as large"), (numpy.linspace(0, 1, 6)[:, None] * (90.0, 0, 0), "on a line")):
                with self.subTest(said):
                    for point in touched + shift:
                        page.touch(point)
                    state = page.state()
                    self.assertIn(said, state["note"])
                    self.assertIn("Not placed", state["note"])
                    self.assertEqual(state["task"], "touch")
                    numpy.testing.assert_array_equal(self.drawn(page), before)
                    self.keep(page, "vr-refused")
                    page.use("cancel")
                    page.use("touch")
            page.use("cancel")
            self.assertEqual(page.state()["task"], "place")
            self.is_quiet(page)

    def test_a_controller_on_the_shank_bends_the_knee(self):
        for model in ("grid", "left"):
            with self.subTest(model), Headset(CHROMIUM, PACKAGES) as page:
                self.opened(page, model, "immersive-vr")
                page.aim_at_panel(1 / 3)
                page.press()
                self.assertAlmostEqual(page.shown()["flexion"], 30, delta=0.1)
                page.aim_at_panel("pin")
                page.press()
                self.assertTrue(page.state()["isPinned"])
                # Flexion turns the shank about -Z of the femur, wherever the femur is.
                axis = -self.drawn(page)[:3, 2]
                held = numpy.array(page.browser.value("[...window.device.controllers.right.quaternion.quat]"))

                def turn(degrees):
                    half = numpy.radians(degrees) / 2
                    x, y, z, w = [*(axis * numpy.sin(half)), numpy.cos(half)]
                    a, b, c, d = held
                    page.hold((0.1, 1.0, -0.3), (w * a + x * d + y * c - z * b, w * b - x * c + y * d + z * a, w * c + x * b - y * a + z * d, w * d - x * a - y * b - z * c))

                for degrees in (0, 25, 55, -20):
                    turn(degrees)
                    self.assertAlmostEqual(page.shown()["flexion"], 30 + degrees, delta=0.2)
                self.assertEqual(page.state()["marks"], [])
                # Lying: beyond the model; absent: not tracked. Both are marked, and the joint stays.
                turn(90)
                self.assertIn("flexion 120°, model ends at 90", " ".join(page.state()["marks"]))
                self.assertEqual(page.shown()["flexion"], 90)
                turn(20)
                page.browser.value("window.isGuess = true")
                turn(40)
                self.assertAlmostEqual(page.shown()["flexion"], 50, delta=0.2)
                self.assertIn("not tracked for", " ".join(page.state()["marks"]))
                self.keep(page, f"vr-pinned-{model}")
                page.browser.value("window.isGuess = false")
                turn(40)
                self.assertAlmostEqual(page.shown()["flexion"], 70, delta=0.2)
                page.browser.value("window.device.controllers.right.connected = false")
                page.frames()
                self.assertIn("not tracked for", " ".join(page.state()["marks"]))
                self.is_quiet(page)

    def test_sessions_end_from_outside_and_start_again(self):
        with Headset(CHROMIUM, PACKAGES) as page:
            for mode in ("immersive-vr", "immersive-ar", "immersive-vr"):
                self.opened(page, mode=mode)
                self.assertEqual(page.state()["xrMode"], mode)
                self.assertEqual(page.state()["placement"] is not None, mode == "immersive-vr")
                page.use("play")
                page.browser.wait("window.vrda.shown().flexion > 3")
                self.keep(page, mode)
                page.browser.value("window.device.activeSession.end()")
                page.browser.wait("!window.vrda.xr.state().isPresenting")
                page.settle()
            # A model that is opened ends the session that shows another.
            page.start("immersive-ar")
            self.assertEqual(page.give(self.models["left"]), "")
            page.browser.wait("!window.vrda.xr.state().isPresenting")
            self.assertIn("left knee", page.text("facts"))
            self.is_quiet(page)

    def test_without_a_surface_and_with_a_refusing_device(self):
        with Headset(CHROMIUM, PACKAGES) as page:
            page.visit(f"file://{PAGE}")
            self.assertEqual(page.give(self.models["grid"]), "")
            page.browser.value("window.device.sem.deleteAll()")
            page.start("immersive-ar")
            page.aim((0.3, 0.75, -0.9))
            page.press()
            self.assertIn("No surface found yet", page.state()["instruction"])
            self.assertIsNone(page.state()["placement"])
            page.use("leave")
            page.browser.wait("!window.vrda.xr.state().isPresenting")
            page.browser.value("navigator.xr.requestSession = () => Promise.reject(new Error('the headset is taken'))")
            page.start("immersive-vr")
            self.assertEqual(page.text("message"), "View in VR: the headset is taken")
            page.set("flexion", 20)
            self.assertIn("flexion 20.0°", page.text("shown"))

    def test_no_headset_no_buttons(self):
        with Page(CHROMIUM) as page:
            page.visit(f"file://{PAGE}")
            self.assertEqual(page.give(self.models["grid"]), "")
            page.settle()
            self.assertEqual(page.text("xr-buttons"), "")
            self.assertTrue(page.browser.value("document.getElementById('xr-note').hidden"))

    def test_no_serious_accessibility_fault(self):
        axe = (pathlib.Path(PACKAGES) / "axe-core/axe.min.js").read_text()
        with Headset(CHROMIUM, PACKAGES) as page:
            page.run_first(axe)

            def check(state):
                found = page.browser.value("axe.run(document).then(({ violations }) => violations.filter((v) => ['serious', 'critical'].includes(v.impact))"
                                           ".map((v) => [v.id, v.nodes.map((n) => n.html + n.failureSummary).join('\\n')]))")
                self.assertEqual(found, [], state)
                self.assertGreater(page.browser.value("axe.run(document).then(({ passes }) => passes.length)"), 10)

            page.visit(f"file://{PAGE}")
            check("empty")
            page.give(self.models["grid"])
            page.browser.wait("document.querySelector('#xr-buttons button') !== null")
            page.browser.value("document.getElementById('marks').textContent = 'tibia hidden for 1.0 s'; document.getElementById('help').open = true")
            page.browser.value("for (const id of ['follow-choice', 'placed-choice', 'xr-note']) document.getElementById(id).hidden = false")
            page.settle()
            check("model")
            page.visit(f"file://{PAGE}", width=390, height=844, is_phone=True)
            page.give(self.models["left"])
            check("phone")
            page.browser.value("document.getElementById('full').click()")
            page.settle()
            check("full screen")

    def test_usdz_has_the_joint_in_metres(self):
        with Page(CHROMIUM) as page:
            page.visit(f"file://{PAGE}")
            self.assertEqual(page.give(self.models["grid"]), "")
            page.set("held", "reference", "change")
            page.set("flexion", 40)
            page.settle()
            vertices = self.vertices(page, patella=True)
            data = bytes(page.browser.value("window.vrda.usdz()"))
            if KEPT:
                (KEPT / "knee.usdz").write_bytes(data)
            with zipfile.ZipFile(io.BytesIO(data)) as archive:
                self.assertIsNone(archive.testzip())
                for info in archive.infolist():
                    self.assertEqual(info.compress_type, zipfile.ZIP_STORED)
                    # Apple wants each file at a multiple of 64 bytes.
                    start = info.header_offset + 30 + int.from_bytes(data[info.header_offset + 26 : info.header_offset + 28], "little") + int.from_bytes(data[info.header_offset + 28 : info.header_offset + 30], "little")
                    self.assertEqual(start % 64, 0, info.filename)
                texts = {name: archive.read(name).decode() for name in archive.namelist()}
            self.assertIn("metersPerUnit = 1", texts["model.usda"])
            nodes = self.nodes(texts["model.usda"])
            self.assertLessEqual({"reference", "moving", "ligaments_1"}, {node["name"] for node in nodes})
            # The corners of the bones, through the transforms above them: turned to the viewer, standing on 0.
            wanted = numpy.unique(numpy.round(numpy.column_stack((-vertices[:, 2], vertices[:, 1] - vertices[:, 1].min(), vertices[:, 0])), 3), axis=0)
            found = numpy.vstack([self.points(node, texts) for node in nodes if node["geometry"] and not node["name"].startswith("ligaments")])
            self.assertLess(numpy.abs(numpy.unique(numpy.round(1000 * found, 3), axis=0).min(0) - wanted.min(0)).max(), PLACEMENT_MM)
            self.assertLess(numpy.abs(found.max(0) * 1000 - wanted.max(0)).max(), PLACEMENT_MM)
            for corner in found[:: len(found) // 50]:
                self.assertLess(numpy.linalg.norm(wanted - 1000 * corner, axis=1).min(), PLACEMENT_MM)

    @staticmethod
    def rows(text):
        return numpy.array(json.loads("[" + text.replace("(", "[").replace(")", "]") + "]"))

    @classmethod
    def nodes(cls, text):
        """The nodes of a USD text: name, parent, transform of rows, name of the geometry's file."""
        nodes, above = [], []
        for line in text.splitlines():
            if match := re.match(r'(\t*)def Xform "(\w+)"', line):
                depth = len(match[1])
                above = above[:depth] + [None] * (depth - len(above[:depth]))
                node = {"name": match[2], "parent": next((one for one in reversed(above) if one), None), "own": numpy.eye(4), "geometry": None}
                nodes.append(node)
                above.append(node)
            if match := re.search(r"matrix4d xformOp:transform = \((.*)\)", line):
                nodes[-1]["own"] = cls.rows(match[1])
            if match := re.search(r"geometries/(Geometry_\d+\.usda)", line):
                nodes[-1]["geometry"] = match[1]
        return nodes

    @classmethod
    def points(cls, node, texts):
        points = cls.rows(re.search(r"point3f\[\] points = \[(.*?)\]", texts[f"geometries/{node['geometry']}"], re.DOTALL)[1])
        points = numpy.column_stack((points, numpy.ones(len(points))))
        while node:
            points, node = points @ node["own"], node["parent"]
        return points[:, :3]


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
