"""Runs the real programs: what a user does, from the command line, with real processes."""
import csv
import json
import math
import os
import pathlib
import shutil
import signal
import subprocess
import tempfile
import time
import unittest

BIN = pathlib.Path(os.environ["COHORT_BIN"])
SHARED = pathlib.Path(os.environ.get("COHORT_SHARED", "/nonexistent"))
# Every file of a results folder; job.json is compared without its object "run".
RESULT_FILES = [
    "matrix.csv", "matrix.npy", "labels.txt", "neighbours.csv", "meshes.csv", "transforms.csv",
    "mean_shape.ply", "variation.ply", "variation.vtk", "variation.png", "heatmap.png",
    "histogram.png", "job.json",
]


def cohort(*arguments, timeout=300, env=None):
    """Runs `cohort` to its end; never raises for an exit code."""
    return subprocess.run([BIN / "cohort", *map(str, arguments)], capture_output=True, text=True,
                          timeout=timeout, env={**os.environ, **(env or {})})


def read_matrix(folder):
    """Labels and values of matrix.csv."""
    with open(folder / "matrix.csv", newline="") as file:
        rows = list(csv.reader(file))
    return rows[0][1:], [[float("nan") if v == "NA" else float(v) for v in row[1:]]
                         for row in rows[1:]]


def contents(folder):
    """Bytes of every result, without times and hosts."""
    found = {}
    for name in RESULT_FILES:
        data = (folder / name).read_bytes()
        if name == "job.json":
            job = json.loads(data)
            job.pop("run")
            data = json.dumps(job).encode()
        found[name] = data
    return found


def processes_with(argument):
    """Ids of live processes one of whose arguments is `argument`."""
    ids = []
    for entry in pathlib.Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                if argument.encode() in (entry / "cmdline").read_bytes().split(b"\0"):
                    ids.append(int(entry.name))
            except OSError:
                pass
    return ids


class ProgramTest(unittest.TestCase):
    """A small cohort, a folder for each test, and processes that end with it."""

    @classmethod
    def setUpClass(cls):
        cls.base = pathlib.Path(tempfile.mkdtemp(prefix="cohort-e2e-"))
        cls.demo = cls.base / "demo"
        made = cohort("demo", "--out", cls.demo, "--vertices", 1200)
        assert made.returncode == 0, made.stderr

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.base, ignore_errors=True)

    def setUp(self):
        self.dir = pathlib.Path(tempfile.mkdtemp(dir=self.base))
        self.children = []

    def tearDown(self):
        for child in self.children:
            if child.poll() is None:
                child.kill()
            child.wait()
            child.stdout.close()

    def start(self, program, *arguments, log=subprocess.DEVNULL):
        """Starts a program in the background; it ends with the test. stderr goes to `log`."""
        child = subprocess.Popen([BIN / program, *map(str, arguments)], stdout=subprocess.PIPE,
                                 stderr=log, text=True)
        self.children.append(child)
        return child

    def start_server(self, *listen, data=None, lease=5):
        """Starts cohort-server and returns (process, addresses)."""
        arguments = ["--data", data or self.dir / "data", "--lease-seconds", lease]
        for address in listen:
            arguments += ["--listen", address]
        server = self.start("cohort-server", *arguments)
        addresses = []
        for _ in listen:
            line = server.stdout.readline()
            self.assertTrue(line.startswith("listening on "), line)
            addresses.append(line.split()[-1])
        return server, addresses

    def run_job(self, folder, out, *arguments, code=0):
        result = cohort("run", folder, "--out", out, *arguments)
        self.assertEqual(result.returncode, code, result.stdout + result.stderr)
        return result

    def check_error(self, result, code, *words):
        self.assertEqual(result.returncode, code, result.stdout + result.stderr)
        lines = [line for line in result.stderr.splitlines() if line.startswith("cohort: ")]
        lines = [line for line in lines if "logs are in" not in line]
        self.assertEqual(len(lines), 1, result.stderr)
        for word in words:
            self.assertIn(word, lines[0])


