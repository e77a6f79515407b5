"""`cohort evaluate`: the thesis's chapter 5 on a small cohort."""
import csv
import json
import unittest

from cohort_e2e import ProgramTest, cohort


class Evaluate(ProgramTest):
    def test_every_table_of_the_thesis_is_there_and_its_formulas_hold(self):
        sparse = self.dir / "sparse"
        self.assertEqual(cohort("demo", "--out", sparse, "--vertices", 600).returncode, 0)
        out = self.dir / "evaluation"
        result = cohort("evaluate", sparse, self.demo, "--labels", self.demo / "labels.csv",
                        "--out", out, "--json", timeout=800)
        self.assertEqual(result.returncode, 0, result.stderr)
        answer = json.loads(result.stdout)
        formulas = [p for p in answer["properties"] if p["class"] == "F"]
        self.assertEqual({p["item"] for p in formulas}, {"5.4", "5.5", "summary"})
        for item in formulas:
            self.assertEqual(item["verdict"], "holds", item)
        of_persons = {p["item"]: p["verdict"] for p in answer["properties"] if p["class"] == "O"}
        self.assertEqual(of_persons["5.7"], "holds")
        for name in (*(f"table_5_{i}.csv" for i in (1, 2, 3, 4, 5, 7, 8, 9, 10, 12, 13, 14, 15)),
                     *(f"table_figure_5_{i}.csv" for i in (6, 7, 8, 10)), "table_converged.csv",
                     "verdicts.csv", "figure_5_6.png", "figure_5_9_first.png"):
            self.assertGreater((out / name).stat().st_size, 20, name)
        with open(out / "table_5_4.csv", newline="") as file:
            for row in csv.DictReader(file):
                self.assertEqual((row["To Each"], row["To One"], row["To Average"]),
                                 ("8", "1", "28"))
        page = (out / "evaluation.md").read_text()
        for words in ("# Evaluation of 8 meshes", "## Verdicts", "## 5.14", "| F | 4 | 0 | 0 |"):
            self.assertIn(words, page)
        self.assertFalse((out / ".cohort-data").exists())

    def test_what_cannot_be_evaluated_gets_one_clear_line(self):
        other = self.dir / "other"
        self.assertEqual(cohort("demo", "--out", other, "--people", 2, "--captures", 2, "--vertices",
                                600).returncode, 0)
        for folders, code, words in (([self.demo, other], 2, "other meshes"),
                                     ([self.dir / "nowhere"], 7, "nowhere")):
            result = cohort("evaluate", *folders, "--out", self.dir / "x")
            self.assertEqual(result.returncode, code, result.stderr)
            self.assertIn(words, result.stderr)
            self.assertEqual(len(result.stderr.strip().splitlines()), 1, result.stderr)


if __name__ == "__main__":
    unittest.main()
