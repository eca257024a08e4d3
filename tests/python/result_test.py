import json
import unittest

import numpy as np
import support
import uniquadric
from support import matrix

AXES = (0.2, 0.3, 0.15)


class ResultTest(unittest.TestCase):
    def setUp(self):
        self.out = support.new_folder() / "estimate"
        self.result = uniquadric.Result(self.out)

    def refuses(self, text, call, *arguments, **named):
        with self.assertRaises(uniquadric.InputError) as caught:
            call(*arguments, **named)
        self.assertEqual(str(caught.exception), text)

    def test_what_is_written_reads_back(self):
        turn = matrix((1, 2, 3), (0.5, 0.5, 0.5, 0.5))
        self.result.camera(matrix((0, 0, 1)), stamp_s=1.1)
        self.result.camera(turn, stamp_ns=1_200_000_001)
        self.result.object(7, turn, AXES, stamp_s=1.1)
        self.result.object(7, matrix((4, 5, 6)), AXES, exponents=(1.5, 1.6, 1.7), stamp_ns=1_200_000_001)
        self.result.object(2, turn, AXES, exponents=1, stamp_ns=1_200_000_001)
        self.result.write()
        read = uniquadric.Truth(self.out)
        np.testing.assert_array_equal(read.camera.stamp_ns, [1_100_000_000, 1_200_000_001])
        np.testing.assert_allclose(read.camera.poses, [matrix((0, 0, 1)), turn], atol=1e-15)
        self.assertEqual(list(read.objects), [2, 7])
        track = read.objects[7]
        np.testing.assert_array_equal(track.frame, [0, 1])
        np.testing.assert_array_equal(track.semi_axes_m, [AXES, AXES])
        np.testing.assert_array_equal(track.exponents, [[2, 2, 2], [1.5, 1.6, 1.7]])
        np.testing.assert_allclose(track.world_from_object, [turn, matrix((4, 5, 6))], atol=1e-15)
        np.testing.assert_array_equal(read.objects[2].exponents, [[1, 1, 1]])

    def test_the_program_takes_it(self):
        truth = uniquadric.Truth(support.data() / "truth")
        shift = matrix((0.01, 0, 0))
        for stamp_ns, pose in zip(*truth.camera):
            self.result.camera(pose, stamp_ns=stamp_ns)
        track = truth.objects[3]
        for stamp_ns, pose in zip(track.stamp_ns, track.world_from_object):
            self.result.object(9, shift @ pose, track.semi_axes_m[0], stamp_ns=stamp_ns)
        self.result.write()
        code, said, error = support.run("check-result", self.out, "--sequence", support.data() / "sequence",
                                        "--truth", support.data() / "truth")
        self.assertEqual((code, error), (0, ""), said)
        code, _, error = support.run("evaluate", support.data() / "truth", self.out, self.out.parent / "evaluation")
        self.assertEqual(code, 0, error)
        [scored] = json.loads((self.out.parent / "evaluation" / "evaluation.json").read_text())["objects"]
        self.assertAlmostEqual(scored["ape"]["translation_m"]["rmse"], 0.01, places=9)

    def test_an_existing_folder_is_replaced_when_asked(self):
        self.result.camera(matrix(), stamp_ns=0)
        self.result.write()
        again = uniquadric.Result(self.out)
        again.camera(matrix((1, 0, 0)), stamp_ns=5)
        with self.assertRaises(uniquadric.InputError):
            again.write()
        np.testing.assert_array_equal(uniquadric.Truth(self.out).camera.stamp_ns, [0])
        forced = uniquadric.Result(self.out, force=True)
        forced.camera(matrix(), stamp_ns=5)
        forced.write()
        np.testing.assert_array_equal(uniquadric.Truth(self.out).camera.stamp_ns, [5])

    def test_stamps(self):
        self.refuses("expected one of stamp_ns and stamp_s", self.result.camera, matrix())
        self.refuses("expected one of stamp_ns and stamp_s", self.result.camera, matrix(), stamp_ns=1, stamp_s=1)
        self.refuses("stamp_ns: 0.5 is not an integer", self.result.camera, matrix(), stamp_ns=0.5)
        self.refuses("stamp_s: nan is not a timestamp in seconds", self.result.camera, matrix(),
                     stamp_s=float("nan"))
        self.refuses("stamp_ns: 5000000000000000000 is not within 4500000000000000000 ns of 1970",
                     self.result.camera, matrix(), stamp_ns=5 * 10**18)
        self.result.camera(matrix(), stamp_ns=10)
        self.refuses("world_from_camera: timestamp 0.000000010 does not come after 0.000000010",
                     self.result.camera, matrix(), stamp_ns=10)
        self.result.object(1, matrix(), AXES, stamp_ns=10)
        self.result.object(2, matrix(), AXES, stamp_ns=5)  # another object's own time
        self.refuses("world_from_object of object 1: timestamp 0.000000009 does not come after 0.000000010",
                     self.result.object, 1, matrix(), AXES, stamp_ns=9)

    def test_poses(self):
        for pose, text in [
                (matrix((np.inf, 0, 0)), "the position holds a number that is not finite"),
                (matrix((0, 2e9, 0)), "is further than 1000000000 m from the origin"),
                (np.diag([1, 1, np.nan, 1]), "the rotation holds a number that is not finite"),
                (np.diag([1, 1, -1, 1]), "the rotation is a reflection, as its determinant is -1"),
                (np.diag([1, 1, 2, 1]), "R^T R is off the identity by 3, so R is no rotation"),
                (matrix((1, 2, 3)).T, "expected 0 0 0 1 as the last row of the matrix"),
                (np.eye(3), "expected 4x4 numbers, found an array of shape (3, 3)"),
                ("text", "expected numbers")]:
            self.refuses("world_from_camera: " + text, self.result.camera, pose, stamp_ns=1)
        self.result.write()  # nothing of the refused is in it
        self.assertEqual(len(uniquadric.Truth(self.out).camera.stamp_ns), 0)

    def test_objects(self):
        for axes, text in [((1, 0, 1), "expected numbers greater than 0"), ((1, -1, 1), "expected numbers greater than 0"),
                           ((1, np.nan, 1), "holds a number that is not finite"),
                           ((1, 2), "expected 3 numbers, found an array of shape (2,)")]:
            self.refuses("semi_axes_m: " + text, self.result.object, 1, matrix(), axes, stamp_ns=1)
        self.refuses("exponents: 0.5 is not from 1 (a box) to 2 (an ellipsoid)", self.result.object, 1, matrix(),
                     AXES, (1, 0.5, 1), stamp_ns=1)
        for bad in (0, -1, 1.5):
            self.refuses(f"id: {bad} is not an integer greater than 0", self.result.object, bad, matrix(), AXES,
                         stamp_ns=1)


if __name__ == "__main__":
    unittest.main()
