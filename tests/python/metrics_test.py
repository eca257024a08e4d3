import json
import subprocess
import unittest

import numpy as np
import support
import uniquadric
from support import CURVE, matrix, path_of
from uniquadric import metrics

CAMERA = uniquadric.Camera(640, 480, np.array([[525, 0, 319.5], [0, 525, 239.5], [0, 0, 1]]), np.zeros(5))
TURN = (0.1825741858350554, 0.3651483716701107, 0.5477225575051661, 0.7302967433402214)


def program_error(kind, line):
    """What `uniquadric metric` says of a JSON line."""
    done = subprocess.run([support.PROGRAM, "metric", kind], input=json.dumps(line), capture_output=True,
                          text=True, check=False)
    return json.loads(done.stdout)["error"]


class BodyMetricsTest(unittest.TestCase):
    def test_the_same_body_has_no_error(self):
        body = (matrix((1, 2, 3), TURN), (0.5, 0.3, 0.2))
        self.assertEqual(metrics.iou3d(body, body), 1)
        self.assertEqual(metrics.iou3d_box(body, body), 1)
        error = metrics.pose_error(body, body)
        self.assertEqual(error["translation_error_m"], 0)
        self.assertEqual(error["axis_errors_m"], [0, 0, 0])

    def test_shifted_boxes(self):
        # Half extents (1, 2, 3), moved by 0.5 along x: 1.5 of 2 in common.
        box, turn = (1, 2, 3), matrix((7, 8, 9), TURN)
        iou = metrics.iou3d_box((turn, box), (turn @ matrix((0.5, 0, 0)), box))
        self.assertAlmostEqual(iou, 1.5 / 2.5, places=12)
        self.assertEqual(metrics.iou3d_box((matrix(), box), (matrix((3, 0, 0)), box)), 0)

    def test_ellipsoids(self):
        # Balls of radius 1 at distance d: the common lens is pi (4 + d) (2 - d)^2 / 12.
        d = 0.4
        lens = np.pi * (4 + d) * (2 - d)**2 / 12
        iou = metrics.iou3d((matrix(), (1, 1, 1)), (matrix((0, d, 0)), (1, 1, 1)))
        self.assertAlmostEqual(iou, lens / (8 * np.pi / 3 - lens), places=8)
        # One within the other: the ratio of the volumes.
        inner = metrics.iou3d((matrix(), (1, 2, 3)), (matrix(), (0.5, 1, 1.5)))
        self.assertAlmostEqual(inner, 1 / 8, places=8)

    def test_shapes(self):
        box, ball = (matrix(), (1, 1, 1), "box"), (matrix(), (1, 1, 1))
        self.assertAlmostEqual(metrics.iou3d(box, (matrix(), (1, 1, 0.5), "box")), 0.5, places=12)
        self.assertAlmostEqual(metrics.iou3d(box, ball), np.pi / 6, delta=0.005)
        cylinder = {"superellipsoid": {"q": [2, 1, 1], "axis": "x"}}
        self.assertAlmostEqual(metrics.iou3d(box, (*ball, cylinder)), np.pi / 4, delta=0.005)
        with self.assertRaisesRegex(uniquadric.InputError, "est.shape: expected ellipsoid, box"):
            metrics.iou3d(box, (*ball, "cube"))
        with self.assertRaisesRegex(uniquadric.InputError, "^est: expected a pose"):
            metrics.iou3d(box, (*ball, "box", 1))

    def test_mesh(self):
        vertices = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
        sides = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
        cube = [triangle for a, b, c, d in sides for triangle in ((a, b, c), (a, c, d))]
        ball = (matrix(), (1, 1, 1))
        self.assertAlmostEqual(metrics.iou3d_mesh(vertices, cube, ball), np.pi / 6, delta=0.005)
        moved = (matrix((11, 0, 0)), (1, 1, 1), "box")
        self.assertAlmostEqual(metrics.iou3d_mesh(vertices + (10, 0, 0), cube, moved), 1 / 3, delta=0.005)
        for vertices_given, triangles, error in (
            (vertices, [(0, 1, 8)], r"triangles\[0\]: 8 is no index of 8 vertices"),
            (vertices, [(0, 1, 0.5)], "triangles: expected whole numbers"),
            (vertices, cube[:1], "triangles: they enclose no volume"),
            (vertices * np.nan, cube, r"vertices\[0\]: expected numbers"),
            (vertices[:, :2], cube, "vertices: expected 8x3 numbers"),
        ):
            with self.assertRaisesRegex(uniquadric.InputError, error):
                metrics.iou3d_mesh(vertices_given, triangles, moved)

    def test_pose_error(self):
        truth = (matrix((1, 0, 0)), (0.5, 0.3, 0.2))
        angle = 0.2
        turned = matrix((1, 3, 4), (0, 0, np.sin(angle / 2), np.cos(angle / 2)))
        error = metrics.pose_error(truth, (turned, (0.6, 0.3, 0.2)))
        self.assertAlmostEqual(error["translation_error_m"], 5)
        self.assertAlmostEqual(error["rotation_error_naive_rad"], angle)
        self.assertAlmostEqual(error["rotation_error_symmetric_rad"], angle)
        np.testing.assert_allclose(error["axis_errors_m"], [0.1, 0, 0], atol=1e-12)
        ball = metrics.pose_error((matrix(), (1, 1, 1)), (turned, (1, 1, 1)))
        self.assertIsNone(ball["rotation_error_symmetric_rad"])

    def test_iou2d(self):
        ball = (matrix((0, 0, 5)), (0.5, 0.5, 0.5))
        same = metrics.iou2d(ball, ball, CAMERA, matrix())
        self.assertEqual(same["status"], "ok")
        for name in ("rect_iou", "ellipse_iou", "aabb_iou", "rect_iou_clipped"):
            self.assertAlmostEqual(same[name], 1, places=9)
        # A ball of the same centre: both outlines are circles of radius f r / sqrt(d^2 - r^2).
        small = metrics.iou2d(ball, (matrix((0, 0, 5)), (0.25, 0.25, 0.25)), CAMERA, matrix())
        squares = [r**2 / (5**2 - r**2) for r in (0.5, 0.25)]
        self.assertAlmostEqual(small["ellipse_iou"], squares[1] / squares[0], places=9)
        behind = metrics.iou2d(ball, (matrix((0, 0, -5)), (0.5, 0.5, 0.5)), CAMERA, matrix())
        self.assertEqual((behind["est_status"], behind["rect_iou"]), ("behind", None))

    def test_errors_have_the_text_of_the_program(self):
        good = {"c": [0, 0, 0], "q": [0, 0, 0, 1], "a": [1, 1, 1]}
        cases = [(matrix((np.nan, 0, 0)), (1, 1, 1), {"c": [np.nan, 0, 0]}),
                 (matrix((0, 2e12, 0)), (1, 1, 1), {"c": [0, 2e12, 0]}),
                 (matrix(), (1, -1, 1), {"a": [1.0, -1.0, 1.0]}),
                 (matrix(), (1, 1, np.inf), {"a": [1, 1, np.inf]}),
                 (matrix(), (1, 1, 1e9), {"a": [1, 1, 1e9]})]
        for pose, axes, wrong in cases:
            expected = program_error("iou3d", {"gt": good, "est": {**good, **wrong}})
            for metric in (metrics.iou3d, metrics.iou3d_box, metrics.pose_error):
                with self.assertRaises(uniquadric.InputError) as caught:
                    metric((matrix(), (1, 1, 1)), (pose, axes))
                self.assertEqual(str(caught.exception), expected)
        with self.assertRaisesRegex(uniquadric.InputError, "^est: .* so R is no rotation$"):
            metrics.iou3d((matrix(), (1, 1, 1)), (np.diag([1, 2, 1, 1]), (1, 1, 1)))


