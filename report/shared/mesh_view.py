"""How meshes are looked at in pictures: one point of view for all panels of a figure."""

from dataclasses import dataclass

import numpy as np

from shared.records import BadRun

LIGHT = np.array([-0.35, 0.45, 0.82])  # in the view's frame: x right, y up, z to the eye


@dataclass
class View:
    """Where the cut goes, and how the picture is seen; the same for all panels of a figure."""

    centre: np.ndarray
    normal: np.ndarray  # of the cutting plane; what lies on its side is taken away
    frame: np.ndarray  # rows: right, up, to the eye
    low: np.ndarray
    high: np.ndarray


def choose_view(mesh):
    """Cuts the input in the middle, across its shortest axis, and looks at the cut a little from the side."""
    centre = (mesh.points.max(axis=0) + mesh.points.min(axis=0)) / 2
    _, _, axes = np.linalg.svd(mesh.points - mesh.points.mean(axis=0), full_matrices=False)
    axes = np.array([axis * np.sign(axis[np.argmax(np.abs(axis))]) for axis in axes])  # the sign of an axis is arbitrary
    longest, middle, normal = axes
    normal = np.cross(longest, middle)
    eye = normal + 0.35 * middle + 0.3 * longest
    eye /= np.linalg.norm(eye)
    right = longest - eye * longest.dot(eye)
    right /= np.linalg.norm(right)
    frame = np.array([right, np.cross(eye, right), eye])
    flat = (mesh.points - centre) @ frame.T
    return View(centre, normal, frame, flat[:, :2].min(axis=0), flat[:, :2].max(axis=0))


def inside(folder, name):
    """A path in the run folder. Throws BadRun for one that leads out of it."""
    path = (folder / name).resolve()
    if not path.is_relative_to(folder.resolve()):
        raise BadRun(f"{name} lies outside the run folder")
    return path


def shade_front(corners, least):
    """Of faces in the view's frame (faces x 3 x 3): which look to the eye, their order from back to front, and how bright each of those is, from
    `least` to 1, in the order of the faces."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    front = (normals[:, 2] > 0) & (lengths > 0)
    order = np.argsort(corners[front, :, 2].mean(axis=1), kind="stable")
    light = LIGHT / np.linalg.norm(LIGHT)
    return front, order, least + (1 - least) * np.clip(normals[front] @ light / lengths[front], 0.0, 1.0)
