"""A headset emulated in the browser: IWER with a room of @iwer/sem, a controller that points, touches and presses."""
import json
import pathlib

import numpy

from web_scenes import Page

ROOM = "office_small"
# IWER calls every position a guess; here the tests decide.
START = """(() => {
  const device = window.device = new IWER.XRDevice(IWER.metaQuest3);
  device.stereoEnabled = false;
  device.installRuntime({ forceInstall: true });
  device.installSEM(IWER_SEM.SyntheticEnvironmentModule);
  device.sem.loadEnvironment(%s);
  window.isGuess = false;
  Object.defineProperty(IWER.XRPose.prototype, "emulatedPosition", { get: () => window.isGuess });
})();"""


def rotation_to(direction):
    """The quaternion (x, y, z, w) that turns -Z to a direction."""
    d = numpy.asarray(direction) / numpy.linalg.norm(direction)
    axis = numpy.cross((0, 0, -1), d)
    q = numpy.array([*axis, 1 - d[2]])
    return q / numpy.linalg.norm(q)


def quaternion_of(R):
    """(x, y, z, w) of a rotation matrix."""
    values, vectors = numpy.linalg.eigh(numpy.array([
        [R[0, 0] - R[1, 1] - R[2, 2], R[0, 1] + R[1, 0], R[0, 2] + R[2, 0], R[2, 1] - R[1, 2]],
        [R[0, 1] + R[1, 0], R[1, 1] - R[0, 0] - R[2, 2], R[1, 2] + R[2, 1], R[0, 2] - R[2, 0]],
        [R[0, 2] + R[2, 0], R[1, 2] + R[2, 1], R[2, 2] - R[0, 0] - R[1, 1], R[1, 0] - R[0, 1]],
        [R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1], R.trace()]]))
    return vectors[:, values.argmax()]


class Headset(Page):
    """The page in a browser with a headset. Use it in a `with`."""

    def __init__(self, chromium, packages):
        # Hundreds of frames without a graphics card.
        super().__init__(chromium, deadline_s=400)
        packages = pathlib.Path(packages)
        if not (packages / "iwer").is_dir():
            raise FileNotFoundError(f"{packages}: found no iwer, wanted the npm packages of the tests; run scripts/setup")
        code = [(packages / name).read_text() for name in ("iwer/build/iwer.min.js", "@iwer/sem/build/iwer-sem.min.js")]
        room = (packages / f"@iwer/sem/captures/{ROOM}.json").read_text()
        self.run_first("\n;".join([*code, START % room]))

    def start(self, mode):
        self.browser.wait("document.querySelector('#xr-buttons button') !== null")
        self.browser.value(f"document.querySelector('#xr-buttons [value={mode}]').click()")
        self.browser.wait("window.vrda.xr.state().isPresenting || !document.getElementById('message').hidden")
        self.frames()

    def hide_joint(self):
        """Frames in which nothing but the panel is drawn take a tenth of the time."""
        self.browser.value("for (const box of document.querySelectorAll('#structure-list input[type=checkbox]:checked')) box.click()")

    def state(self):
        return self.browser.value("window.vrda.xr.state()")

    def frames(self, n=0):
        """Waits for a frame of the session, which has all that was set before, and n more; without a session, of the window.

        A frame that ends the session drops what waits for the next."""
        self.browser.value(f"""new Promise((done) => {{ let n = {n}; const session = window.device.activeSession ?? window;
            session.addEventListener("end", () => done(), {{ once: true }});
            const next = () => (n-- > 0 ? session.requestAnimationFrame(next) : done()); session.requestAnimationFrame(next); }})""")

    def hold(self, position, quaternion=None, hand="right"):
        """Puts a controller somewhere, in metres."""
        x, y, z = position
        turn = "" if quaternion is None else "c.quaternion.set({}, {}, {}, {});".format(*quaternion)
        self.browser.value(f"(() => {{ const c = window.device.controllers.{hand}; c.position.set({x}, {y}, {z}); {turn} }})()")
        self.frames()

    def trigger(self, is_down, hand="right"):
        self.browser.value(f"window.device.controllers.{hand}.updateButtonValue('trigger', {int(is_down)})")
        self.frames()

    def press(self):
        self.trigger(True)
        self.trigger(False)

    def aim(self, point, origin=(0.15, 1.3, 0.1)):
        """Points the controller at a place in the room."""
        self.hold(origin, rotation_to(numpy.subtract(point, origin)))

    def aim_at_panel(self, target):
        self.aim(self.browser.value(f"window.vrda.xr.point({json.dumps(target)})"))

    def use(self, button):
        self.aim_at_panel(button)
        self.press()

    def touch(self, point_mm):
        """Touches a point from below: the ray meets no panel."""
        self.hold(numpy.asarray(point_mm) / 1000, rotation_to((0, 1, 1e-3)))
        self.press()
