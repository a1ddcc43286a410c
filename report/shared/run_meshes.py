"""The meshes that a run's folder keeps, as bodies for the page. What is not there, or cannot be read, is noted and left out."""

import pathlib

from shared.page_parts import Body, Field
from shared.run_file import BadRun, read_text


MOST_FIELD_BYTES = 256 * 2**20  # of the displacement of each vertex


def is_left_behind(run, name):
    """Whether the run's folder has nothing at all of a kind of file ("meshes", "motions"), as an archive does not; noted once."""
    kind = pathlib.PurePath(name).parts[0] if name else ""
    if not kind or (run.folder / kind).exists():
        return False
    run.note(f"no {kind} are drawn: the run's folder has none, as they do not travel with an archive")
    return True


def mesh_beside(run, name):
    """A mesh of the run's folder, or None; what cannot be read is noted."""
    if not isinstance(name, str) or not name:
        return None
    from shared.mesh_file import read_mesh  # needs numpy
    from shared.mesh_view import inside
    try:
        path = inside(run.folder, name)
        return read_mesh(path) if path.is_file() else None
    except BadRun as error:
        run.note(f"not shown in 3D: {error}")
        return None


def displacement_beside(run, name, vertices):
    """The displacement of each vertex that a file of the run's folder has (n x 3, in m), or None; what cannot be read is noted. Quadratic
    elements leave the middles of edges behind the vertices: they are not drawn."""
    if not isinstance(name, str) or not name:
        return None
    import numpy as np
    from shared.mesh_view import inside
    try:
        path = inside(run.folder, name)
        if not path.is_file():
            return None
        field = np.loadtxt(read_text(path, MOST_FIELD_BYTES).splitlines(), delimiter=",", skiprows=1, ndmin=2)[:, 1:4]
    except (BadRun, OSError, ValueError, IndexError) as error:
        run.note(f"not shown in 3D: {name}: {error}")
        return None
    if len(field) < vertices or field.shape[1] != 3:
        run.note(f"not shown in 3D: {name}: expected {vertices} vertices, found {len(field)}")
        return None
    if not np.isfinite(field).all():
        run.note(f"not shown in 3D: {name}: expected finite numbers")
        return None
    return field[:vertices]


def quality_field(mesh):
    from shared.mesh_file import qualities  # needs numpy
    return Field("quality", "", "tet", qualities(mesh), (0.0, 1.0))


def mesh_body(run, title, group, name, **more):
    """A body with its quality, or None without its mesh."""
    mesh = mesh_beside(run, name)
    return None if mesh is None else Body(title, group, mesh, [quality_field(mesh)], **more)
