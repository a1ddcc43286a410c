"""Merges inner vertices into neighbours, shortest edges first, until few enough tetrahedra are left. The skin stays as it is."""
import collections
import json
import math
import sys
import time


def read_mesh(path):
    words, blocks = open(path, encoding="utf-8").read().split(), []
    for name, width, kind in (("Vertices", 3, float), ("Tetrahedra", 4, int)):  # rows with a reference at their end
        start = words.index(name) + 2
        rows = range(start, start + int(words[start - 1]) * (width + 1), width + 1)
        blocks.append([tuple(map(kind, words[row:row + width])) for row in rows])
    return blocks[0], [tuple(v - 1 for v in tet) for tet in blocks[1]]


def volume(points, tet):
    u, v, w = ([p - q for p, q in zip(points[corner], points[tet[0]])] for corner in tet[1:])
    return (u[0] * (v[1] * w[2] - v[2] * w[1]) - u[1] * (v[0] * w[2] - v[2] * w[0]) + u[2] * (v[0] * w[1] - v[1] * w[0])) / 6


def simplify(points, tets, target, least):
    """A merger is taken where every volume stays above `least` of the smallest around the vertex."""
    faces = collections.Counter(tuple(sorted(set(tet) - {v})) for tet in tets for v in tet)
    skin = {v for face, count in faces.items() if count == 1 for v in face}
    before, tets = None, dict.fromkeys(tets)
    while len(tets) > target and len(tets) != before:
        before, touched, stars = len(tets), set(), collections.defaultdict(list)
        for tet in tets:
            for v in tet:
                stars[v].append(tet)
        pairs = {(v, other) for tet in tets for v in tet if v not in skin for other in tet if other != v}
        for gone, kept in sorted(pairs, key=lambda pair: (math.dist(points[pair[0]], points[pair[1]]), pair)):
            if gone in touched or len(tets) <= target:
                continue
            moved = [tuple(kept if v == gone else v for v in tet) for tet in stars[gone] if kept not in tet]
            smallest = min(volume(points, tet) for tet in stars[gone])
            if all(volume(points, tet) > least * smallest for tet in moved):
                for tet in stars[gone]:
                    touched.update(tet)
                    del tets[tet]
                tets.update(dict.fromkeys(moved))
    return list(tets)


request = json.load(open(sys.argv[1], encoding="utf-8"))
points, tets = read_mesh(request["mesh_in"])
target = request["stop"].get("tets", len(tets) * (1 - request["stop"].get("ratio", 1)))  # or as far as it goes: limit
start = time.perf_counter()
left = simplify(points, tets, target, request["options"]["least_volume"])
kernel_s = time.perf_counter() - start  # the method alone: neither reading nor writing
used = {v: number for number, v in enumerate(sorted({v for tet in left for v in tet}), start=1)}
with open(request["mesh_out"], "w", encoding="utf-8") as out:
    rows = [f"{x!r} {y!r} {z!r} 0" for x, y, z in (points[v] for v in used)] + ["Tetrahedra", str(len(left))]
    rows += [" ".join(str(used[v]) for v in tet) + " 0" for tet in left]
    out.write("\n".join(["MeshVersionFormatted 2", "Dimension 3", "Vertices", str(len(used)), *rows, "End", ""]))
report = {"tets_in": len(tets), "tets_out": len(left)}
json.dump({"schema": "palpate/response/1", "status": "ok", "kernel_s": kernel_s, "report": report}, open(sys.argv[2], "w", encoding="utf-8"))
