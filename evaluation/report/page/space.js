// Geometry of the 3D view. A pose is [x, y, z, qx, qy, qz, qw], world_from_object or world_from_camera; z is up.
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

// An ellipsoid: its centre, and its semi-axes as vectors.
function ellipsoid_of(pose, semi_axes_m) {
  return { center: pose.slice(0, 3), arms: pose_axes(pose).map((axis_of, i) => v_scale(axis_of, semi_axes_m[i])) };
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

const on_canvas = (view, p) => [view.cx + (view.focal * p[0]) / p[2], view.cy + (view.focal * p[1]) / p[2]];

// A segment's two ends on the canvas, cut at the plane before the eye; null when it lies behind.
function segment_on_canvas(view, from, to) {
  let a = in_view(view, from), b = in_view(view, to);
  if (a[2] < view.near && b[2] < view.near) return null;
  const cut = () => v_add(a, v_scale(v_sub(b, a), (view.near - a[2]) / (b[2] - a[2])));
  if (a[2] < view.near) a = cut();
  else if (b[2] < view.near) b = cut();
  return [on_canvas(view, a), on_canvas(view, b)];
}

// The outline, an ellipse of the canvas, by the dual conic C* = P Q* P^T; null unless it is wholly before the eye.
function outline_of(view, { center, arms }) {
  const c = in_view(view, center);
  const m = arms.map((arm) => [v_dot(view.right, arm), v_dot(view.down, arm), v_dot(view.forward, arm)]);
  const dual = (i, j) => m[0][i] * m[0][j] + m[1][i] * m[1][j] + m[2][i] * m[2][j] - c[i] * c[j];
  const scale = -dual(2, 2); // C*_33 = -1 after division
  if (c[2] <= view.near || scale <= view.near ** 2) return null;
  const mu = [-dual(0, 2) / scale, -dual(1, 2) / scale];
  const xx = dual(0, 0) / scale + mu[0] * mu[0], xy = dual(0, 1) / scale + mu[0] * mu[1], yy = dual(1, 1) / scale + mu[1] * mu[1];
  const mean = (xx + yy) / 2, half = Math.hypot((xx - yy) / 2, xy);
  return { x: view.cx + view.focal * mu[0], y: view.cy + view.focal * mu[1], a: view.focal * Math.sqrt(mean + half),
    b: view.focal * Math.sqrt(Math.max(0, mean - half)), angle: Math.atan2(2 * xy, xx - yy) / 2, depth: c[2] };
}

function outline_holds(outline, x, y) {
  const dx = x - outline.x, dy = y - outline.y, c = Math.cos(outline.angle), s = Math.sin(outline.angle);
  return ((c * dx + s * dy) / outline.a) ** 2 + ((c * dy - s * dx) / outline.b) ** 2 <= 1;
}

const kRingSteps = 48;

// The three ellipses in the planes of the axes: segments, each with whether the surface there faces the eye.
function rings_of(view, { center, arms }) {
  const eye = v_sub(view.eye, center), eye_parts = arms.map((arm) => v_dot(eye, arm) / v_dot(arm, arm));
  const segments = [];
  for (const [i, j] of [[0, 1], [1, 2], [2, 0]])
    for (let k = 0; k < kRingSteps; ++k) {
      const [from, to] = [k, k + 1].map((step) => (2 * Math.PI * step) / kRingSteps);
      const point = (t) => v_add(center, v_add(v_scale(arms[i], Math.cos(t)), v_scale(arms[j], Math.sin(t))));
      const middle = (from + to) / 2; // of the unit ball: it faces the eye where its dot product with it is above 1
      segments.push({ from: point(from), to: point(to), front: Math.cos(middle) * eye_parts[i] + Math.sin(middle) * eye_parts[j] > 1 });
    }
  return segments;
}

// What a light from straight above would darken of the floor at height z.
function footprint_of({ center, arms }, z) {
  const sum = (i, j) => arms.reduce((total, arm) => total + arm[i] * arm[j], 0);
  const [xx, xy, yy] = [sum(0, 0), sum(0, 1), sum(1, 1)], root = Math.sqrt(Math.max(0, yy - (xy * xy) / xx));
  return Array.from({ length: kRingSteps }, (_, k) => {
    const t = (2 * Math.PI * k) / kRingSteps, x = Math.sqrt(xx); // by the Cholesky factor of the shape seen from above
    return [center[0] + x * Math.cos(t), center[1] + (xy / x) * Math.cos(t) + root * Math.sin(t), z];
  });
}

// 1, 2 or 5 times a power of ten, at least `length`.
function round_length(length) {
  const power = 10 ** Math.floor(Math.log10(length));
  return [1, 2, 5, 10].map((n) => n * power).find((n) => n >= length * (1 - 1e-9));
}
