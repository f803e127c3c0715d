"""Compares what `fingerprint` prints with what another build of it, or another processor, prints.

With --compiler and --flags it builds the other one from --source in --work; with --tunables it runs
the same program with GLIBC_TUNABLES set. Ends with 1 if a line differs.
"""

import argparse
import difflib
import os
import pathlib
import subprocess
import sys


def processor_flags():
    for line in pathlib.Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("flags"):
            return set(line.split(":")[1].split())
    return set()


def build(arguments):
    """The other program."""
    commands = (
        [arguments.cmake, "-G", "Ninja", "-S", arguments.source, "-B", arguments.work,
         f"-DCMAKE_CXX_COMPILER={arguments.compiler}", f"-DCMAKE_CXX_FLAGS={arguments.flags}",
         "-DCMAKE_BUILD_TYPE=None"],
        [arguments.cmake, "--build", arguments.work, "--target", "fingerprint", "--parallel", "1"])
    for command in commands:
        done = subprocess.run(command, check=False, text=True, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT)
        if done.returncode != 0:
            sys.exit(f"{' '.join(command)} failed:\n{done.stdout}")
    return pathlib.Path(arguments.work, "fingerprint")


def run(program, tunables=None):
    environment = dict(os.environ, **({"GLIBC_TUNABLES": tunables} if tunables else {}))
    done = subprocess.run([program], check=False, text=True, stdout=subprocess.PIPE,
                          env=environment)
    if done.returncode != 0 or not done.stdout:
        sys.exit(f"{program} ended with {done.returncode}:\n{done.stdout}")
    return done.stdout.splitlines()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("fingerprint")
    parser.add_argument("--cmake", default="cmake")
    parser.add_argument("--source")
    parser.add_argument("--work")
    parser.add_argument("--compiler")
    parser.add_argument("--flags", default="")
    parser.add_argument("--needs", default="", help="flags of /proc/cpuinfo, by commas")
    parser.add_argument("--tunables")
    arguments = parser.parse_args()
    missing = set(filter(None, arguments.needs.split(","))) - processor_flags()
    if missing:
        print(f"skipped: this processor has no {' '.join(sorted(missing))}")
        return 77

    expected = run(arguments.fingerprint)
    other = build(arguments) if arguments.compiler else arguments.fingerprint
    actual = run(other, arguments.tunables)
    print("\n".join(actual))
    if actual == expected:
        return 0
    print("The same seed gave other bits:")
    print("\n".join(difflib.unified_diff(expected, actual, "this build", "the other", n=0,
                                         lineterm="")))
    return 1


if __name__ == "__main__":
    sys.exit(main())
