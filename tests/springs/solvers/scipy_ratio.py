#!/usr/bin/python3
"""Our identification beside SciPy's lsq_linear, in one run and on the same rows: same answer? how much faster?

    tests/springs/solvers/scipy_ratio.py build/release/bin/palpate [--vertices 1300 10000] [--repeats 5]

For each size the program makes a kidney (or --mesh FILE gives one), identifies `isotropy_patch` springs and says how long
that took (kernel_s, reading and writing left out). The same rows are built here from their definition, with NumPy, and given
to scipy.optimize.lsq_linear with bounds (0, inf), columns scaled to length one, and the tolerance that brings its KKT residual
to ours or the best it does. Prints one JSON object a size. Exit code 1 if the answers differ.
A benchmark, run by hand: it takes minutes, and measures time. Needs SciPy (Debian: python3-scipy), which nothing else does.
"""
import argparse
import json
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

import numpy
import scipy
import scipy.optimize
import scipy.sparse

YOUNG_PA = 1.0e4
MONOMIALS_4 = [(i, j, 4 - i - j) for i in range(5) for j in range(5 - i)]
MONOMIALS_3 = [(i, j, 3 - i - j) for i in range(4) for j in range(4 - i)]
FACTORIAL = [1, 1, 2, 6, 24]


def multiplicity(powers):
    """Number of places of a symmetric tensor that hold the monomial."""
    i, j, k = powers
    return FACTORIAL[i + j + k] // (FACTORIAL[i] * FACTORIAL[j] * FACTORIAL[k])


def sphere_mean(powers):
    """Mean of x^i y^j z^k over the unit sphere, i + j + k = 4."""
    if any(power % 2 for power in powers):
        return 0.0
    return 1.0 / 5.0 if 4 in powers else 1.0 / 15.0


def read_mesh(path, unit_m):
    """Points in metres and tetrahedra of a MEDIT file."""
    words = pathlib.Path(path).read_text(encoding="ascii").split()
    at = words.index("Vertices")
    count = int(words[at + 1])
    points = numpy.array(words[at + 2:at + 2 + 4 * count], dtype=float).reshape(-1, 4)[:, :3] * unit_m
    at = words.index("Tetrahedra")
    count = int(words[at + 1])
    tets = numpy.array(words[at + 2:at + 2 + 5 * count], dtype=int).reshape(-1, 5)[:, :4] - 1
    return points, tets


def read_springs(path):
    table = numpy.loadtxt(path, delimiter=",", skiprows=1)
    return table[:, :2].astype(int), table[:, 2], table[:, 3]


