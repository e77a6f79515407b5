"""The preset fidentis with the real programs, as a user runs it."""
import csv
import json
import math
import pathlib
import shutil
import tempfile
import unittest

from cohort_e2e import RESULT_FILES, SHARED, cohort, contents, read_matrix

PRESET = ("--preset", "fidentis")


class FidentisEndToEnd(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.base = pathlib.Path(tempfile.mkdtemp(prefix="cohort-fidentis-"))
        cls.demo = cls.base / "demo"
        made = cohort("demo", "--out", cls.demo, "--vertices", 600)
        assert made.returncode == 0, made.stderr

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.base, ignore_errors=True)

    def setUp(self):
        self.dir = pathlib.Path(tempfile.mkdtemp(dir=self.base))

    def run_job(self, folder, out, *arguments):
        result = cohort("run", folder, "--out", out, *PRESET, *arguments)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        return result

    def test_results_do_not_depend_on_workers_and_threads(self):
        for method in ("average", "one", "each"):
            with self.subTest(method=method):
                one, three = self.dir / (method + "1"), self.dir / (method + "3")
                result = self.run_job(self.demo, one, "--method", method, "--workers", 1,
                                      "--threads", 1)
                self.assertIn("note: preset fidentis: the numbers of FIDENTIS Analyst",
                              result.stdout)
                self.run_job(self.demo, three, "--method", method, "--workers", 3, "--threads", 2)
                first, second = contents(one), contents(three)
                for name in RESULT_FILES:
                    self.assertEqual(first[name], second[name], name)
                job = json.loads((one / "job.json").read_text())
                self.assertEqual(job["parameters"]["arithmetic"], "fidentis")
                self.assertEqual(job["parameters"]["position_bits"], 0)
                self.assertEqual(len(job["notes"]), 1)

    def test_signed_distances_have_no_nearest_mesh(self):
        out = self.dir / "out"
        self.run_job(self.demo, out, "--method", "one")
        self.assertTrue((out / "neighbours.csv").exists())
        result = self.run_job(self.demo, out, "--method", "one", "--signed", "--metric", "min",
                              "--labels", self.demo / "labels.csv")
        self.assertIn("neighbours.csv is left out", result.stdout)
        self.assertNotIn("nearest mesh", result.stdout)
        self.assertFalse((out / "neighbours.csv").exists(), "of the job before")
        job = json.loads((out / "job.json").read_text())
        self.assertNotIn("neighbours.csv", [file["name"] for file in job["files"]])
        _, values = read_matrix(out)
        self.assertLess(min(map(min, values)), 0)

    def test_what_the_predecessor_lacks_is_named(self):
        for arguments, words in ((("--pose", "principal-axes"), "pose is"),
                                 (("--scale", "symmetric"), "icp.scale is"),
                                 (("--base", "auto"), "base_rule is"),
                                 (("--trim", "0.1"), "icp.trimmed_share is"),
                                 (("--distance", "surface"), "compare.correspondence is"),
                                 (("--retention", "sketch"), "compare.retention is")):
            with self.subTest(arguments=arguments):
                result = cohort("run", self.demo, "--out", self.dir / "o", *PRESET, *arguments)
                self.assertEqual(result.returncode, 2, result.stderr)
                self.assertIn(words, result.stderr)
                self.assertIn("in the preset fidentis", result.stderr)
        result = cohort("run", self.demo, "--out", self.dir / "o", "--signed")
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertIn("preset fidentis", result.stderr)

    @unittest.skipUnless((SHARED / "golden").exists(), f"{SHARED}/golden is not there")
    def test_the_predecessors_own_matrices(self):
        """matrix.csv against what the predecessor exported; tests/worker/tasks has all metrics."""
        for study, meshes, method in (("scale/average", "meshes", "average"),
                                      ("scale/one", "meshes", "one"),
                                      ("scale/each", "meshes", "each"),
                                      ("vn/average", "meshes_vn", "average")):
            for file, options, tolerance in (
                    ("rms_absolute_symmetric.csv", (), 7e-6),
                    ("mean_signed_symmetric.csv", ("--signed", "--metric", "mean"), 5e-5)):
                with self.subTest(study=study, file=file):
                    self.check_golden(study, meshes, file, tolerance, "--method", method, *options)

    def check_golden(self, study, meshes, file, tolerance, *options):
        folder = SHARED / "golden" / meshes
        out = self.dir / "out"
        self.run_job(folder, out, "--workers", 2, *options)
        labels, values = read_matrix(out)
        self.assertEqual(labels, sorted(path.name for path in folder.glob("*.obj")))
        with open(SHARED / "golden" / "2016" / study / file) as table:
            golden = [[float(value) for value in row] for row in csv.reader(table)]
        for row, golden_row in zip(values, golden, strict=True):
            for value, expected in zip(row, golden_row, strict=True):
                self.assertTrue(math.isclose(value, expected, rel_tol=0, abs_tol=tolerance),
                                f"{value} for {expected}")


if __name__ == "__main__":
    unittest.main(verbosity=2)