class TrajectoryMetricsTest(unittest.TestCase):
    def setUp(self):
        self.stamps, self.poses = path_of(CURVE)
        self.moved = matrix((3, 4, 0)) @ self.poses

    def test_ape_of_a_shifted_path(self):
        error = metrics.ape((self.stamps, self.poses), (self.stamps, self.moved))
        self.assertAlmostEqual(error["rmse"], 5)
        self.assertAlmostEqual(error["std"], 0, places=7)
        self.assertEqual((error["n"], error["unit"], error["coverage"]), (20, "m", 1))
        np.testing.assert_array_equal(error["stamp_ns"], self.stamps)
        np.testing.assert_allclose(error["values"], 5)

    def test_alignment(self):
        turned = matrix((3, 4, 5), TURN) @ self.poses
        error = metrics.ape((self.stamps, self.poses), (self.stamps, turned), align="se3")
        self.assertLess(error["max"], 1e-12)
        np.testing.assert_allclose(error["reference_from_estimate"], np.linalg.inv(matrix((3, 4, 5), TURN)),
                                   atol=1e-12)
        half = self.poses.copy()
        half[:, :3, 3] /= 2
        scaled = metrics.ape((self.stamps, self.poses), (self.stamps, half), align="sim3")
        self.assertAlmostEqual(scaled["scale"], 2)
        self.assertLess(scaled["max"], 1e-12)

    def test_parts(self):
        turn = matrix((0, 0, 0), (0, 0, np.sin(0.1), np.cos(0.1)))
        error = metrics.ape((self.stamps, self.poses), (self.stamps, self.poses @ turn), part="rotation")
        np.testing.assert_allclose(error["values"], 0.2)
        self.assertEqual(error["unit"], "rad")

    def test_rpe(self):
        # A shift of the whole path is none of its steps; a path of half the size has half the steps.
        same = metrics.rpe((self.stamps, self.poses), (self.stamps, self.moved))
        self.assertLess(same["max"], 1e-12)
        self.assertEqual(same["n"], 19)
        half = self.poses.copy()
        half[:, :3, 3] /= 2
        steps = np.linalg.norm(np.diff(self.poses[:, :3, 3], axis=0), axis=1)
        error = metrics.rpe((self.stamps, self.poses), (self.stamps, half))
        np.testing.assert_allclose(error["values"], steps / 2)
        np.testing.assert_array_equal(error["stamp_ns"], self.stamps[1:])
        self.assertEqual(metrics.rpe((self.stamps, self.poses), (self.stamps, half), delta="0.5s")["n"], 3)

    def test_files_as_the_program(self):
        truth = support.data() / "truth" / "camera.tum"
        folder = support.new_folder()
        result = uniquadric.Result(folder / "estimate")
        for k, (stamp_ns, pose) in enumerate(zip(*support.read_tum(truth))):
            result.camera(matrix((0.01 * k**2, 0, 0)) @ pose, stamp_ns=stamp_ns)
        result.write()
        estimate = folder / "estimate" / "camera.tum"
        code, said, error = support.run("trajectory", truth, estimate, "--json")
        self.assertEqual(code, 0, error)
        expected = json.loads(said)
        for relation in ("ape", "rpe"):
            for part in ("translation_m", "rotation_rad"):
                found = getattr(metrics, relation)(truth, str(estimate), part=part.split("_")[0])
                for name, value in expected[relation][part].items():
                    self.assertEqual(found[name], value)

    def test_errors(self):
        folder = support.new_folder()
        (folder / "a.tum").write_text("0 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 2\n")
        (folder / "b.tum").write_text("".join(f"{k} 0 0 {k} 0 0 0 1\n" for k in range(5)))
        for reference, estimate, options in [("a", "b", []), ("b", "none", []), ("b", "b", ["--align", "se3"]),
                                             ("b", "b", ["--delta", "9f"])]:
            paths = folder / f"{reference}.tum", folder / f"{estimate}.tum"
            named = {name[2:]: value for name, value in zip(options[::2], options[1::2])}
            with self.assertRaises(uniquadric.InputError) as caught:
                metrics.rpe(*paths, **named)
            self.assertEqual(str(caught.exception), support.error_line("trajectory", *paths, *options))
        path = (self.stamps, self.poses)
        for text, named in [("align: 'sim2' is none of none, first, se3, sim3, scale, posyaw, poses", {"align": "sim2"}),
                            ("part: 'x' is none of translation, rotation, full", {"part": "x"}),
                            ("association: 'x' is none of nearest, one_to_one", {"association": "x"}),
                            ("max_dt_s: expected 0 to 1e9 s", {"max_dt_s": -1})]:
            with self.assertRaises(uniquadric.InputError) as caught:
                metrics.ape(path, path, **named)
            self.assertEqual(str(caught.exception), text)
        with self.assertRaisesRegex(uniquadric.InputError, "^estimate: 0 of 20 poses lie within 0.01 s"):
            metrics.ape(path, (self.stamps + 10**12, self.poses))
        with self.assertRaisesRegex(uniquadric.InputError, r"^estimate\[1\]: timestamp .* does not come after"):
            metrics.ape(path, (self.stamps * 0, self.poses))


if __name__ == "__main__":
    unittest.main()
