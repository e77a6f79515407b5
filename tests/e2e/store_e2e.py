"""What becomes of damaged files, caches and garbage, with real processes."""
import json
import signal
import unittest

from cohort_e2e import ProgramTest, cohort, contents


class Store(ProgramTest):
    def setUp(self):
        super().setUp()
        _, (self.address,) = self.start_server("127.0.0.1:0")
        self.cache = self.dir / "cache"

    def start_worker(self):
        return self.start("cohort-worker", "--server", self.address, "--threads", 1,
                          "--cache-dir", self.cache, "--cache-disk-mb", 1)

    def call(self, *arguments, code=0):
        result = cohort(*arguments, "--server", self.address)
        self.assertEqual(result.returncode, code, result.stdout + result.stderr)
        return result

    def add(self):
        return json.loads(self.call("add", self.demo, "--set", "demo", "--labels",
                                    self.demo / "labels.csv", "--json").stdout)

    def submit(self, *arguments, code=0):
        return json.loads(self.call("submit", "--set", "demo", "--wait", "--json", *arguments,
                                    code=code).stdout)

    def results(self, job, name):
        self.call("results", job, "--out", self.dir / name)
        return self.numbers(name)

    def numbers(self, name):
        """All results but job.json, which has the id of the job."""
        found = contents(self.dir / name)
        found.pop("job.json")
        return found

    def blobs(self):
        return sorted((self.dir / "data" / "blobs" / "sha256").glob("*/*"))

    def flip(self, blob):
        data = bytearray(blob.read_bytes())
        data[len(data) // 2] ^= 1
        blob.chmod(0o644)
        blob.write_bytes(data)

    def test_every_blob_of_a_job_damaged_at_once_is_made_again(self):
        self.start_worker()
        self.add()
        raw = set(self.blobs())
        job = self.submit("--rounds", 1)["id"]
        clean = self.results(job, "clean")
        damaged = set(self.blobs()) - raw
        self.assertGreater(len(damaged), 10)
        for blob in damaged:
            self.flip(blob)
        out = cohort("results", job, "--out", self.dir / "again", "--server", self.address)
        self.check_error(out, 1, "cohort retry")
        self.call("retry", job)
        self.call("watch", job)
        self.assertEqual(self.results(job, "again"), clean)
        self.assertTrue(list((self.dir / "data" / "blobs" / "damaged").iterdir()))

    def test_a_worker_that_meets_damage_has_it_mended(self):
        worker = self.start_worker()
        self.add()
        raw = set(self.blobs())
        self.submit("--method", "none")
        worker.send_signal(signal.SIGTERM)
        self.assertEqual(worker.wait(timeout=20), 0)
        for blob in set(self.blobs()) - raw:
            self.flip(blob)
        for cached in self.cache.glob("sha256/*/*"):
            self.flip(cached)
        self.start_worker()
        mended = self.results(self.submit("--rounds", 1)["id"], "mended")
        self.run_job(self.demo, self.dir / "alone", "--rounds", 1, "--labels",
                     self.demo / "labels.csv")
        self.assertEqual(mended["matrix.csv"], contents(self.dir / "alone")["matrix.csv"])
        self.assertTrue(list((self.dir / "data" / "blobs" / "damaged").iterdir()))

    def test_a_damaged_mesh_file_is_asked_for_and_taken_again(self):
        self.add()
        self.flip(self.blobs()[0])
        self.start_worker()
        failed = self.submit("--method", "none", code=4)
        self.assertIn("add it again", failed["error"])
        self.assertEqual(self.add()["sent"], 1)
        self.call("retry", failed["id"])
        self.call("watch", failed["id"])

    def test_the_cache_stays_small_and_is_used_by_the_next_worker(self):
        worker = self.start_worker()
        self.add()
        self.submit("--method", "none")
        worker.send_signal(signal.SIGTERM)
        self.assertEqual(worker.wait(timeout=20), 0)
        cached = [file for file in self.cache.rglob("*") if file.is_file()]
        self.assertTrue(cached)
        self.assertLessEqual(sum(file.stat().st_size for file in cached), 1_062_500)
        self.start_worker()
        self.submit("--method", "one")

    def test_deleted_jobs_make_space(self):
        self.start_worker()
        self.add()
        raw = set(self.blobs())
        job = self.submit("--method", "none")["id"]
        self.call("delete", job)
        young = json.loads(self.call("gc", "--remember-days", 0, "--json").stdout)
        self.assertEqual(young["removed_blobs"], 0)
        gone = json.loads(self.call("gc", "--remember-days", 0, "--age-hours", 0,
                                    "--json").stdout)
        self.assertGreater(gone["removed_blobs"], 0)
        left = set(self.blobs())
        self.assertTrue(raw <= left)
        self.call("remove", "--all", "--set", "demo")
        self.assertIn("0 blobs stay", self.call("gc", "--age-hours", 0).stdout)
        self.assertEqual(self.blobs(), [])

    def test_a_server_short_of_space_says_so(self):
        self.start_worker()
        self.children[0].send_signal(signal.SIGTERM)
        self.children[0].wait(timeout=20)
        server = self.start("cohort-server", "--data", self.dir / "data", "--listen", self.address,
                            "--min-free-gb", 999999)
        self.assertIn("listening", server.stdout.readline())
        refused = cohort("add", self.demo, "--set", "demo", "--server", self.address)
        self.check_error(refused, 1, "999999.00 GB in reserve")


if __name__ == "__main__":
    unittest.main()
