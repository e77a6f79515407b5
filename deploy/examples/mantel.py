#!/usr/bin/env python3
"""Results of two jobs in numpy: matrices with their labels, and the Mantel test.

usage: mantel.py RESULTS_A RESULTS_B [PERMUTATIONS]

Prints what `cohort mantel RESULTS_A RESULTS_B` prints: r, and p within the chance of permutations.
"""
import pathlib
import sys

import numpy


def read_matrix(folder):
    """Labels and N x N values; row = source, column = target."""
    folder = pathlib.Path(folder)
    return (folder / "labels.txt").read_text().splitlines(), numpy.load(folder / "matrix.npy")


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    permutations = int(sys.argv[3]) if len(sys.argv) > 3 else 9999
    labels, a = read_matrix(sys.argv[1])
    other_labels, b = read_matrix(sys.argv[2])
    if set(labels) != set(other_labels):
        sys.exit(f"{sys.argv[1]} and {sys.argv[2]} are of different meshes")
    # The same meshes in the same order.
    places = [other_labels.index(label) for label in labels]
    b = b[numpy.ix_(places, places)]

    lower = numpy.tril_indices(len(labels), -1)
    r = numpy.corrcoef(a[lower], b[lower])[0, 1]
    random = numpy.random.default_rng(1)
    as_extreme = 0
    for _ in range(permutations):
        order = random.permutation(len(labels))
        permuted = a[numpy.ix_(order, order)]
        as_extreme += numpy.corrcoef(permuted[lower], b[lower])[0, 1] >= r - 1.5e-8
    print(f"meshes {len(labels)}\nr {r:.15g}\np {(1 + as_extreme) / (1 + permutations):.6g}")


if __name__ == "__main__":
    main()
