"""The pages of results/: what each was made from, and whether that is still today's.

A page is a rendering of its record, results/records/NAME.json: numbers, seconds, and the runs and files they come from, each with
hashes. `stale` compares a record with the programs, jobs and meshes of today and the page with a rendering of its record.
"""
import dataclasses
import functools
import hashlib
import importlib
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import tomllib

sys.dont_write_bytecode = True
ROOT = pathlib.Path(__file__).resolve().parent.parent
STALE = "**Stale:**"
HAND_WRITTEN = ("remarks.md", "campaign-estimate.md")
# Jobs without mesh files, from which the version of each solver is known everywhere.
GENERIC = {"stability-search": "jobs/knee-generic-contact.toml", "equilibrium": "jobs/knee-generic.toml"}


@dataclasses.dataclass(frozen=True)
class Run:
    """A job as it was solved for a page."""
    job: str
    settings: tuple = ()
    with_followers: bool = False  # most pages are about the joint, which bodies that follow it do not change

    @property
    def name(self):
        return " ".join((self.job, *self.settings))


@dataclasses.dataclass(frozen=True)
class Page:
    """A page, the command that makes it, and its inputs."""
    path: str
    maker: tuple
    module: str  # of scripts/pages; its function page(numbers, stamp) returns the text
    runs: tuple = ()
    files: tuple = ()  # other inputs: of the checkout, of the data folder as data:PATH, or what the program makes (PREPARED)
    is_long: bool = False  # takes minutes: may be stale while its second line says so


def validation_jobs():
    return tuple(str(job.relative_to(ROOT)) for job in sorted((ROOT / "jobs/validation").glob("*.toml")))


CONTACT, LIGAMENTS, LIVING = GENERIC["stability-search"], GENERIC["equilibrium"], "jobs/knee-jam-smith2019-ligaments.toml"
REAL_KNEES = tuple(f"jobs/knee-{name}.toml" for name in ("jam-smith2019", "pymskt-dess", "vhf-left", "vhf-right"))
SEARCH_OF_THESIS = tuple(f"jobs/validation/{name}.toml" for name in ("ball-in-dish", "bar-on-pyramids", "cap-in-sink"))
COARSE_KNEE = ("grid.flexion.step=10", "grid.varus.step=5", "smooth.degrees=[3]")
BY_EQUILIBRIUM = ("solver.method=equilibrium",)
MENISCI = ("moving.component.2.contact=true", "moving.component.3.contact=true")
PREPARED = "made by vrda prepare"  # of the template knee's own bones: changes with the registration, not with its source text
PAGES = {
    "thesis": Page("results/thesis.md", ("scripts/thesis",), "thesis",
                   tuple(map(Run, (CONTACT, LIGAMENTS, *SEARCH_OF_THESIS)))),
    "validation": Page("results/validation.md", ("scripts/validation",), "validation", (*map(Run, validation_jobs()), Run(CONTACT, COARSE_KNEE))),
    "generic-knee": Page("results/knee-generic.md", ("scripts/generic-knee",), "generic_knee",
                         (Run(LIGAMENTS), Run(CONTACT), Run(CONTACT, BY_EQUILIBRIUM), *map(Run, validation_jobs()),
                         *(Run(job, BY_EQUILIBRIUM) for job in validation_jobs()))),
    "knee-generic": Page("results/knee-generic/README.md", ("scripts/reports",), "knee_report", (Run(LIGAMENTS),),
                         ("results/knee-generic/remarks.md",), is_long=True),
    "knee-jam-smith2019-ligaments": Page("results/knee-jam-smith2019-ligaments/README.md", ("scripts/reports",), "knee_report", (Run(LIVING),),
                                         ("results/knee-jam-smith2019-ligaments/remarks.md", "data:kinematics"), is_long=True),
    "calibration": Page("results/calibration.md", ("scripts/calibration",), "calibration", (), ("jobs/bench-desk.toml",)),
    "living-knee": Page("results/living-knee.md", ("scripts/living-knee",), "living_knee",
                        (Run(LIVING), Run(LIVING, MENISCI), Run(LIVING,
                        (*MENISCI, "moving.component.2.inset_mm=0.5", "moving.component.3.inset_mm=0.5")),
                        Run(LIVING, (*MENISCI, "moving.component.2.overlap_mm=1", "moving.component.3.overlap_mm=1"))),
                        ("data:kinematics", "data:knees/pymskt-dess", PREPARED)),
    "laxity": Page("results/laxity.md", ("scripts/laxity",), "laxity", (Run(LIVING),), ("scripts/laxity",)),
    "identification": Page("results/identification.md", ("scripts/identification",), "identification", (Run(LIVING), Run(LIGAMENTS)),
                           ("data:kinematics", "scripts/identification_cases", "scripts/identification_living.toml"), is_long=True),
    "uncertainty": Page("results/uncertainty.md", ("scripts/uncertainty",), "uncertainty", (Run(LIGAMENTS), Run(LIVING)),
                        ("data:kinematics", "scripts/uncertainty_numbers", "scripts/living_knee_loads"), is_long=True),
    "truth": Page("results/truth.md", ("scripts/truth",), "truth", (Run(LIVING),),
                  ("data:knees/tka-dm", "data:subtalar", "data:kinematics", "data:patella", "scripts/truth_cases", "scripts/truth_patella.py",
                   "scripts/truth_scores"), is_long=True),
    "prepare": Page("results/prepare.md", ("scripts/prepare_trials",), "prepare", (Run(LIVING),),
                    ("data:knees", PREPARED), is_long=True),
    "believable": Page("results/believable.md", ("scripts/believable",), "believable", (Run(LIVING),),
                       ("data:knees", "data:kinematics", PREPARED), is_long=True),
    "player": Page("results/player.md", ("scripts/pictures",), "player", (Run(LIGAMENTS, with_followers=True), Run(LIVING)), ("jobs/bench-desk.toml",), is_long=True),
    "tutorial": Page("results/tutorial.md", ("scripts/tutorial",), "tutorial", (Run(LIGAMENTS, with_followers=True),),
                     ("scripts/tutorial", "pipeline/python/examples/knee.ipynb", PREPARED), is_long=True),
    "fuzz": Page("results/fuzz.md", ("scripts/fuzz", "--record"), "fuzz", (), ("tests/fuzz/corpus",), is_long=True),
    "benchmarks": Page("results/benchmarks.md", ("scripts/bench",), "benchmarks", (Run(CONTACT), Run(LIGAMENTS, with_followers=True),
    Run("jobs/knee-jam-smith2019.toml")), is_long=True),
    "real-knees": Page("results/real-knees.md", ("scripts/real-knees",), "real_knees", tuple(map(Run, REAL_KNEES)), is_long=True),
}


