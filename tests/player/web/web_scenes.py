"""Models of a small generic knee, invalid files, and the page in a browser."""
import atexit
import pathlib
import shutil
import subprocess
import sys

import h5py
import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "scripts"))
from browser import Browser  # noqa: E402

GRID = ["--set", "grid.flexion.step=10", "--set", "grid.varus={from=-6,to=6,step=3}"]
ONCE = ["--set", "solver.equilibrium.restarts=0"]  # half of the time
SMALL = [*GRID, *ONCE]
MODELS = {
    "grid": [*SMALL, "--set", "smooth.degrees=[2,4]"],
    "free": [*ONCE, "--set", "grid.flexion.step=10", "--set", "grid.varus=free", "--set", "smooth.degrees=[2,4]"],
    "left": [*SMALL, "--set", "smooth.degrees=[4]", "--set", "side=left"],
    # Delta differs over flexion.
    "turning": [*SMALL, "--set", "smooth.degrees=[3]", "--set", "side=left",
                "--set", "push.lateral_force_n={flexion_deg=[0,90],value=[[0,0],[6,-4]]}"],
    # Samples of an uncertain job, at quantiles; with a prior.
    "uncertain": [*ONCE, "--set", "grid.flexion.step=30", "--set", "grid.varus=free", "--set", "smooth.degrees=[2]", "--set", "uncertainty.samples=10",
                  "--set", 'uncertainty.parameter=[{quantity="reference_strain",distribution="normal",sd=0.05}]',
                  "--set", 'prior=[{coordinate="internal",shape="walker-1988",stiffness=1000}]'],
    # So few steps that several attitudes do not converge.
    "holes": [*GRID, "--set", "smooth.degrees=[1]", "--set", "solver.method=stability-search", "--set", "solver.search.max_steps=12",
              "--set", "limits.unsolved_fraction=1"],
}
READY = "document.documentElement?.dataset.state === 'ready'"
MEGABYTE = 1 << 20


def make_models(vrda, job, folder, names=tuple(MODELS)):
    """Runs MODELS; returns their files by name."""
    files = {name: folder / f"{name}.h5" for name in names}
    for name, file in files.items():
        subprocess.run([vrda, "run", job, "-o", file, *MODELS[name], "-q", "--progress", "none"], check=True, capture_output=True)
    return files


def changed(model, path, change):
    """A copy of a model changed by `change` (of an open h5py file); HDF5 removes its seal."""
    shutil.copy(model, path)
    with h5py.File(path, "r+") as file:
        change(file)
    return path


def replaced(name, **how):
    """A change that replaces the dataset `name`."""
    def change(file):
        del file[name]
        file.create_dataset(name, **how)
    return change


def assigned(name, place, value):
    def change(file):
        file[name][place] = value
    return change


def attribute(name, value):
    def change(file):
        file.attrs[name] = value
    return change


def linked_outside(file):
    del file["tx"]
    file["tx"] = h5py.ExternalLink("/etc/hostname", "/tx")


def in_circles(file):
    del file["smoothed"]
    file["smoothed"] = h5py.SoftLink("/smoothed/degree_2")


