"""Cut-away pictures: the quality of known tets, the faces that a cut shows, and what becomes of meshes that cannot be read."""

import itertools
import math
import shutil
import unittest

import numpy as np

from support import ReportTest
from simplify import cut_away
from shared import mesh_file
from shared import records
import synthetic
from synthetic import answer

REGULAR = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]], dtype=float)
CORNER = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=float)
PLAN = {**synthetic.CONTEST, "charts": ["cut_away"], "comparisons": []}


def grid(cells, stretch=(3.0, 2.0, 1.0)):
    """A box of cubes, each cut into six tets that share a diagonal."""
    side = cells + 1
    points = np.array(list(itertools.product(range(side), repeat=3)), dtype=float) / cells * stretch
    number = lambda x, y, z: (x * side + y) * side + z
    tets = []
    for x, y, z in itertools.product(range(cells), repeat=3):
        for path in itertools.permutations(range(3)):
            corner, tet = [x, y, z], [number(x, y, z)]
            for axis in path:
                corner[axis] += 1
                tet.append(number(*corner))
            if np.linalg.det(points[tet[1:]] - points[tet[0]]) < 0:
                tet[0], tet[1] = tet[1], tet[0]
            tets.append(tet)
    return mesh_file.Mesh(points, np.array(tets))


def one(points):
    points = np.asarray(points, dtype=float)
    tet = [0, 1, 2, 3] if np.linalg.det(points[1:] - points[0]) > 0 else [1, 0, 2, 3]
    return mesh_file.Mesh(points, np.array([tet]))


class Quality(unittest.TestCase):
    def test_a_regular_tet_is_the_best(self):
        # solid angle 3 acos(1/3) - pi = 0.551286: over 0.55 it exceeds 1, and is cut off there
        self.assertEqual(mesh_file.qualities(one(REGULAR))[0], 1.0)
        tets = np.array([[0, 1, 2, 3]])
        corners = one(REGULAR).points[one(REGULAR).tets]
        self.assertAlmostEqual(mesh_file.solid_angle(corners, 0)[0], 3 * math.acos(1 / 3) - math.pi, 12)
        self.assertEqual(len(mesh_file.outer_faces(tets)[0]), 4)

    def test_the_corner_of_a_cube_in_closed_form(self):
        # Solid angles: pi / 2 at the corner; at the others, by Girard, the sum of three dihedral angles less pi.
        corners = one(CORNER).points[one(CORNER).tets]
        angles = sorted(mesh_file.solid_angle(corners, apex)[0] for apex in range(4))
        least = 2 * math.acos(1 / math.sqrt(3)) + math.pi / 2 - math.pi
        self.assertAlmostEqual(angles[3], math.pi / 2, 12)
        for angle in angles[:3]:
            self.assertAlmostEqual(angle, least, 12)
        expected = (least / 0.55 / math.sqrt(2)) ** (1 / 3)
        self.assertAlmostEqual(mesh_file.qualities(one(CORNER))[0], expected, 12)

    def test_turned_scaled_and_moved_it_stays(self):
        generator = np.random.default_rng(5)
        rotation, _ = np.linalg.qr(generator.normal(size=(3, 3)))
        rotation *= np.sign(np.linalg.det(rotation))
        moved = one(CORNER @ rotation.T * 0.017 + [4, 5, 6])
        self.assertAlmostEqual(mesh_file.qualities(moved)[0], mesh_file.qualities(one(CORNER))[0], 9)

    def test_small_ones_lose_by_their_volume_and_flat_ones_have_none(self):
        points = np.concatenate([REGULAR, REGULAR / 2, CORNER * [1, 1, 0]])
        mesh = mesh_file.Mesh(points, np.array([[0, 2, 1, 3], [4, 6, 5, 7], [8, 9, 10, 11]]))
        mesh.tets[:2] = [tet if np.linalg.det(points[tet[1:]] - points[tet[0]]) > 0 else tet[[1, 0, 2, 3]] for tet in mesh.tets[:2]]
        quality = mesh_file.qualities(mesh)
        self.assertEqual(quality[2], 0.0)
        mean = (8 / 3 + 1 / 3) / 3  # the two volumes and 0
        self.assertAlmostEqual(quality[1], ((3 * math.acos(1 / 3) - math.pi) / 0.55 * (1 / 3) / mean) ** (1 / 3), 12)

    def test_an_inverted_tet_has_none(self):
        mesh = one(REGULAR)
        mesh.tets[0, :2] = mesh.tets[0, 1::-1].copy()
        self.assertEqual(mesh_file.qualities(mesh)[0], 0.0)