def data_folder():
    """Folder of the real knees; may be missing."""
    return pathlib.Path(os.environ.get("VRDA_DATA", ROOT.parent / "shared/data")).resolve()


def sha256(text):
    return hashlib.sha256(text if isinstance(text, bytes) else text.encode()).hexdigest()


def job_text(run):
    """The job's text, if wanted without the bodies that follow the joint."""
    text = (ROOT / run.job).read_text(encoding="utf-8")
    return text if run.with_followers else re.sub(r"(?ms)^\[\[follower\b.*?(?=^\[+(?!follower)|\Z)", "", text)


def job_hash(run):
    """Of the keys and values of a job: comments do not count."""
    return sha256(json.dumps(tomllib.loads(job_text(run)), sort_keys=True, default=str))


def without_scan(text):
    """A prepared job without [scan], which only places exports in the frame of the scan."""
    return re.sub(rb"(?ms)^\[scan\].*?(?=^\[)", b"", text)


def inputs_in(folder):
    """The files of a folder."""
    return [path for path in sorted(folder.rglob("*")) if path.is_file()]


class Today:
    """Solver versions, job keys and hashes of files of today, from `vrda check`."""

    def __init__(self, vrda):
        self.vrda = vrda

    @functools.lru_cache(maxsize=None)
    def _checked(self, run):
        options = [word for setting in run.settings for word in ("--set", setting)]
        with tempfile.NamedTemporaryFile("w", suffix=".toml", encoding="utf-8") as job:
            job.write(job_text(run))
            job.flush()
            done = subprocess.run([self.vrda, "check", job.name, "--data", data_folder(), "--json", *options], capture_output=True, text=True)
        return json.loads(done.stdout) if done.returncode == 0 else None

    def run(self, run):
        """Solver, key and hash of a run; the key is None where the job's meshes are missing."""
        checked = self._checked(run)
        if checked is None:
            written = tomllib.loads(job_text(run)).get("solver", {}).get("method", "equilibrium")
            chosen = dict(setting.split("=", 1) for setting in run.settings).get("solver.method", written)
            return {"solver": self._checked(Run(GENERIC[chosen]))["solver_version"], "key": None, "job": job_hash(run)}
        return {"solver": checked["solver_version"], "key": checked["job_key"], "job": job_hash(run)}

    @functools.lru_cache(maxsize=None)
    def _prepared(self):
        """Hash of the files that `vrda prepare` makes of the template knee's bones."""
        with tempfile.TemporaryDirectory() as folder:
            for words in (("shape", "knee-template", "-o", "bones"),
                          ("prepare", "--femur", "bones/femur.stl", "--tibia", "bones/tibia.stl", "-o", "prepared")):
                subprocess.run([pathlib.Path(self.vrda).resolve(), *words], cwd=folder, check=True, capture_output=True)
            return sha256("".join(f"{file.name} {sha256(without_scan(file.read_bytes()))}\n" for file in inputs_in(pathlib.Path(folder, "prepared"))))

    def file(self, name):
        """Hash of a file or of all files of a folder, without what changes no number; None for data that are missing."""
        if name == PREPARED:
            return self._prepared()
        path = data_folder() / name[5:] if name.startswith("data:") else ROOT / name
        if path.is_dir():
            return sha256("".join(f"{one.relative_to(path)} {sha256(one.read_bytes())}\n" for one in inputs_in(path)))
        return sha256(path.read_bytes()) if path.is_file() else None


