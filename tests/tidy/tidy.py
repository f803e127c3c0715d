#!/usr/bin/python3
"""Checks the rules of rules.py over every file that git knows or would add.

    tests/tidy/tidy.py [--list]

Prints each violation as "file:line: rule: message" and ends with 1 if there is one. An exception
needs a line "rule path: reason" in exceptions.txt; one that is no longer needed is a violation.
"""

import pathlib
import subprocess
import sys

import rules

EXCEPTIONS = "tests/tidy/exceptions.txt"


def read_tree(top):
    """Path from the root -> text, for each text file that git tracks or would add."""
    listed = subprocess.run(
        ["git", "-c", "safe.directory=*", "ls-files", "-z", "--cached", "--others",
         "--exclude-standard"],
        cwd=top, check=True, capture_output=True).stdout.decode()
    tree = {}
    for path in filter(None, listed.split("\0")):
        file = top / path
        if file.is_file() and not file.is_symlink():
            try:
                tree[path] = file.read_text(encoding="utf-8")
            except UnicodeDecodeError:
                tree[path] = ""  # A picture or an archive: only its place is checked.
    return tree


def read_exceptions(text):
    """The exceptions {(rule, path): line number}, and the violations of the file itself."""
    exceptions = {}
    violations = []
    for number, line in enumerate(text.split("\n"), 1):
        if not line.strip() or line.startswith("#"):
            continue
        head, _, reason = line.partition(":")
        fields = head.split()
        if len(fields) != 2 or fields[0] not in rules.RULES or not reason.strip():
            violations.append(f"{EXCEPTIONS}:{number}: exceptions: want 'rule path: reason'")
        else:
            exceptions[tuple(fields)] = number
    return exceptions, violations


def check(tree):
    """All violations in a tree (path from the root -> text), as printed."""
    exceptions, violations = read_exceptions(tree.get(EXCEPTIONS, ""))
    used = set()
    for name, rule in rules.RULES.items():
        for violation in rule(tree):
            key = (name, violation.path)
            if key in exceptions:
                used.add(key)
            else:
                violations.append(
                    f"{violation.path}:{violation.line}: {name}: {violation.message}")
    for key, number in exceptions.items():
        if key not in used:
            violations.append(
                f"{EXCEPTIONS}:{number}: exceptions: no longer needed: {' '.join(key)}")
    return violations


def main(arguments):
    if arguments == ["--list"]:
        for name, rule in rules.RULES.items():
            print(f"{name:16} {rule.__doc__.splitlines()[0]}")
        return 0
    if arguments:
        print(__doc__)
        return 2
    tree = read_tree(pathlib.Path(__file__).resolve().parents[2])
    violations = check(tree)
    print("\n".join(violations))
    print(f"{len(tree)} files, {len(rules.RULES)} rules, {len(violations)} violations")
    return 1 if violations else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
