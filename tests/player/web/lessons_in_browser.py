#!/usr/bin/python3
"""Structures, the state of the view and lessons on the player's page, in headless Chromium, from disk and without a network.

usage: lessons_in_browser.py PAGE CHROMIUM PACKAGES [PICTURES]
PAGE has the sample inside; the lessons that ship are in lessons/ beside it. PACKAGES: the npm packages, for axe-core.
"""
import base64
import gzip
import io
import json
import pathlib
import re
import sys
import tempfile
import unittest
import urllib.parse

import h5py
import numpy
from PIL import Image

from web_scenes import Page, SAMPLE

PAGE, CHROMIUM, PACKAGES = sys.argv[1:4]
KEPT = pathlib.Path(sys.argv[4]) if len(sys.argv) > 4 else None
LESSONS = sorted((pathlib.Path(PAGE).parent / "lessons").glob("*.html"))
FINGER_PX = 44
SIZE = {"width": 1440, "height": 900} if KEPT else {}
DEADLINE_S = 400  # of a browser; measured: 40 s, and 120 s beside ten compilers
# Of 255: rounding of two colours and of their sum.
BLENDED = 2
INTERACTIVE = "button, input:not([type=file]), select, textarea, summary, canvas[tabindex]"
VISIBLE = f"[...document.querySelectorAll('{INTERACTIVE}')].filter((e) => !e.disabled && e.checkVisibility({{ visibilityProperty: true }}) && e.getClientRects().length > 0)"
FEMUR, LCL, ACL = "bodies/reference/femur", "ligaments/LCL", "ligaments/ACLam"


def inside(page):
    """The motion model inside a page, as an open h5py file."""
    text = re.search(r'id="model-inside"[^>]*>([^<]*)<', pathlib.Path(page).read_text())[1]
    return h5py.File(io.BytesIO(gzip.decompress(base64.b64decode(text))))


