"""Breaks a running Cohort at random, and checks that nobody can tell from the results.

One server, three workers and a client that submits job after job. Until the time is up a seeded
nemesis kills, stops, terminates and restarts them and cuts the network; then everything is healed,
the jobs end, and every byte of every result must be that of an undisturbed run with one worker and
one thread. Tasks begun more often than there are must be explained by what was broken.
"""
import argparse
import asyncio
import json
import os
import pathlib
import random
import shutil
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time

LEASE_SECONDS = 3
SLOTS = 2  # Of each worker.
RESULT_FILES = ["matrix.csv", "matrix.npy", "labels.txt", "neighbours.csv", "meshes.csv",
                "transforms.csv", "mean_shape.ply", "variation.ply", "heatmap.png",
                "histogram.png", "job.json"]


class Failed(Exception):
    """What the summary line says."""


class Relay:
    """A TCP relay in front of the server that can be cut: silently, one way or with resets."""

    def __init__(self, target):
        self.target = target
        self.mode = "open"  # open, silent, deaf (nothing to the server), mute (nothing back), reset
        self.connections = set()
        self.loop = asyncio.new_event_loop()
        self.port = None
        started = threading.Event()
        threading.Thread(target=self._run, args=(started,), daemon=True).start()
        started.wait()

    def _run(self, started):
        asyncio.set_event_loop(self.loop)
        server = self.loop.run_until_complete(
            asyncio.start_server(self._serve, "127.0.0.1", 0))
        self.port = server.sockets[0].getsockname()[1]
        started.set()
        self.loop.run_forever()

    async def _serve(self, reader, writer):
        self.connections.add(writer)
        try:
            upstream_reader, upstream = await asyncio.open_connection(*self.target)
        except OSError:
            writer.close()
            return
        self.connections.add(upstream)
        await asyncio.gather(self._copy(reader, upstream, "deaf"),
                             self._copy(upstream_reader, writer, "mute"))

    async def _copy(self, reader, writer, closed_in):
        try:
            while data := await reader.read(65536):
                while self.mode in ("silent", closed_in):
                    await asyncio.sleep(0.05)
                writer.write(data)
                await writer.drain()
        except OSError:
            pass
        finally:
            writer.close()

    def set_mode(self, mode):
        self.mode = mode
        if mode == "reset":
            self.loop.call_soon_threadsafe(self._reset_all)

    def _reset_all(self):
        for writer in list(self.connections):
            sock = writer.get_extra_info("socket")
            if sock is not None and sock.fileno() >= 0:
                sock.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            writer.close()
        self.connections.clear()


class Process:
    """A program that is started again whenever it has ended."""

    def __init__(self, name, command, log):
        self.name = name
        self.command = command
        self.log = log
        self.child = None
        self.stopped = False

    def start(self):
        with open(self.log, "ab") as log:
            self.child = subprocess.Popen(self.command, stdout=log, stderr=log)
        self.stopped = False

    def is_alive(self):
        return self.child is not None and self.child.poll() is None

    def send(self, number):
        if self.is_alive():
            self.child.send_signal(number)
            self.stopped = number == signal.SIGSTOP

    def end(self):
        if self.is_alive():
            self.child.send_signal(signal.SIGCONT)
            self.child.kill()
        if self.child is not None:
            self.child.wait()


def free_port():
    with socket.socket() as sock:
        sock.bind(("127.0.0.1", 0))
        return sock.getsockname()[1]


def contents(folder):
    """Bytes of every result, without what names the run."""
    found = {}
    for name in RESULT_FILES:
        data = (folder / name).read_bytes()
        if name == "job.json":
            job = json.loads(data)
            for key in ("run", "job", "set"):
                job.pop(key)
            data = json.dumps(job).encode()
        found[name] = data
    return found


