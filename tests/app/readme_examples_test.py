"""Runs the shell examples of every README in a temporary folder, as a user would type them.

usage: readme_examples_test.py VRDA VRDA_PLAYER VRDA_WEBCAM
exit: 0 when all examples work, 1 when one fails (printed)

An example that needs what no test machine has, or that another test runs, is listed in ELSEWHERE with that test.
"""
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
READMES = ["README.md", "jobs/README.md", "pipeline/TASKS.md", "player/TASKS.md", "schemas/README.md", "scripts/README.md"]

# Start of an example: the file that runs it.
ELSEWHERE = {
    "scripts/quickstart": "tests/scripts/quickstart_test.py",
    "scripts/test": ".ci/run",
    ".ci/run": ".ci/run",
    "scripts/fuzz": "tests/fuzz/CMakeLists.txt",
    "scripts/check_includes": "tests/scripts/CMakeLists.txt",
    "scripts/bench": "tests/scripts/bench_page_test.py",
    "scripts/fingerprint": "tests/scripts/fingerprint_test.py",
    "scripts/validation": "tests/scripts/validation_page_test.py",
    "scripts/results": "tests/scripts/results_test.py",
    "scripts/thesis": "results/thesis.md",
    "scripts/tutorial": "tests/python/CMakeLists.txt",
    "/usr/bin/python3 -m venv": "tests/python/install_test.py",
    "my-venv/bin/pip": "tests/python/install_test.py",
    "scripts/generic-knee": "results/knee-generic.md",
    "scripts/calibration": "results/calibration.md",
    "scripts/real-knees": "results/real-knees.md",  # as the next: minutes to an hour; the page is what it wrote
    "scripts/reports": "results/knee-generic/README.md",
    "scripts/pictures": "results/player.md",
    "scripts/living-knee": "results/living-knee.md",
    "scripts/laxity": "results/laxity.md",
    "scripts/identification": "results/identification.md",
    "scripts/uncertainty": "results/uncertainty.md",
    "scripts/truth": "results/truth.md",
    "scripts/prepare_trials": "results/prepare.md",
    "scripts/believable": "results/believable.md",
    "scripts/firmware": "tests/player/bench/board_test.cpp",
    "scripts/package": "tests/package/packages_test.py",
    "scripts/trial-packages": "tests/package/bare_root_test.py",
    "scripts/trial-clean-root": "tests/package/bare_root_test.py",
    "tar -xzf": "tests/package/packages_test.py",
    "~/vrda": "tests/package/packages_test.py",
    "vrda submit my-knee.toml --shards 8 --partition": "tests/slurm/README.md",
    "vrda status study": "tests/slurm/README.md",
    "vrda resume study": "tests/slurm/README.md",
    "vrda convert": "tests/app/commands_test.cpp",
    "vrda fit knee.toml --motion": "tests/app/score_test.cpp",
    "vrda fit knee.toml --to": "tests/app/rom_test.cpp",
    "vrda bands": "tests/app/uncertainty_test.cpp",
    "vrda laxity": "tests/app/rom_test.cpp",
    "vrda run fitted.toml": "tests/app/score_test.cpp",
    "vrda prepare": "tests/app/prepare_test.cpp",
    "vrda run my-knee/knee.toml": "tests/app/prepare_test.cpp",
    "vrda check knee.toml": "tests/app/commands_test.cpp",
    "vrda-player body": "tests/player/app/bench_program_test.cpp",
    "vrda-player serve": "tests/player/app/serve_test.cpp",
    "vrda-player calibrate functional": "tests/player/calibration/calibrate_test.cpp",
    "vrda-webcam calibrate": "tests/player/bench/webcam_test.cpp",
    "vrda-player web": "tests/player/web/CMakeLists.txt",
    # a window, which an operator closes
    "vrda-player results/my-knee": "tests/player/app/window_test.cpp",
    "vrda-player $K": "tests/player/app/window_test.cpp",
    "vrda-player calibrate all --virtual": "tests/player/app/window_test.cpp",
    "vrda-player calibrate all --bench": "tests/player/app/bench_program_test.cpp",
    "vrda-player calibrate person": "tests/player/app/bench_program_test.cpp",
}
# Runs as it is although it begins as one above.
HERE = ("--offscreen", "--video", "--headless", "--dry-run", "--local")
# What makes an example end by itself, or sooner.
SHORTER = [
    (" --model $K &", " --model $K --seconds 60 &"),
    ("vrda-player bench", "vrda-player bench --headless --seconds 2"),
    ("--replay monday.log --from 5", "--replay monday.log --from 1"),
    ("--benches 200", "--benches 1"),
    ("vrda-player follow", "vrda-player follow --once --text"),
    ("--degree 8", "--degree 3"),
    ("--degrees 4,6,8", "--degrees 2,3"),
    ("degree_8", "degree_3"),
    ("--degrees 1..12", "--degrees 1..4"),
    ("--flexion 45 --varus 3", "--flexion 30 --varus 0"),
    ("--flexion 45", "--flexion 30"),
    ("--flexion 0:90:10", "--flexion 0:90:45"),
    ("--video knee.mp4", "--video knee.mp4 --fps 5 --speed 90"),
    ("--offscreen film", "--offscreen film --size 320x240"),
    ("knee-generic-contact.toml", "knee-generic-contact.toml --set grid.flexion.step=30 --set grid.varus.step=5"),
]
COARSE = ["--set", "grid.flexion.step=15", "--set", "grid.varus.step=4", "--set", "solver.equilibrium.restarts=0"]


