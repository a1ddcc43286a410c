#!/usr/bin/env python3
"""Writes the skin of a tetrahedral mesh as an STL file, the form in which a segmentation usually leaves an organ.

    skin_as_stl.py MESH.mesh SKIN.stl

The skin is every face that one tetrahedron alone has, seen from outside. Coordinates stay as they are.
"""

import sys


def read_medit(path):
    """(points, tetrahedra with vertices from 0) of an ASCII MEDIT file."""
    with open(path, encoding="utf-8") as stream:
        words = iter(stream.read().split())
    points, tets = [], []
    for word in words:
        if word == "Vertices":
            points = [[float(next(words)) for _ in range(4)][:3] for _ in range(int(next(words)))]
        elif word == "Tetrahedra":
            tets = [[int(next(words)) - 1 for _ in range(5)][:4] for _ in range(int(next(words)))]
    return points, tets


def skin_of(tets):
    """The faces of one tetrahedron, each turned outward (tetrahedra are positively oriented)."""
    faces = {}
    for a, b, c, d in tets:
        for face in ((a, c, b), (a, b, d), (a, d, c), (b, c, d)):
            faces.setdefault(tuple(sorted(face)), []).append(face)
    return [owners[0] for owners in faces.values() if len(owners) == 1]


def main():
    points, tets = read_medit(sys.argv[1])
    lines = ["solid skin"]
    for face in skin_of(tets):
        lines += ["facet normal 0 0 0", "outer loop", *("vertex {!r} {!r} {!r}".format(*points[v]) for v in face), "endloop", "endfacet"]
    with open(sys.argv[2], "w", encoding="utf-8") as stream:
        stream.write("\n".join([*lines, "endsolid skin"]) + "\n")


if __name__ == "__main__":
    main()
