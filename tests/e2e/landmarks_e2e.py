"""Landmarks and symmetric copies, from the command line to the results."""
import csv
import json
import unittest

from cohort_e2e import RESULT_FILES, ProgramTest, cohort, contents, read_matrix


class Landmarks(ProgramTest):
    def write_landmarks(self, path, leave_out=()):
        """Six points of the canonical face, brought to where each scan lies."""
        canonical = {"nose": (0, -8, 95), "eye_l": (32, 30, 70), "eye_r": (-32, 30, 70),
                     "mouth": (0, -40, 85), "chin": (0, -75, 80), "brow": (0, 45, 85)}
        with open(self.demo / "truth.csv", newline="") as file:
            truth = list(csv.DictReader(file))
        lines = ["file,landmark,x,y,z"]
        for row in truth:
            s, w, x, y, z = (float(row[key]) for key in ("scale", "qw", "qx", "qy", "qz"))
            t = [float(row[key]) for key in ("tx", "ty", "tz")]
            rotation = [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]
            for name, p in canonical.items():
                q = [s * sum(rotation[i][j] * p[j] for j in range(3)) + t[i] for i in range(3)]
                if row["file"] not in leave_out:
                    lines.append(",".join([row["file"], name, *map(repr, q)]))
        path.write_text("\n".join(lines) + "\n")
        return path

    def test_landmarks_are_the_pose_for_any_number_of_workers(self):
        landmarks = self.write_landmarks(self.dir / "landmarks.csv")
        for workers in (1, 3):
            self.run_job(self.demo, self.dir / str(workers), "--landmarks", landmarks, "--labels",
                         self.demo / "labels.csv", "--workers", workers, "--threads", 1)
        one, three = contents(self.dir / "1"), contents(self.dir / "3")
        for name in RESULT_FILES:
            self.assertEqual(one[name], three[name], name)
        with open(self.dir / "1" / "meshes.csv", newline="") as file:
            rms = [float(row["pose_rms"]) for row in csv.DictReader(file)]
        self.assertLess(max(rms), 1e-6)
        self.assertEqual(json.loads(one["job.json"])["parameters"]["pose"], "landmarks")

    def test_submit_sends_landmarks_to_a_server(self):
        landmarks = self.write_landmarks(self.dir / "landmarks.csv")
        _, (address,) = self.start_server("127.0.0.1:0")
        self.start("cohort-worker", "--server", address, "--threads", 2)
        cohort("add", self.demo, "--set", "demo", "--server", address)
        result = cohort("submit", "--set", "demo", "--landmarks", landmarks, "--method", "one",
                        "--wait", "--server", address)
        self.assertEqual(result.returncode, 0, result.stderr)

    def test_landmarks_that_do_not_fit(self):
        out = self.dir / "o"
        some = self.write_landmarks(self.dir / "some.csv", ("person01_a.ply", "person02_b.ply"))
        self.check_error(cohort("run", self.demo, "--out", out, "--landmarks", some), 2,
                         "2 of 8 meshes have none: person01_a.ply, person02_b.ply")
        few = self.dir / "few.csv"
        lines = self.write_landmarks(few).read_text().splitlines()
        few.write_text("\n".join(line for line in lines
                                 if "person03_a" not in line or "nose" in line) + "\n")
        self.check_error(cohort("run", self.demo, "--out", out, "--landmarks", few), 2,
                         "person03_a.ply has 1")
        self.check_error(cohort("run", self.demo, "--out", out, "--landmarks", "gone.pp"), 7,
                         "gone.pp")
        self.check_error(cohort("run", self.demo, "--out", out, "--pose", "landmarks"), 2,
                         "--landmarks")
        self.check_error(cohort("run", self.demo, "--out", out, "--landmarks",
                                self.demo / "labels.csv"), 2, "labels.csv", "x, y, z")
        self.assertFalse(out.exists(), "nothing is written before the input is right")

    def test_symmetric_copies_are_of_their_job_alone(self):
        data = ("--data", self.dir / "data", "--method", "one")
        self.run_job(self.demo, self.dir / "before", *data)
        self.run_job(self.demo, self.dir / "copies", "--symmetric-copies", *data)
        self.run_job(self.demo, self.dir / "again", "--symmetric-copies", "--workers", 3,
                     "--method", "one")
        self.run_job(self.demo, self.dir / "after", "--neighbours", 4, *data)  # A new job.
        before, copies, again, after = (contents(self.dir / name) for name in
                                        ("before", "copies", "again", "after"))
        for name in ("matrix.npy", "mean_shape.ply", "transforms.csv", "meshes.csv"):
            self.assertEqual(before[name], after[name], name)
        for name in RESULT_FILES:
            if name != "job.json":  # Its job has another number.
                self.assertEqual(copies[name], again[name], name)
        self.assertNotEqual(before["matrix.npy"], copies["matrix.npy"])
        for folder, is_number in (("before", False), ("copies", True)):
            with open(self.dir / folder / "meshes.csv", newline="") as file:
                for row in csv.DictReader(file):
                    self.assertEqual(row["asymmetry"] != "NA", is_number)
                    if is_number:
                        self.assertTrue(0.01 < float(row["asymmetry"]) < 5, row["asymmetry"])

    def test_gpa_of_landmarks(self):
        landmarks = self.write_landmarks(self.dir / "landmarks.csv")
        rows = landmarks.read_text().splitlines()
        backward = self.dir / "backward.csv"
        backward.write_text("\n".join([rows[0], *reversed(rows[1:])]) + "\n")
        files = ["matrix.csv", "matrix.npy", "labels.txt", "consensus.csv", "aligned.csv",
                 "sets.csv", "heatmap.png"]
        for name, source in (("a", landmarks), ("b", backward)):
            result = cohort("gpa", source, "--out", self.dir / name, "--json")
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertEqual(json.loads(result.stdout)["files"], [*files, "job.json"])
        for name in files:
            self.assertEqual((self.dir / "a" / name).read_bytes(),
                             (self.dir / "b" / name).read_bytes(), name)
        labels, values = read_matrix(self.dir / "a")
        self.assertEqual(labels[0], "person01_a.ply")
        # All landmarks are moved copies of one set.
        self.assertLess(max(map(max, values)), 1e-6)
        # What was written can be read.
        again = cohort("gpa", self.dir / "a" / "aligned.csv", "--out", self.dir / "c", "--size",
                       "kept", "--variant", "fidentis")
        self.assertEqual(again.returncode, 0, again.stderr)
        self.assertIn("8 sets, 6 landmarks in common", again.stdout)

    def test_gpa_that_cannot_be(self):
        landmarks = self.write_landmarks(self.dir / "landmarks.csv")
        out = self.dir / "o"
        one = self.dir / "one.csv"
        one.write_text("name,x,y,z\nnose,0,0,0\nchin,1,0,0\n")
        for code, words, arguments in (
                (2, ("--size tall", "normalized or kept"), (landmarks, "--size", "tall")),
                (2, ("--variant new", "exact or fidentis"), (landmarks, "--variant", "new")),
                (2, ("2 landmarks in common", "one.csv has 2 (nose, chin)"), (landmarks, one)),
                (2, ("there is one: one.csv",), (one,)),
                (2, ("are there twice", "one.csv"), (one, one)),
                (7, ("gone.csv",), ("gone.csv",)),
                (1, ("no landmark file",), (self.base / "demo" / "..",)),
                (2, ("folder of landmarks",), (landmarks, "--out"))):
            with self.subTest(arguments=arguments):
                if arguments[-1] == "--out":
                    marks = self.dir / "marks"
                    marks.mkdir()
                    self.write_landmarks(marks / "all.csv")
                    result = cohort("gpa", marks, "--out", marks)
                else:
                    result = cohort("gpa", *arguments, "--out", out)
                self.check_error(result, code, *words)
        self.assertFalse(out.exists())


if __name__ == "__main__":
    unittest.main(verbosity=2)