def blocks(readme):
    """Shell blocks, each a list of commands, of which a continued one is one."""
    for text in re.findall(r"^```sh\n(.*?)^```", (ROOT / readme).read_text(), re.M | re.S):
        yield [re.sub(r"\s+#\s.*$", "", line).strip() for line in text.replace("\\\n", " ").splitlines() if line.strip()]


def runs_elsewhere(command):
    """The file that runs it, if this test does not."""
    if any(option in command for option in HERE):
        return None
    return next((file for start, file in ELSEWHERE.items() if command.startswith(start)), None)


def prepare(folder, programs):
    """A checkout in miniature, with a coarse model of the generic knee where the examples look for it."""
    tools = folder / "programs"
    tools.mkdir()
    for name, program in programs.items():
        (tools / name).symlink_to(program)
    shutil.copytree(ROOT / "jobs", folder / "jobs")
    (folder / "scripts").symlink_to(ROOT / "scripts")
    environment = dict(os.environ, PATH=f"{tools}:{os.environ['PATH']}", DISPLAY="")
    campaign = folder / "jobs/campaign-example.toml"
    campaign.write_text(campaign.read_text().replace("step = 5 }", "step = 15 }"))
    coarse = (ROOT / "jobs/knee-generic.toml").read_text().replace("step = 1 }", "step = 5 }")
    (folder / "my-knee.toml").write_text(coarse.replace('"Generic knee"', '"My knee"'))
    shutil.copy(ROOT / "jobs/bench-desk.toml", folder / "bench.toml")
    model = "results/knee-generic/knee-generic.h5"
    for words in (
        ["vrda", "run", "jobs/knee-generic.toml", "-o", model, *COARSE],
        ["vrda", "smooth", model, "--degree", "4", "--recontact"],
        ["vrda", "run", "my-knee.toml"],
        ["vrda", "export", model, "--to", "csv", "-o", "measured.csv"],
        ["vrda-player", "calibrate", "all", "--virtual", "--bench", "bench.toml", "--headless", "--calibration", "anna.toml", "--quiet"],
    ):
        subprocess.run(words, cwd=folder, env=environment, check=True, stdout=subprocess.DEVNULL)
    anna = folder / "anna.toml"  # calibrated as a simulated bench, used as the desk
    anna.write_text(anna.read_text().replace("Desk, virtual, seed 1", "Desk"))
    return environment


def run_block(lines, folder, environment):
    """(exit code, output); what it started in the background is stopped."""
    with tempfile.TemporaryFile("w+") as log:
        shell = subprocess.Popen(["bash", "-exc", "\n".join(lines)], cwd=folder, env=environment, stdin=subprocess.DEVNULL,
                                 stdout=log, stderr=log, start_new_session=True)
        code = shell.wait()
        try:
            os.killpg(shell.pid, signal.SIGTERM)
        except ProcessLookupError:
            pass
        log.seek(0)
        return code, log.read()


def main(vrda, player, webcam):
    failures = []
    n_run = 0
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        environment = prepare(folder, {"vrda": vrda, "vrda-player": player, "vrda-webcam": webcam})
        for readme in READMES:
            for block in blocks(readme):
                lines = []
                for command in block:
                    elsewhere = runs_elsewhere(command)
                    if elsewhere:
                        if not (ROOT / elsewhere).exists():
                            failures.append(f"{readme}: {command}: no file {elsewhere}, which should run it")
                        continue
                    for long, short in SHORTER:
                        command = command.replace(long, short)
                    lines.append(command)
                    n_run += not re.match(r"\w+=", command)
                if not lines:
                    continue
                code, output = run_block(lines, folder, environment)
                if code != 0:
                    failures.append(f"{readme}: exit code {code}\n{output[-3000:]}")
    if n_run < 40:
        failures.append(f"found {n_run} examples, wanted 40 at least: are the READMEs read?")
    print("\n".join(failures) or f"{n_run} examples run")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main(*(pathlib.Path(word).resolve() for word in sys.argv[1:4])))
