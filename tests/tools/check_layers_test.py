#!/usr/bin/env python3
"""Tests of check_layers.py: small houses with one defect each."""
import pathlib
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
import check_layers  # noqa: E402


def found_in(files):
    """The violations of a house made of `files`: path -> text."""
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        for path, text in files.items():
            (root / path).parent.mkdir(parents=True, exist_ok=True)
            (root / path).write_text(text)
        return list(check_layers.violations(root))


class Layers(unittest.TestCase):

    def expect_one(self, files, start, *parts):
        found = found_in(files)
        self.assertEqual(len(found), 1, found)
        self.assertTrue(found[0].startswith(start + ": "), found[0])
        for part in parts:
            self.assertIn(part, found[0])

    def test_accepts_includes_of_lower_layers_and_of_the_own_folder(self):
        self.assertEqual(found_in({
            "README.md": "",
            ".clang-format": "",
            "common/base/a.h": "#include <vector>\n",
            "common/geometry/mesh/b.h": '#include "common/base/a.h"\n#include <Eigen/Core>\n',
            "common/geometry/mesh/b.cc": '#include "common/geometry/mesh/b.h"\n',
            "tests/common/base/a_test.cc": '#include <sqlite3.h>\n#include "common/base/a.h"\n',
        }), [])

    def test_refuses_an_include_of_a_higher_layer_and_names_the_line(self):
        self.expect_one({"common/base/a.h": '#pragma once\n\n#include "common/jobs/ids.h"\n'},
                        "common/base/a.h:3", "common/base", "common/jobs/ids.h")

    def test_refuses_server_headers_in_worker_and_client(self):
        for folder in ("worker", "client"):
            self.expect_one({f"{folder}/a.cc": '#include "server/core/c.h"\n'},
                            f"{folder}/a.cc:1", f"{folder} must not include")

    def test_lets_the_coordinator_include_everything_below_it(self):
        self.assertEqual(found_in({"server/core/a.cc": "".join(
            f'#include "{name}/x.h"\n' for name in
            ("common/rpc", "common/report", "server/catalog", "server/planning",
             "server/scheduling", "server/results"))}), [])

    def test_refuses_the_coordinator_to_include_its_skins(self):
        self.expect_one({"server/core/a.cc": '#include "server/services/s.h"\n'},
                        "server/core/a.cc:1")

    def test_refuses_tests_in_production_code(self):
        self.expect_one({"client/a.cc": '#include "tests/testing/status_matchers.h"\n'},
                        "client/a.cc:1")

    def test_refuses_an_include_that_is_relative_to_the_file(self):
        self.expect_one({"client/a.cc": '#include "b.h"\n', "client/b.h": ""}, "client/a.cc:1")
        self.expect_one({"client/a.cc": '#include "../common/base/b.h"\n'}, "client/a.cc:1")

    def test_keeps_protobuf_where_messages_are_converted(self):
        line = '#include "cohort/v1/job.pb.h"\n'
        self.assertEqual(found_in({path: line for path in (
            "common/rpc/a.cc", "server/services/a.cc", "server/main.cc", "worker/a.cc",
            "client/a.cc", "tests/common/rpc/a_test.cc")}), [])
        for folder in ("server/core", "common/jobs", "server/planning"):
            self.expect_one({f"{folder}/a.h": line}, f"{folder}/a.h:1", "job.pb.h")

    def test_keeps_each_library_in_its_one_folder(self):
        homes = {"sqlite3.h": "server/catalog", "soci/soci.h": "server/catalog",
                 "nanoflann.hpp": "common/geometry/nearest",
                 "draco/mesh/mesh.h": "common/geometry/io", "cairo.h": "common/report",
                 "pugixml.hpp": "common/geometry/io", "zstd.h": "common/geometry/comparison",
                 "cairo/cairo.h": "common/report"}
        for header, place in homes.items():
            line = f"#include <{header}>\n"
            self.assertEqual(found_in({f"{place}/a.cc": line}), [])
            self.expect_one({"server/core/a.cc": line}, "server/core/a.cc:1", header, place)

    def test_keeps_clock_threads_and_disk_out_of_what_computes_and_decides(self):
        for header in ("thread", "chrono", "fstream"):
            for folder in ("common/geometry/mesh", "common/analysis", "server/planning"):
                self.expect_one({f"{folder}/a.cc": f"#  include <{header}>\n"},
                                f"{folder}/a.cc:1", header)

    def test_refuses_an_unknown_name_at_the_top(self):
        self.expect_one({"scripts/x.sh": ""}, "scripts:1")

    def test_ignores_the_build_folder(self):
        self.assertEqual(found_in({"build/release/x.pb.h": ""}), [])

    def test_refuses_a_source_in_a_folder_without_a_rule(self):
        self.expect_one({"common/misc/a.cc": ""}, "common/misc/a.cc:1", "no rule")

    def test_refuses_other_suffixes(self):
        self.expect_one({"client/a.cpp": ""}, "client/a.cpp:1")

    def test_refuses_a_cycle_inside_one_layer(self):
        found = found_in({"worker/a/x.h": '#include "worker/b/y.h"\n',
                          "worker/b/y.h": '\n#include "worker/c/z.h"\n',
                          "worker/c/z.h": '#include "worker/a/x.h"\n',
                          "worker/main.cc": '#include "worker/a/x.h"\n'})
        self.assertEqual([line.split(": ")[0] for line in found],
                         ["worker/a/x.h:1", "worker/b/y.h:2", "worker/c/z.h:1"])

    def test_lets_a_program_and_its_subfolders_include_each_other(self):
        self.assertEqual(found_in({"client/main.cc": '#include "client/commands/run.h"\n',
                                   "client/session.h": "",
                                   "client/commands/run.h": '#include "client/session.h"\n'}), [])

    def test_has_a_table_without_cycles(self):
        edges = {(folder, lower): folder
                 for folder, allowed in check_layers.ALLOWED.items()
                 for name in allowed
                 for lower in check_layers.ALLOWED
                 if check_layers.under(lower, name) and lower != folder}
        self.assertEqual(list(check_layers.cycles(edges)), [])


if __name__ == "__main__":
    unittest.main()
