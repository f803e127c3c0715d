"""Just enough of the lexical grammar of C++ to find functions, includes and calls."""

import re

_TOKEN = re.compile(
    r"""(?P<line>//[^\n]*)
      | (?P<block>/\*.*?\*/)
      | (?P<raw>R"(?P<delimiter>[^()\\\s]{0,16})\(.*?\)(?P=delimiter)")
      | (?P<string>"(?:\\.|[^"\\\n])*")
      | (?P<number>\b\d[\w.']*)
      | (?P<char>'(?:\\.|[^'\\\n])*')""",
    re.VERBOSE | re.DOTALL,
)


def _blank(text):
    return re.sub(r"[^\n]", " ", text)


def without_comments(text):
    """`text` with comments blanked out; every other character stays in its place."""

    def replace(match):
        is_comment = match.lastgroup in ("line", "block")
        return _blank(match.group()) if is_comment else match.group()

    return _TOKEN.sub(replace, text)


def without_comments_and_strings(text):
    """As without_comments, and the inside of string and character literals blanked out too."""

    def replace(match):
        kind = match.lastgroup
        if kind in ("line", "block"):
            return _blank(match.group())
        if kind == "number":
            return match.group().replace("'", "0")
        quote = '"' if kind in ("raw", "delimiter", "string") else "'"
        return quote + _blank(match.group()[1:-1]) + quote

    return _TOKEN.sub(replace, text)


def includes(text):
    """Yields (line number, path, is_quoted) for each #include."""
    for number, line in enumerate(without_comments(text).split("\n"), 1):
        match = re.match(r'\s*#\s*include\s*(?:"([^"]+)"|<([^>]+)>)', line)
        if match:
            yield number, match.group(1) or match.group(2), match.group(1) is not None


def function_spans(text):
    """Yields (first line, last line) of each function body at namespace or class scope.

    Lambdas and blocks inside a function belong to it. A span starts where the declaration does.
    """
    code = _without_preprocessor(without_comments_and_strings(text))
    open_blocks = []  # (kind, first line): kind is "scope", "function" or "inner".
    header_start = 0
    parentheses = 0
    for position, char in enumerate(code):
        in_function = any(kind != "scope" for kind, _ in open_blocks)
        if char == "(":
            parentheses += 1
        elif char == ")":
            parentheses -= 1
        elif char == "{":
            header = code[header_start:position]
            kind = "inner" if in_function or parentheses > 0 else _kind_of_block(header)
            first = header_start + len(header) - len(header.lstrip())
            open_blocks.append((kind, code.count("\n", 0, first) + 1))
            if kind in ("scope", "function"):
                header_start = position + 1
        elif char == "}" and open_blocks:
            kind, first_line = open_blocks.pop()
            if kind == "function":
                yield first_line, code.count("\n", 0, position) + 1
            if kind in ("scope", "function"):
                header_start = position + 1
        elif char == ";" and parentheses == 0 and not in_function:
            header_start = position + 1


def _kind_of_block(header):
    header = re.sub(r"\b(public|private|protected)\s*:(?!:)", " ", header)
    header = _without_template(header.strip()).strip()
    if re.match(r"(inline\s+)?(namespace|class|struct|union|extern)\b", header):
        return "scope" if "(" not in re.sub(r"\[\[.*?\]\]|alignas\s*\([^)]*\)", "", header) else (
            "function")
    return "function" if "(" in header and not header.startswith("enum") else "inner"


def _without_template(header):
    while header.startswith("template"):
        depth = 0
        for position, char in enumerate(header):
            depth += (char == "<") - (char == ">")
            if char == ">" and depth == 0:
                header = header[position + 1:].lstrip()
                break
        else:
            return header
    return header


def _without_preprocessor(code):
    return re.sub(r"^[ \t]*#(?:[^\n]*\\\n)*[^\n]*", lambda m: _blank(m.group()), code, flags=re.M)
