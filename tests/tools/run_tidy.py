#!/usr/bin/env python3
"""Runs clang-tidy-14 on the sources of a build folder, so that what changed last is seen first.

usage: run_tidy.py [--build build/release] [--budget-seconds 600] [--jobs N] [--fresh] [FILE.cc ...]

A source that passed once is not checked again until it, a header it includes, its compile command
or a .clang-tidy above it changes; that memory is ~/.cache/cohort-tidy, and --fresh ignores it. When
the budget is used up no further source is started, and those left out are named: by the order they
are those whose own text changed longest ago. A changed header counts as seen with one source that
includes it. Needs a finished Ninja build, which knows the headers of each source. Exits with 1 if a
source has findings.
"""
import argparse
import concurrent.futures
import hashlib
import json
import math
import os
import pathlib
import shlex
import subprocess
import sys
import time

TIDY = "clang-tidy-14"


def output_of(*command, cwd=None):
    return subprocess.run(command, cwd=cwd, capture_output=True, check=True).stdout.decode()


def read_headers(build):
    """Object file -> the files its source includes, as Ninja recorded them."""
    headers, current = {}, []
    for line in output_of("ninja", "-C", str(build), "-t", "deps").splitlines():
        if line.startswith("    "):
            current.append(os.path.normpath(build / line.strip()))
        elif ": #deps" in line:
            current = headers.setdefault(line.split(": #deps")[0], [])
    return headers


def source_path(entry):
    return pathlib.Path(os.path.normpath(pathlib.Path(entry["directory"]) / entry["file"]))


def ages(root):
    """Tracked path -> number of commits since it changed; 0 for what is not committed."""
    order, commit = {}, 0
    changed = output_of("git", "-C", root, "status", "--porcelain", "--untracked-files=all")
    for line in changed.splitlines():
        order[line[3:]] = 0
    log = output_of("git", "-C", root, "log", "--format=tformat:@", "--name-only")
    for line in log.splitlines():
        if line == "@":
            commit += 1
        elif line:
            order.setdefault(line, commit)
    return order


class Source:
    """One translation unit and the files of the repository in it."""

    def __init__(self, root, build, entry, headers):
        self.path = source_path(entry)
        self.name = self.path.relative_to(root).as_posix()
        arguments = shlex.split(entry["command"])
        target = arguments[arguments.index("-o") + 1]
        self.headers = sorted(headers.get(target, []))
        self.command = entry["command"].replace(str(build), "BUILD").replace(str(root), "ROOT")
        self.own = {self.name} | {os.path.relpath(path, root) for path in self.headers
                                  if path.startswith(f"{root}/")}

    def rules(self, root):
        """The texts of the .clang-tidy files that apply, the root's first."""
        folders = reversed(self.path.relative_to(root).parents)
        files = [root / folder / ".clang-tidy" for folder in folders]
        return "".join(file.read_text() for file in files if file.exists())

    def key(self, root, version):
        digest = hashlib.sha256((version + self.rules(root) + self.command).encode())
        for path in [str(self.path)] + self.headers:
            if path.startswith(str(root)):
                digest.update(os.path.relpath(path, root).encode())
                digest.update(pathlib.Path(path).read_bytes())
            else:
                digest.update(f"{path} {os.stat(path).st_size}".encode())
        return digest.hexdigest()


def sources_of(root, build, wanted):
    headers = read_headers(build)
    found = {}
    for entry in json.loads((build / "compile_commands.json").read_text()):
        path = str(source_path(entry))
        if not path.startswith(f"{root}/") or path.startswith(f"{build}/"):
            continue
        source = Source(root, build, entry, headers)
        if not wanted or source.path in wanted:
            found.setdefault(source.name, source)
    return found


def newest_first(sources, age):
    """The sources by their own age; each header with the first source that shows it.

    A header that no source before it includes is shown by its own .cc, else by the source with the
    fewest headers.
    """
    def rank(name):
        return age.get(name, math.inf), name not in sources, name

    shown, order = set(), {}
    files = set().union(*(source.own for source in sources.values()))
    for name in sorted(files, key=rank):
        if name in sources:
            chosen = sources[name]
        elif name not in shown:
            own = os.path.splitext(name)[0] + ".cc"
            chosen = min((source for source in sources.values() if name in source.own),
                         key=lambda source: (source.name != own, len(source.headers), source.name))
        else:
            continue
        order[chosen.name] = chosen
        shown |= chosen.own
    return list(order.values())


def check(build, source):
    start = time.monotonic()
    done = subprocess.run([TIDY, "-quiet", "-p", str(build), str(source.path)], check=False,
                          stdin=subprocess.DEVNULL, capture_output=True)
    text = done.stdout.decode() or done.stderr.decode()  # stderr else only counts warnings
    return done.returncode, text, time.monotonic() - start


def run(build, pending, jobs, deadline, passed):
    """Checks `pending` in order until `deadline`; returns (names with findings, names left out)."""
    bad, left_out = [], []

    def one(item):
        source, key = item
        if time.monotonic() >= deadline:
            left_out.append(source.name)
            return
        status, text, seconds = check(build, source)
        print(f"  {'ok ' if status == 0 else 'BAD'} {seconds:5.1f} s  {source.name}", flush=True)
        if status == 0:
            (passed / key).touch()
        else:
            print(text, flush=True)
            bad.append(source.name)

    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        list(pool.map(one, pending))
    return sorted(bad), sorted(left_out)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--build", default="build/release", type=pathlib.Path)
    parser.add_argument("--budget-seconds", default=600, type=float)
    parser.add_argument("--jobs", default=os.cpu_count(), type=int)
    parser.add_argument("--fresh", action="store_true")
    parser.add_argument("files", nargs="*", type=pathlib.Path)
    options = parser.parse_args()
    root = pathlib.Path(__file__).resolve().parents[2]
    build = options.build.resolve()

    passed = pathlib.Path(os.environ.get("XDG_CACHE_HOME", pathlib.Path.home() / ".cache"))
    passed = passed / "cohort-tidy"
    passed.mkdir(parents=True, exist_ok=True)
    version = output_of(TIDY, "--version")
    sources = newest_first(sources_of(root, build, {path.resolve() for path in options.files}),
                           ages(root))
    keyed = [(source, source.key(root, version)) for source in sources]
    pending = [item for item in keyed if options.fresh or not (passed / item[1]).exists()]
    print(f"clang-tidy: {len(sources)} sources, {len(sources) - len(pending)} passed before "
          f"unchanged, {len(pending)} to check on {options.jobs} cores", flush=True)

    deadline = time.monotonic() + options.budget_seconds
    bad, left_out = run(build, pending, options.jobs, deadline, passed)
    for name in left_out:
        print(f"  left out for lack of time: {name}")
    for name in bad:
        print(f"  has findings: {name}")
    good = len(pending) - len(left_out) - len(bad)
    print(f"clang-tidy: {good} passed, {len(bad)} with findings, {len(left_out)} left out")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
