#!/usr/bin/python3
"""The player's web page in headless Chromium, with models of a small generic knee.

usage: page_in_browser.py VRDA PRINT_POSES PAGE CHROMIUM JOB [PICTURES]
Compares its poses with the library's, and checks that the controls move the joint, that the rendering shows a knee, and
the messages for invalid files; all from disk, without network requests. PICTURES: folder for screenshots.
"""
import base64
import io
import json
import pathlib
import random
import re
import subprocess
import sys
import tempfile
import unittest

import h5py
import numpy
from PIL import Image

from web_scenes import MODELS, Page, bad_files, changed, make_models

VRDA, PRINT_POSES, PAGE, CHROMIUM, JOB = sys.argv[1:6]
KEPT = pathlib.Path(sys.argv[6]) if len(sys.argv) > 6 else None
SIZE = {"width": 1400, "height": 1000} if KEPT else {}
# Required accuracy; measured: both below 1e-12.
MM, RAD = 1e-6, 1e-9
ATTITUDES, SEED = 200, 7
HDF5_MESSAGES = re.compile(r"error: (HDF5-DIAG| +#\d+:| +major:| +minor:)")
# Least fraction of bone pixels: for the joint, and for whole bones.
LEAST_BONE = (0.1, 0.03)
# Rounding of lengths of 20 mm and more, divided by slack lengths.
STRAIN = 1e-12
# Least fraction of pixels that a layer changes; opaque menisci cover a part of the gap layer.
LEAST_LAYER = 0.002
# Least standard deviation of the grey levels of bones, on 0 to 255.
LEAST_SHADING = 10
ALL = ("(list) => list.map(([set, flexion, varus]) => { const p = window.vrda.pose(set, flexion, varus);"
       " return [p.isSolved, p.isFlexionClamped, p.isVarusClamped, p.X_reference_moving ?? null, p.theta_rad ?? null, p.followers ?? []]; })")


def travel_to(mesh, point, direction):
    """Gap from a point to the nearest facing triangle, from 3 mm of overlap to 6 mm, by testing all triangles."""
    deepest, range_mm = 3, 6
    start = point - deepest * direction
    a, b = mesh[:, 1] - mesh[:, 0], mesh[:, 2] - mesh[:, 0]
    across = numpy.cross(direction, b)
    facing = (a * across).sum(axis=1)
    own = facing > 0
    s, q = start - mesh[own, 0], numpy.cross(start - mesh[own, 0], a[own])
    u, v = (s * across[own]).sum(axis=1) / facing[own], q @ direction / facing[own]
    travel = (b[own] * q).sum(axis=1) / facing[own]
    met = travel[(u >= 0) & (v >= 0) & (u + v <= 1) & (travel >= 0) & (travel <= deepest + range_mm)]
    return met.min() - deepest if met.size else None


def attitudes_of(file):
    """Flexion and varus in degrees, one third nodes, one third between nodes, one third from a range 1.5 times as wide; for print_poses."""
    chosen = random.Random(SEED)

    def angle(axis, k):
        margin = 0.25 * (axis[-1] - axis[0]) + 1
        return (chosen.choice(axis), chosen.uniform(axis[0], axis[-1]), chosen.uniform(axis[0] - margin, axis[-1] + margin))[k % 3]

    with h5py.File(file) as model:
        axes = [model[name][()].tolist() for name in ("/flexion", "/varus")]
    return "".join(f"{angle(axes[0], k)!r} {angle(axes[1], k)!r}\n" for k in range(ATTITUDES))


