"""Three walks through the rooms of experiments, and how often each comes back to a room that it had left.

    walks.py ROOT      prints the walks with their rooms and returns; exits with 1 if a step is not in the code, or a walk returns too often

A walk follows one value: a mesh file to its judged record, a scene to its displacement error, a plan's entry of a contestant to the request that
its program is given. WALKS names the calls that hand it on, in the order in which they are made, as "caller > callee". Functions are those of
experiments/; where a name stands in more than one file, "file:" goes before it. The walk's rooms are those of the callees, the same one in
succession once; a return is a room that was entered before. The main loop (room runner), which calls what is next, is no room of a walk.

Counted so, with the rooms that its files lie in now, the house before it had rooms (commit d3d38e2) returned 6, 10 and 5 times. Most of what is
left is a contest that asks for one thing after another: make it, run it, judge it.
"""

import pathlib
import re
import sys

# Calls in order, and the most returns.
WALKS = {
    "mesh file to judged record": (5, """
        Runner:prepare > simplify_contest:prepare
        simplify_contest:prepare > prepare_meshes
        prepare_meshes > obtain_mesh
        obtain_mesh > read_mesh
        run_repeat > simplify_contest:fill_task
        run_repeat > run_contestant
        run_contestant > run_guarded
        run_guarded > run_process
        run_guarded > read_answer
        run_repeat > simplify_contest:build_record
        simplify_contest:build_record > judge_answer
        judge_bounded > run_bounded
        simplify_contest:build_record > read_mesh
        simplify_contest:build_record > judge_output
        simplify_contest:build_record > add_region_figures
        """),
    "scene to displacement error": (9, """
        read_deform_plan > read_plan_scenes
        read_plan_scenes > read_plan_scene
        read_plan_scene > read_scene
        Runner:prepare > deform_contest:prepare
        deform_contest:prepare > deform_input:build_input
        deform_input:build_input > place_swept_scene
        place_swept_scene > build_scene_mesh
        build_scene_mesh > make_shape
        place_swept_scene > place_scene
        deform_input:build_input > build_problem
        deform_input:build_input > write_problem
        write_problem > write_problem_folder
        deform_contest:record_inputs > deform_input:solve_reference
        deform_input:solve_reference > deform_input:solve_level
        deform_input:solve_level > solution:solve
        solution:solve > run_cached
        run_cached > run_contestant
        run_guarded > run_process
        run_repeat > deform_contest:fill_task
        run_repeat > run_contestant
        run_guarded > run_process
        run_repeat > deform_contest:build_record
        deform_contest:build_record > judge_answer
        judge_bounded > run_bounded
        deform_contest:build_record > judge_displacement
        """),
    "entry of a contestant to request": (3, """
        read_simplify_plan > read_contestants
        read_contestants > read_entry
        read_entry > plan_contestant:find_method
        plan_contestant:find_method > contestant:find
        simplify_contest > cross_cases
        add_cases > resolve_options
        run_repeat > simplify_contest:fill_task
        run_repeat > run_contestant
        run_guarded > build_request
        build_request > stop_request
        run_guarded > write_file_atomically
        run_guarded > run_process
        """),
}
# A function begins where its name does at the left, or in a class; it ends at the brace that stands as far left.
FUNCTION = re.compile(r"^(?P<indent> {0,2})(?:[A-Za-z_][\w:<>,&*\s]*[\s&*])?(?:\w+::)*(?P<name>~?\w+)\([^;{}]*\{\n", re.MULTILINE)


def read_functions(folder):
    """By name: (file, text) of each definition below the folder."""
    found = {}
    for path in sorted(folder.rglob("*.cpp")):
        text = path.read_text(encoding="utf-8")
        for match in FUNCTION.finditer(text):
            end = text.find("\n" + match["indent"] + "}", match.end())
            found.setdefault(match["name"], []).append((path, text[match.start():end]))
    return found


def find_one(functions, name):
    """The definitions that "file:name" or "name" stands for."""
    place, _, own = name.rpartition(":")
    return [(path, text) for path, text in functions.get(own, []) if not place or path.stem == place.lower()]


def walk(root, steps):
    """The rooms in order, and what is wrong with the steps."""
    functions = read_functions(root / "experiments")
    rooms, wrong = [], []
    for step in steps.split("\n"):
        caller, _, callee = step.strip().partition(" > ")
        if not callee:
            continue
        callees, own = find_one(functions, callee), callee.rpartition(":")[2]
        if not any(re.search(rf"\b{own}\b[\s({{,]", text) for _, text in find_one(functions, caller)):
            wrong.append(f"{step.strip()}: no such call")
        if not callees:
            continue  # a function of another wing
        for room in dict.fromkeys(path.parent.relative_to(root / "experiments").as_posix() for path, _ in callees):
            if room != "runner" and rooms[-1:] != [room]:
                rooms.append(room)
    return rooms, wrong


def main():
    root = pathlib.Path(sys.argv[1])
    failed = False
    for name, (most, steps) in WALKS.items():
        rooms, wrong = walk(root, steps)
        returns = len(rooms) - len(set(rooms))
        failed = failed or bool(wrong) or returns > most
        print(f"{name}: {len(set(rooms))} rooms, {returns} returns, at most {most}\n  " + " > ".join(rooms))
        print("".join(f"  {each}\n" for each in wrong), end="")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
