"""Optimises planar pose graphs with GTSAM, to be compared with `cairn graph`.

    python3 -m venv venv && venv/bin/pip install gtsam numpy
    venv/bin/python pose_graphs.py [--repeat N] FILE.g2o ...

Both begin at the poses of the file, or, when it has none, along the edges: those between
consecutive vertices first. The first vertex is held by a prior. One line for each file and method:
name, vertices, edges, chi2 at the start and at the end (twice GTSAM's error, without the prior),
iterations, and medians in milliseconds of reading the file, of optimising, and of both.
"""

import argparse
import statistics
import time

import gtsam
import numpy as np


def edges_of(graph):
    """Ends and measurement of every edge, in the order of the file."""
    for index in range(graph.size()):
        factor = graph.at(index)
        if isinstance(factor, gtsam.BetweenFactorPose2):
            first, second = factor.keys()
            yield first, second, factor.measured()


def along_edges(graph):
    """Poses made from the edges, for a file without poses."""
    edges = list(edges_of(graph))
    parent = {}

    def root(vertex):
        parent.setdefault(vertex, vertex)
        while parent[vertex] != vertex:
            parent[vertex] = parent[parent[vertex]]
            vertex = parent[vertex]
        return vertex

    steps = {}
    consecutive = [e for e in edges if abs(e[0] - e[1]) == 1]
    others = [e for e in edges if abs(e[0] - e[1]) != 1]
    for first, second, measured in consecutive + others:
        a, b = root(first), root(second)
        if a != b:
            parent[max(a, b)] = min(a, b)
            steps.setdefault(first, []).append((second, measured))
            steps.setdefault(second, []).append((first, measured.inverse()))
    values = gtsam.Values()
    for start in sorted(parent):
        if values.exists(start):
            continue
        values.insert(start, gtsam.Pose2())
        open_vertices = [start]
        while open_vertices:
            vertex = open_vertices.pop()
            pose = values.atPose2(vertex)
            for other, measured in steps.get(vertex, []):
                if not values.exists(other):
                    values.insert(other, pose.compose(measured))
                    open_vertices.append(other)
    return values


def has_poses(path):
    with open(path, encoding="ascii", errors="replace") as lines:
        return any(line.startswith("VERTEX_SE2") for line in lines)


def read(path):
    graph, values = gtsam.readG2o(path, False)
    return graph, values


def optimise(method, graph, values):
    if method == "gauss_newton":
        optimiser = gtsam.GaussNewtonOptimizer(graph, values, gtsam.GaussNewtonParams())
    else:
        optimiser = gtsam.LevenbergMarquardtOptimizer(
            graph, values, gtsam.LevenbergMarquardtParams()
        )
    result = optimiser.optimize()
    return result, optimiser.iterations()


def measure(path, method, repeat):
    reading, optimising, both = [], [], []
    is_placed = has_poses(path)
    for _ in range(repeat):
        begin = time.perf_counter()
        graph, values = read(path)
        read_at = time.perf_counter()
        # What Python does in between is not counted.
        if not is_placed:
            values = along_edges(graph)
        anchor = min(values.keys())
        prior = gtsam.noiseModel.Diagonal.Sigmas(np.full(3, 1e-4))
        held = gtsam.NonlinearFactorGraph(graph)
        held.add(gtsam.PriorFactorPose2(anchor, values.atPose2(anchor), prior))
        ready = time.perf_counter()
        result, iterations = optimise(method, held, values)
        end = time.perf_counter()
        reading.append(1e3 * (read_at - begin))
        optimising.append(1e3 * (end - ready))
        both.append(reading[-1] + optimising[-1])
    name = path.rsplit("/", 1)[-1]
    print(
        f"{name:<20}{method:<22}{values.size():>8}{graph.size():>8}"
        f"{2 * graph.error(values):>14.6e}{2 * graph.error(result):>14.4f}{iterations:>6}"
        f"{statistics.median(reading):>10.2f}{statistics.median(optimising):>12.2f}"
        f"{statistics.median(both):>10.2f}{min(both):>10.2f}",
        flush=True,
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("files", nargs="+")
    parser.add_argument("--repeat", type=int, default=5)
    arguments = parser.parse_args()
    print(
        f"{'file':<20}{'method':<22}{'vertices':>8}{'edges':>8}{'chi2 start':>14}{'chi2 end':>14}"
        f"{'iter':>6}{'read ms':>10}{'optimise ms':>12}{'both ms':>10}{'least':>10}"
    )
    for path in arguments.files:
        for method in ["gauss_newton", "levenberg_marquardt"]:
            measure(path, method, arguments.repeat)


if __name__ == "__main__":
    main()
