"""The service's promises as its user meets them: jobs held, retried, known again, sets that grow,
servers and workers that come and go."""
import json
import signal
import time
import unittest
from pathlib import Path

from cohort_e2e import ProgramTest, cohort, read_matrix


class Service(ProgramTest):
    def setUp(self):
        super().setUp()
        self.server, [self.address] = self.start_server("unix:" + str(self.dir / "socket"))
        self.files = sorted(self.demo.glob("*.ply"))

    def call(self, *arguments, code=0):
        result = cohort(*arguments, "--server", self.address)
        self.assertEqual(result.returncode, code, result.stdout + result.stderr)
        return result

    def add(self, files):
        self.call("add", *files, "--set", "faces")

    def submit(self, *arguments):
        return self.call("submit", "--set", "faces", "--rounds", 1, *arguments).stdout.strip()

    def show(self, job):
        return json.loads(self.call("status", job, "--json").stdout)

    def wait(self, job, *states):
        deadline = time.monotonic() + 120
        while self.show(job)["state"] not in states:
            self.assertLess(time.monotonic(), deadline, self.show(job))
            time.sleep(0.05)
        return self.show(job)

    def start_worker(self, *arguments):
        log = open(self.dir / f"worker-{len(self.children)}.log", "w")
        self.addCleanup(log.close)
        worker = self.start("cohort-worker", "--server", self.address, "--threads", 1,
                            "--log-level", "debug", *arguments, log=log)
        worker.log = log.name
        return worker

    def begun(self):
        """Tasks that all workers have begun."""
        return sum(Path(child.log).read_text().count("event=task_begun")
                   for child in self.children if hasattr(child, "log"))

    def results(self, job):
        out = self.dir / job
        self.call("results", job, "--out", out)
        return read_matrix(out)

    def test_what_is_known_is_not_computed_again(self):
        self.start_worker()
        self.add(self.files)
        first = self.submit()
        self.wait(first, "succeeded")
        begun = self.begun()
        again = self.submit()
        shown = self.wait(again, "succeeded")
        self.assertEqual(shown["tasks_reused"], shown["tasks_total"])
        self.assertEqual(self.begun(), begun)
        self.assertEqual(self.results(again), self.results(first))
        self.assertIn("tasks were known from earlier jobs", self.call("status", again).stdout)
        fresh = self.submit("--fresh")
        self.assertEqual(self.wait(fresh, "succeeded")["tasks_reused"], 0)
        self.assertEqual(self.results(fresh), self.results(first))

    def test_a_set_that_grows_and_shrinks_costs_only_what_is_new(self):
        self.start_worker()
        self.add(self.files[1:6])
        first = self.submit()
        self.wait(first, "succeeded")
        names, before = self.results(first)
        self.add([self.files[0], self.files[7]])
        self.call("remove", "--set", "faces", names[2])
        grown = self.call("submit", "--set", "faces", "--reference", first).stdout.strip()
        shown = self.wait(grown, "succeeded")
        kept = [name for name in names if name != names[2]]
        self.assertEqual(shown["counters"]["pairs"], 2 * len(kept) * 2 + 4)
        labels, after = self.results(grown)
        self.assertEqual(labels, sorted([self.files[0].name, self.files[7].name, *kept]))
        for i in kept:
            for j in kept:
                self.assertEqual(after[labels.index(i)][labels.index(j)],
                                 before[names.index(i)][names.index(j)])
        result = cohort("submit", "--set", "faces", "--reference", first, "--method", "one",
                        "--server", self.address)
        self.check_error(result, 2, "--reference", "keeps the options")
        result = cohort("remove", "--set", "faces", "nobody.ply", "--server", self.address)
        self.check_error(result, 7, "nobody.ply")

    def test_a_job_can_be_held_cancelled_retried_and_deleted(self):
        self.add(self.files)
        job = self.submit()
        self.assertIn("paused", self.call("pause", job).stdout)
        self.start_worker()
        time.sleep(1)
        self.assertEqual(self.show(job)["tasks_done"], 0)
        self.check_error(cohort("delete", job, "--server", self.address), 1, job, "paused")
        self.call("resume", job)
        self.call("cancel", job)
        self.assertEqual(self.show(job)["state"], "cancelled")
        self.check_error(cohort("pause", job, "--server", self.address), 1, job, "cancelled")
        self.call("retry", job)
        self.wait(job, "succeeded")
        self.check_error(cohort("retry", job, "--server", self.address), 1, job, "succeeded")
        self.assertIn("deleted " + job, self.call("delete", job).stdout)
        self.check_error(cohort("status", job, "--server", self.address), 7, job)

    def test_a_server_that_dies_and_comes_back_redoes_nothing(self):
        self.add(self.files)
        worker = self.start_worker()
        job = self.submit()
        while self.show(job)["tasks_done"] < 3:
            time.sleep(0.01)
        self.server.kill()
        self.server.wait()
        time.sleep(0.5)
        self.server, _ = self.start_server("unix:" + str(self.dir / "socket"))
        shown = self.wait(job, "succeeded")
        self.assertEqual(self.begun(), shown["tasks_total"], Path(worker.log).read_text())
        self.assertIsNone(worker.poll())

    def test_workers_and_what_they_do_can_be_seen(self):
        self.assertIn("no workers", self.call("workers").stdout)
        worker = self.start_worker("--name", "anna")
        deadline = time.monotonic() + 30
        while not json.loads(self.call("workers", "--json").stdout):
            self.assertLess(time.monotonic(), deadline)
            time.sleep(0.1)
        self.add(self.files)
        self.wait(self.submit(), "succeeded")
        [shown] = json.loads(self.call("workers", "--json").stdout)
        self.assertEqual(shown["name"], "anna")
        self.assertGreater(shown["tasks_done"], 10)
        self.assertEqual(shown["tasks_failed"], 0)
        self.assertIn("anna", self.call("workers").stdout)
        self.assertIn("1 workers, 0 of 1 slots compute, 0 jobs under way",
                      self.call("top", "--once").stdout)
        worker.send_signal(signal.SIGTERM)
        self.assertEqual(worker.wait(timeout=30), 0)


if __name__ == "__main__":
    unittest.main()
