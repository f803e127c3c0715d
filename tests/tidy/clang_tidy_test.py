"""Goal: joining files for clang-tidy loses no fault and says where each one is.

Method: small files with and without a fault, in both orders, alone and where they cannot be joined.
"""

import pathlib
import shutil
import tempfile
import unittest

import clang_tidy

PROGRAM = shutil.which("clang-tidy-14") or "clang-tidy"
COMMAND = "c++ -std=c++20"
CLEAN = "namespace { int One() { return 1; } }\nint First() { return One(); }\n"


class WithFiles(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def write(self, name, text):
        path = pathlib.Path(self.folder.name, name)
        path.write_text(text)
        return path


class Groups(WithFiles):
    def test_joins_what_shares_a_command_line(self):
        a, b, c = (self.write(f"{name}.cc", "") for name in "abc")
        found = list(clang_tidy.groups([(a, "x"), (b, "y"), (c, "x")]))
        self.assertEqual(found, [[a, c], [b]])

    def test_leaves_no_source_out(self):
        sources = [(self.write(f"{i}.cc", ""), "x") for i in range(2 * clang_tidy.GROUP + 1)]
        found = list(clang_tidy.groups(sources))
        self.assertEqual([len(group) for group in found], [clang_tidy.GROUP] * 2 + [1])
        self.assertEqual(sorted(sum(found, [])), sorted(source for source, _ in sources))

    def test_parts_files_with_the_same_using_declaration(self):
        a, b = (self.write(f"{name}.cc", "using std::move;\n") for name in "ab")
        self.assertEqual(list(clang_tidy.groups([(a, "x"), (b, "x")])), [[a], [b]])


class Compiled(WithFiles):
    def test_is_a_file_itself_or_what_cmake_has_joined_in_it(self):
        a, b = (self.write(f"{name}.cc", "") for name in "ab")
        self.assertEqual(clang_tidy.compiled(a), [a.resolve()])
        joined = self.write("unity_core_0_cxx.cxx", f'#include "a.cc"\n#include "{b}"\n')
        self.assertEqual(clang_tidy.compiled(joined), [a.resolve(), b.resolve()])


class Complaints(WithFiles):
    def complaints(self, *sources):
        folder = pathlib.Path(self.folder.name)
        found = dict(clang_tidy.complaints(PROGRAM, folder, list(sources), COMMAND))
        self.assertEqual(set(found), set(sources))
        return found

    def test_says_nothing_of_clean_files(self):
        a = self.write("a.cc", CLEAN)
        b = self.write("b.cc", "int Second() { return 2; }\n")
        self.assertEqual(self.complaints(a, b), {a: "", b: ""})

    # misc-unused-using-decls looks at the main file alone, which each joined file has to count as.
    def test_finds_a_fault_in_each_place(self):
        fault = "#include <utility>\nusing std::move;\n"
        clean, faulty = self.write("a.cc", CLEAN), self.write("b.cc", fault)
        for order in ((clean, faulty), (faulty, clean)):
            found = self.complaints(*order)
            self.assertEqual(found[clean], "")
            self.assertIn("misc-unused-using-decls", found[faulty])
            self.assertIn(f"{faulty}:2:", found[faulty])

    def test_leaves_out_the_check_that_it_is_told_to(self):
        a = self.write("a.cc", "#include <utility>\nusing std::move;\n")
        folder = pathlib.Path(self.folder.name)
        [(_, found)] = clang_tidy.complaints(PROGRAM, folder, [a], COMMAND,
                                             without="misc-unused-using-decls")
        self.assertEqual(found, "")

    def test_looks_alone_at_what_cannot_stand_together(self):
        a, b = self.write("a.cc", CLEAN), self.write("b.cc", CLEAN.replace("First", "Second"))
        self.assertEqual(self.complaints(a, b), {a: "", b: ""})
        b.write_text(b.read_text() + "class Box { public: Box(int size); };\n")
        found = self.complaints(a, b)
        self.assertEqual(found[a], "")
        self.assertIn("google-explicit-constructor", found[b])


if __name__ == "__main__":
    unittest.main()