class WebPage(unittest.TestCase):
    """One set of models for all tests; each test reopens the page."""

    @classmethod
    def setUpClass(cls):
        if KEPT:
            KEPT.mkdir(parents=True, exist_ok=True)
        cls.folder = tempfile.TemporaryDirectory(prefix="vrda-web-test-")
        cls.root = pathlib.Path(cls.folder.name)
        cls.models = make_models(VRDA, JOB, cls.root)
        cls.poses = {name: json.loads(subprocess.run([PRINT_POSES, file], input=attitudes_of(file), check=True, capture_output=True, text=True).stdout)
                     for name, file in cls.models.items()}

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def opened(self, page, model, **how):
        self.assertEqual(page.open(f"file://{PAGE}", self.models[model], **how), "")

    def is_quiet(self, page):
        """Checks that there are no console messages and no network requests."""
        self.assertEqual(page.browser.said, [])
        self.assertEqual([a for a in page.browser.requests if not a.startswith(("file:", "data:", "blob:", "about:"))], [])

    def picture(self, page, element, name):
        png = page.browser.element(f"document.querySelector('{element}')")
        if KEPT:
            (KEPT / f"{name}.png").write_bytes(png)
        return numpy.asarray(Image.open(io.BytesIO(png)).convert("RGB")).astype(int)

    def whole(self, page, name):
        if KEPT:
            size = page.browser.value("[document.documentElement.scrollWidth, document.documentElement.scrollHeight]")
            clip = {"x": 0, "y": 0, "width": size[0], "height": size[1], "scale": 1}
            png = page.browser.call("Page.captureScreenshot", format="png", captureBeyondViewport=True, clip=clip)["data"]
            (KEPT / f"{name}.png").write_bytes(base64.b64decode(png))

    def test_poses_are_the_library_s(self):
        with Page(CHROMIUM) as page:
            for name in MODELS:
                self.opened(page, name)
                self.assertEqual(page.browser.value("window.vrda.sets()"), list(self.poses[name]))
                outcomes, followed = set(), 0
                for motion, wanted in self.poses[name].items():
                    requested = [[motion, p["flexion"], p["varus"]] for p in wanted]
                    found = page.browser.value(f"({ALL})({json.dumps(requested)})")
                    for ours, theirs in zip(found, wanted, strict=True):
                        with self.subTest(model=name, set=motion, flexion=theirs["flexion"], varus=theirs["varus"]):
                            self.assertEqual(ours[:3], [theirs["is_solved"], theirs["is_flexion_clamped"], theirs["is_varus_clamped"]])
                            outcomes.add((ours[0], ours[1]))
                            if ours[0]:
                                apart = numpy.abs(numpy.array(ours[3]) - theirs["X"]).reshape(4, 4)
                                self.assertLess(apart[:, 3].max(), MM)
                                self.assertLess(apart[:, :3].max(), RAD)
                                self.assertLess(abs(ours[4] - theirs["theta_rad"]), RAD)
                                self.assertEqual([X is None for X in ours[5]], [X is None for X in theirs["followers"]])
                                for X, wanted_X in zip(ours[5], theirs["followers"]):
                                    apart = numpy.abs(numpy.array(X or 0) - (wanted_X or 0))
                                    self.assertLess(apart.max(), MM)
                                    followed += X is not None
                self.assertLessEqual({(True, False), (True, True)}, outcomes)
                self.assertEqual((False, False) in outcomes, name == "holes")
                self.assertGreater(followed, 0)
            self.is_quiet(page)

    def test_the_default_motion_is_shown_with_its_reason(self):
        sets = {}
        with Page(CHROMIUM) as page:
            for name in ("grid", "holes"):
                self.opened(page, name)
                with h5py.File(self.models[name]) as file:
                    sets[name], reason = (file["default_motion"].attrs[key][0] for key in ("set", "reason"))
                self.assertEqual(page.shown()["set"], sets[name])
                self.assertIn(reason, page.text("note"))
                self.assertEqual("criteria" in page.text("note"), bool(reason))
        self.assertEqual(sets, {"grid": "two_sided", "holes": "raw"})

    def test_band_of_an_uncertain_job(self):
        with Page(CHROMIUM) as page:
            self.opened(page, "grid")
            self.assertTrue(page.browser.value("document.getElementById('band-choice').hidden"))
            self.opened(page, "uncertain")
            page.set("flexion", 30)
            page.set("quantity", "clinical_internal", "change")
            page.settle()
            with h5py.File(self.models["uncertain"]) as file:
                self.assertEqual(page.browser.value("window.vrda.sets()")[-6:], [*(f"quantile_{percent}" for percent in (0, 5, 50, 95, 100)), "bones_alone"])
                wanted = [file["/uncertainty/rotation_band"][k, :, 2] for k in (3, 1)]
            # The ends of the band at the model's flexions.
            drawn = page.browser.value("window.vrda.curve()")
            for ends, values in zip(wanted, (drawn["band"]["high"], drawn["band"]["low"]), strict=True):
                at = [values[drawn["x"].index(f)] for f in (0, 30, 60, 90)]
                numpy.testing.assert_allclose(at, ends, rtol=0, atol=1e-9)
            # The bones alone: a thin line behind the others.
            self.assertEqual([(name, width) for name, width in drawn["lines"] if width < 2], [("bones alone", 1)])
            alone = [numpy.degrees(page.browser.value(f"window.vrda.pose('bones_alone', {f}, 0).theta_rad")) for f in (0, 30, 60, 90)]
            numpy.testing.assert_allclose([drawn["curves"][-1][drawn["x"].index(f)] for f in (0, 30, 60, 90)], alone, rtol=0, atol=1e-9)
            self.assertGreater(max(numpy.abs(numpy.subtract(alone, [drawn["curves"][0][drawn["x"].index(f)] for f in (0, 30, 60, 90)]))), 0.1)
            # Of contacts and bundles: around the motion shown, and as wide as its poses are apart.
            for name in ("contact", "strain"):
                page.browser.wait(f"(document.querySelectorAll('figure.of-{name}')[0].scrollIntoView(), window.vrda.band('{name}'))")
            band = page.browser.value("window.vrda.band('strain')")
            with h5py.File(self.models["uncertain"]) as file:
                poses = [page.browser.value(f"window.vrda.pose('quantile_{percent}', 30, 0).X_reference_moving") for percent in (5, 95)]
                own = file["/ligaments/bundle"].asstr()[()] == page.browser.value("window.vrda.structures().find((one) => one.id.startsWith('ligaments/')).id").removeprefix("ligaments/")
            strains = [100 * numpy.array(page.browser.value(f"window.vrda.strains({{ R: {X[:3, :3].tolist()}, t: {X[:3, 3].tolist()} }})"))[own].max() for X in (numpy.reshape(one, (4, 4)) for one in poses)]
            k = band["x"].index(30)
            self.assertLess(max(band["low"][k] - min(strains), max(strains) - band["high"][k]), 1e-9)
            self.assertGreater(max(numpy.subtract(band["high"], band["low"])), 0)
            contact = page.browser.value("window.vrda.band('contact')")
            self.assertTrue(all(low <= high for low, high in zip(contact["low"], contact["high"], strict=True)))
            self.assertGreater(max(numpy.subtract(contact["high"], contact["low"])), 0.1)
            without = self.picture(page, "#joint", "band-off")
            page.browser.value("document.getElementById('band').click()")
            page.settle()
            # The ghosts show beyond the outline of the tibia, not as patches on it.
            changed = (numpy.abs(self.picture(page, "#joint", "band-on") - without).sum(axis=2) > 20).mean()
            self.assertTrue(0.001 < changed < 0.01, changed)
            page.browser.value("document.getElementById('band').click()")
            page.settle()
            numpy.testing.assert_array_equal(self.picture(page, "#joint", "band-off-again"), without)
            self.is_quiet(page)

    def test_slider_moves_the_joint_to_the_pose(self):
        node = next(p for p in self.poses["grid"]["raw"] if p["flexion"] >= 30 and p["is_solved"] and not p["is_flexion_clamped"] and not p["is_varus_clamped"])
        with Page(CHROMIUM) as page:
            self.opened(page, "grid")
            before = self.picture(page, "#joint", "straight")
            page.set("set", "raw", "change")
            page.set("flexion", node["flexion"])
            page.set("varus", node["varus"])
            page.settle()
            shown = page.shown()
            self.assertAlmostEqual(shown["flexion"], node["flexion"])
            self.assertLess(numpy.abs(numpy.array(shown["X_reference_moving"]) - node["X"]).max(), MM)
            self.assertIn("raw", page.text("shown"))
            after = self.picture(page, "#joint", "bent")
            self.assertGreater((numpy.abs(before - after).sum(axis=2) > 30).mean(), 0.02)
            self.is_quiet(page)

    def test_degree_switch_moves_the_joint_and_the_curve(self):
        with Page(CHROMIUM) as page:
            self.opened(page, "grid")
            page.set("flexion", 55)
            poses, curves = [], []
            for motion in ("degree_4", "degree_2", "degree_4"):
                page.set("set", motion, "change")
                page.settle()
                poses.append(page.shown()["X_reference_moving"])
                curves.append(self.picture(page, "#curve canvas", f"curve-{motion}"))
            self.assertEqual(poses[0], poses[2])
            self.assertGreater(numpy.abs(numpy.array(poses[0]) - poses[1]).max(), 1e-3)
            self.assertGreater(numpy.abs(curves[0] - curves[1]).max(), 30)
            self.assertEqual(numpy.abs(curves[0] - curves[2]).max(), 0)
            for quantity in ("ty", "clinical_internal"):
                page.set("quantity", quantity, "change")
                page.settle()
                self.assertGreater(numpy.abs(self.picture(page, "#maps canvas", quantity)).std(), 10)
            self.is_quiet(page)

    def test_it_looks_like_a_knee(self):
        with Page(CHROMIUM) as page:
            self.opened(page, "grid", **SIZE)
            for view in ("oblique", "front", "lateral", "top"):
                page.browser.value(f"document.querySelector('#views [value={view}]').click()")
                page.settle()
                pixels = self.picture(page, ".picture", f"view-{view}")
                red, green, blue = pixels[..., 0], pixels[..., 1], pixels[..., 2]
                bone = (red > green) & (green > blue) & (red - blue > 15)
                self.assertGreater(bone.mean(), LEAST_BONE[view == "top"], view)
                self.assertGreater(pixels[bone].mean(axis=1).std(), LEAST_SHADING, view)
                meniscus = (red - green > 45) & (red - blue > 45)
                self.assertGreater(meniscus.mean(), 0.001 if view != "top" else 0.0, view)
            self.whole(page, "page")
            self.is_quiet(page)

    def test_ligaments_are_as_taut_as_the_library_s(self):
        with h5py.File(self.models["grid"]) as file, Page(CHROMIUM) as page:
            self.opened(page, "grid")
            strain, poses = file["/ligaments/strain"][()], file["/X_reference_moving"][()]
            solved = file["/status"][()] == 0
            self.assertGreater(solved.sum(), 10)
            self.assertGreater((strain[solved] > 0).sum(), 10)
            for cell in numpy.argwhere(solved):
                X = poses[tuple(cell)]
                found = page.browser.value(f"window.vrda.strains({{ R: {X[:3, :3].tolist()}, t: {X[:3, 3].tolist()} }})")
                self.assertLess(numpy.abs(found - strain[tuple(cell)]).max(), STRAIN)
            self.is_quiet(page)

    def test_layers_show_and_hide(self):
        with Page(CHROMIUM) as page:
            self.opened(page, "grid", **SIZE)
            page.set("set", "degree_4_recontacted", "change")
            page.set("flexion", 10)
            pictures = {}
            for ligaments, gaps in ((True, False), (False, False), (False, True), (True, True)):
                for name, wanted in (("ligaments", ligaments), ("gaps", gaps)):
                    if page.browser.value(f"document.getElementById('{name}').checked") != wanted:
                        page.browser.value(f"document.getElementById('{name}').click()")
                page.settle()
                pictures[ligaments, gaps] = self.picture(page, ".picture", f"layers-{ligaments}-{gaps}".lower())
            differs = lambda a, b: (numpy.abs(pictures[a] - pictures[b]).sum(axis=2) > 60).mean()  # noqa: E731
            self.assertGreater(differs((True, False), (False, False)), LEAST_LAYER)
            self.assertGreater(differs((False, True), (False, False)), LEAST_LAYER)
            self.assertEqual(page.text("strain-scale"), "strainslack08 %more")
            self.whole(page, "page-layers")
            self.is_quiet(page)

    def test_gaps_are_those_of_every_triangle(self):
        with h5py.File(self.models["grid"]) as file, Page(CHROMIUM) as page:
            self.opened(page, "grid")
            page.set("flexion", 25)
            page.browser.value("document.getElementById('gaps').click()")
            page.settle()
            found = page.browser.value("window.vrda.gaps()")
            X, delta = numpy.array(page.shown()["X_reference_moving"]).reshape(-1, 4), file.attrs["delta"]
            mesh = file["/bodies/reference/vertices"][()][file["/bodies/reference/triangles"][()]]
            near = 0
            for x, y, z, gap in found[:: max(1, len(found) // 300)]:
                wanted = travel_to(mesh, X[:3, :3] @ (x, y, z) + X[:3, 3], X[:3, :3] @ delta)
                near += gap is not None
                self.assertEqual(gap is None, wanted is None)
                self.assertAlmostEqual(gap or 0, wanted or 0, delta=MM)
            self.assertGreater(near, 20)
            self.assertLess(near, 300)
            self.is_quiet(page)

    def test_plays_and_stops(self):
        with Page(CHROMIUM) as page:
            self.opened(page, "grid")
            page.browser.call("Input.dispatchKeyEvent", type="keyDown", key=" ", code="Space", text=" ")
            page.browser.wait("window.vrda.shown().flexion > 20")
            self.assertEqual(page.text("play"), "Pause")
            page.browser.call("Input.dispatchKeyEvent", type="keyDown", key=" ", code="Space", text=" ")
            stopped = page.shown()["flexion"]
            page.settle()
            self.assertEqual(page.shown()["flexion"], stopped)
            # While frames are slow, here by their times, a motion has fewer pixels; the still picture has all.
            width = "document.getElementById('joint').width"
            sharp = page.browser.value(width)
            page.browser.value("window.requestAnimationFrame = ((real) => (act) => real((now) => act(10 * now)))(window.requestAnimationFrame)")
            page.browser.value("document.getElementById('play').click()")
            page.browser.wait(f"{width} < {sharp}")
            page.browser.value("document.getElementById('play').click()")
            page.settle()
            self.assertEqual(page.browser.value(width), sharp)
            Page.current = None  # its frames have other times
            self.is_quiet(page)

    def test_says_that_it_clamps(self):
        with Page(CHROMIUM) as page:
            self.opened(page, "grid")
            self.assertEqual(page.text("note"), "Varus is determined by this motion.")  # of the two-sided one
            page.set("set", "degree_4_recontacted", "change")
            page.set("flexion-number", 200)
            self.assertRegex(page.text("note"), "Flexion 200.0° .* 0.0 to 90.0°: .* 90.0°")
            page.set("flexion-number", 40)
            page.set("varus-number", -50)
            self.assertRegex(page.text("note"), "Varus −50.0° .* −6.0 to 6.0°: .* −6.0°")
            page.set("varus-number", 1)
            self.assertEqual(page.text("note"), "")
            self.opened(page, "free")
            page.set("set", "raw", "change")
            self.assertIn("Varus was free", page.text("note"))
            self.assertTrue(page.browser.value("document.getElementById('varus').disabled"))
            self.is_quiet(page)

    def test_says_where_no_attitude_is_solved(self):
        hole = next(p for p in self.poses["holes"]["raw"] if not p["is_solved"] and not p["is_flexion_clamped"] and not p["is_varus_clamped"])
        with Page(CHROMIUM) as page:
            self.opened(page, "holes")
            page.set("set", "raw", "change")
            page.set("flexion", hole["flexion"])
            page.set("varus", hole["varus"])
            self.assertRegex(page.text("doubt"), r"^no pose at [0-9.]+ degrees: .* only the tibia is drawn$")
            self.assertIn("have no pose", page.text("warnings"))
            self.assertIn(False, [span["hasPose"] for span in page.browser.value("window.vrda.spans()")])
            self.assertEqual({name: body["visible"] for name, body in page.browser.value("window.vrda.drawn()").items()}, {"reference": False, "moving": True, "patella": False})
            self.assertIn("iteration limit", page.text("maps"))
            self.whole(page, "holes")
            self.is_quiet(page)

    def test_doubts_of_a_follower_are_said_where_the_joint_has_none(self):
        def doubt(file):
            file["plausibility"][...] = 0
            file["plausibility"][2, :] = 4  # flexion 20 degrees
            file["followers/patella/plausibility"][...] = 0
            file["followers/patella/plausibility"][2:4, :] = 3

        with Page(CHROMIUM) as page:
            self.assertEqual(page.open(f"file://{PAGE}", changed(self.models["grid"], self.root / "doubt.h5", doubt)), "")
            page.set("set", "raw", "change")
            for flexion, wanted in ((10, "$"), (20, "border contact: "), (30, "patella: dislocated: "), (35, "patella: dislocated: "), (40, "$")):
                page.set("flexion", flexion)
                self.assertRegex(page.text("doubt"), f"^{wanted}", flexion)
            self.assertIn("patella: 10 of 50 poses: dislocated", page.text("warnings"))

    def test_a_solid_is_cut_in_a_filled_area_and_an_open_sheet_in_a_line(self):
        def opened_up(file):
            for path in (f"bodies/reference/{part}{name}" for part in ("", "visual/") for name in ("triangles", "component")):
                values = file[path][()]
                del file[path]
                file[path] = values[numpy.arange(len(values)) % 10 != 0]

        bone = numpy.array([0.839, 0.745, 0.591])
        area, line = (255 * (1.055 * (brightness * bone) ** (1 / 2.4) - 0.055) for brightness in (0.8, 0.24))
        with Page(CHROMIUM) as page:
            for model, wanted in ((self.models["grid"], (0.05, 0)), (changed(self.models["grid"], self.root / "sheet.h5", opened_up), (0, 0.002))):
                self.assertEqual(page.open(f"file://{PAGE}", model), "")
                ids = page.browser.value("window.vrda.structures().map(({ id }) => id)")
                state = {**page.browser.value("window.vrda.state()"), "fixed": "reference", "view": "lateral", "section": {"plane": "sagittal", "at_mm": 10},
                         "structures": {one: {"visible": False} for one in ids if one != "bodies/reference/femur" and not one.startswith("layers/")}}
                page.browser.value(f"window.vrda.useState({json.dumps(state)})")
                page.settle()
                picture = self.picture(page, "#joint", f"section-{model.stem}")
                found = [(numpy.abs(picture - colour).max(axis=2) < 1.5).mean() for colour in (area, line)]
                for part, least in zip(found, wanted, strict=True):
                    self.assertGreaterEqual(part, least)
                    self.assertLess(part, 5e-4 if least == 0 else 1)  # shades of the surface
            # The line is cut again when the plane or the pose changes, not in every frame.
            page.browser.value("""for (const real of [WebGL2RenderingContext.prototype.bufferData])
              WebGL2RenderingContext.prototype.bufferData = function (...given) { ++window.uploads; return real.apply(this, given); }""")
            for at_mm, is_cut in ((10, False), (11, True)):
                state["section"]["at_mm"] = at_mm
                page.browser.value(f"window.uploads = 0; window.vrda.useState({json.dumps({**state, 'view': 'medial'})})")
                page.settle()
                self.assertEqual(page.browser.value("window.uploads > 0"), is_cut)
            Page.current = None
            self.is_quiet(page)

    def test_the_named_body_does_not_move(self):
        with Page(CHROMIUM) as page:
            self.opened(page, "left")
            for held, still in (("moving", ["moving"]), ("reference", ["reference"]), ("push", [])):
                page.set("held", held, "change")
                drawn = []
                for flexion in (3, 27.7, 61):
                    page.set("flexion", flexion)
                    drawn.append(page.browser.value("window.vrda.drawn()"))
                self.assertEqual([name for name in ("reference", "moving") if all(d[name] == drawn[0][name] for d in drawn)], still)
            self.is_quiet(page)

    def test_joint_slider_and_play_are_visible_together_on_a_phone(self):
        for width, height in ((390, 844), (844, 390)):
            with self.subTest(width=width, height=height), Page(CHROMIUM) as page:
                self.opened(page, "left", width=width, height=height, is_phone=True)
                # Warnings of a scanned knee are not before the picture.
                page.browser.value("""(() => { const list = document.getElementById("warnings"); list.hidden = false;
                    list.replaceChildren(...Array.from({ length: 5 }, () => Object.assign(document.createElement("li"), { textContent: "needles, at some place in the axes of the file" }))); })()""")
                for is_full in (False, True):
                    if is_full:
                        page.browser.value("document.getElementById('full').click()")
                        page.settle()
                    boxes = page.browser.value("""Object.fromEntries(["joint", "flexion", "play", "full"].map((id) => {
                        const box = document.getElementById(id).getBoundingClientRect();
                        return [id, [box.left, box.top, box.right, box.bottom]]; }))""")
                    for name, (left, top, right, bottom) in boxes.items():
                        self.assertGreaterEqual(left, 0, name)
                        self.assertGreaterEqual(top, 0, name)
                        self.assertLessEqual(right, width, name)
                        self.assertLessEqual(bottom, height, name)
                    self.assertGreater(boxes["flexion"][2] - boxes["flexion"][0], 0.35 * width)
                    # On top, and large enough for a finger.
                    for name in ("flexion", "play", "full"):
                        left, top, right, bottom = boxes[name]
                        self.assertGreaterEqual(bottom - top, 30, name)
                        found = page.browser.value(f"document.elementFromPoint({(left + right) / 2}, {(top + bottom) / 2}).id")
                        self.assertEqual(found, name)
                    # The joint's bone is on the screenshot of the visible part, above the controls.
                    png = base64.b64decode(page.browser.call("Page.captureScreenshot", format="png")["data"])
                    if KEPT:
                        (KEPT / f"phone-{width}-{'full' if is_full else 'page'}.png").write_bytes(png)
                    pixels = numpy.asarray(Image.open(io.BytesIO(png)).convert("RGB")).astype(int)
                    scale = pixels.shape[1] / width
                    picture = pixels[int(scale * boxes["joint"][1]) : int(scale * boxes["play"][1])]
                    bone = (picture[..., 0] > picture[..., 1]) & (picture[..., 1] > picture[..., 2]) & (picture[..., 0] - picture[..., 2] > 15)
                    self.assertGreater(bone.mean(), 0.04 if width > height else 0.1)
                    if is_full:
                        self.assertGreaterEqual(boxes["joint"][3] - boxes["joint"][1], height - 1)
                self.is_quiet(page)

    def test_the_page_says_that_webgl_is_missing(self):
        with Page(CHROMIUM) as page:
            page.run_first("""
                const real = HTMLCanvasElement.prototype.getContext;
                HTMLCanvasElement.prototype.getContext = function (kind, ...rest) { return kind.startsWith("webgl") ? null : real.call(this, kind, ...rest); };""")
            self.opened(page, "grid")
            self.assertFalse(page.browser.value("document.getElementById('no-webgl').hidden"))
            self.assertIn("no WebGL", page.text("no-webgl"))
            page.set("flexion", 40)
            self.assertIn("flexion 40.0°", page.text("shown"))
            self.is_quiet(page)
        with Page(CHROMIUM) as page:
            self.opened(page, "grid")
            self.assertTrue(page.browser.value("document.getElementById('no-webgl').hidden"))

    def key(self, page, key):
        page.browser.call("Input.dispatchKeyEvent", type="keyDown", key=key)
        page.browser.call("Input.dispatchKeyEvent", type="keyUp", key=key)
        page.settle()

    def test_keys_are_those_of_the_window(self):
        with Page(CHROMIUM) as page:
            self.opened(page, "grid")
            self.key(page, "End")
            self.assertEqual(page.shown()["flexion"], 0)  # the page scrolls, since the pointer is elsewhere
            page.browser.value("document.getElementById('joint').focus()")
            for key, flexion in (("End", 90), ("ArrowLeft", 89), ("PageDown", 79), ("Home", 0), ("ArrowRight", 1)):
                self.key(page, key)
                self.assertAlmostEqual(page.shown()["flexion"], flexion)
            for key, name in (("i", "ligaments"), ("e", "paths"), ("g", "gaps"), ("d", "named")):
                before = page.browser.value(f"document.getElementById('{name}').checked")
                self.key(page, key)
                self.assertEqual(page.browser.value(f"document.getElementById('{name}').checked"), not before, name)
            first = page.shown()["set"]
            self.key(page, "s")
            self.assertNotEqual(page.shown()["set"], first)
            self.key(page, "h")
            self.assertIn("Left drag", page.text("help"))
            self.is_quiet(page)

    def test_help_moves_nothing_and_escape_closes_it_first(self):
        with Page(CHROMIUM) as page:
            self.opened(page, "grid", **SIZE)
            tops = "['curve', 'maps', 'plateau'].map((id) => document.getElementById(id).getBoundingClientRect().top + scrollY)"
            before, help_open, full = page.browser.value(tops), "document.getElementById('help').open", "document.getElementById('picture').classList.contains('full')"
            self.whole(page, "help-before")
            self.key(page, "h")
            self.assertTrue(page.browser.value(help_open))
            self.assertEqual(page.browser.value(tops), before)
            self.assertIn("leaves full screen", page.text("help"))
            self.whole(page, "help")
            page.browser.value("document.querySelector('#help summary').focus()")
            self.key(page, "Escape")
            self.assertFalse(page.browser.value(help_open))
            page.browser.value("document.activeElement.blur(); document.getElementById('picture').classList.add('full')")
            self.key(page, "h")
            box = page.browser.value("(() => { const r = document.getElementById('help-lines').getBoundingClientRect(); const e = document.elementFromPoint(r.x + 9, r.y + 9); return e.closest('#help') !== null; })()")
            self.assertTrue(box, "the help is over the full picture")
            for wanted in ((False, True), (False, False), (False, False)):
                self.key(page, "Escape")
                self.assertEqual((page.browser.value(help_open), page.browser.value(full)), wanted)
            self.is_quiet(page)

    def test_zoom_stops_at_the_surface(self):
        with Page(CHROMIUM) as page:
            self.opened(page, "grid")
            page.browser.value("document.getElementById('joint').scrollIntoView({ block: 'center', behavior: 'instant' })")
            x, y = page.browser.value("(() => { const r = document.getElementById('joint').getBoundingClientRect(); return [r.x + r.width / 2, r.y + r.height / 2]; })()")
            before = page.browser.value("window.vrda.seen()")
            self.picture(page, ".picture", "zoom-before")
            for delta, n in ((-400, 25), (400, 2)):
                for _ in range(n):
                    page.browser.call("Input.dispatchMouseEvent", type="mouseWheel", x=x, y=y, deltaX=0, deltaY=delta)
                page.settle()
                self.picture(page, ".picture", f"zoom-{delta}")
                seen = page.browser.value("window.vrda.seen()")
                if delta < 0:
                    nearest = seen
                    self.assertTrue(9.9 < nearest < 0.2 * before, (nearest, before))
            self.assertGreater(seen, 1.2 * nearest)
            self.is_quiet(page)

    def test_a_lost_context_is_said_and_the_joint_is_drawn_again(self):
        with Page(CHROMIUM) as page:
            self.opened(page, "grid")
            before = self.picture(page, ".picture", "context-before")
            message = "document.getElementById('context-lost')"
            self.assertTrue(page.browser.value(f"{message}.hidden"))
            page.browser.value("window.lost = document.getElementById('joint').getContext('webgl2').getExtension('WEBGL_lose_context'); window.lost.loseContext()")
            page.browser.wait(f"!{message}.hidden")
            self.assertIn("lost its WebGL context", page.text("context-lost"))
            page.set("flexion", 40)  # the page stays usable
            self.assertIn("flexion 40.0°", page.text("shown"))
            page.set("flexion", 0)
            lost = self.picture(page, ".picture", "context-lost")
            self.assertGreater((numpy.abs(lost - before).sum(axis=2) > 30).mean(), 0.05)
            page.browser.value("window.lost.restoreContext()")
            page.browser.wait(f"{message}.hidden")
            page.settle()
            numpy.testing.assert_array_equal(self.picture(page, ".picture", "context-restored"), before)
            self.is_quiet(page)

    def test_words_and_labels(self):
        with Page(CHROMIUM) as page:
            self.opened(page, "grid", **SIZE)
            self.assertRegex(page.text("shown"), "(internal|external) rotation [0-9.]+°, (anterior|posterior) [0-9.]+ mm")
            self.assertNotIn("_", page.text("shown") + page.text("set") + page.text("held"))
            self.assertIn("femur", page.text("held"))
            self.assertFalse(page.browser.value("document.getElementById('paths').checked"))
            self.assertTrue(page.browser.value("document.getElementById('ligaments').checked"))
            self.assertTrue(page.browser.value("document.getElementById('labels').hidden"))
            page.browser.value("document.getElementById('named').click()")
            page.settle()
            names = {"femur": "bodies/reference/femur", "tibia": "bodies/moving/tibia", "patella": "followers/patella/body/patella"}
            unseen = {"bodies/reference/femur": {"visible": False}, "bodies/moving/tibia": {"visible": False}}
            for view, structures, wanted, absent in (("oblique", {}, {"femur", "tibia", "patella", "LCL", "medial", "lateral"}, set()), ("medial", {}, {"femur", "tibia", "MCL"}, {"ACL", "PCL", "medial", "lateral"}),
                                                     ("medial", unseen, {"ACL", "PCL", "MCL"}, {"femur", "tibia"})):
                state = {**page.browser.value("window.vrda.state()"), "view": view, "structures": structures}
                page.browser.value(f"window.vrda.useState({json.dumps(state)})")
                page.settle()
                # Box of each label, and where its line ends: on what it names, which is not behind bone.
                shown = page.browser.value("""[...document.querySelectorAll("#labels span")].flatMap((e, k) => {
                    const box = e.getBoundingClientRect(), end = document.querySelector(`#labels [data-of="${k}"] circle`), at = end && [end.cx.baseVal.value, end.cy.baseVal.value];
                    return e.style.visibility === "visible" ? [[e.textContent, box.left, box.top, box.right, box.bottom, at, at && window.vrda.pick(...at)]] : []; })""")
                texts = {text for text, *_ in shown}
                self.assertLessEqual(wanted, texts)
                self.assertFalse(absent & texts, view)
                for k, (text, left, top, right, bottom, _, on) in enumerate(shown):
                    self.assertTrue(text in ("medial", "lateral") or (on or "").startswith(names.get(text, f"ligaments/{text}")), (view, text, on))
                    for _, other_left, other_top, other_right, other_bottom, *_ in shown[:k]:
                        self.assertTrue(right <= other_left or left >= other_right or bottom <= other_top or top >= other_bottom)
                if view == "oblique":
                    places = {text: left for text, left, *_ in shown}
                    self.assertLess(abs(places["LCL"] - places["lateral"]), abs(places["LCL"] - places["medial"]))
            # The oblique view is from the lateral side, which the section removes.
            page.browser.value(f"window.vrda.useState({json.dumps({**state, 'view': 'oblique', 'structures': {}, 'section': {'plane': 'sagittal', 'at_mm': 0}})})")
            page.settle()
            sides = "[...document.querySelectorAll('#labels span')].filter((e) => e.style.visibility === 'visible').map((e) => e.textContent)"
            self.assertEqual({"medial", "lateral"} & set(page.browser.value(sides)), {"medial"})
            self.whole(page, "page-labels")
            self.is_quiet(page)

    def test_two_motions_are_compared(self):
        with Page(CHROMIUM) as page:
            self.opened(page, "free")
            other = page.browser.value("window.vrda.curve()")
            self.opened(page, "uncertain")
            own, motion = page.browser.value("window.vrda.curve()"), page.shown()["set"]

            def differences(name):
                page.browser.wait(f"window.vrda.differences('{name}') !== null")
                return page.browser.value(f"window.vrda.differences('{name}')")

            def halves(name):
                picture = self.picture(page, "#joint", name)[60:-70]  # without the texts and the slider
                half = picture.shape[1] // 2
                return picture[:, :half], picture[:, half : 2 * half]

            # The same motion: nothing differs, and both sides show the same.
            page.set("compare", motion, "change")
            page.settle()
            for name in ("rotation", "translation", "bundles"):
                for line in differences(name):
                    self.assertEqual({abs(y) for y in line["y"] if y is not None}, {0}, name)
            first, second = halves("compare-same")
            self.assertGreater(first.std(), LEAST_SHADING)
            self.assertLess((numpy.abs(first - second).sum(axis=2) > 60).mean(), 0.01)
            # Names and contact paths are those of both.
            names = ["[...document.querySelectorAll('#%s span')].filter((one) => one.style.visibility === 'visible').map((one) => one.textContent).sort()" % of
                     for of in ("labels", "labels-other")]
            for of_both in ("named", "paths"):
                page.browser.value(f"document.getElementById('{of_both}').click()")
            page.settle()
            self.assertGreater(len(page.browser.value(names[0])), 2)
            self.assertEqual(*map(page.browser.value, names))

            def press(*ids):
                for of in ids:
                    page.browser.value(f"document.{of}.click()")
                page.settle()
                return halves("compare-paths")[1]

            named, paths, femur = "getElementById('named')", "getElementById('paths')", "querySelector('[aria-label=\"Show: Femur\"]')"
            with_paths, without = press(named, femur), press(paths)
            self.assertGreater((numpy.abs(with_paths - without).sum(axis=2) > 60).mean(), LEAST_LAYER / 10)
            press(femur)
            # Without a ligament on the right.
            page.set("compare-without", "ligaments/LCL", "change")
            page.settle()
            left, right = halves("compare-without")
            numpy.testing.assert_array_equal(left, first)
            self.assertGreater((numpy.abs(right - second).sum(axis=2) > 60).mean(), LEAST_LAYER)
            self.assertIn("LCL not drawn", page.text("shown-other"))
            # Another model, over the first.
            page.set("compare-as", "over", "change")
            page.browser.give("#other", self.models["free"])
            page.browser.wait("document.getElementById('shown-other').textContent.includes('free.h5')")
            page.set("flexion", 60)
            page.settle()
            self.assertIn("translucent: free.h5: flexion 60.0°", page.text("shown-other"))
            over = self.picture(page, "#joint", "compare-over")[60:-70]
            line = differences("rotation")[0]
            for f in (0, 30, 60, 90):
                k, k_own, k_other = line["x"].index(f), own["x"].index(f), other["x"].index(f)
                self.assertAlmostEqual(line["y"][k], other["curves"][0][k_other] - own["curves"][0][k_own], delta=RAD)
                self.assertAlmostEqual(line["band"]["low"][k], -abs(own["band"]["low"][k_own] - own["curves"][0][k_own]), delta=RAD)
                self.assertAlmostEqual(line["band"]["high"][k], abs(own["band"]["high"][k_own] - own["curves"][0][k_own]), delta=RAD)
            page.set("compare", "", "change")
            page.settle()
            self.assertGreater((numpy.abs(self.picture(page, "#joint", "compare-nothing")[60:-70] - over).sum(axis=2) > 20).mean(), LEAST_LAYER)
            self.assertTrue(page.browser.value("document.getElementById('differences').hidden"))
            self.is_quiet(page)

    def test_as_wide_as_a_phone(self):
        with Page(CHROMIUM) as page:
            self.opened(page, "left", width=390, height=844, is_phone=True, scale=2)
            self.assertLessEqual(page.browser.value("document.documentElement.scrollWidth"), 390)
            # Pictures have the pixels of the screen.
            for name in ("joint", "plateau"):
                drawn, shown = page.browser.value(f"((e) => [e.width, e.clientWidth])(document.getElementById('{name}'))")
                self.assertLessEqual(abs(drawn - 2 * shown), 2, name)
            # Names keep off the bar of controls, which is higher than on a wide screen, at any zoom.
            page.browser.value("document.getElementById('named').click()")
            page.settle()
            for _ in range(8):
                page.browser.value("document.getElementById('joint').dispatchEvent(new WheelEvent('wheel', { deltaY: -200, clientX: 195, clientY: 150, cancelable: true }))")
                page.settle()
                bar, *bottoms = page.browser.value("""[document.querySelector(".transport").getBoundingClientRect().top, ...[...document.querySelectorAll("#labels span")]
                    .filter((e) => e.style.visibility === "visible").map((e) => e.getBoundingClientRect().bottom)]""")
                self.assertLessEqual(max(bottoms), bar)
            self.whole(page, "phone")
            self.is_quiet(page)

    def test_of_two_files_the_last_requested_is_shown(self):
        with Page(CHROMIUM) as page:
            page.visit(f"file://{PAGE}")
            # The first file is delayed until the second is shown, like a large file on a slow disk.
            page.browser.value("""(() => {
                const read = File.prototype.arrayBuffer;
                const isFirst = { value: true };
                File.prototype.arrayBuffer = function () {
                    if (!isFirst.value) return read.call(this);
                    isFirst.value = false;
                    return new Promise((go) => { window.goOn = () => go(read.call(this)); });
                };
            })()""")
            page.browser.give("#file", self.models["left"])
            self.assertEqual(page.give(self.models["grid"]), "")
            facts = page.text("facts")
            self.assertTrue(facts.startswith(self.models["grid"].name), facts)
            page.browser.value("window.goOn()")
            page.settle()
            self.assertEqual(page.text("facts"), facts)

    def test_bad_files_leave_the_page_usable(self):
        with Page(CHROMIUM) as page:
            self.opened(page, "grid")
            for path, wanted in bad_files(self.models["grid"], self.root):
                with self.subTest(path.name):
                    message = page.give(path)
                    if wanted:
                        self.assertIn(wanted, message)
                        self.assertTrue(message.startswith(path.name), message)
                    self.assertTrue(page.browser.value("window.vrda.pose('raw', 30, 0).isSolved"))
            self.assertEqual(page.give(self.models["grid"]), "")
            # The console may contain only the messages of HDF5.
            self.assertEqual([word for word in page.browser.said if not HDF5_MESSAGES.match(word)], [])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
