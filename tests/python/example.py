# What docs/python.md quotes; run in a folder with out/data.
import uniquadric
from uniquadric import metrics

sequence = uniquadric.Sequence("out/data/sequence")
print(sequence.name, sequence.camera.matrix)
for frame in sequence.frames:
    rgb = frame.rgb()        # height x width x 3, uint8, red green blue
    depth = frame.depth_m()  # height x width, float32 [m], 0: none; None without a depth image
    masks = frame.masks()    # height x width, uint16, 0: background; None without masks
for scan in sequence.scans:
    points = scan.points()   # points["x"], ..., points["offset_ns"]: each at its own time

truth = uniquadric.Truth("out/data/truth")
result = uniquadric.Result("out/mine")
for stamp_ns, world_from_camera in zip(*truth.camera):  # your estimate instead
    result.camera(world_from_camera, stamp_ns=stamp_ns)
for track in truth.objects.values():
    for stamp_ns, world_from_object in zip(track.stamp_ns, track.world_from_object):
        result.object(track.id, world_from_object, semi_axes_m=[0.2, 0.2, 0.2], stamp_ns=stamp_ns)
result.write()  # out/mine, for `uniquadric evaluate` and `check-result`

track = truth.objects[min(truth.objects)]
true_body = (track.world_from_object[0], track.semi_axes_m[0])
estimate = (track.world_from_object[0], [0.2, 0.2, 0.2])
print(metrics.iou3d(true_body, estimate), metrics.iou3d_box(true_body, estimate))
print(metrics.pose_error(true_body, estimate)["d_shape_m"])
print(metrics.iou2d(true_body, estimate, sequence.camera, truth.camera.poses[0])["rect_iou"])
print(metrics.ape("out/data/truth/camera.tum", "out/mine/camera.tum", align="se3")["rmse"])
print(metrics.rpe(truth.camera, uniquadric.Truth("out/mine").camera, part="rotation", delta="1f")["mean"])
