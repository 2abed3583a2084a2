#!/usr/bin/python3
"""vrda-player configures and builds without the pipeline's rooms, and shows its help.

usage: without_pipeline.py CMAKE SOURCE FOLDER CXX_FLAGS
FOLDER is to build in, and goes afterwards. As deep as that of the release build and with its CXX_FLAGS, so that ccache knows the
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


def build(cmake, source, folder, flags):
    run(cmake, "-S", source, "-B", folder, "-G", "Ninja", "-DVRDA_PIPELINE=OFF", "-DVRDA_TESTS=OFF",
        "-DCMAKE_BUILD_TYPE=Release", f"-DCMAKE_CXX_FLAGS_RELEASE={flags}", "-DCMAKE_CXX_COMPILER=g++",
        "-DCMAKE_C_COMPILER_LAUNCHER=ccache", "-DCMAKE_CXX_COMPILER_LAUNCHER=ccache")
    run(cmake, "--build", folder, "--parallel", "2", "--target", "vrda-player")
    if "Example:" not in run(pathlib.Path(folder) / "vrda-player", "--help"):
        sys.exit("vrda-player --help says nothing")


def main():
    cmake, source, folder, flags = sys.argv[1:]
    shutil.rmtree(folder, ignore_errors=True)
    try:
        build(cmake, source, folder, flags)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    main()
