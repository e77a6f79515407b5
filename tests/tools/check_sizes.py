#!/usr/bin/env python3
"""Fails when a source is longer than 500 lines or carries a name that says nothing (STYLE).

usage: check_sizes.py [ROOT]

Functions are measured by clang-tidy (readability-function-size). Sources over 300 lines are named
without failing. Prints "file:line: reason" for each violation and exits with 1.
"""
import pathlib
import sys

sys.dont_write_bytecode = True
import check_layers  # noqa: E402

HARD_LINES, SOFT_LINES = 500, 300
EMPTY_NAMES = {"util", "utils", "helper", "helpers", "manager", "misc", "data", "info"}
SOURCES = (".h", ".cc", ".proto", ".py", ".sh", ".cmake")


def main():
    default = pathlib.Path(__file__).resolve().parents[2]
    root = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else default
    found, long = [], []
    for path in check_layers.project_files(root):
        if not path.endswith(SOURCES):
            continue
        lines = (root / path).read_text().count("\n")
        if lines > HARD_LINES:
            found.append(f"{path}:{lines}: {lines} lines, at most {HARD_LINES} are allowed")
        elif lines > SOFT_LINES:
            long.append(f"{path}: {lines} lines")
        if pathlib.PurePosixPath(path).stem.removesuffix("_test") in EMPTY_NAMES:
            found.append(f"{path}:1: the name says nothing")
    if long:
        print(f"over {SOFT_LINES} lines, is each still one thing?  " + ";  ".join(long))
    print("\n".join(found) or "sizes ok")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
