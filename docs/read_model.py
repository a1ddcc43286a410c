"""Reads a model that `palpate export` wrote (docs/model_file.md): its forces, and steps by symplectic Euler.

    read_model.py MODEL.json STATE.csv OUT.csv STEP_S STEPS    rows x,y,z,vx,vy,vz: displacement (m), velocity (m/s)
"""
import json
import sys
import numpy as np


def stress(law, lam, mu, h):
    eye, f = np.eye(3), np.eye(3) + h
    if law == "linear":
        eps = 0.5 * (h + h.transpose(0, 2, 1))
        return 2 * mu * eps + lam * np.trace(eps, axis1=1, axis2=2)[:, None, None] * eye
    if law == "neo_hookean":
        inverse_t = np.linalg.inv(f).transpose(0, 2, 1)
        return mu * (f - inverse_t) + lam * np.log(np.linalg.det(f))[:, None, None] * inverse_t
    if law == "stable_neo_hookean":
        rows = (np.cross(f[:, 1], f[:, 2]), np.cross(f[:, 2], f[:, 0]), np.cross(f[:, 0], f[:, 1]))
        cofactors = np.stack(rows, axis=1)
        return mu * (f - cofactors) + (lam + mu) * (np.linalg.det(f) - 1)[:, None, None] * cofactors
    u, s, vt = np.linalg.svd(f)  # corotated; F = R S
    sign = np.sign(np.linalg.det(u @ vt))
    u[:, :, 2], s[:, 2] = u[:, :, 2] * sign[:, None], s[:, 2] * sign
    r = u @ vt
    return 2 * mu * (f - r) + lam * (s.sum(axis=1) - 3)[:, None, None] * r


def forces(m, u, v):
    points, f = np.array(m["points_m"]), -np.array(m["vertex_damping_n_s_per_m"])[:, None] * v
    net = m["springs"]
    if net["vertices"]:
        a, b = np.array(net["vertices"]).T
        length, k, c = (np.array(net[key])[:, None] for key in ("rest_length_m", "stiffness_n_per_m", "damping_n_s_per_m"))
        d, du, dv = points[b] - points[a], u[b] - u[a], v[b] - v[a]
        n = d / length if net["force"] == "linear" else (d + du) / np.linalg.norm(d + du, axis=1, keepdims=True)
        longer = (n * du).sum(1, keepdims=True) if net["force"] == "linear" else (n * (d + du)).sum(1, keepdims=True) - length
        pull = k * longer * n + c * ((n * dv).sum(1, keepdims=True) * n if net["damping"] == "axial" else dv)
        np.add.at(f, a, pull)
        np.add.at(f, b, -pull)
    for t in m["strain_terms"]:
        if t["damping_s"] and t["law"] != "linear":
            raise SystemExit("damped large strains are not read here")
        owner, at, g = np.repeat(np.arange(len(t["volume_m3"])), np.diff(t["offsets"])), t["vertices"], np.array(t["gradients_per_m"])
        h = np.zeros((len(t["volume_m3"]), 3, 3))
        np.add.at(h, owner, (u + t["damping_s"] * v)[at][:, :, None] * g[:, None, :])
        p = np.array(t["volume_m3"])[:, None, None] * stress(t["law"], t["lambda_pa"], t["mu_pa"], h)
        np.subtract.at(f, at, np.einsum("sij,sj->si", p[owner], g))
    if m["volume_force"]:
        x, t, w = points + u, np.array(m["tets"]).T, m["volume_force"]
        volume = np.linalg.det(np.stack([x[t[i]] - x[t[0]] for i in (1, 2, 3)], axis=1)).sum() / 6
        arm = np.array(w["center_weights"]) @ x - x
        f += w["stiffness_n_per_m3"] * (volume - w["rest_volume_m3"]) * arm / np.linalg.norm(arm, axis=1, keepdims=True)
    return f


if __name__ == "__main__":
    model, state = json.load(open(sys.argv[1])), np.loadtxt(sys.argv[2], delimiter=",")
    u, v, step = state[:, :3], state[:, 3:], float(sys.argv[4])
    for _ in range(int(sys.argv[5])):
        v = v + step * forces(model, u, v) / np.array(model["mass_kg"])[:, None]
        u = u + step * v
    np.savetxt(sys.argv[3], np.hstack([u, v, forces(model, u, v)]), delimiter=",", fmt="%.17g")
