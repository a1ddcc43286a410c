#!/usr/bin/env python3
"""A picture of a scene: its skin from above and from below, with what holds it and what loads it.

    show_scene.py FOLDER OUT_DIR NAME

Reads FOLDER/body.mesh (in metres) and FOLDER/problem.json (palpate/problem/1), writes OUT_DIR/NAME.svg and NAME.png. Exit codes: 0
done; 2 a file that cannot be read; 3 matplotlib is missing, or a fault of its own.
"""

import pathlib
import sys

from shared.exit_codes import guarded
from shared.mesh_file import read_mesh
from shared.run_file import read_object


def main(arguments):
    if len(arguments) != 3:
        print(__doc__, file=sys.stderr)
        return 2
    folder = pathlib.Path(arguments[0])
    try:
        from scene import scene_picture
    except ImportError as error:
        print(f"matplotlib is missing (the package python3-matplotlib has it): {error}", file=sys.stderr)
        return 3

    def draw():
        mesh = read_mesh(folder / "body.mesh")
        problem = read_object(folder / "problem.json")
        scene_picture.draw_scene(mesh, problem, pathlib.Path(arguments[1]), arguments[2])
        return 0

    return guarded(draw)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
