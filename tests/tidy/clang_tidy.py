#!/usr/bin/python3
"""Runs clang-tidy, with the checks of .clang-tidy, over the sources of core, server and client.

    tests/tidy/clang_tidy.py --build build/release [--clang-tidy PROGRAM] [--jobs N] [REGEX]

A file that passed is not looked at again until it, one of our headers that it includes, its
command line or the checks change: a stamp in BUILD/clang_tidy has the hash of all of these.
"""

import argparse
import concurrent.futures
import hashlib
import json
import os
import pathlib
import re
import shlex
import subprocess
import sys
import time

import cxx

TOP = pathlib.Path(__file__).resolve().parents[2]
FOLDERS = ("core", "proto", "server", "client")


def commands(build, regex):
    """(source, command line) of each of our sources that the build compiles."""
    for entry in json.loads((build / "compile_commands.json").read_text()):
        source = pathlib.Path(entry["directory"], entry["file"]).resolve()
        if TOP in source.parents and source.relative_to(TOP).parts[0] in FOLDERS:
            if re.search(regex, str(source.relative_to(TOP))):
                yield source, entry["command"]


def digest(source, command, common):
    """The hash of everything of ours that decides what clang-tidy says about `source`."""
    roots = [TOP] + [pathlib.Path(word[2:]) for word in shlex.split(command) if word[:2] == "-I"]
    hasher = hashlib.sha256((common + command).encode())
    seen = set()
    queue = [source]
    while queue:
        file = queue.pop(0)
        if file in seen:
            continue
        seen.add(file)
        text = file.read_text()
        hasher.update(f"{file}\n{text}".encode())
        for _, included, _ in cxx.includes(text):
            queue += [root / included for root in roots if (root / included).is_file()][:1]
    return hasher.hexdigest()


def analyse(program, build, source):
    """What clang-tidy complains about in `source`; empty if nothing."""
    done = subprocess.run(
        [program, "-p", str(build), "--quiet",
         # Warnings that only gcc knows are no news here.
         "--extra-arg=-Wno-unknown-warning-option", str(source)],
        capture_output=True, text=True, check=False)
    return "" if done.returncode == 0 else done.stdout + done.stderr


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("regex", nargs="?", default="")
    parser.add_argument("--build", type=pathlib.Path, required=True)
    parser.add_argument("--clang-tidy", default="clang-tidy-14")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    arguments = parser.parse_args()
    version = subprocess.run([arguments.clang_tidy, "--version"], capture_output=True, text=True,
                             check=True).stdout
    common = version + (TOP / ".clang-tidy").read_text()
    stamps = arguments.build / "clang_tidy"
    stamps.mkdir(exist_ok=True)

    def one(item):
        source, command = item
        stamp = stamps / digest(source, command, common)
        if stamp.exists():
            return source, None, 0.0
        start = time.monotonic()
        complaint = analyse(arguments.clang_tidy, arguments.build, source)
        if not complaint:
            stamp.touch()
        return source, complaint, time.monotonic() - start

    work = sorted(commands(arguments.build, arguments.regex))
    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        results = list(pool.map(one, work))
    for source, complaint, seconds in results:
        if complaint is not None:
            print(f"{seconds:6.1f} s  {source.relative_to(TOP)}")
        if complaint:
            print(complaint)
    fresh = sum(complaint is not None for _, complaint, _ in results)
    failed = sum(bool(complaint) for _, complaint, _ in results)
    print(f"{len(results)} files, {fresh} looked at, {failed} with complaints")
    return 1 if failed or not results else 0


if __name__ == "__main__":
    sys.exit(main())
