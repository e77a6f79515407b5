#!/usr/bin/env python3
"""Makes the matrices of tests/common/analysis/reference and what SciPy and R say of them.

usage: reference_statistics.py [FOLDER]       (apt-get install python3-scipy r-cran-vegan)

Writes distances_{a,b,c}.csv (symmetric, 16 meshes), labels.csv, scipy.txt and, by
reference_statistics.R, r.txt. The tests read these files; neither SciPy nor R is needed for them.
A line of the .txt files is a name and its numbers; versions are in comments.
"""
import pathlib
import subprocess
import sys

import numpy as np
import scipy
from scipy.cluster import hierarchy
from scipy.interpolate import interp1d
from scipy.optimize import brentq
from scipy.spatial.distance import squareform
from scipy.stats import mannwhitneyu, median_abs_deviation, spearmanr

HERE = pathlib.Path(__file__).resolve().parent
COUNT, PERSONS = 16, 6
LINKAGES = ("average", "complete", "single", "ward")


def labels():
    """Mesh, person, group: the persons have two or three meshes each, the groups six or more."""
    return [(f"m{i:02d}.ply", f"p{i % PERSONS}", "north" if i % PERSONS < 4 else "south")
            for i in range(COUNT)]


def distances(random, noise):
    """Points of people and groups, then noise on the distances: no longer Euclidean."""
    people = np.random.default_rng(7).normal(size=(PERSONS, 4))
    points = people[np.arange(COUNT) % PERSONS] + random.normal(scale=0.6, size=(COUNT, 4))
    points[:, 0] += [0.9 if group == "north" else 0.0 for _, _, group in labels()]
    matrix = np.linalg.norm(points[:, None] - points[None], axis=2)
    matrix += squareform(random.uniform(0, noise, size=COUNT * (COUNT - 1) // 2))
    np.fill_diagonal(matrix, 0)
    return matrix


def write_matrix(path, matrix):
    names = [mesh for mesh, _, _ in labels()]
    rows = [",".join(["rms", *names])]
    rows += [",".join([name, *(repr(float(v)) for v in row)]) for name, row in zip(names, matrix)]
    path.write_text("\n".join(rows) + "\n")


def verification(matrix):
    """FAR = FRR by the usual recipe on the ROC with linear steps, d' and the area."""
    persons = np.array([person for _, person, _ in labels()])
    row, column = np.tril_indices(COUNT, -1)
    scores, same = matrix[row, column], persons[row] == persons[column]
    genuine, impostor = scores[same], scores[~same]
    thresholds = np.concatenate([[-np.inf], np.unique(scores)])
    far = np.array([(impostor <= t).mean() for t in thresholds])
    frr = np.array([(genuine > t).mean() for t in thresholds])
    # A function of the place on the polyline: FAR may stand still while FRR falls.
    place = np.arange(len(thresholds))
    gap = interp1d(place, far - frr)
    at = brentq(gap, 0, len(thresholds) - 1, xtol=1e-14)
    d_prime = abs(genuine.mean() - impostor.mean()) / np.sqrt((genuine.var() + impostor.var()) / 2)
    area = mannwhitneyu(impostor, genuine).statistic / (len(genuine) * len(impostor))
    return {"equal_error_rate": [interp1d(place, far)(at)], "d_prime": [d_prime], "area": [area]}


def match_shares(matrix):
    persons = [person for _, person, _ in labels()]
    ranks = []
    for i in range(COUNT):
        others = [j for j in range(COUNT) if j != i]
        mate = min((matrix[i, j] for j in others if persons[j] == persons[i]), default=None)
        if mate is not None:
            ranks.append(1 + sum(matrix[i, j] <= mate for j in others if persons[j] != persons[i]))
    return [sum(rank <= k for rank in ranks) / len(ranks) for k in range(1, COUNT)]


def scipy_lines(a, b):
    results = {}
    for linkage in LINKAGES:
        tree = hierarchy.linkage(squareform(a), linkage)
        results[f"{linkage}_left"] = tree[:, 0]
        results[f"{linkage}_right"] = tree[:, 1]
        results[f"{linkage}_height"] = tree[:, 2]
        results[f"{linkage}_size"] = tree[:, 3]
        results[f"{linkage}_leaves"] = hierarchy.leaves_list(tree)
        results[f"{linkage}_three_clusters"] = hierarchy.fcluster(tree, 3, "maxclust")
    results["pearson"] = [np.corrcoef(squareform(a), squareform(b))[0, 1]]
    results["spearman"] = [spearmanr(squareform(a), squareform(b)).correlation]
    results["match_share"] = match_shares(a)
    results.update(verification(a))
    means = a.sum(axis=1) / (COUNT - 1)
    results["robust_z"] = 0.6745 * (means - np.median(means)) / median_abs_deviation(means)
    yield f"# scipy {scipy.__version__}, numpy {np.__version__}"
    for name, values in results.items():
        yield " ".join([name, *(repr(float(v)) for v in values)])


def main():
    folder = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else \
        HERE.parent / "common" / "analysis" / "reference"
    random = np.random.default_rng(20261122)
    matrices = [distances(random, noise) for noise in (0.4, 1.5, 0.8)]
    for name, matrix in zip("abc", matrices):
        write_matrix(folder / f"distances_{name}.csv", matrix)
    rows = ["file,person,group", *(",".join(row) for row in labels())]
    (folder / "labels.csv").write_text("\n".join(rows) + "\n")
    (folder / "scipy.txt").write_text("\n".join(scipy_lines(*matrices[:2])) + "\n")
    subprocess.run(["Rscript", HERE / "reference_statistics.R", folder], check=True)


if __name__ == "__main__":
    main()