def bad_files(model, folder):
    """[(path, required part of the page's message)]"""
    whole = model.read_bytes()
    flipped = bytearray(whole)
    flipped[len(whole) // 2] ^= 1
    written = (("text", b"not a model\n", "not an HDF5 file"), ("empty", b"", "file is empty"), ("cut", whole[: len(whole) // 2], "cut off or damaged"),
               ("flipped", bytes(flipped), "do not match its seal"))
    rows = []
    for name, content, wanted in written:
        path = folder / f"{name}.h5"
        path.write_bytes(content)
        rows.append((path, wanted))
    huge = {"shape": (10, 5), "dtype": "f8"}
    changes = (
        ("newer", attribute("format_version", ["2.0"]), "format version 2.0"),
        ("other", attribute("format", ["something else"]), "is not a motion model"),
        ("unsolved", lambda file: file["status"].write_direct(numpy.full((10, 5), 3, dtype="i1")), "No attitude of this motion model is solved"),
        ("nan", assigned("smoothed/degree_2/coefficients_tx", 0, float("nan")), "coefficients_tx"),
        ("frames", lambda file: file.create_dataset("frame", data=numpy.arange(10.0)), "sequence of frames"),
        ("falling", assigned("flexion", 1, -5.0), "/flexion"),
        ("triangles", assigned("bodies/moving/triangles", (0, 0), 1 << 30), "/bodies/moving/triangles"),
        ("kind", replaced("ty", **{**huge, "dtype": "f4"}), "/ty"),
        ("bomb", replaced("bodies/reference/vertices", shape=(1 << 29, 3), dtype="f8", chunks=(1024, 3)), "/bodies/reference/vertices"),
        ("outside", linked_outside, "/tx"),
        ("circles", in_circles, None),  # read as a model without smoothed sets, or rejected, but it must not hang
    )
    rows += [(changed(model, folder / f"{name}.h5", change), wanted) for name, change, wanted in changes]
    big = folder / "big.h5"
    with big.open("wb") as file:
        file.truncate(500 * MEGABYTE)
    rows.append((big, "at most 400 MB"))
    return rows


# Edges are not smoothed, which takes half of the time without a graphics card.
ROUGH = """{ const real = HTMLCanvasElement.prototype.getContext;
    HTMLCanvasElement.prototype.getContext = function (kind, options) { return real.call(this, kind, kind.startsWith("webgl") ? { ...options, antialias: false } : options); }; }"""
# The page as it was when its model had been opened.
RESET = """(() => { const byId = (id) => document.getElementById(id), quantity = byId("quantity");
    if (byId("picture").classList.contains("full")) byId("full").click();
    for (const id of ["help", "teach"]) byId(id).open = false;
    byId("message").hidden = true;
    byId("speed").selectedIndex = 1;
    for (const select of [quantity, byId("compare")]) {
      if (select.selectedIndex === 0) continue;
      select.selectedIndex = 0;
      select.dispatchEvent(new Event("change"));
    }
    document.activeElement.blur();
    scrollTo(0, 0);
    window.vrda.useState(window.atFirst); })()"""
SAMPLE = "sample"


class Page:
    """The page in a tab. Use it in a `with`. The pages of a process share one browser, until one fails."""

    shared, current = None, None

    def __init__(self, chromium, deadline_s=120):
        if not Page.shared:
            Page.shared = Browser(chromium)
        self.browser = Page.shared
        self.browser.begin(deadline_s)
        self.scripts = []
        self.run_first(ROUGH)

    def __enter__(self):
        return self

    def __exit__(self, failure, *_):
        if failure:
            return Page.end()
        if len(self.scripts) > 1:
            Page.current = None
        for script in self.scripts:
            self.browser.call("Page.removeScriptToEvaluateOnNewDocument", identifier=script)
        self.browser.call("Network.emulateNetworkConditions", offline=False, latency=0, downloadThroughput=-1, uploadThroughput=-1)

    @staticmethod
    def end():
        if Page.shared:
            Page.shared.__exit__()
        Page.shared = Page.current = None

    def run_first(self, script):
        """Runs a script before those of each document that is visited."""
        self.scripts.append(self.browser.call("Page.addScriptToEvaluateOnNewDocument", source=script)["identifier"])

    def visit(self, address, ready=READY, **how):
        Page.current = None
        self.browser.visit(address, ready, **{"width": 1000, "height": 600, **how})

    def open(self, address, model=None, **how):
        """The page with a model, at first or as at first. Returns its message, or an empty text."""
        wanted = (address, model, how)
        if Page.current == wanted and len(self.scripts) == 1:
            self.browser.value(RESET)
            self.settle()
            return ""
        self.visit(address, **how)
        said = ""
        if model == SAMPLE:
            self.browser.value("document.getElementById('sample').click()")
        elif model:
            said = self.give(model)
        if not said:
            self.browser.wait(f"!document.getElementById('player').hidden && {READY}")
            self.settle()
            self.browser.value("window.atFirst = window.vrda.state()")
            Page.current = wanted
        return said

    def settle(self):
        """Waits until all changes are drawn, and observers of sizes and places have been called."""
        self.browser.value("""new Promise((done) => { let n = 3;
            const next = () => (n-- > 0 || !window.vrda.isStill() ? requestAnimationFrame(next) : done()); next(); })""")

    def give(self, path):
        """Opens a file by the page's button; returns the page's message, or an empty text."""
        self.browser.value("document.getElementById('message').textContent = ''; document.documentElement.dataset.state = 'requested'")
        self.browser.value("document.getElementById('message').hidden = true")
        self.browser.give("#file", path)
        self.browser.wait(f"({READY}) || !document.getElementById('message').hidden")
        return self.browser.value("document.getElementById('message').hidden ? '' : document.getElementById('message').textContent")

    def set(self, name, value, event="input"):
        """Sets a control and dispatches its event."""
        self.browser.value(f"(() => {{ const e = document.getElementById('{name}'); e.value = '{value}'; e.dispatchEvent(new Event('{event}')); }})()")

    def text(self, name):
        return self.browser.value(f"document.getElementById('{name}').textContent")

    def shown(self):
        return self.browser.value("window.vrda.shown()")


atexit.register(Page.end)
