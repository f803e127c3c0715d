"""The rules of style that a machine can check.

A rule takes the tree (path from the root -> text) and yields a Violation for each place that breaks
it. Its name is the function's, with dashes; its docstring says what it wants. tidy_test.py has a
violating snippet for each.
"""

import ast
import re
from typing import NamedTuple

import cxx

FUNCTION_LINES_MAX = 70
FILE_LINES_MAX = 500
LINE_COLUMNS_MAX = 100

# Of core: each may include itself and those before it.
CORE_LAYERS = ("base", "geometry", "metric", "mesh", "delaunay", "transfer", "pliant", "motion",
               "threads")

# The library of core that lends threads to the others, which know none.
MAY_USE_THREADS = re.compile(r"core/threads/")

# What core knows nothing of: the wire, logging, files, clocks, threads, other random numbers.
NOT_IN_CORE = re.compile(
    r"(grpc|google/|absl/|spdlog|fmt/|pliant/v1/|server/|client/)"
    r"|(iostream|fstream|filesystem|thread|mutex|shared_mutex|condition_variable|future|stop_token"
    r"|semaphore|latch|barrier|chrono|ctime|time\.h|random|syncstream)$")

# Where elementary functions live: their bits differ between CPUs and libraries, so a mesh must
# not depend on the library's.
MAY_USE_LIBM = re.compile(r"core/(base/math|metric/expression)\.(h|cc)$")
LIBM = re.compile(
    r"(?<![\w.:>])(?:std::|::)?((?:exp|exp2|expm1|log|log2|log10|log1p|sin|cos|tan|asin|acos|atan|"
    r"atan2|sinh|cosh|tanh|asinh|acosh|atanh|pow|cbrt|hypot|erf|erfc|tgamma|lgamma)f?)\s*"
    r"\((?!\s*\))")

# Everything that the top level may hold, besides files whose name starts with a dot.
ROOT = {"CMakeLists.txt", "CMakePresets.json", "LICENSE", "README.md",
        "proto", "server", "core", "client", "tests", "deploy"}

# First parts of absolute paths that mean the same on every machine, or start at our own root.
COMMON_PATHS = ROOT | {"usr", "bin", "etc", "tmp", "dev", "proc", "var", "run", "opt", "lib", "sys"}


class Violation(NamedTuple):
    """One place that breaks one rule."""

    path: str
    line: int
    message: str


def is_cxx(path):
    return path.endswith((".h", ".cc"))


def is_source(path):
    if path.startswith("tests/data/"):
        return False
    name = path.rsplit("/", 1)[-1]
    return (path.endswith((".h", ".cc", ".py", ".proto", ".cmake", ".sh", ".ts", ".js", ".css"))
            or name == "CMakeLists.txt" or "." not in name and name != "LICENSE")


def sources(tree, accept=is_source):
    return ((path, text) for path, text in sorted(tree.items()) if accept(path))


def product_cxx(tree, folders=("core", "proto", "server", "client")):
    return sources(tree, lambda path: is_cxx(path) and path.split("/")[0] in folders)


def find(pattern, path, text, message):
    """A violation for each line of `text` in which `pattern` occurs."""
    for number, line in enumerate(text.split("\n"), 1):
        match = re.search(pattern, line)
        if match:
            yield Violation(path, number, message.format(match.group().strip()))


def function_length(tree):
    """A function has at most 70 lines."""
    for path, text in sources(tree):
        spans = ()
        if is_cxx(path):
            spans = cxx.function_spans(text)
        elif path.endswith(".py"):
            spans = ((node.lineno, node.end_lineno) for node in ast.walk(ast.parse(text))
                     if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)))
        for first, last in spans:
            if last - first + 1 > FUNCTION_LINES_MAX:
                yield Violation(path, first, f"function of {last - first + 1} lines, "
                                f"at most {FUNCTION_LINES_MAX}")


def file_length(tree):
    """A file has at most 500 lines."""
    for path, text in sources(tree):
        count = len(text.splitlines())
        if count > FILE_LINES_MAX:
            yield Violation(path, count, f"{count} lines, at most {FILE_LINES_MAX}")


def line_length(tree):
    """A line has at most 100 columns."""
    for path, text in sources(tree):
        for number, line in enumerate(text.split("\n"), 1):
            if len(line) > LINE_COLUMNS_MAX:
                yield Violation(path, number, f"{len(line)} columns, at most {LINE_COLUMNS_MAX}")


def test_file(tree):
    """a/b.h with a/b.cc is tested by tests/a/b_test.cc; client/cpp/b by tests/client/b_test.cc."""
    for path, _ in product_cxx(tree):
        stem = path[:-len(".cc")]
        if not path.endswith(".cc") or stem + ".h" not in tree:
            continue
        test = f"tests/{stem.replace('client/cpp/', 'client/', 1)}_test.cc"
        if test not in tree:
            yield Violation(path, 1, f"{test} is missing")


def core_layers(tree):
    """A layer of core includes only itself and earlier ones."""
    for path, text in product_cxx(tree, ("core",)):
        layer = path.split("/")[1]
        if layer not in CORE_LAYERS:
            yield Violation(path, 1, f"'{layer}' is no layer; they are {', '.join(CORE_LAYERS)}")
            continue
        for number, included, _ in cxx.includes(text):
            parts = included.split("/")
            if parts[0] != "core" or parts[1] not in CORE_LAYERS:
                continue
            if CORE_LAYERS.index(parts[1]) > CORE_LAYERS.index(layer):
                yield Violation(path, number, f"{included}: {parts[1]} is above {layer}")


