"""What a case of the engine leaves of its motion: columns and rows over time, and frames of the whole body."""

from shared.records import BadRun
from shared.run_file import are_numbers, is_number, read_object
from shared.run_meshes import is_left_behind


def read_motion(run, case):
    """{"columns", "rows", "frames"} that a case left, or None; what cannot be read is noted, and so is what is no motion."""
    name = case.record.get("mesh_file")
    if not isinstance(name, str) or is_left_behind(run, name):
        return None
    try:
        from shared.mesh_view import inside  # needs numpy
        return motion_of(read_object(inside(run.folder, name)), name)
    except BadRun as error:
        run.note(f"no motion of {case.label} on {case.scene}: {error}")
        return None


def motion_of(data, name):
    """The motion in an object of JSON. Throws BadRun."""
    columns, rows, frames = data.get("columns"), data.get("rows"), data.get("frames", [])
    if not isinstance(columns, list) or not columns or not all(isinstance(column, str) for column in columns):
        raise BadRun(f"{name}: columns: expected names")
    if "time_s" not in columns or len(set(columns)) != len(columns):
        raise BadRun(f"{name}: columns: expected each once, time_s among them")
    place = columns.index("time_s")
    if not isinstance(rows, list) or not rows or not all(is_row(row, len(columns)) and is_number(row[place]) for row in rows):
        raise BadRun(f"{name}: rows: expected lists of {len(columns)} finite numbers, or null beside the time")
    if not isinstance(frames, list) or not all(is_frame(frame) for frame in frames):
        raise BadRun(f"{name}: frames: expected a time and a displacement of finite numbers each")
    return {"columns": columns, "rows": rows, "frames": frames}


def is_row(row, width):
    return isinstance(row, list) and len(row) == width and are_numbers([value for value in row if value is not None])


def is_frame(frame):
    return isinstance(frame, dict) and is_number(frame.get("time_s")) and are_numbers(frame.get("displacement_m"))
