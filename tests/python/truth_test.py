import json
import unittest

import numpy as np
import support
import uniquadric


class TruthTest(unittest.TestCase):
    def setUp(self):
        self.folder = support.data() / "truth"
        self.truth = uniquadric.Truth(self.folder)

    def test_poses_are_those_of_the_files(self):
        stamps, poses = support.read_tum(self.folder / "camera.tum")
        np.testing.assert_array_equal(self.truth.camera.stamp_ns, stamps)
        np.testing.assert_allclose(self.truth.camera.poses, poses, atol=1e-14)
        track = self.truth.objects[3]
        stamps, poses = support.read_tum(self.folder / "objects" / "3.tum")
        np.testing.assert_array_equal(track.stamp_ns, stamps)
        np.testing.assert_allclose(track.world_from_object, poses, atol=1e-14)

    def test_object_is_that_of_the_scene(self):
        self.assertEqual(list(self.truth.objects), [3])
        track = self.truth.objects[3]
        self.assertEqual((track.id, track.name), (3, "crate"))
        np.testing.assert_allclose(track.semi_axes_m, [[0.2, 0.3, 0.15]] * 3, atol=1e-6)
        np.testing.assert_array_equal(track.exponents, np.full((3, 3), 2.0))
        np.testing.assert_array_equal(track.frame, [0, 1, 2])
        np.testing.assert_allclose(np.diff(track.world_from_object[:, :3, 3], axis=0), [[0.02, 0, 0]] * 2,
                                   atol=1e-9)
        self.assertTrue(np.isnan(track.variances).all())
        self.assertEqual(track.status, ["active"] * 3)
        self.assertEqual(track.profile_axis, ["z"] * 3)
        self.assertEqual(self.truth.calibration.width, 160)

    def test_evaluation_reads_the_same(self):
        # What is written from the arrays has no error against the truth.
        out = support.new_folder()
        result = uniquadric.Result(out / "estimate")
        for stamp_ns, pose in zip(*self.truth.camera):
            result.camera(pose, stamp_ns=stamp_ns)
        track = self.truth.objects[3]
        for stamp_ns, pose, axes in zip(track.stamp_ns, track.world_from_object, track.semi_axes_m):
            result.object(3, pose, axes, stamp_ns=stamp_ns)
        result.write()
        code, _, error = support.run("evaluate", self.folder, out / "estimate", out / "evaluation")
        self.assertEqual(code, 0, error)
        evaluation = json.loads((out / "evaluation" / "evaluation.json").read_text())
        self.assertLess(evaluation["camera"]["ape"]["translation_m"]["max"], 1e-12)
        [scored] = evaluation["objects"]
        self.assertLess(scored["ape"]["translation_m"]["max"], 1e-12)
        self.assertGreater(scored["iou3d"]["min"], 1 - 1e-9)

    def test_faults_have_the_text_of_the_program(self):
        copy = support.new_folder() / "truth"
        support.shutil.copytree(self.folder, copy)
        (copy / "hashes.txt").unlink()
        lines = (copy / "camera.tum").read_text().splitlines()
        lines[2] = "0.1 1 2 nan 0 0 0 1"
        (copy / "camera.tum").write_text("\n".join(lines))
        with self.assertRaises(uniquadric.InputError) as caught:
            uniquadric.Truth(copy)
        expected = support.error_line("evaluate", copy, self.folder, support.new_folder() / "out")
        self.assertEqual(str(caught.exception), expected)
        self.assertIn("camera.tum:3: 'nan' is not a finite number", expected)
        with self.assertRaises(ValueError):
            uniquadric.Truth(copy / "none")


class SequenceFaultTest(unittest.TestCase):
    def test_faults_have_the_text_of_the_program(self):
        missing = support.new_folder() / "none"
        with self.assertRaises(uniquadric.InputError) as caught:
            uniquadric.Sequence(missing)
        self.assertEqual(str(caught.exception),
                         support.error_line("perceive", missing, support.new_folder() / "out", "--variant",
                                            support.SOURCE / "configs/variants/superquadric.yaml"))

    def test_a_truncated_image_is_named(self):
        copy = support.new_folder() / "sequence"
        support.shutil.copytree(support.data() / "sequence", copy)
        sequence = uniquadric.Sequence(copy)
        image = next(copy.glob("rgb/*"))
        image.write_bytes(image.read_bytes()[:200])
        with self.assertRaisesRegex(uniquadric.InputError, str(image)):
            for frame in sequence.frames:
                frame.rgb()


if __name__ == "__main__":
    unittest.main()
