#!/usr/bin/python3
"""vrda-player configures and builds without the pipeline's rooms, and shows its help.

usage: without_pipeline.py CMAKE SOURCE FOLDER
FOLDER is to build in, and goes afterwards. As deep as that of the release build and of its preset, so that ccache knows the
objects.
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


def build(cmake, source, folder):
    run(cmake, "-S", source, "-B", folder, "--preset", "release", "-DVRDA_PIPELINE=OFF", "-DVRDA_TESTS=OFF")
    run(cmake, "--build", folder, "--parallel", "2", "--target", "vrda-player")
    if "Example:" not in run(pathlib.Path(folder) / "vrda-player", "--help"):
        sys.exit("vrda-player --help says nothing")


def main():
    cmake, source, folder = sys.argv[1:]
    shutil.rmtree(folder, ignore_errors=True)
    try:
        build(cmake, source, folder)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    main()
