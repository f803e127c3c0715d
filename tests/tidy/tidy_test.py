"""Goal: each rule finds what it forbids, where it is, and lets what it allows pass.

Method: for every rule, small trees with exactly one violation, and look-alikes with none.
"""

import unittest

import cxx
import rules
import tidy

HEADER = "#pragma once\n"
LEFT_TO_DO = "TO" + "DO"  # In two parts, so that the rule does not find it here.

# rule -> (file, text, line of the violation, other files of the tree)
VIOLATIONS = {
    "function-length": [
        ("core/mesh/a.cc", "int F(int x) {\n" + "  ++x;\n" * 69 + "}\n", 1, {}),
        ("core/mesh/a.cc", "namespace {\nclass A {\n public:\n  A() : b_{1}, c_(2) {}\n"
         "  template <class T>\n  int F(T x) const noexcept {\n" + "  ++x;\n" * 70 + "}\n};\n}\n",
         5, {}),
        ("tests/support/a.py", "x = 1\ndef f():\n" + "    g()\n" * 70, 2, {}),
    ],
    "file-length": [("server/a.h", HEADER + "\n" * 500, 501, {})],
    "line-length": [("server/a.h", HEADER + "// " + "a" * 98 + "\n", 2, {})],
    "test-file": [
        ("core/mesh/a.cc", "", 1, {"core/mesh/a.h": HEADER}),
        ("client/cpp/a.cc", "", 1, {"client/cpp/a.h": HEADER, "tests/client/b_test.cc": ""}),
    ],
    "core-layers": [
        ("core/geometry/a.cc", '\n#include "core/metric/metric.h"\n', 2, {}),
        ("core/solver/a.cc", "", 1, {}),
    ],
    "core-includes": [
        ("core/mesh/a.cc", "#include <iostream>\n", 1, {}),
        ("core/mesh/a.cc", "#include <grpcpp/grpcpp.h>\n", 1, {}),
        ("core/mesh/a.cc", '#include "pliant/v1/pliant.pb.h"\n', 1, {}),
    ],
    "client-layers": [("client/cpp/a.cc", '#include "server/session.h"\n', 1, {})],
    "wire-and-core": [
        ("server/service.cc",
         '#include "pliant/v1/pliant.pb.h"\n#include "core/mesh/mesh.h"\n', 2, {}),
    ],
    "libm": [
        ("core/mesh/a.cc", "double F(double x) {\n  return std::exp(x);\n}\n", 2, {}),
        ("core/mesh/a.cc", "double F(double x) { return hypot(x, 1.0); }\n", 1, {}),
    ],
    "no-exit": [
        ("server/a.cc", "void F() { std::abort(); }\n", 1, {}),
        ("client/cli/a.cc", "void F() {\n\n  exit(1);\n}\n", 3, {}),
    ],
    "no-assert": [
        ("core/mesh/a.cc", "void F(int x) { assert(x > 0); }\n", 1, {}),
        ("core/mesh/a.cc", "#include <cassert>\n", 1, {}),
    ],
    "no-todo": [("server/a.cc", f"\n// {LEFT_TO_DO}: finish this.\n", 2, {})],
    "no-sleep": [
        ("tests/server/a_test.cc", "void F() { std::this_thread::sleep_for(1s); }\n", 1, {}),
    ],
    "pragma-once": [("core/mesh/a.h", "/// A file.\n#ifndef A\n#define A\n#endif\n", 1, {})],
    "include-root": [("core/mesh/a.cc", '#include "a.h"\n', 1, {})],
    "proto-comments": [
        ("proto/pliant/v1/a.proto", "// A.\nmessage A {\n  int32 x = 1;\n}\n", 3, {}),
        ("proto/pliant/v1/a.proto", "message A {\n}\n", 1, {}),
        ("proto/pliant/v1/a.proto", "// E.\nenum E {\n  E_UNSPECIFIED = 0;\n}\n", 3, {}),
        ("proto/pliant/v1/a.proto", "// S.\nservice S {\n  rpc F(A) returns (B);\n}\n", 3, {}),
        ("proto/pliant/v1/a.proto", "// A.\nmessage A {\n  map<string, int32> m = 1;\n}\n", 3, {}),
    ],
    "machine-path": [("tests/run", "cd /some" "where/main\n", 1, {})],
    "root": [("notes.txt", "", 1, {})],
    "readme": [("core/README.md", None, 1, {"core/mesh/a.h": HEADER})],
}

