#!/usr/bin/env python3
"""Writes the table of a job's options in README.md from what `cohort submit --help` prints, or
checks that it is what would be written.
  usage: readme_options.py --cohort PROGRAM [--readme README.md] [--check]
"""
import argparse
import re
import subprocess
import sys
from pathlib import Path

BEGIN = "<!-- from `cohort submit --help`, by tests/tools/readme_options.py -->"
END = "<!-- end of what tests/tools/readme_options.py writes -->"
GROUPS = ("Job", "Alignment", "Comparison")


def read_groups(text):
    """{group: [(option, kind, default, meaning)]} of a CLI11 help text."""
    groups = {}
    group = None
    for line in text.splitlines():
        heading = re.fullmatch(r"(\w[\w ]*):", line)
        if heading:
            group = groups.setdefault(heading[1], [])
            continue
        option = re.match(r"  (--[\w-]+)(?: (\S.*?))?(?:\s{2,}(.*)|$)", line)
        if option and group is not None:
            group.append([option[1], option[2] or "", option[3] or ""])
        elif group and re.match(r"\s{10,}\S", line):
            group[-1][2] = (group[-1][2] + " " + line.strip()).strip()
        elif line and not line.startswith(" "):
            group = None
    return {name: [parse(*option) for option in groups.get(name, [])] for name in GROUPS}


def parse(name, kind, text):
    # "TEXT=average", "INT:INT in [-100 - 100]=0", "FLOAT ...": the kind, its range, its default.
    shape = re.fullmatch(r"([A-Z]+)?(?::.*? in \[.*?\])?(?:=(\S+))?(?: \.\.\.)?(?: REQUIRED)?", kind)
    if shape is None:
        raise ValueError(f"{name}: cannot read '{kind}'")
    default = shape[2]
    bracket = re.fullmatch(r"(.*?) \[([^\[\]]+)\]", text)
    if default is None and bracket:
        text, default = bracket[1], bracket[2]
    if default is None:
        default = "-" if shape[1] else "off"
    return name, shape[1] or "", default, text


def table(groups):
    lines = ["| option | default | what it says |", "|---|---|---|"]
    for group in GROUPS:
        if not groups[group]:
            raise ValueError(f"the help has no group '{group}'")
        lines.append(f"| **{group}** | | |")
        for name, kind, default, meaning in groups[group]:
            value = f" {kind}" if kind else ""
            meaning = meaning.replace("|", "\\|")
            lines.append(f"| `{name}{value}` | {default} | {meaning} |")
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--cohort", required=True)
    parser.add_argument("--readme", default=Path(__file__).parents[2] / "README.md", type=Path)
    parser.add_argument("--check", action="store_true")
    arguments = parser.parse_args()
    text = subprocess.run([arguments.cohort, "submit", "--help"], check=True, text=True,
                          stdout=subprocess.PIPE).stdout
    readme = arguments.readme.read_text()
    if readme.count(BEGIN) != 1 or readme.count(END) != 1:
        sys.exit(f"{arguments.readme}: expected one line '{BEGIN}' and one '{END}'")
    before, rest = readme.split(BEGIN)
    _, after = rest.split(END)
    written = f"{before}{BEGIN}\n\n{table(read_groups(text))}\n\n{END}{after}"
    if written == readme:
        return
    if arguments.check:
        sys.exit(f"{arguments.readme}: its table of options is not what the program says; "
                 f"run tests/tools/readme_options.py --cohort {arguments.cohort}")
    arguments.readme.write_text(written)


if __name__ == "__main__":
    main()
