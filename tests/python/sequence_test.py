import csv
import unittest

import numpy as np
import support
import uniquadric

try:
    from PIL import Image
except ImportError:
    Image = None


def listed(name):
    """The lines of rgb.txt and the like."""
    lines = (support.data() / "sequence" / name).read_text().splitlines()
    return [line.split() for line in lines if not line.startswith("#")]


class SequenceTest(unittest.TestCase):
    def setUp(self):
        self.folder = support.data() / "sequence"
        self.sequence = uniquadric.Sequence(self.folder)

    def test_header(self):
        s = self.sequence
        self.assertEqual((s.name, s.seed, s.rate_hz), ("three_frames", 1, 10))
        self.assertEqual(s.program, "uniquadric " + uniquadric.__version__)
        self.assertEqual((s.camera.width, s.camera.height), (160, 120))
        np.testing.assert_array_equal(s.camera.matrix, [[131, 0, 79.5], [0, 132, 59.5], [0, 0, 1]])
        np.testing.assert_array_equal(s.camera.distortion, np.zeros(5))
        self.assertEqual([frame.stamp_ns for frame in s.frames], [0, 100_000_000, 200_000_000])
        self.assertEqual([frame.index for frame in s.frames], [0, 1, 2])
        stamps, poses = support.read_tum(self.folder / "camera_given.tum")
        np.testing.assert_array_equal(s.given_camera.stamp_ns, stamps)
        np.testing.assert_allclose(s.given_camera.poses, poses, atol=1e-14)

    def test_calibration(self):
        s = self.sequence
        self.assertEqual((s.imu.rate_hz, s.imu.gravity_mps2), (200, 9.81))
        self.assertEqual((s.lidar.pattern, s.lidar.rate_hz), ("livox_avia", 10))
        # Both stand in one body's frame, so their places differ by those of the scene, in the body's axes.
        shift = s.lidar.camera_from_lidar[:3, 3] - s.imu.camera_from_imu[:3, 3]
        in_body = s.lidar.camera_from_lidar[:3, :3].T @ shift
        np.testing.assert_allclose(in_body, [0.07, -0.02, 0.20], atol=1e-12)

    @unittest.skipIf(Image is None, "python3-pil is not installed")
    def test_images_are_those_of_another_reader(self):
        self.assertIn("depth: {units_per_m: 1000}", (self.folder / "sequence.yaml").read_text())
        for frame, rgb, depth, masks in zip(self.sequence.frames, listed("rgb.txt"), listed("depth.txt"),
                                            listed("masks.txt")):
            units = np.asarray(Image.open(self.folder / depth[1])).astype(np.int64)
            units[units == 65535] = 0
            np.testing.assert_array_equal(frame.rgb(), np.asarray(Image.open(self.folder / rgb[1])))
            np.testing.assert_allclose(frame.depth_m(), units / 1000, rtol=1e-6)
            np.testing.assert_array_equal(frame.masks(), np.asarray(Image.open(self.folder / masks[1])))

    def test_images_show_the_scene(self):
        frame = self.sequence.frames[0]
        rgb, depth, masks = frame.rgb(), frame.depth_m(), frame.masks()
        self.assertEqual((rgb.shape, rgb.dtype), ((120, 160, 3), np.uint8))
        self.assertEqual((depth.shape, depth.dtype), ((120, 160), np.float32))
        self.assertEqual((masks.shape, masks.dtype), ((120, 160), np.uint16))
        crate = (masks > 0) & (depth > 0)
        self.assertGreater(crate.sum(), 300)
        # The crate's points lie within its box's diagonal of its true centre.
        truth = uniquadric.Truth(support.data() / "truth")
        camera_from_crate = np.linalg.inv(truth.camera.poses[0]) @ truth.objects[3].world_from_object[0]
        v, u = np.nonzero(crate)
        k = self.sequence.camera.matrix
        rays = np.stack([(u - k[0, 2]) / k[0, 0], (v - k[1, 2]) / k[1, 1], np.ones(len(u))])
        distance = np.linalg.norm((rays * depth[crate]).T - camera_from_crate[:3, 3], axis=1)
        half_diagonal = np.linalg.norm(truth.objects[3].semi_axes_m[0])
        self.assertLess(np.median(distance), half_diagonal)
        self.assertGreater(np.median(distance), 0.1)

    def test_scans(self):
        scans = self.sequence.scans
        self.assertEqual([scan.stamp_ns for scan in scans],
                         [round(float(stamp) * 1e9) for stamp, _ in listed("lidar.txt")])
        points = scans[0].points()
        self.assertEqual(points.dtype.names, ("x", "y", "z", "intensity", "offset_ns", "ring", "tag"))
        path = self.folder / listed("lidar.txt")[0][1]
        header, _, body = path.read_bytes().partition(b"DATA binary\n")
        lines = dict(line.split(" ", 1) for line in header.decode().splitlines() if " " in line)
        names = {"F4": "<f4", "U4": "<u4", "U2": "<u2", "U1": "u1"}
        kinds = [names[t + s] for t, s in zip(lines["TYPE"].split(), lines["SIZE"].split())]
        read = np.frombuffer(body, dtype=list(zip(lines["FIELDS"].split(), kinds)), count=int(lines["POINTS"]))
        self.assertEqual(len(points), len(read))
        self.assertGreater(len(points), 1000)
        for name in ("x", "y", "z", "intensity", "ring", "tag"):
            np.testing.assert_array_equal(points[name], read[name])
        np.testing.assert_array_equal(points["offset_ns"], read["offset_time"])

    def test_imu(self):
        samples = self.sequence.imu_samples()
        with open(self.folder / "imu.csv") as file:
            rows = list(csv.reader(file))[1:]
        self.assertEqual(len(samples), len(rows))
        np.testing.assert_array_equal(samples["stamp_ns"], [int(row[0]) for row in rows])
        np.testing.assert_array_equal(samples["angular_velocity_radps"],
                                      [[float(v) for v in row[1:4]] for row in rows])
        np.testing.assert_array_equal(samples["specific_force_mps2"], [[float(v) for v in row[4:]] for row in rows])

    def test_what_is_missing_is_none(self):
        copy = support.new_folder() / "sequence"
        support.shutil.copytree(self.folder, copy)
        for name in ("depth.txt", "masks.txt", "camera_given.tum"):
            (copy / name).unlink()
        sequence = uniquadric.Sequence(copy)
        self.assertIsNone(sequence.given_camera)
        frame = sequence.frames[0]
        self.assertIsNone(frame.depth_m())
        self.assertIsNone(frame.masks())
        self.assertEqual(frame.rgb().shape, (120, 160, 3))


if __name__ == "__main__":
    unittest.main()
