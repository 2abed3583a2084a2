#!/usr/bin/python3
"""Checks that vrda-player configures without the pipeline's rooms and packages, and that its build commands and sources are
those of BUILT, so that the resulting program is the same.

usage: without_pipeline.py CMAKE SOURCE BUILT FOLDER
BUILT is a build folder with the program; FOLDER is the folder to configure in, removed afterwards.
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
    """The build commands of the program, independent of the build folder."""
    return set(run("ninja", "-C", folder, "-t", "commands", "vrda-player").replace(folder, "BUILD").splitlines())


def joined_sources_in(folder):
    """CMake's unity source files by their path."""
    return {path.relative_to(folder): path.read_text(encoding="utf-8").replace(folder, "BUILD")
            for path in pathlib.Path(folder).glob("**/Unity/*.cxx")}


def compare(built, folder):
    known = commands_in(built)
    for command in commands_in(folder) - known:
        if not command.startswith("ninja: "):
            sys.exit(f"a command that is not in {built}:\n{command}")
    sources = joined_sources_in(built)
    for path, text in joined_sources_in(folder).items():
        if sources.get(path) != text:
            sys.exit(f"{path} differs from that in {built}")
    if "Example:" not in run(pathlib.Path(built) / "vrda-player", "--help"):
        sys.exit("vrda-player --help prints no example")


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
