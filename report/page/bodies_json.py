"""Bodies as data for the 3D view: positions as 32-bit floats, indices as narrow as they fit, figures in bytes; compressed, in base64.

A body has a few hundred kilobytes, so a page takes as many as there is room for, one of each group after the other, and says what it left.
"""

import base64
import zlib
from dataclasses import dataclass

import numpy as np

MOST_BYTES = 1_500_000  # of all bodies together, as they stand in the page
MOST_TETS = 400_000  # of one body: more take too long to open
MOST_FRAMES = 160  # of a motion
MOTION_LEVELS = 2047  # of the largest displacement: finer than a picture shows, and coarse enough to be packed


def packed(array):
    return base64.b64encode(zlib.compress(np.ascontiguousarray(array).tobytes(), 9)).decode("ascii")


def indices(array, count):
    narrow = count <= 65536
    return {"type": "u16" if narrow else "u32", "data": packed(np.asarray(array, dtype="<u2" if narrow else "<u4"))}


def floats(array):
    return {"type": "f32", "data": packed(np.asarray(array, dtype="<f4"))}


def levels(values, low, high):
    """Figures as 255 levels from low to high; 255 itself is one that is not known."""
    values = np.asarray(values, dtype=float)
    span = high - low if high > low else 1.0
    known = np.isfinite(values)
    shares = np.clip((np.where(known, values, low) - low) / span, 0.0, 1.0)
    return packed(np.where(known, np.rint(254 * shares), 255).astype(np.uint8))


def field_data(field):
    values = np.asarray(field.values, dtype=float)
    known = values[np.isfinite(values)]
    low, high = field.range or ((float(known.min()), float(known.max())) if len(known) else (0.0, 1.0))
    return {"title": field.title, "unit": field.unit, "on": field.on, "low": low, "high": high, "scale": field.scale, "data": levels(values, low, high)}


def motion_data(moves, count):
    """Frames as steps of the largest displacement, each frame but the first as what it differs by from the one before."""
    chosen = moves if len(moves) <= MOST_FRAMES else [moves[round(k * (len(moves) - 1) / (MOST_FRAMES - 1))] for k in range(MOST_FRAMES)]
    frames = np.array([np.asarray(field, dtype=float).reshape(count, 3) for _, field in chosen])
    most = float(np.abs(frames).max()) or 1.0
    steps = np.rint(frames / most * MOTION_LEVELS)
    return {"times_s": [float(time) for time, _ in chosen], "most": most, "levels": MOTION_LEVELS, "of": len(moves),
            "data": packed(np.diff(steps, axis=0, prepend=0.0).astype("<i2"))}


def mesh_data(mesh):
    return {"vertices": len(mesh.points), "tets": len(mesh.tets), "positions": floats(mesh.points), "indices": indices(mesh.tets, len(mesh.points))}


def body_data(body):
    """One body as it stands in the page, without its mesh. Throws ValueError where its figures do not fit it."""
    points, tets = body.mesh.points, body.mesh.tets
    for field in body.fields:
        wanted = len(points) if field.on == "vertex" else len(tets)
        if len(field.values) != wanted:
            raise ValueError(f"{body.title}: {field.title}: expected {wanted} figures, found {len(field.values)}")
    data = {"title": body.title, "group": body.group, "unit": body.unit, "note": body.note, "fields": [field_data(field) for field in body.fields]}
    if body.case:
        data["case"] = body.case
    if body.displacement is not None:
        data["displacement"] = floats(np.asarray(body.displacement, dtype=float).reshape(-1, 3))
    if len(body.moves) > 1:
        data["motion"] = motion_data(body.moves, len(points))
    return data


def size_of(data):
    return sum(len(each) if isinstance(each, str) else size_of(each) if isinstance(each, dict) else
               sum(size_of(one) for one in each if isinstance(one, dict)) if isinstance(each, list) else 8 for each in data.values())


def in_turn(bodies):
    """One of each group, then the next of each."""
    groups = {}
    for body in bodies:
        groups.setdefault(body.group, []).append(body)
    most = max((len(group) for group in groups.values()), default=0)
    return [group[place] for place in range(most) for group in groups.values() if place < len(group)]


@dataclass
class Chosen:
    """What of the bodies stands in the page: each mesh once, each body with the place of its mesh; and a sentence on what was left out."""

    meshes: list
    bodies: list
    note: str


def choose_bodies(bodies, room=MOST_BYTES):
    """The bodies that there is room for, in their own order."""
    bodies = list(bodies)
    kept, meshes, places = {}, [], {}
    left, large, used = 0, 0, 0
    for body in in_turn(bodies):
        if len(body.mesh.tets) > MOST_TETS:
            large += 1
            continue
        if used >= room:  # before the work
            left += 1
            continue
        mark = (body.mesh.points.tobytes(), body.mesh.tets.tobytes())
        mesh = None if mark in places else mesh_data(body.mesh)
        data = body_data(body)
        size = size_of(data) + (size_of(mesh) if mesh else 0)
        if used + size > room:
            left += 1
            continue
        used += size
        if mesh:
            places[mark] = len(meshes)
            meshes.append(mesh)
        kept[id(body)] = {**data, "mesh": places[mark]}
    notes = []
    if left:
        notes.append(f"{left} of {len(bodies)} meshes are left out, so that the page stays small; they are in the run's folder.")
    if large:
        notes.append(f"{large} with over {MOST_TETS:,} tetrahedra are too large to show here.")
    return Chosen(meshes, [kept[id(body)] for body in bodies if id(body) in kept], " ".join(notes))