class Chaos:
    def __init__(self, options):
        self.options = options
        self.random = random.Random(options.seed)
        self.bin = pathlib.Path(options.bin)
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="cohort-chaos-"))
        self.counts = {}
        self.slots_hit = 0
        self.server = None
        self.workers = []
        self.relay = None
        self.jobs = []

    def cohort(self, *arguments, check=True, timeout=600):
        result = subprocess.run([self.bin / "cohort", *map(str, arguments)], capture_output=True,
                                text=True, timeout=timeout)
        if check and result.returncode != 0:
            raise Failed(f"cohort {arguments[0]} ended with {result.returncode}: "
                         f"{result.stderr.strip()}")
        return result

    def spec(self):
        return ["--rounds", 1, "--retention", "vectors", "--fresh"]

    def prepare(self):
        self.demo = self.folder / "demo"
        self.cohort("demo", "--out", self.demo, "--people", self.options.meshes // 2,
                    "--vertices", self.options.vertices)
        self.cohort("run", self.demo, "--out", self.folder / "expected", "--workers", 1,
                    "--threads", 1, *self.spec())
        self.expected = contents(self.folder / "expected")
        port = free_port()
        self.direct = f"127.0.0.1:{port}"
        self.server = Process("server", [self.bin / "cohort-server", "--data",
                                         self.folder / "data", "--listen", self.direct,
                                         "--lease-seconds", str(LEASE_SECONDS)],
                              self.folder / "server.log")
        self.server.start()
        self.relay = Relay(("127.0.0.1", port))
        behind_relay = f"127.0.0.1:{self.relay.port}"
        for number, (address, more) in enumerate([
                (self.direct, ["--store", self.folder / "data" / "blobs"]),
                (self.direct, []), (behind_relay, [])]):
            self.workers.append(Process(
                f"worker-{number}",
                [self.bin / "cohort-worker", "--server", address, "--threads", str(SLOTS),
                 "--drain-seconds", "1", "--log-level", "debug", *more],
                self.folder / f"worker-{number}.log"))
            self.workers[-1].start()
        deadline = time.monotonic() + 60
        while self.cohort("jobs", "--server", self.direct, check=False).returncode != 0:
            if time.monotonic() > deadline:
                raise Failed("the server does not come up")
            time.sleep(0.1)
        self.cohort("add", *sorted(self.demo.glob("*.ply")), "--set", "faces", "--server",
                    self.direct)

    def count(self, what):
        self.counts[what] = self.counts.get(what, 0) + 1

    def disturb(self):
        """One random misfortune. A worker loses at most what its slots compute."""
        worker = self.random.choice(self.workers)
        what = self.random.choices(
            ["kill server", "kill worker", "stop worker", "terminate worker", "cut network",
             "stop server"], [3, 4, 2, 2, 3, 1])[0]
        self.count(what)
        if what == "kill server":
            self.server.end()
            time.sleep(self.random.uniform(0, 1))
            self.server.start()
        elif what == "kill worker":
            worker.end()
            self.slots_hit += SLOTS
            time.sleep(self.random.uniform(0, 1))
            worker.start()
        elif what == "stop worker":
            worker.send(signal.SIGSTOP)
            time.sleep(self.random.uniform(0.5, 2 * LEASE_SECONDS))
            worker.send(signal.SIGCONT)
            self.slots_hit += SLOTS
        elif what == "terminate worker":
            worker.send(signal.SIGTERM)
            try:
                worker.child.wait(timeout=30)
            except subprocess.TimeoutExpired as error:
                raise Failed(f"{worker.name} does not end within 30 s of SIGTERM") from error
            self.slots_hit += SLOTS
            worker.start()
        elif what == "cut network":
            self.relay.set_mode(self.random.choice(["silent", "deaf", "mute", "reset"]))
            time.sleep(self.random.uniform(0.5, 2 * LEASE_SECONDS))
            self.relay.set_mode("open")
            self.slots_hit += SLOTS
        elif what == "stop server":
            self.server.send(signal.SIGSTOP)
            time.sleep(self.random.uniform(0.2, 2))
            self.server.send(signal.SIGCONT)

    def submit_until(self, deadline, problems):
        """The client: job after job; sometimes it dies while it watches one."""
        chance = random.Random(self.options.seed + 1)
        try:
            while time.monotonic() < deadline:
                request = f"job-{len(self.jobs)}"
                command = ["submit", "--set", "faces", "--request-id", request, "--server",
                           self.direct, *self.spec()]
                result = self.cohort(*command, check=False)
                if result.returncode == 6:  # Unreachable: the same request again.
                    time.sleep(0.2)
                    continue
                if result.returncode != 0:
                    raise Failed(f"submit ended with {result.returncode}: {result.stderr.strip()}")
                self.jobs.append(result.stdout.strip())
                watch = subprocess.Popen(
                    [self.bin / "cohort", "watch", self.jobs[-1], "--server", self.direct],
                    stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
                while watch.poll() is None and time.monotonic() < deadline:
                    if chance.random() < 0.01:
                        self.count("kill client")
                        break
                    time.sleep(0.1)
                if watch.poll() is None:
                    watch.kill()
                watch.wait()
        except (Failed, subprocess.TimeoutExpired) as error:
            problems.append(error)

    def run(self):
        self.prepare()
        problems = []
        deadline = time.monotonic() + self.options.seconds
        client = threading.Thread(target=self.submit_until, args=(deadline, problems))
        client.start()
        while time.monotonic() < deadline and not problems:
            time.sleep(self.random.uniform(0.1, 1.5))
            self.disturb()
        client.join()
        if problems:
            raise problems[0]
        self.check()

    def check(self):
        """Everything is whole again: every acknowledged job ends, with the same bytes."""
        if not self.server.is_alive():
            self.server.start()
        for worker in self.workers:
            if not worker.is_alive():
                worker.start()
        tasks = 0
        for number, job in enumerate(self.jobs):
            deadline = time.monotonic() + 300
            while True:
                shown = self.cohort("status", job, "--server", self.direct, "--json", check=False)
                state = json.loads(shown.stdout) if shown.returncode == 0 else {"state": "away"}
                if state["state"] == "succeeded":
                    break
                if state["state"] in ("failed", "cancelled"):
                    raise Failed(f"{job} is {state['state']}: {state['error']}")
                if time.monotonic() > deadline:
                    raise Failed(f"{job} stands at {state}")
                time.sleep(0.2)
            tasks += state["tasks_total"]
            out = self.folder / f"results-{number}"
            self.cohort("results", job, "--out", out, "--server", self.direct)
            for name, data in contents(out).items():
                if data != self.expected[name]:
                    raise Failed(f"{job}: {name} is not that of the undisturbed run")
            shutil.rmtree(out)
        listed = self.cohort("jobs", "--server", self.direct, "--json", "--limit", 1000)
        if len(json.loads(listed.stdout)) != len(self.jobs):
            raise Failed(f"{len(self.jobs)} jobs were acknowledged, the server has "
                         f"{len(json.loads(listed.stdout))}")
        begun = sum(worker.log.read_text(errors="replace").count("event=task_begun")
                    for worker in self.workers)
        self.tasks, self.redone = tasks, begun - tasks
        if self.redone < 0:
            raise Failed(f"{tasks} tasks were done, the workers' logs tell of {begun}")
        if self.redone > self.slots_hit:
            raise Failed(f"{self.redone} tasks were begun again, at most {self.slots_hit} slots "
                         "were hit")

    def summary(self):
        broken = ", ".join(f"{count} x {what}" for what, count in sorted(self.counts.items()))
        return (f"seed {self.options.seed}, {self.options.seconds} s: {broken}; {len(self.jobs)} "
                f"jobs, {self.tasks} tasks, {self.redone} redone (at most {self.slots_hit}): all "
                "bytes equal")

    def close(self, keep):
        for process in [*self.workers, *([self.server] if self.server else [])]:
            process.end()
        if keep:
            print(f"chaos: logs and data are in {self.folder}", file=sys.stderr)
        else:
            shutil.rmtree(self.folder, ignore_errors=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--bin", default=os.environ.get("COHORT_BIN"), help="folder of programs")
    parser.add_argument("--seconds", type=float, default=120)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--runs", type=int, default=1, help="seeds SEED, SEED + 1, ...")
    parser.add_argument("--meshes", type=int, default=24)
    parser.add_argument("--vertices", type=int, default=3000)
    options = parser.parse_args()
    first = options.seed
    for seed in range(first, first + options.runs):
        options.seed = seed
        chaos = Chaos(options)
        try:
            chaos.run()
            print(f"chaos: {chaos.summary()}", flush=True)
            chaos.close(keep=False)
        except (Failed, subprocess.TimeoutExpired) as error:
            chaos.close(keep=True)
            sys.exit(f"chaos: FAILED with seed {seed} after {chaos.counts}: {error}")
        except BaseException:
            chaos.close(keep=True)
            raise


if __name__ == "__main__":
    main()
