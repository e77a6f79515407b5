#!/usr/bin/env python3
"""Tests of run_tidy.py: in which order it checks, and what makes it check again."""
import pathlib
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
import run_tidy  # noqa: E402

BUILD = pathlib.Path("/build")


def source(root, name, headers):
    entry = {"directory": str(BUILD), "file": str(root / name), "command": f"c++ -o {name}.o"}
    paths = [str(root / header) for header in headers] + ["/usr/include/stdio.h"]
    return run_tidy.Source(root, BUILD, entry, {f"{name}.o": paths})


def order_of(files, age):
    """The order of the sources in `files`: name -> headers."""
    root = pathlib.Path("/root")
    sources = {name: source(root, name, headers) for name, headers in files.items()}
    return [chosen.name for chosen in run_tidy.newest_first(sources, age)]


class NewestFirst(unittest.TestCase):

    def test_takes_sources_by_their_own_age_and_unknown_ones_last(self):
        files = {"a.cc": [], "b.cc": [], "c.cc": [], "d.cc": []}
        self.assertEqual(order_of(files, {"a.cc": 3, "b.cc": 0, "c.cc": 1}),
                         ["b.cc", "c.cc", "a.cc", "d.cc"])

    def test_shows_a_new_header_with_its_own_source(self):
        files = {"a.cc": ["x.h"], "b.cc": [], "x.cc": ["x.h", "y.h"]}
        self.assertEqual(order_of(files, {"x.h": 0, "y.h": 2, "b.cc": 1, "a.cc": 2, "x.cc": 2}),
                         ["x.cc", "b.cc", "a.cc"])

    def test_shows_a_new_header_without_a_source_with_the_fewest_others(self):
        files = {"a.cc": ["x.h", "y.h"], "b.cc": ["x.h"], "c.cc": []}
        self.assertEqual(order_of(files, {"x.h": 0, "y.h": 9, "a.cc": 9, "b.cc": 9, "c.cc": 1}),
                         ["b.cc", "c.cc", "a.cc"])

    def test_lets_a_new_source_show_its_new_headers(self):
        files = {"a.cc": ["x.h"], "b.cc": [], "x.cc": ["x.h"]}
        self.assertEqual(order_of(files, {"x.h": 0, "a.cc": 0, "b.cc": 1, "x.cc": 2}),
                         ["a.cc", "b.cc", "x.cc"])


class Key(unittest.TestCase):

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        for name in (".clang-tidy", "a.cc", "x.h", "tests/.clang-tidy", "tests/b.cc"):
            (self.root / name).parent.mkdir(exist_ok=True)
            (self.root / name).write_text(name)

    def changes_key_of(self, name, changed):
        checked = source(self.root, name, ["x.h"])
        before = checked.key(self.root, "14")
        (self.root / changed).write_text("changed")
        return checked.key(self.root, "14") != before

    def test_follows_the_source_and_its_headers(self):
        self.assertTrue(self.changes_key_of("a.cc", "a.cc"))
        self.assertTrue(self.changes_key_of("a.cc", "x.h"))
        self.assertFalse(self.changes_key_of("a.cc", "tests/b.cc"))

    def test_follows_the_rules_of_its_folders_only(self):
        self.assertTrue(self.changes_key_of("a.cc", ".clang-tidy"))
        self.assertTrue(self.changes_key_of("tests/b.cc", "tests/.clang-tidy"))
        self.assertFalse(self.changes_key_of("a.cc", "tests/.clang-tidy"))


if __name__ == "__main__":
    unittest.main()
