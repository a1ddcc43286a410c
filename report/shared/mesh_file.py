"""Meshes of a run folder, and their quality by the thesis's formula: arithmetic of its own, so that a picture that disagrees
with the judge's figures shows a fault of one of them."""

from dataclasses import dataclass

import numpy as np

from shared.run_file import BadRun, read_text

MOST_MESH_BYTES = 128 * 2**20  # five times what is drawn at most
FACES = ((1, 2, 3), (0, 3, 2), (0, 1, 3), (0, 2, 1))  # of a tet, counter-clockwise seen from outside


@dataclass
class Mesh:
    points: np.ndarray  # n x 3
    tets: np.ndarray  # m x 4, from 0


def read_block(words, place, count, width, what):
    values = words[place:place + count * width]
    if len(values) != count * width:
        raise BadRun(f"{what}: the file ends early")
    return np.array(values, dtype=float).reshape(count, width)


def read_mesh(path):
    """Points and tetrahedra of an ASCII MEDIT file. Throws BadRun."""
    words = read_text(path, MOST_MESH_BYTES).split()
    found = {}
    for name, width in (("Vertices", 4), ("Tetrahedra", 5)):
        if name not in words:
            raise BadRun(f"{path}: expected the section {name}")
        place = words.index(name) + 1
        try:
            found[name] = read_block(words, place + 1, int(words[place]), width, f"{path}: {name}")
        except (ValueError, IndexError) as error:
            raise BadRun(f"{path}: {name}: expected numbers") from error
    points, corners = found["Vertices"][:, :3], found["Tetrahedra"][:, :4]
    if not np.isfinite(points).all():
        raise BadRun(f"{path}: Vertices: expected finite numbers")
    if not ((corners >= 1) & (corners <= len(points))).all():
        raise BadRun(f"{path}: Tetrahedra: expected vertices from 1 to {len(points)}")
    return Mesh(points, corners.astype(int) - 1)


def qualities(mesh):
    """q = cbrt(q1 q2 q3) of each tet (thesis 2.3.5), in 0..1; a tet without positive volume has 0.

    q1 is the least solid angle over 0.55, q2 the shortest over the longest edge, q3 the volume over the mesh's mean, at most 1.
    """
    corners = mesh.points[mesh.tets]
    volume = np.linalg.det(corners[:, 1:] - corners[:, :1]) / 6.0
    pairs = [(a, b) for a in range(4) for b in range(a)]
    lengths = np.stack([np.linalg.norm(corners[:, a] - corners[:, b], axis=1) for a, b in pairs])
    angles = np.stack([solid_angle(corners, apex) for apex in range(4)])
    with np.errstate(divide="ignore", invalid="ignore"):
        shape = angles.min(axis=0) / 0.55 * lengths.min(axis=0) / lengths.max(axis=0)
        relative = np.minimum(1.0, volume / volume.mean())
        quality = np.cbrt(shape * relative)
    return np.where((volume > 0) & np.isfinite(quality), np.clip(quality, 0.0, 1.0), 0.0)


def solid_angle(corners, apex):
    """The solid angle at one corner of each tet, by Van Oosterom and Strackee (1983)."""
    a, b, c = (corners[:, other] - corners[:, apex] for other in range(4) if other != apex)
    la, lb, lc = (np.linalg.norm(edge, axis=1) for edge in (a, b, c))
    dot = lambda u, v: np.einsum("ij,ij->i", u, v)
    numerator = np.abs(dot(a, np.cross(b, c)))
    denominator = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb
    return 2.0 * np.abs(np.arctan2(numerator, denominator))


def outer_faces(tets):
    """Faces that belong to one of these tets alone: their vertices (outwards) and the place of their tet."""
    faces = np.concatenate([tets[:, face] for face in FACES])
    owners = np.tile(np.arange(len(tets)), len(FACES))
    _, first, counts = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
    single = np.sort(first[counts == 1])
    return faces[single], owners[single]
