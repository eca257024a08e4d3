// Bodies as they are: superellipsoids by their support function (core/geometry/superquadric.h), true meshes.
const kRows = 24, kColumns = 48;

// The point of the unit body with exponents [outline, upper, lower] that supports a normal; z is the profile's axis.
function support_point([outline, upper, lower], [x, y, z]) {
  const power = (v, e) => (v === 0 ? 0 : Math.sign(v) * Math.abs(v) ** e), q = z > 0 ? upper : lower;
  const s = Math.abs(x) ** outline + Math.abs(y) ** outline;
  const scale = (s ** (q / outline) + Math.abs(z) ** q) ** (1 / q - 1), across = s > 0 ? scale * s ** (q / outline - 1) : 0;
  return [across * power(x, outline - 1), across * power(y, outline - 1), scale * power(z, q - 1)];
}

// Normals half a step off the planes of the axes, where a box's corners meet; a fan of triangles at each pole.
const unit_meshes = new Map();
function unit_solid(solid) {
  const key = solid.join();
  if (unit_meshes.has(key)) return unit_meshes.get(key);
  const [outline, upper, lower, axis] = solid, points = [], triangles = [];
  const add = (normal) => {
    const p = support_point([outline, upper, lower], normal), turned = [0, 0, 0];
    [1, 2, 0].forEach((step, i) => { turned[(axis + step) % 3] = p[i]; }); // a turn, so that outside stays outside
    points.push(turned);
  };
  for (let row = 0; row < kRows; ++row)
    for (let column = 0; column < kColumns; ++column) {
      const up = (Math.PI * (row + 0.5)) / kRows - Math.PI / 2, round = (2 * Math.PI * (column + 0.5)) / kColumns;
      add([Math.cos(up) * Math.cos(round), Math.cos(up) * Math.sin(round), Math.sin(up)]);
    }
  add([0, 0, -1]);
  add([0, 0, 1]);
  const at = (row, column) => row * kColumns + (column % kColumns), south = points.length - 2, north = points.length - 1;
  for (let column = 0; column < kColumns; ++column) {
    triangles.push(south, at(0, column + 1), at(0, column), north, at(kRows - 1, column), at(kRows - 1, column + 1));
    for (let row = 0; row + 1 < kRows; ++row)
      triangles.push(at(row, column), at(row, column + 1), at(row + 1, column + 1), at(row, column), at(row + 1, column + 1), at(row + 1, column));
  }
  unit_meshes.set(key, { points, triangles });
  return unit_meshes.get(key);
}

// The true mesh of an object, null where the results have none.
function true_mesh(scene, id) {
  const mesh = scenery[scene]?.meshes.find((m) => m.id === id);
  if (!mesh) return null;
  mesh.points ??= Array.from({ length: mesh.positions_mm.length / 3 }, (_, i) => [0, 1, 2].map((k) => mesh.positions_mm[3 * i + k] / 1000));
  return mesh;
}

// The surface's points in the world; a true body without a mesh is its solid.
function world_points({ mesh, pose, scale }) {
  const [x, y, z] = pose_axes(pose), origin = pose.slice(0, 3);
  return mesh.points.map((p) => v_add(origin, v_add(v_scale(x, p[0] * scale[0]), v_add(v_scale(y, p[1] * scale[1]), v_scale(z, p[2] * scale[2])))));
}

// Andrew's monotone chain: the convex hull of points of a plane, counter-clockwise.
function convex_hull(list) {
  const sorted = [...list].sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  const half = (points) => {
    const hull = [];
    for (const p of points) {
      while (hull.length > 1) {
        const [a, b] = hull.slice(-2);
        if ((b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) > 0) break;
        hull.pop();
      }
      hull.push(p);
    }
    return hull.slice(0, -1);
  };
  return [...half(sorted), ...half(sorted.reverse())];
}

// The outline of a body in a view; null unless it is wholly before the eye.
function outline_of(view, body) {
  const seen = world_points(body).map((p) => in_view(view, p));
  if (seen.some((p) => p[2] <= view.near)) return null;
  return { points: convex_hull(seen.map((p) => on_canvas(view, p))), depth: in_view(view, body.pose.slice(0, 3))[2] };
}

function outline_holds({ points: hull }, x, y) {
  return hull.every((a, i) => {
    const b = hull[(i + 1) % hull.length];
    return (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]) >= 0;
  });
}
