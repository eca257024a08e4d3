// Geometry of the views. A pose is [x, y, z, qx, qy, qz, qw], world_from_object or world_from_camera; z is up.
const v_add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
const v_sub = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const v_scale = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
const v_dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const v_cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const v_length = (a) => Math.hypot(...a);

// The pose's x, y and z axis in the world. The quaternion's digits were cut: it is made a unit again.
function pose_axes(pose) {
  const n = Math.hypot(pose[3], pose[4], pose[5], pose[6]);
  const [x, y, z, w] = pose.slice(3).map((part) => part / n);
  return [
    [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)],
    [2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)],
    [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)],
  ];
}

const kHalfAngle = (20 * Math.PI) / 180; // of the view, over the shorter side of the canvas

// An eye that looks at `target` from a yaw and a pitch [rad]; x right, y down, z forward.
function orbit_view({ target, yaw, pitch, distance }, width, height) {
  const back = [Math.cos(pitch) * Math.cos(yaw), Math.cos(pitch) * Math.sin(yaw), Math.sin(pitch)];
  const forward = v_scale(back, -1), right = [-Math.sin(yaw), Math.cos(yaw), 0];
  return { eye: v_add(target, v_scale(back, distance)), right, down: v_cross(forward, right), forward,
    focal: Math.min(width, height) / 2 / Math.tan(kHalfAngle), cx: width / 2, cy: height / 2, near: distance / 100 };
}

function in_view(view, point) {
  const d = v_sub(point, view.eye);
  return [v_dot(view.right, d), v_dot(view.down, d), v_dot(view.forward, d)];
}

const on_canvas = (view, p) => [view.cx + (view.focal * p[0]) / p[2], view.cy + ((view.focal_y ?? view.focal) * p[1]) / p[2]];

// 1, 2 or 5 times a power of ten, at least `length`.
function round_length(length) {
  const power = 10 ** Math.floor(Math.log10(length));
  return [1, 2, 5, 10].map((n) => n * power).find((n) => n >= length * (1 - 1e-9));
}