class Lessons(unittest.TestCase):
    def opened(self, page, address=f"file://{PAGE}", **how):
        page.browser.call("Network.emulateNetworkConditions", offline=True, latency=0, downloadThroughput=0, uploadThroughput=0)
        is_sample = "/lessons/" not in address and "saved" not in address
        page.open(address, SAMPLE if is_sample else None, **{**SIZE, **how})

    def is_quiet(self, page):
        self.assertEqual(page.browser.said, [])
        self.assertEqual([a for a in page.browser.requests if not a.startswith(("file:", "data:", "blob:", "about:"))], [])

    def picture(self, page, name=""):
        png = page.browser.element("document.getElementById('joint')")
        if KEPT and name:
            KEPT.mkdir(parents=True, exist_ok=True)
            (KEPT / f"{name}.png").write_bytes(png)
        return numpy.asarray(Image.open(io.BytesIO(png)).convert("RGB")).astype(int)

    def state(self, page, **change):
        """Shows the present state with changes; returns it."""
        state = {**page.browser.value("window.vrda.state()"), **change}
        page.browser.value(f"window.vrda.useState({json.dumps({key: value for key, value in state.items() if value is not None})})")
        page.settle()
        return page.browser.value("window.vrda.state()")

    def structures(self, page):
        return [one["id"] for one in page.browser.value("window.vrda.structures()")]

    def only(self, page, *shown, **looks):
        """Looks with only these structures and layers hidden."""
        return {**{one: {"visible": False} for one in self.structures(page) if one not in shown and not one.startswith("layers/")}, **looks}

    def click(self, page, x, y):
        left, top = page.browser.value("(() => { const r = document.getElementById('joint').getBoundingClientRect(); return [r.left, r.top]; })()")
        for kind in ("mousePressed", "mouseReleased"):
            page.browser.call("Input.dispatchMouseEvent", type=kind, x=left + x, y=top + y, button="left", buttons=1, clickCount=1)
        page.settle()

    def pixel_of(self, page, structure, shown):
        """A pixel in the middle of the structure, where nothing is in front of it: from pictures of it alone, and of `shown`."""
        looks = page.browser.value("window.vrda.state()").get("structures", {})
        self.state(page, structures=self.only(page), highlighted=None)
        nothing = self.picture(page)
        self.state(page, structures=self.only(page, structure))
        alone = self.picture(page)
        self.state(page, structures=shown)
        seen = (numpy.abs(alone - nothing).sum(axis=2) > 60) & (numpy.abs(alone - self.picture(page)).sum(axis=2) < 6)
        for _ in range(14 if seen.sum() > 4000 else 3 if seen.sum() > 400 else 1):  # away from its outline, and thin ones beside it
            inner = seen.copy()
            for axis in (0, 1):
                inner &= numpy.roll(seen, 1, axis) & numpy.roll(seen, -1, axis)
            seen = inner if inner.any() else seen
        self.assertTrue(seen.any(), structure)
        self.state(page, structures=looks)
        rows, columns = numpy.nonzero(seen)
        k = numpy.hypot(rows - rows.mean(), columns - columns.mean()).argmin()
        return float(columns[k]), float(rows[k])

    def test_a_touched_structure_is_the_one_drawn_there(self):
        with Page(CHROMIUM, DEADLINE_S) as page:
            self.opened(page)
            names = {one["id"]: one["name"] for one in page.browser.value("window.vrda.structures()")}
            for view, structure in (("lateral", FEMUR), ("front", "bodies/moving/tibia"), ("front", "followers/patella/body/patella"), ("front", "bodies/moving/meniscus_medial"),
                                    ("lateral", LCL), ("medial", "ligaments/MCLs"), ("front", "followers/patella/ligaments/PT")):
                with self.subTest(structure):
                    self.state(page, view=view, structures={}, highlighted=None)
                    self.click(page, *self.pixel_of(page, structure, {}))
                    self.assertEqual(page.browser.value("window.vrda.state().highlighted"), structure)
                    self.assertEqual(page.text("card-name"), names[structure])
            # Through a faded bone, to what is opaque behind it.
            faded = {FEMUR: {"opacity": 0.2}, "bodies/moving/tibia": {"opacity": 0.2}}
            self.state(page, view="medial", flexion=90, structures=self.only(page, ACL, **faded), highlighted=None)
            self.click(page, *self.pixel_of(page, ACL, self.only(page, ACL)))
            self.assertEqual(page.browser.value("window.vrda.state().highlighted"), ACL)
            # Beside the joint: nothing.
            self.click(page, 5, 300)
            self.assertNotIn("highlighted", page.browser.value("window.vrda.state()"))
            self.is_quiet(page)

    def test_the_card_has_the_strains_of_the_file(self):
        with inside(PAGE) as model, Page(CHROMIUM, DEADLINE_S) as page:
            own = model["/ligaments/bundle"].asstr()[()] == "LCL"
            strains, tension = (model[f"/ligaments/{name}"][:, 0, own] for name in ("strain", "tension"))
            flexion = model["/flexion"][()].tolist()
            self.opened(page)
            for at in (30, 80):
                k = flexion.index(at)
                self.state(page, set="raw", flexion=at, highlighted=LCL)
                strain, force = 100 * strains[k].max(), tension[k].sum()
                now = f"Strain {strain:.1f} %, {force:.0f} N" if strain > 0 else f"Slack (−{-strain:.1f} %)"
                best = strains.max(axis=1).argmax()
                self.assertEqual(page.text("card-strain"), f"{now} at {at}°. Tightest at {flexion[best]:.0f}°: {100 * strains[best].max():.1f} %.")
            self.is_quiet(page)

    def test_parts_of_a_translucent_structure_do_not_show_through_each_other(self):
        with Page(CHROMIUM, DEADLINE_S) as page:
            self.opened(page)
            # Shaft and condyles of the femur overlap; each pixel has its nearest surface only.
            pictures = {}
            for name, looks in (("none", self.only(page)), ("opaque", self.only(page, FEMUR)), ("translucent", self.only(page, FEMUR, **{FEMUR: {"opacity": 0.4}}))):
                self.state(page, structures=looks)
                pictures[name] = self.picture(page, f"translucent-{name}")
            blended = 0.4 * pictures["opaque"] + 0.6 * pictures["none"]
            away = numpy.abs(pictures["translucent"] - blended).max(axis=2)
            self.assertGreater((numpy.abs(pictures["opaque"] - pictures["none"]).sum(axis=2) > 60).mean(), 0.05)
            # Outlines are smoothed before they are blended.
            self.assertLess((away > BLENDED).mean(), 0.005)
            # An opaque structure behind it is seen through it, and one in front hides it.
            self.state(page, view="medial", flexion=90, structures=self.only(page, FEMUR, ACL, **{FEMUR: {"opacity": 0.2}}))
            through = self.picture(page, "translucent-through")
            self.state(page, structures=self.only(page, FEMUR, **{FEMUR: {"opacity": 0.2}}))
            self.assertGreater((numpy.abs(through - self.picture(page)).sum(axis=2) > 60).sum(), 200)
            self.is_quiet(page)

    def test_a_section_is_filled_and_hides_what_is_behind_it(self):
        linear = 0.8 * numpy.array([0.839, 0.745, 0.591])  # of bone
        cap = 255 * (1.055 * linear ** (1 / 2.4) - 0.055)
        with Page(CHROMIUM, DEADLINE_S) as page:
            self.opened(page)
            pictures = []
            for at, shown in ((10, (FEMUR,)), (10, (FEMUR, "ligaments/MCLs")), (-10, (FEMUR,))):
                self.state(page, view="lateral", section={"plane": "sagittal", "at_mm": at}, structures=self.only(page, *shown))
                pictures.append(self.picture(page, f"section-{len(pictures)}"))
            filled = [numpy.abs(one - cap).max(axis=2) < 1.5 for one in pictures]
            for one in filled:
                self.assertGreater(one.mean(), 0.05)
            # The medial ligament is behind the lateral plane's cap; elsewhere it is drawn.
            numpy.testing.assert_array_equal(pictures[0][filled[0]], pictures[1][filled[0]])
            self.assertGreater((filled[0] != filled[2]).mean(), 0.005)
            self.is_quiet(page)

    def test_a_link_reopens_the_state(self):
        with Page(CHROMIUM, DEADLINE_S) as page:
            self.opened(page)
            page.browser.value("document.querySelector('#views [value=lateral]').click()")
            left, top = page.browser.value("(() => { const r = document.getElementById('joint').getBoundingClientRect(); return [r.left, r.top]; })()")
            for kind, x in (("mousePressed", 200), ("mouseMoved", 260), ("mouseReleased", 260)):
                page.browser.call("Input.dispatchMouseEvent", type=kind, x=left + x, y=top + 300, button="left", buttons=1, clickCount=1)
            looks = {FEMUR: {"opacity": 0.3}, LCL: {"visible": False}, "layers/contact_paths": {"visible": True}}
            state = self.state(page, flexion=42.5, set="raw", fixed="reference", labels=True, whole=None, highlighted=ACL,
                               section={"plane": "coronal", "at_mm": -4.5}, structures=looks)
            self.assertEqual([state["structures"], state["flexion"], state["set"], state["fixed"], state["labels"], state["highlighted"]], [looks, 42.5, "raw", "reference", True, ACL])
            self.assertIn("eye_mm", state["view"])
            # Chromium smooths lines of one place in more than one way, so they are compared as text.
            lines = "(() => { const svg = document.querySelector('#labels svg'); svg.style.visibility = 'hidden'; return svg.innerHTML; })()"
            drawn, before = page.browser.value(lines), self.picture(page, "link")
            self.assertIn("path", drawn)
            page.browser.wait("location.hash.includes('42.5')")
            address = page.browser.value("location.href")
            self.assertEqual(json.loads(urllib.parse.parse_qs(urllib.parse.urlsplit(address).fragment)["view"][0]), state)
            page.visit(f"file://{LESSONS[0]}")  # another document, so that the next one is not the same with another fragment
            self.opened(page, address)
            self.assertEqual(page.browser.value("window.vrda.state()"), state)
            self.assertEqual(page.browser.value(lines), drawn)
            numpy.testing.assert_array_equal(self.picture(page, "link-reopened"), before)
            for change, wanted in (({"structures": {"ligaments/ABC": {}}}, 'address.structures: found "ligaments/ABC", wanted a structure of the model'),
                                   ({"structures": {LCL: {"opacity": 0}}}, 'opacity: found 0, wanted a number above 0'), ({"version": 2}, "address.version: found 2, wanted 1"),
                                   ({"set": "degree_9"}, 'address.set: found "degree_9", wanted two_sided'), ({"flexion": "30"}, "address.flexion: found \"30\", wanted degrees"),
                                   ({"view": {"eye_mm": [9, 0, 0], "target_mm": [0, 0, 0], "roll": 361}}, "address.view.roll: found 361, wanted degrees"), ({"view": "above"}, 'address.view: found "above", wanted oblique'), ({"section": {"plane": [1, 1, 0], "at_mm": 0}}, "address.section.plane: found [1,1,0], wanted sagittal, coronal, axial, or a unit vector"), ({"hidden": []}, "address.hidden: found \"this key\", wanted format")):
                page.browser.value("document.getElementById('message').hidden = true")
                page.browser.value(f"location.hash = new URLSearchParams({{ view: {json.dumps(json.dumps({**state, **change}))} }})")
                page.browser.wait("!document.getElementById('message').hidden")
                self.assertIn(wanted, page.text("message"))
                self.assertEqual(page.browser.value("window.vrda.state()"), state)
            self.is_quiet(page)

    def test_a_roll_turns_the_picture(self):
        front = {"eye_mm": [600, 0, 0], "target_mm": [0, 0, 0]}
        with Page(CHROMIUM, DEADLINE_S) as page:
            self.opened(page)
            self.state(page, view="front", fixed="reference", structures=self.only(page, FEMUR))
            upright = self.picture(page)
            # A square about the middle, without the texts.
            seen = {}
            for roll in (None, 0, 90, 180):
                structures = self.only(page) if roll is None else self.only(page, FEMUR)
                state = self.state(page, view={**front, **({"roll": roll} if roll else {})}, structures=structures)
                self.assertEqual(abs(state["view"].get("roll", 0)), roll or 0)
                picture = self.picture(page, f"roll-{roll}")
                rows, columns = (n // 2 for n in picture.shape[:2])
                half = min(rows, columns) - 70
                seen[roll] = picture[rows - half : rows + half, columns - half : columns + half]
            outline = {roll: numpy.abs(seen[roll] - seen[None]).sum(axis=2) > 6 for roll in (0, 90, 180)}
            self.assertGreater(outline[0].mean(), 0.1)
            # The camera turns to its left, hence the picture to the right.
            for roll, turned in ((90, numpy.rot90(outline[0], -1)), (180, numpy.rot90(outline[0], 2))):
                self.assertLess((outline[roll] != turned).mean(), 0.01, roll)
            # A drag along the picture's horizontal turns about its vertical, the canonical Z.
            self.state(page, view={**front, "roll": 90})
            left, top = page.browser.value("(() => { const r = document.getElementById('joint').getBoundingClientRect(); return [r.left, r.top]; })()")
            for kind, x in (("mousePressed", 200), ("mouseMoved", 260), ("mouseReleased", 260)):
                page.browser.call("Input.dispatchMouseEvent", type=kind, x=left + x, y=top + 300, button="left", buttons=1, clickCount=1)
            page.settle()
            place = page.browser.value("window.vrda.state()")["view"]
            self.assertLess(abs(place["eye_mm"][2]), 1e-2)
            self.assertGreater(abs(place["eye_mm"][1]), 50)
            # A view by its name is upright again.
            page.browser.value("document.querySelector('#views [value=front]').click()")
            page.settle()
            numpy.testing.assert_array_equal(self.picture(page), upright)
            self.is_quiet(page)

    def test_lessons_open_without_a_network(self):
        self.assertEqual([lesson.stem for lesson in LESSONS], ["knee-without-acl", "ligaments", "screw-home"])
        for lesson in LESSONS:
            with self.subTest(lesson.stem), Page(CHROMIUM, DEADLINE_S) as page:
                wanted = json.loads(re.search(r'id="lesson-inside">(.*?)</script>', lesson.read_text(), re.DOTALL)[1])
                self.opened(page, f"file://{lesson}")
                self.assertEqual(page.text("message"), "")
                n_questions = 0
                for k, step in enumerate(wanted["steps"]):
                    if k > 0:
                        page.browser.value("document.getElementById('lesson-next').click()")
                        page.settle()
                    shown = page.browser.value("window.vrda.state()")
                    self.assertEqual([page.text("lesson-title"), page.text("lesson-count"), page.text("lesson-text")], [wanted["title"], f"{k + 1} of {len(wanted['steps'])}", step["text"]])
                    self.assertEqual(shown, step["state"])
                    self.assertEqual(page.browser.value("getComputedStyle(document.getElementById('arrow')).visibility") == "visible", "arrow" in step)
                    self.picture(page, f"{lesson.stem}-{k + 1}")
                    if "question" not in step:
                        continue
                    n_questions += 1
                    self.assertEqual(page.text("lesson-ask"), step["question"]["ask"])
                    answers = step["question"]["answers"]
                    visible = [one["id"] for one in page.browser.value("window.vrda.structures()") if one["visible"]]
                    wrong = next(one for one in visible if one not in answers)
                    page.browser.value(f"document.querySelectorAll('#structure-list button')[{self.structures(page).index(wrong)}].click()")
                    self.assertIn(f"no. {step['question']['wrong']}", page.text("lesson-answer"))
                    self.assertTrue(page.browser.value("document.getElementById('card').hidden"))  # it would say the answer
                    shown.pop("highlighted", None)
                    self.click(page, *self.pixel_of(page, answers[0], self.only(page, answers[0]) if answers[0] != LCL else shown["structures"]))
                    self.assertIn(f"right. {step['question']['right']}", page.text("lesson-answer"))
                self.assertGreater(n_questions, 0)
                self.assertTrue(page.browser.value("document.getElementById('lesson-next').disabled"))
                page.browser.value("document.getElementById('lesson-back').click()")
                self.assertEqual(page.text("lesson-count"), f"{len(wanted['steps']) - 1} of {len(wanted['steps'])}")
                self.is_quiet(page)

    def test_a_lesson_that_was_made_and_saved(self):
        with tempfile.TemporaryDirectory(prefix="vrda-lesson-") as folder, Page(CHROMIUM, DEADLINE_S) as page:
            self.opened(page)
            press = lambda name: page.browser.value(f"document.getElementById('{name}').click()")  # noqa: E731
            page.browser.value("document.getElementById('teach').open = true")
            first = self.state(page, view="front", flexion=10)
            press("teach-add")
            page.set("teach-title", "</script> & <b>")
            page.set("teach-text", "One: </script>")
            self.state(page, view="lateral", flexion=60)
            spot = self.pixel_of(page, FEMUR, {})
            second = self.state(page, highlighted=LCL)
            press("teach-add")
            page.set("teach-text", "Two")
            page.set("teach-ask", "Which?")
            press("teach-save")
            self.assertIn("Step 2: found a question without an answer", page.text("message"))
            press("teach-answer")
            page.set("teach-right", "Yes")
            press("teach-arrow")
            page.browser.value("document.getElementById('joint').scrollIntoView({ block: 'center', behavior: 'instant' })")
            self.click(page, *spot)
            page.browser.value("URL.createObjectURL = (blob) => { blob.text().then((text) => { window.saved = text; }); return 'data:,'; }")
            press("teach-save")
            page.browser.wait("window.saved !== undefined")
            path = pathlib.Path(folder) / "saved.html"
            path.write_text(page.browser.value("window.saved"))
            self.opened(page, f"file://{path}#step=2")
            self.assertEqual([page.text("lesson-title"), page.text("lesson-text"), page.text("lesson-ask")], ["</script> & <b>", "Two", "Which?"])
            self.assertEqual(page.browser.value("window.vrda.state()"), second)
            # The arrow's tip is where the picture was touched; of two joints side by side each has one.
            tips = "(of) => of.map((id) => { const e = document.getElementById(id), m = new DOMMatrix(getComputedStyle(e).transform); return [m.e, m.f, getComputedStyle(e).visibility]; })"
            (*tip, _), (*_, seen) = page.browser.value(f"({tips})(['arrow', 'arrow-other'])")
            self.assertLess(numpy.abs(numpy.array(tip) - spot).max(), 1.5)
            self.assertEqual(seen, "hidden")
            page.set("compare", second["set"], "change")
            page.settle()
            (x, y, seen), (x_other, y_other, seen_other) = page.browser.value(f"({tips})(['arrow', 'arrow-other'])")
            self.assertEqual([seen, seen_other], ["visible", "visible"])
            self.picture(page, "arrows-of-two")
            width = page.browser.value("document.getElementById('joint').clientWidth")
            numpy.testing.assert_allclose([x_other - x, y_other - y], [width / 2, 0], rtol=0, atol=1e-3)
            page.set("compare", "", "change")
            page.settle()
            page.browser.value("document.getElementById('lesson-back').click()")
            self.assertEqual(page.text("lesson-text"), "One: </script>")
            self.assertEqual(page.browser.value("window.vrda.state()"), first)
            self.is_quiet(page)

    def test_the_first_plots_are_those_that_most_readers_look_for(self):
        with Page(CHROMIUM, DEADLINE_S) as page:
            self.opened(page)
            captions = page.browser.value("[...document.querySelectorAll('figcaption')].filter((e) => e.checkVisibility()).map((e) => e.textContent)")
            self.assertEqual(captions[:6], ["Internal rotation over flexion", "Varus over flexion", "Anterior translation over flexion", "Contact positions on the moving bone over flexion",
                                            "Strain of each bundle over flexion", "Force of each bundle over flexion"])
            colours = "(id) => getComputedStyle(document.querySelector(id)).color"
            self.assertIn("Varus is determined by this motion.", page.text("note"))
            self.assertEqual(page.browser.value(f"({colours})('#note span')"), page.browser.value(f"({colours})('#facts')"))
            self.assertNotRegex(page.browser.value("document.body.innerText"), "Delta|theta")

    def test_keys_reach_everything(self):
        with Page(CHROMIUM, DEADLINE_S) as page:
            self.opened(page, f"file://{LESSONS[0]}")
            self.state(page, highlighted=LCL)
            page.browser.value("document.getElementById('teach').open = true; document.activeElement.blur()")
            page.browser.value(f"window.all = {VISIBLE}; window.reached = new Set()")
            n = page.browser.value("window.all.length")
            self.assertGreater(n, 60)
            for _ in range(n + 10):
                page.browser.call("Input.dispatchKeyEvent", type="keyDown", key="Tab", code="Tab", windowsVirtualKeyCode=9)
                page.browser.call("Input.dispatchKeyEvent", type="keyUp", key="Tab", code="Tab", windowsVirtualKeyCode=9)
                page.browser.value("window.reached.add(document.activeElement)")
            self.assertEqual(page.browser.value("window.all.filter((e) => !window.reached.has(e)).map((e) => e.outerHTML)"), [])

    def test_fingers_and_axe(self):
        axe = (pathlib.Path(PACKAGES) / "axe-core/axe.min.js").read_text()
        with Page(CHROMIUM, DEADLINE_S) as page:
            page.run_first(axe)
            for address, how in ((f"file://{PAGE}", {}), (f"file://{LESSONS[1]}", {"is_dark": True}), (f"file://{LESSONS[1]}", {"width": 390, "height": 844, "is_phone": True})):
                self.opened(page, address, **how)
                self.state(page, highlighted=ACL)
                page.browser.value("for (const id of ['teach', 'structures']) document.getElementById(id).open = true; document.getElementById('teach-add').click()")
                page.settle()
                found = page.browser.value("axe.run(document).then(({ violations }) => violations.filter((v) => ['serious', 'critical'].includes(v.impact))"
                                           ".map((v) => [v.id, v.nodes.map((n) => n.html + n.failureSummary).join('\\n')]))")
                self.assertEqual(found, [], how)
            self.assertLessEqual(page.browser.value("document.documentElement.scrollWidth"), 390)
            # In the full picture the lesson's text and the controls are on top.
            page.browser.value("document.getElementById('teach').open = false; document.getElementById('full').click()")
            self.state(page, highlighted=None)
            for element in ("lesson-text", "lesson-next", "play", "flexion"):
                self.assertTrue(page.browser.value(f"(() => {{ const e = document.getElementById('{element}'), r = e.getBoundingClientRect(), top = document.elementFromPoint(r.x + r.width / 2, r.y + Math.min(10, r.height / 2)); return e.contains(top); }})()"), element)
            page.browser.value("document.getElementById('full').click(); document.getElementById('teach').open = true")
            page.settle()
            small = page.browser.value(f"{VISIBLE}.map((e) => e.type === 'checkbox' ? e.closest('label') : e).filter((e) => {{ const r = e.getBoundingClientRect(); return r.height < {FINGER_PX} || r.width < {FINGER_PX}; }}).map((e) => e.outerHTML)")
            self.assertEqual(small, [])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
