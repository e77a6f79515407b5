#!/usr/bin/env python3
"""Writes README.md's table of speeds from the table that `tests/bench/run.sh --readme` has written
into tests/bench/README.md, or checks that it is what would be written.
  usage: readme_figures.py [--check]
"""
import re
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
BEGIN = "<!-- from tests/bench/README.md, by tests/tools/readme_figures.py -->"
END = "<!-- end of what tests/tools/readme_figures.py writes -->"
SIZES = ("10k", "20k", "60k")
# What README calls a figure, the rival, and the rows of the benchmark: {} is the size.
FIGURES = (
    ("all nearest vertices, AVX-512", "nanoflann 1.4.3", "all nearest neighbours, {}, AVX-512"),
    ("the same, AVX2", "nanoflann 1.4.3", "all nearest neighbours, {}, AVX2"),
    ("the same, without either", "nanoflann 1.4.3", "all nearest neighbours, {}, portable"),
    ("nearest points of a surface", "Embree", "vertex to surface against Embree, {}"),
    ("the same", "CGAL", "vertex to surface against CGAL, {}"),
    ("one pass of ICP", "nanoflann and sums", "converged ICP pass, {}"),
    ("ICP to 1e-6 mm, symmetric scale", "plain ICP on nanoflann",
     "whole alignment to 1e-6 mm, {}, scale symmetric"),
    ("preview matrix", "exact pairs", "preview matrix of 60 meshes, {}"),
)


def read_rows(text):
    """{figure: "14.1 x"} of the benchmark's table."""
    rows = {}
    for line in text.splitlines():
        cells = [cell.strip() for cell in line.split("|")]
        if len(cells) >= 6 and re.match(r"[\d.]+ x", cells[3]):
            rows[cells[1]] = re.match(r"[\d.]+ x", cells[3])[0]
    return rows


def table(rows):
    lines = ["| figure | against | " + " | ".join(SIZES) + " vertices |", "|---" * 5 + "|"]
    for name, rival, row in FIGURES:
        values = [rows.get(row.format(size), "") for size in SIZES]
        if not any(values):
            raise ValueError(f"the benchmark's table has no row '{row}'")
        lines.append(f"| {name} | {rival} | " + " | ".join(values) + " |")
    return "\n".join(lines)


def main():
    readme = ROOT / "README.md"
    before, rest = readme.read_text().split(BEGIN)
    _, after = rest.split(END)
    rows = read_rows((ROOT / "tests/bench/README.md").read_text())
    written = f"{before}{BEGIN}\n\n{table(rows)}\n\n{END}{after}"
    if written == readme.read_text():
        return
    if "--check" in sys.argv[1:]:
        sys.exit("README.md: its table of speeds is not that of tests/bench/README.md; run "
                 "tests/tools/readme_figures.py")
    readme.write_text(written)


if __name__ == "__main__":
    main()