# rule -> trees without a violation of it
CLEAN = {
    "function-length": [
        {"core/mesh/a.cc": "int F(int x) {\n" + "  ++x;\n" * 68 + "}\n"},
        {"core/mesh/a.cc": "constexpr int kTable[] = {\n" + "  1,\n" * 90 + "};\n"},
        {"core/mesh/a.cc": "void F(Options o = {}, char c = '{');\nvoid G() {\n}\n" * 40},
        {"core/mesh/a.cc": 'const char* k = R"({{{)";\n' + "void F() {\n}\n" * 40},
    ],
    "test-file": [
        {"core/mesh/a.cc": "", "core/mesh/a.h": HEADER, "tests/core/mesh/a_test.cc": ""},
        {"client/cpp/a.cc": "", "client/cpp/a.h": HEADER, "tests/client/a_test.cc": ""},
        {"server/main.cc": ""},
    ],
    "core-layers": [{"core/mesh/a.cc": '#include "core/mesh/a.h"\n#include "core/base/b.h"\n'}],
    "core-includes": [{"core/mesh/a.cc": "#include <vector>\n// #include <iostream>\n"}],
    "wire-and-core": [
        {"server/convert_array.cc": '#include "pliant/v1/a.pb.h"\n#include "core/mesh/mesh.h"\n'},
        {"server/service.cc": '#include "pliant/v1/a.pb.h"\n#include "core/base/result.h"\n'},
    ],
    "libm": [
        {"core/base/math.cc": "double F(double x) { return std::exp(x); }\n"},
        {"core/mesh/a.cc": "// std::exp(x)\ndouble F(double x) { return std::sqrt(x) * Exp(x); }"},
        {"core/mesh/a.cc": "double F(const A& a) { return a.log() + a->exp() + A::pow(); }\n"},
        {"core/mesh/a.h": HEADER + "struct A {\n  const Log& log() const { return log_; }\n};\n"},
    ],
    "no-exit": [{"server/a.cc": "void F() { OnExit(1); loop.exit(); }\n"}],
    "no-assert": [{"core/mesh/a.cc": "static_assert(sizeof(int) == 4);\n"}],
    "include-root": [{"core/mesh/a.cc": '#include "core/mesh/a.h"\n#include <a.h>\n'}],
    "proto-comments": [
        {"proto/a.proto": 'syntax = "proto3";\noption go_package = "a";\n// A.\nmessage A {\n'
                          "  reserved 3;\n  int32 x = 1;  // Its x.\n\n  // Its y.\n"
                          "  repeated double y = 2;\n}\n"},
    ],
    "machine-path": [
        {"tests/run": '#!/bin/bash\n#!/usr/bin/env python3\ncurl "http://host/a/b"\na/b/c $x/y'},
    ],
    "root": [{"CMakeLists.txt": "", ".clang-tidy": "", "core/README.md": ""}],
    "pragma-once": [{"core/mesh/a.h": "// Why.\n#pragma once\n"}],
}


def found(rule, tree):
    return [(violation.path, violation.line) for violation in rules.RULES[rule](tree)]


class Rules(unittest.TestCase):
    def test_each_rule_finds_its_violation_and_nothing_else(self):
        self.assertEqual(set(VIOLATIONS), set(rules.RULES))
        for rule, cases in VIOLATIONS.items():
            for path, text, line, others in cases:
                tree = dict(others) if text is None else {**others, path: text}
                with self.subTest(rule=rule, text=text):
                    self.assertEqual(found(rule, tree), [(path, line)])

    def test_look_alikes_pass(self):
        for rule, trees in CLEAN.items():
            for tree in trees:
                with self.subTest(rule=rule, tree=tree):
                    self.assertEqual(found(rule, tree), [])


class Check(unittest.TestCase):
    TREE = {"server/a.cc": "void F() { exit(1); }\n", "server/README.md": ""}
    EXCEPTION = "no-exit server/a.cc: the example of the test\n"

    def test_a_violation_is_named_with_file_line_and_rule(self):
        self.assertEqual(tidy.check(self.TREE), [
            "server/a.cc:1: no-exit: exit( ends the process; return an Error"])

    def test_an_exception_with_a_reason_is_accepted(self):
        tree = {**self.TREE, tidy.EXCEPTIONS: self.EXCEPTION, "tests/README.md": ""}
        self.assertEqual(tidy.check(tree), [])

    def test_an_exception_without_a_reason_is_a_violation(self):
        tree = {tidy.EXCEPTIONS: "no-exit server/a.cc:\n", "tests/README.md": ""}
        self.assertEqual(len(tidy.check(tree)), 1)

    def test_an_exception_that_nothing_needs_is_a_violation(self):
        tree = {tidy.EXCEPTIONS: "# Why.\n" + self.EXCEPTION, "tests/README.md": ""}
        self.assertEqual(tidy.check(tree), [
            f"{tidy.EXCEPTIONS}:2: exceptions: no longer needed: no-exit server/a.cc"])


class Cxx(unittest.TestCase):
    def test_blanking_keeps_every_position(self):
        text = 'int a = 1\'000; // "x"\nchar c = \'"\'; /* \n */ auto s = "// \\" {";\n'
        code = cxx.without_comments_and_strings(text)
        self.assertEqual(len(code), len(text))
        self.assertEqual(code.count("\n"), text.count("\n"))
        self.assertNotIn("{", code)
        self.assertIn("auto s =", code)

    def test_spans_of_all_kinds_of_functions(self):
        text = ("namespace a::b {\n"                       # 1
                "template <class T, int (*F)(int) = G>\n"  # 2
                "struct S : Base<T> {\n"                   # 3
                "  explicit S(int x) : x_(x) {}\n"         # 4
                "  auto operator()(int y) -> int {\n"      # 5
                "    if (y) { return 1; }\n"               # 6
                "  }\n"                                    # 7
                "  enum class E { kA, kB };\n"             # 8
                "};\n"                                     # 9
                "#define M(x) { x\n"                       # 10
                "TEST(S, Works) {\n"                       # 11
                "}\n"                                      # 12
                "}\n")
        self.assertEqual(list(cxx.function_spans(text)), [(4, 4), (5, 7), (11, 12)])


if __name__ == "__main__":
    unittest.main()