class EndToEnd(ProgramTest):
    # ---- the main job

    def test_each_method_finds_the_same_person(self):
        for method in ("average", "one", "each"):
            with self.subTest(method=method):
                out = self.dir / method
                result = self.run_job(self.demo, out, "--method", method, "--labels",
                                      self.demo / "labels.csv")
                self.assertIn("nearest mesh is the same person: 8 of 8", result.stdout)
                labels, values = read_matrix(out)
                self.assertEqual(labels, sorted(p.name for p in self.demo.glob("*.ply")))
                for i, row in enumerate(values):
                    self.assertEqual(row[i], 0)
                    for j, value in enumerate(row):
                        self.assertEqual(value, values[j][i])
                for name in RESULT_FILES:
                    self.assertTrue((out / name).stat().st_size > 0, name)
                self.assertFalse((out / ".cohort-data").exists())

    def test_a_preview_is_labelled_and_changes_nothing(self):
        self.run_job(self.demo, self.dir / "with", "--preview")
        self.run_job(self.demo, self.dir / "without")
        self.assertEqual((self.dir / "with/matrix.npy").read_bytes(),
                         (self.dir / "without/matrix.npy").read_bytes())
        table = (self.dir / "with/preview_matrix.csv").read_text(encoding="utf-8").splitlines()
        self.assertTrue(table[0].startswith("preview of corresponded rms,"), table[0])
        self.assertEqual(len(table), 1 + len(list(self.demo.glob("*.ply"))))
        self.assertTrue((self.dir / "with/preview_heatmap.png").stat().st_size > 0)
        self.assertFalse((self.dir / "without/preview_matrix.csv").exists())

    def test_the_choice_of_the_base_is_told(self):
        self.run_job(self.demo, self.dir / "auto", "--base", "auto")
        ranks = (self.dir / "auto/base_choice.csv").read_text(encoding="utf-8").splitlines()
        self.assertEqual(ranks[0], "rank,file,mean_distance")
        self.assertEqual(len(ranks), 1 + len(list(self.demo.glob("*.ply"))))
        distances = [float(row.split(",")[2]) for row in ranks[1:]]
        self.assertEqual(distances, sorted(distances))

    def test_none_measures_where_the_meshes_are(self):
        # Unaligned scans are far apart, whoever they are.
        self.run_job(self.demo, self.dir / "none", "--method", "none", "--pose", "none")
        self.run_job(self.demo, self.dir / "one", "--method", "one")
        _, none = read_matrix(self.dir / "none")
        _, one = read_matrix(self.dir / "one")
        self.assertGreater(sum(map(sum, none)), 1.5 * sum(map(sum, one)))

    def test_results_do_not_depend_on_workers_and_threads(self):
        self.run_job(self.demo, self.dir / "a", "--workers", 1, "--threads", 1)
        self.run_job(self.demo, self.dir / "b", "--workers", 3, "--threads", 4)
        first, second = contents(self.dir / "a"), contents(self.dir / "b")
        for name in RESULT_FILES:
            self.assertEqual(first[name], second[name], name)

    def test_results_do_not_depend_on_the_instruction_set(self):
        outs = {}
        for isa in ("portable", "avx2", "avx512"):
            environment = {"COHORT_ISA": isa}
            out = self.dir / isa
            result = cohort("run", self.demo, "--out", out, env=environment)
            if isa != "portable" and "does not run it" in result.stderr:
                continue
            self.assertEqual(result.returncode, 0, result.stderr)
            outs[isa] = contents(out)
        for isa, found in outs.items():
            for name in RESULT_FILES:
                self.assertEqual(found[name], outs["portable"][name], f"{isa}: {name}")
        result = cohort("run", self.demo, "--out", self.dir / "x",
                        env={"COHORT_ISA": "bogus"})
        self.assertEqual(result.returncode, 2)
        self.assertIn("COHORT_ISA=bogus", result.stderr)

    def test_counters_are_those_of_the_thesis(self):
        n, rounds, iterations = 8, 2, 5
        expected_builds = {"average": n * rounds + rounds + 1, "one": 1, "each": n}
        for method, builds in expected_builds.items():
            with self.subTest(method=method):
                out = self.dir / method
                self.run_job(self.demo, out, "--method", method, "--rounds", rounds,
                             "--max-iterations", iterations, "--tolerance", 0)
                counters = json.loads((out / "job.json").read_text())["counters"]
                with open(out / "meshes.csv", newline="") as file:
                    vertices = [int(row["vertices"]) for row in csv.DictReader(file)]
                total = sum(vertices)
                lookups = {
                    "average": total * iterations * (rounds + 1) + n * rounds * vertices[0],
                    "one": total * iterations,
                    "each": n * total * iterations,
                }[method]
                work = [counters["align"], counters["average"]]
                self.assertEqual(sum(w["index_builds"] for w in work), builds)
                self.assertEqual(sum(w["lookups"] for w in work), lookups)

    # ---- losses

    def test_a_killed_worker_changes_nothing(self):
        self.run_job(self.demo, self.dir / "calm", "--workers", 1, "--threads", 1)
        _, (address,) = self.start_server("unix:" + str(self.dir / "s"), lease=2)
        added = cohort("add", self.demo, "--set", self.demo.name, "--server", address)
        self.assertEqual(added.returncode, 0, added.stderr)
        submitted = cohort("submit", "--set", self.demo.name, "--server", address)
        job = submitted.stdout.strip()
        for _ in range(4):
            worker = self.start("cohort-worker", "--server", address, "--threads", 2)
            time.sleep(0.7)
            worker.send_signal(signal.SIGKILL)
        self.start("cohort-worker", "--server", address, "--threads", 2)
        watched = cohort("watch", job, "--server", address)
        self.assertEqual(watched.returncode, 0, watched.stderr)
        cohort("results", job, "--out", self.dir / "killed", "--server", address)
        calm, killed = contents(self.dir / "calm"), contents(self.dir / "killed")
        for name in RESULT_FILES:
            if name != "job.json":  # Its set has another name.
                self.assertEqual(calm[name], killed[name], name)
        counters = [json.loads(c["job.json"])["counters"] for c in (calm, killed)]
        self.assertEqual(counters[0], counters[1])

    def test_run_survives_the_death_of_its_worker_and_of_its_server(self):
        self.run_job(self.demo, self.dir / "calm", "--method", "each")
        store = str(self.dir / "out" / ".cohort-data" / "blobs")
        run = self.start("cohort", "run", self.demo, "--out", self.dir / "out", "--method", "each")
        for argument in (store, str(self.dir / "out" / ".cohort-data")):
            victims = []
            while run.poll() is None and not victims:
                victims = processes_with(argument)
                time.sleep(0.02)
            time.sleep(0.5)
            for victim in processes_with(argument):
                os.kill(victim, signal.SIGKILL)
        self.assertEqual(run.wait(timeout=120), 0)
        calm, killed = contents(self.dir / "calm"), contents(self.dir / "out")
        for name in RESULT_FILES:
            self.assertEqual(calm[name], killed[name], name)

    def test_a_worker_that_cannot_start_ends_the_run(self):
        programs = self.dir / "bin"
        programs.mkdir()
        for name in ("cohort", "cohort-server"):
            shutil.copy(BIN / name, programs / name)
        worker = programs / "cohort-worker"
        worker.write_text("#!/bin/sh\necho cannot start\nexit 7\n")
        worker.chmod(0o755)
        out = self.dir / "out"
        run = subprocess.run([programs / "cohort", "run", self.demo, "--out", out],
                             capture_output=True, text=True, timeout=60)
        self.assertEqual(run.returncode, 1, run.stderr)
        last = run.stderr.splitlines()[-1]
        for word in ("worker-1", "exit code 7", "worker-1.log"):
            self.assertIn(word, last)
        self.assertEqual(processes_with(str(out / ".cohort-data")), [], "left running")
        self.run_job(self.demo, out)  # The same command, mended, goes on.

    def test_an_interrupted_run_goes_on(self):
        out = self.dir / "out"
        run = self.start("cohort", "run", self.demo, "--out", out, "--method", "each",
                         "--threads", 1)
        catalog = out / ".cohort-data" / "catalog.db"
        while not catalog.exists():
            time.sleep(0.02)
        time.sleep(1.5)
        run.send_signal(signal.SIGINT)
        code = run.wait(timeout=30)
        self.assertIn(code, (0, 130))
        self.run_job(self.demo, out, "--method", "each", "--threads", 1)
        if code == 130:
            self.assertEqual(json.loads((out / "job.json").read_text())["job"], "j-000001")

    # ---- a cluster by hand

    def test_a_cluster_started_by_hand_on_tcp_and_unix_socket(self):
        socket = "unix:" + str(self.dir / "server.sock")
        server, (tcp, unix) = self.start_server("127.0.0.1:0", socket)
        workers = [self.start("cohort-worker", "--server", tcp, "--threads", 1)
                   for _ in range(2)]
        for address in (tcp, unix):
            with self.subTest(address=address):
                added = cohort("add", *self.demo.glob("*.ply"), "--set", "demo", "--labels",
                               self.demo / "labels.csv", "--server", address)
                self.assertEqual(added.returncode, 0, added.stderr)
                job = cohort("submit", "--set", "demo", "--method", "one", "--server",
                             address).stdout.strip()
                watched = cohort("watch", job, "--server", address)
                self.assertEqual(watched.returncode, 0, watched.stderr)
                self.assertIn(": ", watched.stderr)
                status = json.loads(cohort("status", job, "--json", "--server", address).stdout)
                self.assertEqual((status["state"], status["percent"]), ("succeeded", 100))
                self.assertIn(job, cohort("jobs", env={"COHORT_SERVER": address}).stdout)
                out = self.dir / ("results-" + job)
                fetched = cohort("results", job, "--out", out, "--server", address)
                self.assertEqual(fetched.returncode, 0, fetched.stderr)
                self.assertIn("same person: 8 of 8", fetched.stdout)
                for name in RESULT_FILES:
                    self.assertTrue((out / name).exists(), name)
        for process in (*workers, server):
            process.send_signal(signal.SIGTERM)
            self.assertEqual(process.wait(timeout=20), 0)

    def test_the_same_request_id_gives_the_same_job(self):
        _, (address,) = self.start_server("127.0.0.1:0")
        cohort("add", self.demo, "--set", "demo", "--server", address)
        jobs = {cohort("submit", "--set", "demo", "--request-id", "r", "--server",
                       address).stdout for _ in range(3)}
        self.assertEqual(len(jobs), 1)
        cancelled = cohort("cancel", jobs.pop().strip(), "--server", address)
        self.assertIn("cancelled", cancelled.stdout)

    def test_a_second_server_on_the_same_data_or_port_refuses(self):
        _, (address,) = self.start_server("127.0.0.1:0")
        same_data = subprocess.run([BIN / "cohort-server", "--data", self.dir / "data", "--listen",
                                    "127.0.0.1:0"], capture_output=True, text=True, timeout=30)
        self.assertEqual(same_data.returncode, 1)
        self.assertIn("another cohort-server", same_data.stderr)
        same_port = subprocess.run([BIN / "cohort-server", "--data", self.dir / "other", "--listen",
                                    address], capture_output=True, text=True, timeout=30)
        self.assertEqual(same_port.returncode, 1)
        self.assertIn("cannot listen on " + address, same_port.stderr)

    # ---- bad input: one clear line, a non-zero exit, nothing else lost

    def test_a_backup_of_a_server_at_work_is_a_catalog(self):
        data, copy = self.dir / "data", self.dir / "copy.db"
        server, (address,) = self.start_server("127.0.0.1:0", data=data)
        cohort("add", self.demo, "--set", "demo", "--server", address)
        job = cohort("submit", "--set", "demo", "--server", address).stdout.strip()
        backup = [BIN / "cohort-server", "backup", "--data", data, "--to", copy]
        made = subprocess.run(backup, capture_output=True, text=True)
        self.assertEqual(made.returncode, 0, made.stderr)
        again = subprocess.run(backup, capture_output=True, text=True)
        self.assertEqual(again.returncode, 1)
        self.assertIn(f"{copy}: is there already", again.stderr)
        server.terminate()
        server.wait()
        restored = self.dir / "restored"
        shutil.copytree(data / "blobs", restored / "blobs")
        shutil.copy(copy, restored / "catalog.db")
        _, (address,) = self.start_server("127.0.0.1:0", data=restored)
        self.start("cohort-worker", "--server", address, "--threads", 1)
        watched = cohort("watch", job, "--server", address)
        self.assertEqual(watched.returncode, 0, watched.stderr)

    def test_folders_without_meshes(self):
        empty = self.dir / "empty"
        empty.mkdir()
        self.check_error(cohort("run", empty, "--out", self.dir / "o"), 1, str(empty), "no .obj")
        self.check_error(cohort("run", self.dir / "gone", "--out", self.dir / "o"), 7, "gone")

    def test_one_broken_file_among_good_ones(self):
        scans = self.dir / "scans"
        shutil.copytree(self.demo, scans)
        (scans / "broken.ply").write_text("ply\nformat ascii 1.0\nelement vertex 4000000000\n"
                                          "property float x\nproperty float y\nproperty float z\n"
                                          "end_header\n0 0 0\n")
        result = self.run_job(scans, self.dir / "out", code=3)
        self.assertIn("rejected: broken.ply", result.stdout)
        labels, _ = read_matrix(self.dir / "out")
        self.assertEqual(len(labels), 8)
        with open(self.dir / "out" / "meshes.csv", newline="") as file:
            rows = {row["file"]: row for row in csv.DictReader(file)}
        self.assertEqual(rows["broken.ply"]["status"], "rejected")
        self.assertIn("4000000000", rows["broken.ply"]["reason"])

    def test_unreachable_server_and_unknown_job(self):
        self.check_error(cohort("status", "j-000001", "--server", "127.0.0.1:1"), 6, "127.0.0.1:1")
        self.check_error(cohort("jobs", "--server", "nonsense"), 2, "HOST:PORT")
        _, (address,) = self.start_server("127.0.0.1:0")
        for command in (("status", "j-999999"), ("watch", "j-999999"), ("cancel", "j-999999"),
                        ("results", "j-999999", "--out", self.dir / "o")):
            self.check_error(cohort(*command, "--server", address), 7, "j-999999")
        self.check_error(cohort("submit", "--set", "nobody", "--server", address), 7, "nobody")

    def test_output_that_cannot_be_written(self):
        blocker = self.dir / "file"
        blocker.write_text("not a folder")
        result = cohort("run", self.demo, "--out", blocker / "out")
        self.assertNotEqual(result.returncode, 0)
        self.assertIn(str(blocker / "out"), result.stderr)
        result = cohort("run", self.demo, "--out", "/proc/cohort")
        self.assertNotEqual(result.returncode, 0)
        self.assertIn("/proc/cohort", result.stderr)

    def test_results_do_not_go_among_the_scans(self):
        scans = self.dir / "scans"
        shutil.copytree(self.demo, scans)
        self.check_error(cohort("run", scans, "--out", scans), 2, "folder of the scans")

    def test_two_units_of_length(self):
        scans = self.dir / "scans"
        scans.mkdir()
        for name, unit in (("mm.obj", 1), ("m.obj", 0.001)):
            lines = []
            for i in range(12):
                for j in range(12):
                    z = 20 * math.cos(i / 4) * math.cos(j / 5)
                    lines.append(f"v {10 * i * unit} {10 * j * unit} {z * unit}")
            for i in range(11):
                for j in range(11):
                    a = 12 * i + j + 1
                    lines.append(f"f {a} {a + 12} {a + 13} {a + 1}")
            (scans / name).write_text("\n".join(lines) + "\n")
        result = cohort("run", scans, "--out", self.dir / "out")
        self.check_error(result, 4, "m.obj", "unit")

    def test_a_full_disk(self):
        disk = self.dir / "disk"
        disk.mkdir()
        mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=200k", "tmpfs", disk],
                                 capture_output=True)
        if mounted.returncode != 0:
            self.skipTest("no right to mount a small file system")
        try:
            result = cohort("run", self.demo, "--out", disk / "out")
            self.check_error(result, 1)
            # The store meets it as the one, SQLite as the other.
            self.assertRegex(result.stderr, "No space left|disk is full")
        finally:
            subprocess.run(["umount", "-l", disk], check=True)

    def test_wrong_options_name_themselves(self):
        for arguments in (("--method", "bogus"), ("--metric", "bogus"), ("--rounds", "0"),
                          ("--tolerance", "-1"), ("--preset", "bogus"), ("--base", "gone.ply")):
            with self.subTest(arguments=arguments):
                result = cohort("run", self.demo, "--out", self.dir / "o", *arguments)
                self.assertNotEqual(result.returncode, 0)
                self.assertIn(arguments[1] if arguments[1] != "0" else "rounds", result.stderr)

    def test_labels_that_do_not_fit(self):
        labels = self.dir / "labels.csv"
        labels.write_text("file,person\nx.ply,a\n")
        self.check_error(cohort("run", self.demo, "--out", self.dir / "o", "--labels", labels), 2,
                         "x.ply")
        labels.write_text("name,person\nx.ply,a\n")
        self.check_error(cohort("run", self.demo, "--out", self.dir / "o", "--labels", labels), 2,
                         "labels.csv", "file")


