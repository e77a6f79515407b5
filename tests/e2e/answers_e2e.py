"""What is asked of a finished job: other measures, single pairs, unknown faces, proof."""
import csv
import json
import math
import shutil
import unittest

from cohort_e2e import ProgramTest, cohort, read_matrix

METRICS = ["rms", "mean", "geometric-mean", "min", "max", "variance", "p75"]


class Answers(ProgramTest):
    """Jobs of two retentions are made once and never changed by what is asked of them."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.jobs = {}
        for retention in ("vectors", "sketch"):
            out = cls.base / retention
            made = cohort("run", cls.demo, "--out", out, "--keep-data", "--rounds", 1, "--retention",
                          retention, "--labels", cls.demo / "labels.csv")
            assert made.returncode == 0, made.stdout + made.stderr
            cls.jobs[retention] = out

    def call(self, *arguments, code=0):
        result = cohort(*arguments)
        self.assertEqual(result.returncode, code, result.stdout + result.stderr)
        return result

    def remeasure(self, job, *arguments):
        """(matrix, remeasure.json, bytes of matrix.csv) of a new matrix."""
        out = self.dir / "again"
        shutil.rmtree(out, ignore_errors=True)
        answer = json.loads(self.call("remeasure", self.jobs[job], "--out", out, "--json",
                                      *arguments).stdout)
        self.assertEqual(json.loads((out / "remeasure.json").read_text()), answer)
        return read_matrix(out)[1], answer, (out / "matrix.csv").read_bytes()

    def test_every_metric_comes_again_byte_for_byte_from_vectors(self):
        first = (self.jobs["vectors"] / "matrix.csv").read_bytes()
        self.assertEqual(self.remeasure("vectors", "--source", "kept")[2], first)
        for metric in METRICS:
            wanted = self.remeasure("vectors", "--metric", metric)
            self.assertEqual(wanted[1]["source"], "metrics")
            for source in ("kept", "recompute"):
                _, answer, data = self.remeasure("vectors", "--metric", metric, "--source", source)
                self.assertEqual(data, wanted[2], (metric, source))
                self.assertEqual(answer["source"], source)
                self.assertEqual(answer["largest_error"], 0)

    def test_sketches_answer_within_the_error_they_state(self):
        for metric in METRICS + ["p5", "p50", "p95"]:
            for window in ([], ["--upper", 0.9], ["--lower", 0.1, "--upper", 0.8]):
                exact = self.remeasure("vectors", "--metric", metric, *window)[0]
                rough, answer, _ = self.remeasure("sketch", "--metric", metric, *window, "--source",
                                                  "kept")
                self.assertEqual(answer["retention"], "sketch")
                error = max(abs(a - b) for left, right in zip(exact, rough)
                            for a, b in zip(left, right))
                self.assertLessEqual(error, answer["largest_error"] + 1e-12, (metric, window))

    def test_what_was_not_kept_is_computed_again(self):
        for asked in (["--signed"], ["--by-area"]):
            _, answer, _ = self.remeasure("sketch", *asked)
            self.assertEqual(answer["source"], "recompute")
        by_area = self.remeasure("sketch", "--by-area")[2]
        _, answer, kept = self.remeasure("vectors", "--by-area")
        self.assertEqual(answer["source"], "kept")
        self.assertEqual(kept, by_area)
        refused = self.call("remeasure", self.jobs["sketch"], "--out", self.dir / "no", "--by-area",
                            "--source", "kept", code=1)
        self.assertIn("--source recompute", refused.stderr)

    def test_a_region_counts_alone(self):
        vertices = int(next(line.split()[2] for line in (self.jobs["vectors"] / "mean_shape.ply")
                            .read_bytes().split(b"end_header")[0].decode().splitlines()
                            if line.startswith("element vertex")))
        mask = self.dir / "mask.txt"
        mask.write_text("1\n" * vertices)
        everything = self.remeasure("vectors", "--region", mask)[0]
        plain = self.remeasure("vectors")[0]
        for left, right in zip(everything, plain):
            for a, b in zip(left, right):
                self.assertAlmostEqual(a, b, places=9)
        mask.write_text("1\n" * (vertices // 2) + "0\n" * (vertices - vertices // 2))
        kept, _, data = self.remeasure("vectors", "--region", mask)
        self.assertNotEqual(kept, plain)
        self.assertEqual(self.remeasure("vectors", "--region", mask, "--source", "recompute")[2],
                         data)
        mask.write_text("1\n")
        refused = self.call("remeasure", self.jobs["vectors"], "--out", self.dir / "no", "--region",
                            mask, code=2)
        self.assertIn(f"1 weights for the {vertices} vertices", refused.stderr)

    def test_a_pair_is_what_the_matrix_says(self):
        labels, _ = read_matrix(self.jobs["vectors"])
        out = self.dir / "pair"
        numbers = json.loads(self.call("pair", self.jobs["vectors"], labels[0], labels[3], "--out",
                                       out, "--json").stdout)
        for metric in METRICS:
            matrix = self.remeasure("vectors", "--metric", metric, "--symmetrize", "directed")[0]
            there, back = (side["metrics"][metric] for side in numbers["directions"])
            self.assertEqual((there, back), (matrix[0][3], matrix[3][0]))
        with open(out / "distances_a_to_b.csv", newline="") as file:
            distances = [float(row["distance"]) for row in csv.DictReader(file)]
        rms = math.sqrt(sum(d * d for d in distances) / len(distances))
        self.assertAlmostEqual(rms, numbers["directions"][0]["metrics"]["rms"], places=9)
        for name in ("distances_a_to_b.ply", "distances_b_to_a.ply", "distances_a_to_b.png",
                     "histogram.png", "pair.json"):
            self.assertGreater((out / name).stat().st_size, 100, name)

    def test_two_files_compare_as_a_job_of_two_does(self):
        files = sorted(self.demo.glob("*.ply"))[:2]
        folder = self.dir / "two"
        folder.mkdir()
        for file in files:
            shutil.copy(file, folder)
        self.run_job(folder, self.dir / "out", "--method", "one", "--base", files[1].name,
                     "--symmetrize", "directed")
        _, matrix = read_matrix(self.dir / "out")
        numbers = json.loads(self.call("compare", files[0], files[1], "--json").stdout)
        self.assertTrue(numbers["alignment"]["converged"])
        there, back = (side["metrics"]["rms"] for side in numbers["directions"])
        self.assertAlmostEqual(there, matrix[0][1], places=5)
        self.assertAlmostEqual(back, matrix[1][0], places=5)

    def test_the_options_of_the_alignment_count(self):
        files = sorted(self.demo.glob("*.ply"))[:2]
        values = {}
        for option in ((), ("--undersample", "random:0.3"), ("--scale", "off"), ("--keep-pose",)):
            numbers = json.loads(self.call("compare", *files, "--json", *option).stdout)
            values[option] = numbers["directions"][0]["metrics"]["rms"]
        self.assertEqual(len(set(values.values())), len(values), values)
        self.assertEqual(max(values, key=values.get), ("--keep-pose",))

    def test_an_unknown_face_finds_its_person(self):
        files = sorted(self.demo.glob("*.ply"))
        gallery = self.dir / "gallery"
        gallery.mkdir()
        for file in files[1:]:
            shutil.copy(file, gallery)
        self.run_job(gallery, self.dir / "out", "--keep-data", "--rounds", 1, "--labels",
                     self.demo / "labels.csv")
        before = (self.dir / "out" / "matrix.csv").read_bytes()
        answer = json.loads(self.call("identify", self.dir / "out", files[0], "--top", 3, "--out",
                                      self.dir / "who", "--json").stdout)
        matches = answer["probes"][0]["matches"]
        self.assertEqual([match["rank"] for match in matches], [1, 2, 3])
        self.assertEqual(matches[0]["person"], "person01")
        values = [match["value"] for match in matches]
        self.assertEqual(values, sorted(values))
        self.assertLess(matches[0]["different_pairs_as_near"], 0.05)
        with open(self.dir / "who" / "identified.csv", newline="") as file:
            self.assertEqual([row["mesh"] for row in csv.DictReader(file)],
                             [match["mesh"] for match in matches])
        # A face of the job is nearest to itself, and its other distances are those of the matrix
        # but for where its own ICP, from another start, came to rest.
        labels, matrix = read_matrix(self.dir / "out")
        known = json.loads(self.call("identify", self.dir / "out", gallery / labels[2], "--top",
                                     100, "--json").stdout)["probes"][0]["matches"]
        self.assertEqual(known[0]["mesh"], labels[2])
        for match in known:
            wanted = matrix[2][labels.index(match["mesh"])]
            self.assertAlmostEqual(match["value"], wanted, delta=0.1)
        # By signature first: the same answers, and how many such a list misses.
        self.assertIsNone(answer["shortlist"])
        short = json.loads(self.call("identify", self.dir / "out", files[0], "--top", 3,
                                     "--shortlist", 4, "--json").stdout)
        self.assertEqual(short["probes"][0]["matches"], matches)
        self.assertEqual(short["shortlist"]["length"], 4)
        self.assertEqual(short["shortlist"]["recall_probes"], len(labels))
        self.assertGreater(short["shortlist"]["recall"], 0.6)
        all_others = json.loads(self.call("identify", self.dir / "out", files[0], "--top", 3,
                                          "--shortlist", len(labels) - 1, "--json").stdout)
        self.assertEqual(all_others["shortlist"]["recall"], 1)
        text = self.call("identify", self.dir / "out", files[0], "--top", 3, "--shortlist", 4,
                         "--metric", "p95").stdout
        self.assertIn("the 4 of 7 meshes that are nearest by signature", text)
        self.assertIn("not known for p95", text)
        refused = self.call("identify", self.dir / "out", files[0], "--shortlist", 2, code=2)
        self.assertIn("--shortlist 2 is shorter than --top 10", refused.stderr)
        self.call("results", self.dir / "out", "--verify", 20)
        self.assertEqual((self.dir / "out" / "matrix.csv").read_bytes(), before)

    def test_shapes_vary_by_modes_and_by_groups(self):
        out = self.dir / "shape"
        answer = json.loads(self.call("shape", self.jobs["vectors"], "--modes", 3, "--by", "capture",
                                      "--out", out, "--json").stdout)
        self.assertEqual(len(answer["explained"]), 3)
        self.assertEqual(answer["explained"], sorted(answer["explained"], reverse=True))
        self.assertLessEqual(sum(answer["explained"]), 1)
        self.assertEqual([g["meshes"] for g in answer["groups"]], [4, 4])
        with open(out / "scores.csv", newline="") as file:
            scores = [[float(row[f"mode_{k}"]) for k in (1, 2, 3)] for row in csv.DictReader(file)]
        for k, deviation in enumerate(answer["deviations"]):
            column = [row[k] for row in scores]
            self.assertAlmostEqual(sum(column), 0, places=4)
            self.assertAlmostEqual(sum(v * v for v in column) / 7, deviation ** 2, places=6)
        for name in ("mode_1_plus.ply", "mode_3_minus.ply", "variation_a.ply", "variation_b.ply",
                     "difference_b_minus_a.ply", "difference_b_minus_a.png", "modes.csv"):
            self.assertGreater((out / name).stat().st_size, 50, name)
        refused = self.call("shape", self.jobs["vectors"], "--by", "sex", "--out", out, code=2)
        self.assertIn("--by sex", refused.stderr)

    def test_results_prove_themselves(self):
        for job in self.jobs.values():
            proof = json.loads(self.call("results", job, "--verify", 1000, "--json").stdout)
            self.assertEqual((proof["pairs"], proof["of"], proof["numbers"]), (64, 64, 7 * 64))
            self.assertEqual(proof["differences"], [])
        some = self.call("results", self.jobs["sketch"], "--verify", 5)
        self.assertIn("5 of 64 directed pairs", some.stdout)

    def test_wrong_questions_get_one_clear_line(self):
        job = self.jobs["vectors"]
        for arguments, code, words in (
                (["remeasure", job, "--out", self.dir / "x", "--metric", "p200"], 2, "p200"),
                (["remeasure", job, "--out", self.dir / "x", "--metric", "rmse"], 2, "rmse"),
                (["remeasure", job, "--out", self.dir / "x", "--lower", 0.9, "--upper", 0.1], 2,
                 "--lower 0.9"),
                (["remeasure", self.demo, "--out", self.dir / "x"], 1, "--keep-data"),
                (["pair", job, "nobody.ply", "person01_a.ply"], 7, "nobody.ply"),
                (["identify", job, self.demo / "labels.csv"], 2, "labels.csv"),
                (["identify", job, self.dir / "missing.ply"], 7, "missing.ply"),
                (["compare", self.demo / "person01_a.ply", self.dir / "missing.ply"], 7,
                 "missing.ply"),
                (["results", job], 2, "--out")):
            result = self.call(*arguments, code=code)
            self.assertIn(words, result.stderr)
            self.assertEqual(len(result.stderr.strip().splitlines()), 1, result.stderr)


if __name__ == "__main__":
    unittest.main()
