"""The statistics of a matrix, from the command line to the files: analyze and mantel."""
import csv
import json
import pathlib
import shutil
import subprocess
import unittest

from cohort_e2e import ProgramTest, cohort, read_matrix

EXAMPLES = pathlib.Path(__file__).resolve().parents[2] / "deploy" / "examples"
TABLES = ["neighbours.csv", "clusters.csv", "merges.csv", "dendrogram.newick", "pcoa.csv",
          "pcoa_eigenvalues.csv", "outliers.csv", "groups.csv", "permanova.csv",
          "identification.csv", "cmc.csv", "roc.csv", "scores_genuine.txt", "scores_impostor.txt"]


class Analysis(ProgramTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.results = cls.base / "results"
        for method, out in (("average", cls.results), ("one", cls.base / "one")):
            made = cohort("run", cls.demo, "--out", out, "--method", method, "--labels",
                          cls.demo / "labels.csv")
            assert made.returncode == 0, made.stderr

    def rows(self, name, folder=None):
        with open((folder or self.dir / "out") / name, newline="") as file:
            return list(csv.DictReader(file))

    def analyze(self, *arguments, source=None):
        result = cohort("analyze", source or self.results, *arguments)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(result.stderr, "")
        return result.stdout

    def test_analyze_writes_every_table(self):
        text = self.analyze("--by", "person", "--clusters", 4, "--out", self.dir / "out")
        for line in ("clusters:", "pcoa:", "permanova:", "outliers:", "identification:"):
            self.assertIn(line, text)
        self.assertEqual(sorted(path.name for path in (self.dir / "out").iterdir()),
                         sorted([*TABLES, "analysis.json"]))
        labels, values = read_matrix(self.results)
        # Each table against the matrix it was made from.
        nearest = [row for row in self.rows("neighbours.csv") if row["rank"] == "1"]
        for row, distances in zip(nearest, values):
            others = [value for value in distances if value > 0]
            self.assertEqual(float(row["value"]), min(others))
        merges = self.rows("merges.csv")
        self.assertEqual(len(merges), len(labels) - 1)
        self.assertEqual(float(merges[0]["height"]),
                         min(value for row in values for value in row if value > 0))
        clusters = self.rows("clusters.csv")
        self.assertEqual({row["cluster"] for row in clusters}, {"1", "2", "3", "4"})
        self.assertEqual(sorted(int(row["position"]) for row in clusters), list(range(1, 9)))
        newick = (self.dir / "out" / "dendrogram.newick").read_text()
        self.assertTrue(newick.endswith(";\n") and all(label in newick for label in labels))
        # All axes of a matrix give its distances back, if no eigenvalue is negative.
        pcoa = [[float(row[f"axis{axis}"]) for axis in range(1, 8)] for row in
                self.rows("pcoa.csv")]
        distance = sum((x - y) ** 2 for x, y in zip(pcoa[0], pcoa[5])) ** 0.5
        self.assertAlmostEqual(distance, values[0][5], places=9)
        permanova = {row["term"]: row for row in self.rows("permanova.csv")}
        self.assertEqual(permanova["person"]["df"], "3")
        total = sum(value ** 2 for row in values for value in row) / 2 / len(labels)
        self.assertAlmostEqual(float(permanova["total"]["sum_of_squares"]), total, places=9)
        self.assertEqual(self.rows("groups.csv")[0]["pairs"], "4")
        self.assertEqual(len(self.rows("outliers.csv")), 8)
        self.assertNotEqual(self.rows("outliers.csv")[0]["residual"], "NA")
        self.assertEqual({row["rank"] for row in self.rows("identification.csv")}, {"1"})
        self.assertEqual(self.rows("cmc.csv")[0]["share"], "1")
        self.assertEqual(self.rows("roc.csv")[-1]["false_accept_rate"], "1")
        genuine = (self.dir / "out" / "scores_genuine.txt").read_text().split()
        impostor = (self.dir / "out" / "scores_impostor.txt").read_text().split()
        self.assertEqual((len(genuine), len(impostor)), (4, 24))

    def test_analyze_has_the_same_bytes_again(self):
        for name in ("out", "again"):
            self.analyze("--by", "person", "--seed", 5, "--out", self.dir / name)
        for name in TABLES:
            self.assertEqual((self.dir / "out" / name).read_bytes(),
                             (self.dir / "again" / name).read_bytes(), name)

    def test_analyze_says_the_same_of_a_folder_a_file_and_a_server(self):
        _, (address,) = self.start_server("127.0.0.1:0")
        self.start("cohort-worker", "--server", address, "--threads", 2)
        cohort("add", self.demo, "--set", "demo", "--labels", self.demo / "labels.csv",
               "--server", address)
        cohort("submit", "--set", "demo", "--wait", "--server", address)
        of_folder, of_file, of_job = (
            json.loads(self.analyze("--by", "person", "--json", *more, source=source))
            for source, more in ((self.results, []),
                                 (self.results / "matrix.csv",
                                  ["--labels", self.demo / "labels.csv"]),
                                 ("j-000001", ["--server", address])))
        self.assertEqual(of_folder["groups"], of_job["groups"])
        self.assertEqual(of_folder["groups"], of_file["groups"])
        self.assertEqual(of_folder["outliers"], of_job["outliers"])
        self.assertEqual(of_folder["identification"]["equal_error_rate"], 0)
        self.assertEqual(of_job["metric"], "rms")
        self.assertIsNone(of_file["metric"])
        p75 = json.loads(self.analyze("--metric", "p75", "--json", "--server", address,
                                      source="j-000001"))
        self.assertEqual(p75["metric"], "p75")
        self.assertNotEqual(p75["clusters"]["lowest"], of_job["clusters"]["lowest"])

    def test_analyze_takes_away_what_an_earlier_one_left(self):
        self.analyze("--by", "person", "--out", self.dir / "out")
        self.analyze("--out", self.dir / "out", source=self.results / "matrix.csv")
        left = {path.name for path in (self.dir / "out").iterdir()}
        self.assertFalse(left & {"groups.csv", "permanova.csv", "roc.csv", "scores_genuine.txt"})

    def test_analyze_that_cannot_be(self):
        def check(code, *words, source=self.results, more=()):
            self.check_error(cohort("analyze", source, *more), code, *words)
        check(2, "no mesh of", "'sex'", "capture, expression, person", more=("--by", "sex"))
        check(2, "--neighbours -1", more=("--neighbours", -1))
        check(2, "--linkage upgma", more=("--linkage", "upgma"))
        check(2, "is a results folder", more=("--out", self.results))
        check(7, "no such folder", source=self.dir / "gone")
        check(6, "127.0.0.1:1", source="j-000001", more=("--server", "127.0.0.1:1"))
        one = self.dir / "one.csv"
        one.write_text("file,team\n" + "".join(f"{row['file']},x\n" for row in
                                              self.rows("labels.csv", self.demo)))
        check(2, "groups by team", "one group, x", more=("--labels", one, "--by", "team"))
        two = self.dir / "two.csv"
        two.write_text(",a,b\na,0,1\nb,1,0\n")
        check(2, "two.csv", "2 meshes, at least 3", source=two)
        directed = self.dir / "directed.csv"
        directed.write_text(",a,b,c\na,0,1,2\nb,9,0,3\nc,2,3,0\n")
        check(2, "directed.csv", "not symmetric", "b, a is 9", "--symmetrize", source=directed)

    def test_mantel_of_two_methods(self):
        result = cohort("mantel", self.results, self.base / "one", "--json", "--permutations", 999,
                        "--closer-to", self.results)
        self.assertEqual(result.returncode, 0, result.stderr)
        answer = json.loads(result.stdout)
        _, a = read_matrix(self.results)
        _, b = read_matrix(self.base / "one")
        x = [a[i][j] for i in range(8) for j in range(i)]
        y = [b[i][j] for i in range(8) for j in range(i)]
        mean_x, mean_y = sum(x) / len(x), sum(y) / len(y)
        r = sum((u - mean_x) * (v - mean_y) for u, v in zip(x, y)) / (
            sum((u - mean_x) ** 2 for u in x) * sum((v - mean_y) ** 2 for v in y)) ** 0.5
        self.assertAlmostEqual(answer["r"], r, places=12)
        self.assertEqual(answer["p"], (1 + answer["as_extreme"]) / 1000)
        self.assertEqual(answer["neighbours"]["wanted"], 24)
        self.assertEqual(answer["closer"]["b"], 0)
        again = cohort("mantel", self.results, self.base / "one", "--permutations", 999)
        self.assertIn(f"r = {r:.4f}", again.stdout)
        self.assertIn("nearest mesh is the same", again.stdout)

    def test_the_vignettes_of_r_and_python_find_the_same(self):
        answer = json.loads(cohort("mantel", self.results, self.base / "one", "--permutations", 999,
                                   "--json").stdout)
        run = 0
        for program, script, needs in (
                ("/usr/bin/python3", "mantel.py", ["-c", "import numpy"]),
                ("Rscript", "mantel.R", ["-e", "1"])):
            if shutil.which(program) is None or subprocess.run(
                    [program, *needs], capture_output=True, check=False).returncode != 0:
                continue
            told = subprocess.run([program, EXAMPLES / script, self.results, self.base / "one",
                                   "999"], capture_output=True, text=True, check=False)
            self.assertEqual(told.returncode, 0, told.stderr)
            values = dict(line.split() for line in told.stdout.splitlines())
            self.assertAlmostEqual(float(values["r"]), answer["r"], places=12)
            # Three standard errors of two independent estimates of p.
            error = 3 * (2 * answer["p"] * (1 - answer["p"]) / 999) ** 0.5
            self.assertLess(abs(float(values["p"]) - answer["p"]), error + 2 / 1000)
            run += 1
        if run == 0:
            self.skipTest("neither numpy nor R is installed")

    def test_mantel_that_cannot_be(self):
        some = self.dir / "some.csv"
        some.write_text(",a,b,c\na,0,1,2\nb,1,0,3\nc,2,3,0\n")
        self.check_error(cohort("mantel", self.results, some), 2, "8 meshes of", "are not in",
                         "person01_a.ply", "--common")
        constant = self.dir / "constant.csv"
        constant.write_text(",a,b,c\na,0,2,2\nb,2,0,2\nc,2,2,0\n")
        self.check_error(cohort("mantel", some, constant), 1, "constant.csv",
                         "every pair is 2")
        self.check_error(cohort("mantel", some, some, "--neighbours", -1), 2, "--neighbours -1")
        self.check_error(cohort("mantel", some, some, "--permutations", 0), 2, "permutations: 0")
        self.check_error(cohort("mantel", some, self.results, "--common"), 2, "0 meshes are in all")
        self.check_error(cohort("mantel", some, some, "--partial", some), 1,
                         "nothing is left")

    def test_help_has_an_example(self):
        for command in ("analyze", "mantel"):
            result = cohort(command, "--help")
            self.assertEqual(result.returncode, 0)
            self.assertIn(f"cohort {command} ", result.stdout.split("Examples:")[1])


if __name__ == "__main__":
    unittest.main()
