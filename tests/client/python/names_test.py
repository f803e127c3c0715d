"""client/README.md says which operations are the same in C++ and Python: all of them are there, and
none is missing in the table."""

import inspect
import pathlib
import re

import pliant

ROOT = pathlib.Path(__file__).resolve().parents[3]
# Not for users, or no operation.
CPP_OTHERS = {"Client": {"address", "server_info", "GetMesh", "GetQuality"},
              "Session": {"id", "SetAnswers"}, "Subscription": {"replica"}}
PYTHON_OTHERS = {"Client": {"close"},
                 "Session": {"close", "start", "field", "field_names", "session_id", "revision"},
                 "Subscription": {"mesh", "revision"}}


def rows():
    text = (ROOT / "client/README.md").read_text(encoding="utf-8")
    found = re.findall(r"^\| (?:`([\w:]+)`)? ?\| (?:`([\w.()=]+)`)? ?\|", text, re.MULTILINE)
    found = [row for row in found if "::" in row[0] or row[1]]
    assert len(found) > 40
    return found


def header_of(name):
    folder = ROOT / "client/cpp"
    files = {"Client": "client.h", "Session": "session.h", "Subscription": "subscription.h"}
    return (folder / files.get(name, "types.h")).read_text(encoding="utf-8")


def class_body(name):
    text = re.search(rf"^(?:class|struct) {name} \{{\n(.*?)^\}};", header_of(name),
                     re.MULTILINE | re.DOTALL).group(1)
    return re.sub(r"//.*", "", text)


def test_what_the_table_names_exists():
    for cpp, python in rows():
        if cpp:
            owner, name = cpp.split("::")
            assert re.search(rf"\b{name}\b", class_body(owner)), cpp
        if python:
            path, _, argument = python.rstrip("=)").partition("(")
            thing = pliant
            for part in path.split("."):
                thing = getattr(thing, part)
            assert not argument or argument in inspect.signature(thing).parameters, python


def test_the_table_names_every_operation():
    named = {name for row in rows() for name in row}
    for owner, others in CPP_OTHERS.items():
        body = class_body(owner).split(" private:")[0]
        methods = set(re.findall(r"^  [^\n(]*?\b([A-Z]\w*)\(", body, re.MULTILINE))
        for name in methods - others - {owner}:
            assert f"{owner}::{name}" in named, f"{owner}::{name}"
    for owner, others in PYTHON_OTHERS.items():
        for name in dir(getattr(pliant, owner)):
            if not name.startswith("_") and name not in others:
                assert f"{owner}.{name}" in named, f"{owner}.{name}"
