"""What a server and a worker tell Prometheus while a job runs, read over HTTP."""
import json
import re
import time
import unittest
import urllib.error
import urllib.request

from cohort_e2e import ProgramTest, cohort

SAMPLE = re.compile(r'^(cohort_[a-z_]+|exposer_[a-z_]+)(\{[^}]*\})? ([0-9.eE+-]+|\+?Inf|[Nn]a[Nn])$')


class Metrics(ProgramTest):
    def start_with_metrics(self, program, *arguments):
        """Starts a program and returns where it serves its page."""
        child = self.start(program, *arguments, "--metrics-listen", "127.0.0.1:0")
        for line in child.stdout:
            if line.startswith("metrics on "):
                return child, line.split()[-1]
        self.fail(f"{program} says no address")

    def read(self, address):
        """The values of a page by name with labels; checks its form."""
        with urllib.request.urlopen(address, timeout=10) as answer:
            self.assertTrue(answer.headers["Content-Type"].startswith("text/plain"))
            text = answer.read().decode()
        values, described = {}, set()
        for line in text.splitlines():
            if line.startswith("# HELP "):
                described.add(line.split()[2])
                continue
            if line.startswith("# TYPE "):
                continue
            match = SAMPLE.match(line)
            self.assertIsNotNone(match, line)
            base = re.sub("_(bucket|sum|count)$", "", match[1])
            self.assertTrue(match[1] in described or base in described, line)
            values[match[1] + (match[2] or "")] = float(match[3])
        return values

    def test_server_and_worker_tell_how_a_job_goes(self):
        socket = "unix:" + str(self.dir / "s")
        _, page = self.start_with_metrics("cohort-server", "--data", self.dir / "data",
                                          "--listen", socket, "--lease-seconds", 5)
        added = cohort("add", *sorted(self.demo.glob("*.ply")), "--set", "s", "--server", socket)
        self.assertEqual(added.returncode, 0, added.stderr)
        submitted = cohort("submit", "--set", "s", "--server", socket)
        self.assertEqual(submitted.returncode, 0, submitted.stderr)
        waiting = self.read(page)
        self.assertEqual(waiting["cohort_workers"], 0)
        self.assertGreater(waiting["cohort_tasks_ready"], 1)
        self.assertEqual(waiting['cohort_jobs{state="queued"}'], 1)
        self.assertGreater(waiting["cohort_store_free_bytes"], 0)
        self.assertGreaterEqual(self.read(page)["cohort_tasks_ready_wait_seconds"],
                                waiting["cohort_tasks_ready_wait_seconds"])

        _, worker_page = self.start_with_metrics("cohort-worker", "--server", socket,
                                                 "--threads", 1)
        seen = []
        job = submitted.stdout.strip()
        deadline = time.monotonic() + 120
        while time.monotonic() < deadline:
            seen.append((self.read(page), self.read(worker_page)))
            last, worker = seen[-1]
            done = sum(value for name, value in last.items()
                       if name.startswith("cohort_tasks_completed_total{"))
            # The worker counts a task when it has heard that its result was taken.
            if (last['cohort_jobs_ended_total{state="succeeded"}'] == 1 and
                    worker["cohort_worker_tasks_completed_total"] == done):
                break
            time.sleep(0.1)
        self.assertEqual(last['cohort_jobs_ended_total{state="succeeded"}'], 1, cohort(
            "status", job, "--server", socket).stdout)
        self.assertEqual(last["cohort_tasks_ready"] + last["cohort_tasks_leased"], 0)
        self.assertEqual(last["cohort_workers"], 1)
        self.assertEqual(last["cohort_worker_slots"], 1)
        self.assertTrue(any(s["cohort_worker_slots_busy"] == 1 for _, s in seen) or
                        any(s["cohort_tasks_leased"] > 0 for s, _ in seen), "never at work")
        self.assertEqual(last["cohort_complete_task_seconds_count"], done)
        self.assertGreater(last["cohort_catalog_write_seconds_count"], 2)
        self.assertEqual(worker["cohort_worker_tasks_completed_total"], done)
        self.assertGreater(worker["cohort_worker_cache_bytes"], 0)
        with self.assertRaises(urllib.error.HTTPError):
            urllib.request.urlopen(page.replace("/metrics", "/"), timeout=10)

    def test_an_estimate_is_what_the_job_then_is(self):
        _, (address,) = self.start_server("unix:" + str(self.dir / "s"))

        def call(*arguments, code=0):
            result = cohort(*arguments, "--server", address)
            self.assertEqual(result.returncode, code, result.stdout + result.stderr)
            return result

        files = sorted(self.demo.glob("*.ply"))
        call("add", *files, "--set", "s")
        before = json.loads(call("estimate", "--set", "s", "--rounds", 2, "--json").stdout)
        self.assertEqual(before["meshes"], len(files))
        self.assertEqual(before["pairs"], len(files) * (len(files) - 1))
        self.assertEqual((before["slots"], before["wall_seconds"]), (0, None))
        self.assertEqual(before["measured_share"], 0)
        self.assertTrue(before["fits"])
        self.assertEqual(json.loads(call("jobs", "--json").stdout), [])
        self.start("cohort-worker", "--server", address, "--threads", 2)
        job = json.loads(call("submit", "--set", "s", "--rounds", 2, "--wait", "--json").stdout)
        self.assertEqual(job["state"], "succeeded")
        self.assertEqual(job["tasks_total"], sum(stage["tasks"] for stage in before["stages"]))
        after = json.loads(call("estimate", "--set", "s", "--rounds", 2, "--json").stdout)
        self.assertEqual(after["slots"], 2)
        self.assertEqual(after["measured_share"], 1)
        text = call("estimate", "--set", "s").stdout
        self.assertIn("by the rates measured on this server", text)
        self.assertIn("with the 2 slots", text)
        call("estimate", "--set", "nothing", code=7)

    def test_an_address_that_cannot_be_served_is_refused(self):
        bad = cohort("serve", "--data", self.dir / "d", "--listen", "127.0.0.1:0",
                     "--metrics-listen", "9464")
        self.assertEqual(bad.returncode, 2)
        self.assertIn("--metrics-listen 9464: expected HOST:PORT", bad.stderr)


if __name__ == "__main__":
    unittest.main()
