"""The build under test: its programs, its packages, and a small run for comparison."""
import hashlib
import json
import os
import pathlib
import re
import subprocess

SOURCE = pathlib.Path(__file__).parents[2]
BUILD = pathlib.Path(os.environ["VRDA_BUILD"])
PACKAGES = pathlib.Path(os.environ["VRDA_PACKAGES"])
# Of the Python module, if the build has it.
PYTHON = "VRDA_PYTHON:BOOL=ON" in (BUILD / "CMakeCache.txt").read_text()
PYTHON_FOLDER = "lib/python3/dist-packages/vrda"
PYTHON_FILES = {f"{PYTHON_FOLDER}/{name}" for name in ("__init__.py", "_errors.py", "_core.pyi", "py.typed")} | {
    f"share/doc/python3-vrda/examples/knee.{kind}" for kind in ("py", "ipynb")} | {
    f"{PYTHON_FOLDER}/{path.name}" for path in (BUILD / "python/vrda").glob("_core.*.so")} if PYTHON else set()
TARBALLS = ("vrda", "vrda-player")
PROGRAMS = TARBALLS + (("vrda-webcam",) if (BUILD / "vrda-webcam").exists() else ())
PLAYER_FILES = {"share/vrda/vrda-player.html"} | {f"share/vrda/lessons/{path.stem}.html" for path in (SOURCE / "player/web/lessons").glob("*.json")}
# 7 x 5 attitudes of the generic knee: it needs no file but the job, and takes a second.
COARSE = ("--set", "grid.flexion.step=15", "--set", "grid.varus.step=5", "--set", "solver.equilibrium.restarts=0", "--progress", "none")


def run(*command, **options):
    """Runs a command, which must succeed; returns its output as text."""
    done = subprocess.run(command, capture_output=True, text=True, stdin=subprocess.DEVNULL, check=False, **options)
    if done.returncode != 0:
        raise AssertionError(f"{command}: exit code {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout


def sha256(path):
    return hashlib.sha256(pathlib.Path(path).read_bytes()).hexdigest()


def coarse_knee(folder):
    """SHA-256 of the coarse generic knee, solved by the build tree's vrda from the source tree's job."""
    model = pathlib.Path(folder) / "by-the-build-tree.h5"
    run(BUILD / "vrda", "run", SOURCE / "jobs/knee-generic.toml", *COARSE, "-o", model)
    return sha256(model)


def shared_files():
    """Contents of share/vrda in every installation: all jobs and schemas, by path relative to the prefix."""
    kinds = (".toml", ".md", ".json", ".csv", ".xml")
    found = [path for folder in ("jobs", "schemas") for path in (SOURCE / folder).rglob("*") if path.suffix in kinds]
    return {"share/vrda/" + str(path.relative_to(SOURCE)) for path in found}


def files_below(folder):
    """Files and links below a folder, by relative path; folders only if empty."""
    folder = pathlib.Path(folder)
    return {str(path.relative_to(folder)) for path in folder.rglob("*")
            if path.is_symlink() or not path.is_dir() or not any(path.iterdir())}


def stills_of(page):
    """The images in a report page of one model, and the page's note on missing images, or None."""
    text = re.search(r'<script type="application/json" id="report-data">(.*?)</script>', pathlib.Path(page).read_text(), re.DOTALL)
    stills = json.loads(text.group(1))["models"][0]["stills"]
    return stills["stills"], stills["note"] or None
