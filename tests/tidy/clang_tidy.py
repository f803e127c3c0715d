#!/usr/bin/python3
"""Runs clang-tidy, with the checks of .clang-tidy, over the sources of core, server and client.

    tests/tidy/clang_tidy.py --build build/release [--clang-tidy PROGRAM] [--jobs N] [REGEX]

A file that passed is not looked at again until it, one of our headers that it includes, its
command line or the checks change: a stamp in BUILD/clang_tidy has the hash of all of these.

Most of clang-tidy's time goes into headers, those of gRPC first. So files that share a command line
are written one after the other into one, which is analysed once: a quarter of the time. What cannot
stand together, because two files give different things the same name, is analysed by itself.
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
GROUP = 24  # Files in one; more would leave cores idle at the end.
# It looks at every function of every header: two thirds of the time where gRPC's are among them.
SLOW_WITH_GRPC = "performance-unnecessary-value-param"


def compiled(file):
    """The sources that `file` of a build is made of: several where CMake has joined them."""
    if not re.fullmatch(r"unity_.*_cxx\.cxx", file.name):
        return [file.resolve()]
    included = re.findall(r'^#include "(.*)"', file.read_text(), re.MULTILINE)
    return [(file.parent / name).resolve() for name in included]


def commands(build, regex):
    """The command line of each of our sources that the build compiles, by source.

    Of a source that is compiled twice it is the line with the most checks inside the code, which
    leaves nothing out.
    """
    found = {}
    for entry in json.loads((build / "compile_commands.json").read_text()):
        for source in compiled(pathlib.Path(entry["directory"], entry["file"])):
            if TOP in source.parents and source.relative_to(TOP).parts[0] in FOLDERS:
                if re.search(regex, str(source.relative_to(TOP))):
                    if source not in found or "-DPLIANT_VALIDATE_EVERY" in entry["command"]:
                        found[source] = re.sub(r" -fPI[CE]| -o .*", "", entry["command"])
    return found


def left_out(source):
    """The check that `source` goes without unless PLIANT_LONG_TESTS=1 is set; empty if none."""
    in_core = source.relative_to(TOP).parts[0] == "core"
    return "" if in_core or os.environ.get("PLIANT_LONG_TESTS") == "1" else SLOW_WITH_GRPC


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


def groups(sources):
    """Lists of at most GROUP of the (source, command) pairs that can be analysed as one file."""
    open_groups = {}
    for source, command in sources:
        declared = set(re.findall(r"^using .*;", source.read_text(), re.MULTILINE))
        members, usings = open_groups.get(command, ([], set()))
        # The same declaration in two files would hide that one of them does not use it.
        if len(members) == GROUP or declared & usings:
            yield members
            members, usings = [], set()
        open_groups[command] = (members + [source], usings | declared)
    yield from (members for members, _ in open_groups.values())


class Joined:
    """A file with the text of several, which knows where each of its lines comes from."""

    def __init__(self, path, sources):
        self.path = path
        self.origins = []
        text = []
        for source in sources:
            lines = source.read_text().splitlines()
            text += lines
            self.origins += [(source, number) for number in range(1, len(lines) + 1)]
        path.write_text("\n".join(text) + "\n")

    def translate(self, complaint):
        """`complaint` with the places in the joined file replaced by those in its sources."""
        def origin(match):
            source, number = self.origins[int(match[1]) - 1]
            return f"{source}:{number}"
        return re.sub(re.escape(str(self.path)) + r":(\d+)", origin, complaint)


def analyse(program, file, command, without=""):
    """What clang-tidy complains about in `file`; empty if nothing."""
    done = subprocess.run(
        [program, "--quiet", f"--config-file={TOP / '.clang-tidy'}",
         *([f"--checks=-{without}"] if without else []),
         # Warnings that only gcc knows are no news here.
         "--extra-arg=-Wno-unknown-warning-option", str(file), "--", *shlex.split(command)[1:]],
        capture_output=True, text=True, check=False)
    return "" if done.returncode == 0 else done.stdout + done.stderr


def complaints(program, folder, sources, command, without=""):
    """(source, complaint) of each of `sources`, which share the command line.

    without: a check of .clang-tidy that is left out
    """
    if len(sources) > 1:
        name = hashlib.sha256("\n".join(map(str, sources)).encode()).hexdigest()[:16]
        joined = Joined(folder / f"{name}.cc", sources)
        complaint = joined.translate(analyse(program, joined.path, command, without))
        joined.path.unlink()
        if not complaint:
            return [(source, "") for source in sources]
    # One of them has a fault, or they cannot stand together.
    return [(source, analyse(program, source, command, without)) for source in sources]


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

    sources = commands(arguments.build, arguments.regex)
    stamp = {source: stamps / digest(source, command, common + left_out(source))
             for source, command in sources.items()}
    fresh = [item for item in sorted(sources.items()) if not stamp[item[0]].exists()]

    def look(group):
        start = time.monotonic()
        found = complaints(arguments.clang_tidy, stamps, group, sources[group[0]],
                           left_out(group[0]))
        for source, complaint in found:
            if not complaint:
                stamp[source].touch()
        return found, time.monotonic() - start

    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        results = list(pool.map(look, groups(fresh)))
    for found, seconds in results:
        print(f"{seconds:6.1f} s  " + " ".join(str(s.relative_to(TOP)) for s, _ in found))
        for _, complaint in found:
            if complaint:
                print(complaint)
    failed = sum(bool(complaint) for found, _ in results for _, complaint in found)
    print(f"{len(sources)} files, {len(fresh)} looked at, {failed} with complaints")
    return 1 if failed or not sources else 0


if __name__ == "__main__":
    sys.exit(main())