def core_includes(tree):
    """Core knows nothing of the wire, logging, files, clocks, threads and std's random numbers."""
    for path, text in product_cxx(tree, ("core",)):
        if MAY_USE_THREADS.match(path):
            continue
        for number, included, _ in cxx.includes(text):
            if NOT_IN_CORE.match(included):
                yield Violation(path, number, f"core includes {included}")


def client_layers(tree):
    """The client knows nothing of the server."""
    for path, text in product_cxx(tree, ("client",)):
        for number, included, _ in cxx.includes(text):
            if included.startswith("server/"):
                yield Violation(path, number, f"client includes {included}")


def wire_and_core(tree):
    """Only server/convert*.* includes both wire types and core's (core/base is everyone's)."""
    for path, text in product_cxx(tree, ("server",)):
        if re.match(r"server/convert(_\w+)?\.(h|cc)$", path):
            continue
        included = list(cxx.includes(text))
        wire = [name for _, name, _ in included if name.startswith("pliant/v1/")]
        core = [(number, name) for number, name, _ in included
                if name.startswith("core/") and not name.startswith("core/base/")]
        if wire and core:
            number, name = core[0]
            yield Violation(path, number, f"includes {name} as well as {wire[0]}")


def libm(tree):
    """Core takes elementary functions from core/base/math only."""
    for path, text in product_cxx(tree, ("core",)):
        if not MAY_USE_LIBM.match(path):
            code = cxx.without_comments_and_strings(text)
            yield from find(LIBM, path, code, "{} differs between machines; see core/base/math.h")


def no_exit(tree):
    """Nothing ends the process."""
    for path, text in product_cxx(tree):
        code = cxx.without_comments_and_strings(text)
        yield from find(r"(?<![\w.>])(?:std::)?(_exit|_Exit|quick_exit|exit|abort|terminate)\s*\(",
                        path, code, "{} ends the process; return an Error")


def no_assert(tree):
    """PLIANT_CHECK instead of assert: it stays on in release builds and says the values."""
    for path, text in product_cxx(tree):
        code = cxx.without_comments_and_strings(text)
        yield from find(r"(?<!\w)assert\s*\(|#\s*include\s*<(cassert|assert\.h)>", path, code,
                        "{}: use PLIANT_CHECK")


def no_todo(tree):
    """What is left to do is an issue, not a comment."""
    for path, text in sources(tree):
        yield from find(r"\b(TO" r"DO|FIX" r"ME|XX" r"X)\b", path, text, "{}")


def no_sleep(tree):
    """Tests wait for what they need, not for time to pass."""
    for path, text in sources(tree, lambda path: is_cxx(path) and path.startswith("tests/")):
        code = cxx.without_comments_and_strings(text)
        yield from find(r"\b(sleep_for|sleep_until|usleep|nanosleep|sleep)\s*\(", path, code, "{}")


def pragma_once(tree):
    """A header starts with #pragma once; licences and comments may come before."""
    for path, text in sources(tree, lambda path: path.endswith(".h")):
        if not cxx.without_comments(text).lstrip().startswith("#pragma once"):
            yield Violation(path, 1, "no #pragma once")


def include_root(tree):
    """Quoted includes are relative to the root of the repository."""
    for path, text in sources(tree, is_cxx):
        for number, included, is_quoted in cxx.includes(text):
            known = ("core/", "server/", "client/", "proto/", "tests/", "pliant/v1/")
            if is_quoted and not included.startswith(known):
                yield Violation(path, number, f'"{included}" does not start at the root')


def proto_comments(tree):
    """Every element of the protocol has a comment above it, or behind it on its line."""
    element = re.compile(
        r"\s*(message|enum|service|rpc|oneof)\s+\w+|\s*((repeated|optional)\s+|map\s*<[^>]*>\s*)?"
        r"[\w.]*\s+\w+\s*=\s*-?\d+|\s*[A-Z][A-Z0-9_]*\s*=\s*-?\d+")
    for path, text in sources(tree, lambda path: path.endswith(".proto")):
        lines = text.split("\n")
        for number, line in enumerate(lines, 1):
            code, _, comment = line.partition("//")
            if not element.match(code) or comment:
                continue
            if not (number >= 2 and lines[number - 2].lstrip().startswith("//")):
                yield Violation(path, number, f"no comment: {code.strip()}")


def machine_path(tree):
    """No absolute path that exists on one machine only."""
    pattern = re.compile(r"""(?:^|[\s"'`=(])/([A-Za-z]\w*)/[\w.]""")
    for path, text in sorted(tree.items()):
        if path.startswith("tests/data/") or not (is_source(path) or path.endswith(".md")):
            continue
        for number, line in enumerate(text.split("\n"), 1):
            for match in pattern.finditer(line):
                if match.group(1) not in COMMON_PATHS:
                    yield Violation(path, number, f"/{match.group(1)}/ is a path of one machine")


def root(tree):
    """The top level holds what it holds, and nothing else."""
    for path in sorted(tree):
        top = path.split("/")[0]
        if top not in ROOT and not top.startswith("."):
            yield Violation(path, 1, f"{top} does not belong at the top level")


def readme(tree):
    """Each folder of the top level says what it holds."""
    for folder in sorted({path.split("/")[0] for path in tree if "/" in path}):
        if folder in ROOT and f"{folder}/README.md" not in tree:
            yield Violation(f"{folder}/README.md", 1, "is missing")


RULES = {rule.__name__.replace("_", "-"): rule for rule in (
    function_length, file_length, line_length, test_file, core_layers, core_includes,
    client_layers, wire_and_core, libm, no_exit, no_assert, no_todo, no_sleep, pragma_once,
    include_root, proto_comments, machine_path, root, readme)}
