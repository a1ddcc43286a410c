"""Linear finite elements at small strain, solved densely: for bodies of some thousand unknowns."""
import json
import sys
import time

import numpy as np


def read_mesh(path):
    words, blocks = open(path, encoding="utf-8").read().split(), []
    for name, width in (("Vertices", 4), ("Tetrahedra", 5)):  # the last number of a row is a reference
        start = words.index(name) + 2
        rows = words[start:start + int(words[start - 1]) * width]
        blocks.append(np.array(rows, float).reshape(-1, width)[:, :-1])
    return blocks[0], blocks[1].astype(int) - 1


def assemble(points, tets, problem):
    """Stiffness of the body, of its supports, and the load: gravity, supports that are moved, tractions, pressure, forces."""
    body, supports, load = np.zeros((*points.shape, *points.shape)), np.zeros((*points.shape, *points.shape)), np.zeros(points.shape)
    young, nu, density = (problem["material"][key] for key in ("young_modulus_pa", "poisson_ratio", "density_kg_m3"))
    lame, shear = young * nu / ((1 + nu) * (1 - 2 * nu)), young / (2 * (1 + nu))
    for tet in tets:
        edges = (points[tet[1:]] - points[tet[0]]).T
        inverse, size = np.linalg.inv(edges), np.linalg.det(edges) / 6
        g = np.vstack([-inverse.sum(axis=0), inverse])  # gradients of the four shape functions
        block = lame * np.einsum("ai,bj->aibj", g, g) + shear * np.einsum("aj,bi->aibj", g, g)
        block += shear * np.einsum("ak,bk,ij->aibj", g, g, np.eye(3))
        body[np.ix_(tet, range(3), tet, range(3))] += size * block
        load[tet] += density * size / 4 * np.array(problem["gravity_m_s2"])
    for region in problem["supports"] + problem["tractions"]:
        for face, weight in zip(region["faces"], region["weight"]):
            normal = weight * np.cross(*(points[face[1:]] - points[face[0]])) / 2  # its size is the area
            if "stiffness_pa_per_m" in region:
                mass = np.linalg.norm(normal) * region["stiffness_pa_per_m"] / 12 * (1 + np.eye(3))
                supports[np.ix_(face, range(3), face, range(3))] += np.einsum("ab,ij->aibj", mass, np.eye(3))
                load[face] += mass.sum(axis=1)[:, None] * np.array(region["by_m"])
            else:
                load[face] += (np.linalg.norm(normal) * np.array(region["traction_pa"]) - region["pressure_pa"] * normal) / 3
    for force in problem["nodal_forces"]:
        load[force["vertex"]] += force["force_n"]
    return body.reshape(load.size, -1), supports.reshape(load.size, -1), load.ravel()


request, clock = json.load(open(sys.argv[1], encoding="utf-8")), time.perf_counter
problem, (points, tets) = json.load(open(request["problem_in"], encoding="utf-8")), read_mesh(request["mesh_in"])
start = clock()
body, supports, load = assemble(points, tets, problem)
moved = {3 * v + a: part["by_m"][a] for part in problem["held"] for face in part["faces"] for v in face for a in range(3) if part["axes"][a]}
u, free = np.zeros(load.size), np.setdiff1d(np.arange(load.size), list(moved))
u[list(moved)] = list(moved.values())
u[free] = np.linalg.solve((body + supports)[np.ix_(free, free)], (load - (body + supports) @ u)[free])
report = {"outcome": "converged", "energy_j": u @ body @ u / 2, "identify_s": 0, "solve_s": clock() - start, "iterations": 1}
report["residual_relative"] = float(np.linalg.norm((load - (body + supports) @ u)[free]) / np.linalg.norm(load))
rows = [f"{v},{x!r},{y!r},{z!r}" for v, (x, y, z) in enumerate(u.reshape(-1, 3).tolist())]
open(request["displacement_out"], "w", encoding="utf-8").write("\n".join(["vertex,ux_m,uy_m,uz_m", *rows, ""]))
json.dump({"schema": "palpate/response/1", "status": "ok", "kernel_s": report["solve_s"], "report": report}, open(sys.argv[2], "w", encoding="utf-8"))
