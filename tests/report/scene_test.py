"""The picture of a scene: which faces are marked how, from where it is seen, and that both files are there."""

import json
import pathlib
import tempfile
import unittest

import numpy as np

import support
import show_scene
from scene import scene_picture
from shared.mesh_file import Mesh, outer_faces

CORNER = np.array([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]], dtype=float)
TETS = np.array([[0, 1, 2, 3]])
PROBLEM = {"material": {"young_modulus_pa": 1e4, "poisson_ratio": 0.45, "density_kg_m3": 1050}, "gravity_m_s2": [0, 0, -9.81],
           "held": [], "tractions": [],
           "supports": [{"faces": [[0, 2, 1]], "weight": [1.0], "stiffness_pa_per_m": 1e6, "by_m": [0, 0, 0]},
                        {"faces": [[1, 2, 3]], "weight": [0.5], "stiffness_pa_per_m": 5e6, "by_m": [0, 0, -0.002]}]}


class ScenePictureTest(unittest.TestCase):
    def test_supports_stay_and_pads_move(self):
        self.assertEqual([mark.kind for mark in scene_picture.read_marks(PROBLEM)], ["support", "pad"])
        held = {"held": [{"faces": [[0, 2, 1]], "by_m": [0, 0, 0]}, {"faces": [[1, 2, 3]], "by_m": [0, 1, 0]}]}
        self.assertEqual([mark.kind for mark in scene_picture.read_marks(held)], ["held", "pad"])

    def test_a_face_is_coloured_by_its_weight(self):
        faces, _ = outer_faces(TETS)
        colors = scene_picture.face_colors(faces, scene_picture.read_marks(PROBLEM))
        skin = np.array(scene_picture.to_rgb(scene_picture.SKIN))
        by_face = {tuple(sorted(face)): color for face, color in zip(faces.tolist(), colors)}
        np.testing.assert_allclose(by_face[0, 1, 3], skin)
        support_color = np.array(scene_picture.to_rgb(scene_picture.BETTER))
        np.testing.assert_allclose(by_face[0, 1, 2], 0.15 * skin + 0.85 * support_color)
        half = 0.425
        np.testing.assert_allclose(by_face[1, 2, 3], (1 - half) * skin + half * np.array(scene_picture.to_rgb(scene_picture.THAN)))

    def test_up_is_up_from_both_sides(self):
        up = scene_picture.up_of(PROBLEM)
        np.testing.assert_allclose(up, [0, 0, 1])
        for above in (True, False):
            frame = scene_picture.frame_of(np.random.default_rng(1).normal(size=(50, 3)), up, above)
            np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-12)
            self.assertGreater(np.linalg.det(frame), 0)
            self.assertGreater(frame[1] @ up, 0)
            self.assertEqual(frame[2] @ up > 0, above)

    def test_both_files_are_written(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            lines = ["MeshVersionFormatted 2", "Dimension 3", "Vertices 4", *(" ".join(map(str, p)) + " 0" for p in CORNER),
                     "Tetrahedra 1", "1 2 3 4 0", "End"]
            (folder / "body.mesh").write_text("\n".join(lines) + "\n", encoding="utf-8")
            (folder / "problem.json").write_text(json.dumps(PROBLEM), encoding="utf-8")
            self.assertEqual(show_scene.main([name, name, "mine"]), 0)
            self.assertEqual((folder / "mine.png").read_bytes()[1:4], b"PNG")
            self.assertIn("<svg", (folder / "mine.svg").read_text(encoding="utf-8"))
            self.assertEqual(show_scene.main([name + "/none", name, "mine"]), 2)
            self.assertEqual(show_scene.main([]), 2)


if __name__ == "__main__":
    unittest.main()