def record_path(name, root=ROOT):
    return root / "results/records" / f"{name}.json"


def read_record(name, root=ROOT):
    return json.loads(record_path(name, root).read_text(encoding="utf-8"))


def collect(name, files):
    """The numbers of a page from the files of its command: by the module's function collect, else one JSON file."""
    module = importlib.import_module(f"pages.{PAGES[name].module}")
    paths = [pathlib.Path(file) for file in files]
    return module.collect(*paths) if hasattr(module, "collect") else json.loads(paths[0].read_text(encoding="utf-8"))


def write_record(name, numbers, seconds, today):
    """Keeps the numbers with today's versions and hashes."""
    page = PAGES[name]
    record = {"seconds": round(seconds), "runs": {run.name: today.run(run) for run in page.runs},
        "files": {file: today.file(file) for file in page.files},
              "numbers": numbers}
    missing = [run for run, found in record["runs"].items() if found["key"] is None] + [file for file,
        found in record["files"].items() if found is None]
    if missing:
        sys.exit(f"results: {name}: found no data for {', '.join(missing)} in {data_folder()}, wanted the folder of the real knees")
    record_path(name).parent.mkdir(parents=True, exist_ok=True)
    record_path(name).write_text(json.dumps(record, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


def counted(things, noun):
    """1 run, 2 runs."""
    return f"{len(things)} {noun}{'' if len(things) == 1 else 's'}"


def stamp(record):
    """The line of a page that says what it was made with."""
    solvers = sorted({run["solver"] for run in record["runs"].values()})
    known = {key: {part: value for part, value in run.items() if part != "solver"} for key, run in record["runs"].items()}
    inputs = sha256(json.dumps([known, record["files"]], sort_keys=True))[:12]
    used = f"Solver: {', '.join(solvers)}" if solvers else "No solver used"
    return f"{used}. Inputs: `{inputs}` ({counted(record['runs'], 'run')}, {counted(record['files'], 'file')}, in `results/records/`). Made in {record['seconds']:,} s."


def render(name, root=ROOT):
    """The page's text from its record."""
    record = read_record(name, root)
    module = importlib.import_module(f"pages.{PAGES[name].module}")
    return module.page(record["numbers"], stamp(record))


def stale(name, today, root=ROOT):
    """What in a page is not today's: lines for people, empty if the page is current, or a long one that says that it is stale."""
    page = PAGES[name]
    text = (root / page.path).read_text(encoding="utf-8")
    old = outdated(name, today, root)
    if old and not (page.is_long and STALE in text):
        return old
    if record_path(name, root).is_file() and text != marked(render(name, root), name, old):
        return [f"{page.path}: found other text than its record gives; run scripts/results --render {name}"]
    return []


def marked(text, name, old):
    """The text of a long page whose record is outdated, with a line that says so."""
    if not old or not PAGES[name].is_long:
        return text
    title, rest = text.split("\n", 1)
    return f"{title}\n\n{STALE} the solver or an input has changed since; `scripts/results {name}` makes it again.\n{rest}"


def outdated(name, today, root=ROOT):
    """What in a page's record is not today's."""
    page = PAGES[name]
    again = f"; make it again with scripts/results {name}"
    if not record_path(name, root).is_file():
        return [f"{page.path}: found no record results/records/{name}.json{again}"]
    record = read_record(name, root)
    found = []
    if set(record["runs"]) != {run.name for run in page.runs} or set(record["files"]) != set(page.files):
        found.append(f"{page.path}: found other runs or files in its record than in scripts/result_pages.py{again}")
    for run in page.runs:
        made, current = record["runs"].get(run.name, {}), today.run(run)
        for part, words in (("solver", "solver"), ("job", "keys of the job"), ("key", "job key")):
            if current[part] is not None and made.get(part) != current[part]:
                found.append(f"{page.path}: {run.name}: {words}: found {made.get(part)}, wanted {current[part]}{again}")
    for file in page.files:
        current = today.file(file)
        if current is not None and record["files"].get(file) != current:
            found.append(f"{page.path}: {file}: found {record['files'].get(file)}, wanted {current}{again}")
    return found


def pages_on_disk(root=ROOT):
    """Every page of results/ that is tracked or would be."""
    folders = [root / "results", *(path for path in (root / "results").glob("knee-*") if (path / "README.md").is_file())]
    return sorted(str(path.relative_to(root)) for folder in folders for path in folder.glob("*.md") if path.name not in HAND_WRITTEN)