class Cut(unittest.TestCase):
    def test_outer_faces_of_a_box_are_its_skin(self):
        mesh = grid(3)
        faces, owners = mesh_file.outer_faces(mesh.tets)
        self.assertEqual(len(faces), 6 * 9 * 2)
        self.assertTrue(all(set(face) <= set(mesh.tets[owner]) for face, owner in zip(faces, owners)))
        corners = mesh.points[faces]
        areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2
        self.assertAlmostEqual(np.einsum("ij,ij->", areas, corners.mean(axis=1)) / 3, 6.0, 12)  # outwards: the volume

    def test_what_lies_before_the_plane_is_gone(self):
        # A box of 4 x 4 x 4 cubes cut across its shortest side: two layers stay, with the skin of a box of 4 x 4 x 2.
        mesh = grid(4)
        view = cut_away.choose_view(mesh)
        self.assertAlmostEqual(abs(view.normal @ [0, 0, 1]), 1.0, 9)
        kept = cut_away.kept_tets(mesh, view)
        self.assertEqual(kept.sum(), 4 * 4 * 2 * 6)
        self.assertEqual(len(mesh_file.outer_faces(mesh.tets[kept])[0]), 2 * (16 + 8 + 8) * 2)

    def test_only_faces_turned_to_the_eye_are_drawn(self):
        # Of a box, three sides are seen: one of each pair.
        mesh = grid(4)
        polygons, quality, brightness = cut_away.visible_faces(mesh, cut_away.choose_view(mesh))
        self.assertEqual((len(polygons), len(quality), len(brightness)), (32 + 16 + 16,) * 3)
        self.assertTrue(np.all((brightness >= 0.72) & (brightness <= 1)))

    def test_the_nearest_face_is_drawn_last(self):
        mesh = grid(2)
        view = cut_away.choose_view(mesh)
        polygons, _, _ = cut_away.visible_faces(mesh, view)
        flat = (mesh.points - view.centre) @ view.frame.T
        depth = {tuple(np.round(xy, 9)): z for *xy, z in flat}  # one point of view: no two vertices share a place
        depths = [np.mean([depth[tuple(np.round(corner, 9))] for corner in polygon]) for polygon in polygons]
        self.assertEqual(depths, sorted(depths))


class Pictures(ReportTest):
    def write_contest(self, meshes):
        """A run whose labels have these meshes (None: no file)."""
        lines = []
        for label, mesh in meshes.items():
            name = f"meshes/kidney/{label}.mesh"
            if mesh is not None:
                synthetic.write_mesh(self.folder / name, mesh.points.tolist(), mesh.tets.tolist())
            made = answer(label, 90, mesh_file=name)
            lines.append({**made, "sweep": {}} if label == "input" else made)
        synthetic.write_run(self.folder, lines, PLAN)

    def test_a_mesh_that_was_written_is_read_back(self):
        mesh = grid(2)
        synthetic.write_mesh(self.folder / "a.mesh", mesh.points.tolist(), mesh.tets.tolist())
        read = mesh_file.read_mesh(self.folder / "a.mesh")
        self.assertTrue(np.array_equal(read.points, mesh.points) and np.array_equal(read.tets, mesh.tets))

    def test_one_picture_a_mesh_and_ratio_the_same_bytes_each_time(self):
        self.write_contest({"input": grid(4), "refined": grid(3), "cgal_1": grid(2)})
        self.assertEqual(self.report()[0], 0)
        first = self.charts()
        self.assertEqual(set(first), {f"cut_away_kidney_tets_removed_ratio_0.22.{ending}" for ending in ("svg", "png")})
        self.report()
        self.assertEqual(first, self.charts())

    def test_panels_name_what_they_show(self):
        self.write_contest({"input": grid(4), "refined": grid(3)})
        run = records.read_run(self.folder)
        from simplify import contest
        section, = contest.read_sections(run)
        titles = [(title, text) for title, text, _ in cut_away.panels_of(run, section)]
        self.assertEqual([title for title, _ in titles], ["input", "refined"])
        self.assertIn("6,240 tets, 90.00% > 0.5", titles[1][1])

    def test_a_mesh_that_is_missing_or_broken_is_said_and_the_others_are_drawn(self):
        self.write_contest({"input": grid(3), "refined": grid(2), "gone": None, "broken": grid(2)})
        path = self.folder / "meshes/kidney/broken.mesh"
        path.write_text(path.read_text(encoding="utf-8")[:200], encoding="utf-8")
        code, out, _ = self.report()
        self.assertEqual(code, 0)
        self.assertIn("no cut-away of gone on kidney", out)
        self.assertIn("no cut-away of broken on kidney", out)
        self.assertEqual(len(self.charts()), 2)

    def test_meshes_that_did_not_come_along_are_said_once(self):
        self.write_contest({"input": grid(3), "refined": grid(2)})
        shutil.rmtree(self.folder / "meshes")
        printed = self.report()[1]
        self.assertEqual([line for line in printed.splitlines() if line.startswith("note") and "meshes" in line],
                         ["note: no meshes are drawn: the run's folder has none, as they do not travel with an archive"])

    def test_a_picture_that_disagrees_with_the_judge_is_said(self):
        self.write_contest({"input": grid(3), "refined": grid(2)})
        run = records.read_run(self.folder)
        from simplify import contest
        record = run.groups[0].records[0]
        for shift, expected in ((0.0, 0), (1e-5, 1)):
            record["judge"]["mean_quality"] = float(mesh_file.qualities(grid(2)).mean()) + shift
            run.notes.clear()
            section, = contest.read_sections(run)
            cut_away.panels_of(run, section)
            self.assertEqual(sum("refined has a mean quality" in note for note in run.notes), expected)

    def test_a_file_outside_the_run_is_not_read(self):
        self.write_contest({"input": grid(3), "refined": grid(2)})
        synthetic.write_mesh(self.folder.parent / "other.mesh", CORNER.tolist(), [[0, 1, 2, 3]])
        run = records.read_run(self.folder)
        run.groups[0].records[0] = {**run.groups[0].records[0], "mesh_file": "../other.mesh"}
        from simplify import contest
        section, = contest.read_sections(run)
        self.assertEqual([title for title, _, _ in cut_away.panels_of(run, section)], ["input"])
        self.assertTrue(any("outside" in note for note in run.notes))


if __name__ == "__main__":
    unittest.main()