@unittest.skipUnless(SHARED.exists(), f"{SHARED} is not there: tests on shared scans are left out")
class SharedScans(unittest.TestCase):
    """The thesis's table 5.7-5.8 on scans that are not in the repository."""

    def setUp(self):
        self.dir = pathlib.Path(tempfile.mkdtemp(prefix="cohort-shared-"))
        self.addCleanup(shutil.rmtree, self.dir, ignore_errors=True)

    def check_set(self, folder, method, max_median_ratio):
        """Nearest is the same person for all; returns nothing, fails with the numbers."""
        out = self.dir / (folder.name + "-" + method)
        result = cohort("run", folder, "--out", out, "--method", method, timeout=900)
        self.assertEqual(result.returncode, 0, result.stderr)
        labels, values = read_matrix(out)
        person = [label.rsplit("_", 1)[0] for label in labels]
        ratios = []
        for i in range(len(labels)):
            same = min(values[i][j] for j in range(len(labels)) if j != i and person[j] == person[i])
            other = min(values[i][j] for j in range(len(labels)) if person[j] != person[i])
            ratios.append(same / other)
        ratios.sort()
        self.assertLess(ratios[-1], 1, f"{folder.name} {method}: {ratios}")
        median = (ratios[len(ratios) // 2] + ratios[(len(ratios) - 1) // 2]) / 2
        print(f"{folder.name} {method}: largest ratio {ratios[-1]:.3f}, median {median:.3f}")
        self.assertLess(median, max_median_ratio)

    def test_faces_4x2_10k(self):
        for method in ("average", "one", "each"):
            with self.subTest(method=method):
                self.check_set(SHARED / "data/sets/faces_4x2_10k", method, 0.65)

    def test_faces_rough_4x2_5k(self):
        for method in ("average", "one", "each"):
            with self.subTest(method=method):
                self.check_set(SHARED / "data/sets/faces_rough_4x2_5k", method, 1)


if __name__ == "__main__":
    unittest.main(verbosity=2)
