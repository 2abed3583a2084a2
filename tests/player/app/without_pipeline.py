#!/usr/bin/python3
"""vrda-player configures without the pipeline's rooms and packages, and would be built by the very commands of BUILT, from the
same sources: what they make there they make here.

usage: without_pipeline.py CMAKE SOURCE BUILT FOLDER
BUILT is a build folder that holds the program; FOLDER is to configure in, and goes afterwards.
"""
import pathlib
import shutil
import subprocess
import sys


def run(*command):
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))} failed:\n{done.stdout[-4000:]}")
    return done.stdout


def commands_in(folder):
    """All that makes the program, whichever folder it is made in."""
    return set(run("ninja", "-C", folder, "-t", "commands", "vrda-player").replace(folder, "BUILD").splitlines())


def joined_sources_in(folder):
    """CMake's files that include the sources of a room, by their place."""
    return {path.relative_to(folder): path.read_text(encoding="utf-8").replace(folder, "BUILD")
            for path in pathlib.Path(folder).glob("**/Unity/*.cxx")}


def compare(built, folder):
    known = commands_in(built)
    for command in commands_in(folder) - known:
        if not command.startswith("ninja: "):
            sys.exit(f"a command that {built} does not know:\n{command}")
    sources = joined_sources_in(built)
    for path, text in joined_sources_in(folder).items():
        if sources.get(path) != text:
            sys.exit(f"{path} is another one in {built}")
    if "Example:" not in run(pathlib.Path(built) / "vrda-player", "--help"):
        sys.exit("vrda-player --help says nothing")


def main():
    cmake, source, built, folder = sys.argv[1:]
    shutil.rmtree(folder, ignore_errors=True)
    try:
        run(cmake, "-S", source, "-B", folder, "--preset", "release", "-DVRDA_PIPELINE=OFF", "-DVRDA_TESTS=OFF")
        compare(built, folder)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    main()