def vertex_volumes_and_areas(points, tets):
    """A quarter of the tets' volumes and a third of the boundary faces' outward area vectors, a vertex."""
    corner = points[tets]
    volume = numpy.einsum("ij,ij->i", numpy.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]),
                          corner[:, 3] - corner[:, 0]) / 6.0
    assert (volume > 0).all(), "the mesh has inverted tetrahedra"
    volumes = numpy.zeros(len(points))
    for local in range(4):
        numpy.add.at(volumes, tets[:, local], volume / 4.0)
    faces = numpy.concatenate([tets[:, local] for local in ([1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1])])
    _, first, uses = numpy.unique(numpy.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
    boundary = faces[first[uses == 1]]
    area = numpy.cross(points[boundary[:, 1]] - points[boundary[:, 0]],
                       points[boundary[:, 2]] - points[boundary[:, 0]]) / 2.0
    areas = numpy.zeros((len(points), 3))
    for local in range(3):
        numpy.add.at(areas, boundary[:, local], area / 3.0)
    return volumes, areas


def build_rows(points, tets, springs, rest_length):
    """The 15 isotropy and 10 patch rows a vertex for w = k U^2, and their right-hand side."""
    volumes, areas = vertex_volumes_and_areas(points, tets)
    ends = numpy.concatenate([springs[:, 0], springs[:, 1]])
    spring = numpy.tile(numpy.arange(len(springs)), 2)
    unit = (points[springs[:, 1]] - points[springs[:, 0]]) / rest_length[:, None]
    direction = numpy.concatenate([unit, -unit])
    length = numpy.tile(rest_length, 2)
    degree = numpy.bincount(ends, minlength=len(points))
    mean_length = numpy.bincount(ends, weights=length, minlength=len(points)) / degree
    row, column, value = [], [], []
    rhs = numpy.zeros((len(points), 25))
    for number, powers in enumerate(MONOMIALS_4):
        weight = numpy.sqrt(multiplicity(powers))
        row.append(25 * ends + number)
        column.append(spring)
        value.append(weight * numpy.prod(direction ** numpy.array(powers), axis=1))
        rhs[:, number] = weight * 12.0 * YOUNG_PA * volumes * sphere_mean(powers)
    for number, powers in enumerate(MONOMIALS_3, start=15):
        weight = numpy.sqrt(multiplicity(powers))
        row.append(25 * ends + number)
        column.append(spring)
        value.append(weight * mean_length[ends] / length * numpy.prod(direction ** numpy.array(powers), axis=1))
        axes = [axis for axis, power in enumerate(powers) for _ in range(power)]
        tensor = sum((axes[b] == axes[c]) * areas[:, axes[a]] for a, b, c in ((0, 1, 2), (1, 0, 2), (2, 0, 1)))
        rhs[:, number] = -weight * mean_length * YOUNG_PA / 2.5 * tensor
    matrix = scipy.sparse.csr_matrix(
        (numpy.concatenate(value), (numpy.concatenate(row), numpy.concatenate(column))),
        shape=(25 * len(points), len(springs)))
    return matrix, rhs.ravel()


def kkt_relative(scaled, rhs, z):
    """max |min(z, g)| / max |A^T b|, columns of length one: the definition in nonnegative_least_squares.cpp."""
    gradient = scaled.T @ (scaled @ z - rhs)
    return float(numpy.abs(numpy.minimum(z, gradient)).max() / numpy.abs(scaled.T @ rhs).max())


def run_ours(program, mesh, folder, repeats):
    """Median kernel time, the report of the last run, and the springs that it wrote."""
    times = []
    csv = pathlib.Path(folder) / "springs.csv"
    for _ in range(repeats):
        done = subprocess.run([program, "springs", mesh, "-o", str(csv), "--method", "isotropy_patch", "--young-pa",
                               str(YOUNG_PA), "--poisson", "0.25", "--unit-m", "0.001", "--json"],
                              check=True, capture_output=True, text=True)
        report = json.loads(done.stdout)
        times.append(report["kernel_s"])
    return statistics.median(times), report, read_springs(csv)


def run_scipy(matrix, rhs):
    """Time and answer of lsq_linear on columns of length one (which favours it)."""
    norms = numpy.sqrt(matrix.multiply(matrix).sum(axis=0)).A1
    scaled = (matrix @ scipy.sparse.diags(1.0 / norms)).tocsr()
    start = time.perf_counter()
    answer = scipy.optimize.lsq_linear(scaled, rhs, bounds=(0.0, numpy.inf), tol=1e-12, lsmr_tol=1e-12, max_iter=500)
    seconds = time.perf_counter() - start
    return seconds, answer, scaled, norms


def compare(program, mesh, unit_m, repeats, folder):
    seconds, report, (springs, rest_length, stiffness) = run_ours(program, mesh, folder, repeats)
    points, tets = read_mesh(mesh, unit_m)
    matrix, rhs = build_rows(points, tets, springs, rest_length)
    scipy_seconds, answer, scaled, norms = run_scipy(matrix, rhs)
    ours = stiffness * rest_length ** 2 * norms
    size = numpy.abs(ours).max()
    return {
        "vertices": len(points), "springs": len(springs),
        "ours_s": seconds, "scipy_s": scipy_seconds, "ratio": scipy_seconds / seconds,
        "ours_kkt": kkt_relative(scaled, rhs, ours), "ours_kkt_reported": report["kkt_relative"],
        "scipy_kkt": kkt_relative(scaled, rhs, answer.x), "scipy_status": int(answer.status),
        "scipy_iterations": int(answer.nit),
        "largest_difference": float(numpy.abs(ours - answer.x).max() / size),
        "ours_objective": float(((scaled @ ours - rhs) ** 2).sum() / (rhs ** 2).sum()),
        "scipy_objective": float(((scaled @ answer.x - rhs) ** 2).sum() / (rhs ** 2).sum()),
        "scipy": scipy.__version__,
    }


def agrees(row):
    """Ours is a KKT point of rows that were built apart from it, and no worse than SciPy's; both are one answer as far
    as SciPy's own residual says."""
    return (row["ours_kkt"] <= 1.1e-10 and row["ours_objective"] <= row["scipy_objective"] * (1.0 + 1e-12)
            and row["largest_difference"] <= max(1e-6, 1e3 * row["scipy_kkt"]))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("--vertices", type=int, nargs="*", default=[1300, 10000])
    parser.add_argument("--mesh", nargs="*", default=[], help="MEDIT files in millimetres, beside those made")
    parser.add_argument("--repeats", type=int, default=5)
    arguments = parser.parse_args()
    fine = True
    with tempfile.TemporaryDirectory() as folder:
        meshes = list(arguments.mesh)
        for vertices in arguments.vertices:
            path = str(pathlib.Path(folder) / f"kidney_{vertices}.mesh")
            subprocess.run([arguments.program, "make", "kidney", "-o", path, "--vertices", str(vertices)],
                           check=True, capture_output=True)
            meshes.append(path)
        for mesh in meshes:
            row = compare(arguments.program, mesh, 0.001, arguments.repeats, folder)
            row["same_answer"] = bool(agrees(row))
            fine = fine and row["same_answer"]
            print(json.dumps(row), flush=True)
    return 0 if fine else 1


if __name__ == "__main__":
    sys.exit(main())
