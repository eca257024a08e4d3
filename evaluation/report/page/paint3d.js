// Paints the 3D view with three.js, or without WebGL in lines: `look` says what and in which colours, `view` from
// where (space.js).
const kFloorAlpha = 0.6, kLaterAlpha = 0.3, kCloudPixels = 2;

// The context is asked for first: three.js writes an error where it gets none.
function make_painter(canvas) {
  const context = canvas.getContext("webgl", { alpha: true, antialias: true, depth: true });
  return context ? new Painter(canvas, context) : new LinePainter(canvas);
}

// The ends of the floor's lines.
function floor_points({ x, y, z, step }) {
  const points = [];
  for (let at = x[0]; at <= x[1] + step / 2; at += step) points.push([at, y[0], z], [at, y[1], z]);
  for (let at = y[0]; at <= y[1] + step / 2; at += step) points.push([x[0], at, z], [x[1], at, z]);
  return points;
}

// The base of a camera's pyramid.
function image_corners({ pose, depth, half_width, half_height }) {
  const [right, down, forward] = pose_axes(pose), middle = v_add(pose.slice(0, 3), v_scale(forward, depth));
  const corner = (x, y) => v_add(middle, v_add(v_scale(right, x * half_width * depth), v_scale(down, y * half_height * depth)));
  return [corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1)];
}

// On a flat canvas, where near things do not hide far ones.
class LinePainter {
  constructor(canvas) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
  }

  paint(view, look) {
    const ratio = window.devicePixelRatio || 1, floor = floor_points(look.floor);
    Object.assign(this.canvas, { width: Math.round(look.width * ratio), height: Math.round(look.height * ratio) });
    this.context.setTransform(ratio, 0, 0, ratio, 0, 0);
    this.view = view;
    for (let i = 0; i < floor.length; i += 2) this.line(floor.slice(i, i + 2), look.colors.line, { opacity: kFloorAlpha });
    if (look.cloud) this.cloud(look.cloud);
    for (const path of look.paths) this.path(path, look.index);
    for (const camera of look.cameras) this.frustum(camera);
    for (const body of look.bodies) this.outline(body, body.color, { fill: body.truth ? 0.08 : 0.25, dash: body.truth });
    for (const { center, sigmas_m, color } of look.sigmas) this.outline({ mesh: unit_solid([2, 2, 2, 2]), pose: [...center, 0, 0, 0, 1], scale: sigmas_m }, color, { fill: 0.1 });
  }

  // Through points of the world; it breaks where there is none, and behind the eye.
  line(points, color, { opacity = 1, dash = false } = {}) {
    with_style(this.context, { dash: dash ? [6, 4] : [], set: { strokeStyle: color, globalAlpha: opacity, lineWidth: 1.4 } }, () => {
      let draw = "moveTo";
      this.context.beginPath();
      for (const point of points) {
        const p = point && in_view(this.view, point), is_seen = p && p[2] > this.view.near;
        if (is_seen) this.context[draw](...on_canvas(this.view, p));
        draw = is_seen ? "lineTo" : "moveTo";
      }
      this.context.stroke();
    });
  }

  path({ points, color, dash, colors }, index) {
    if (!colors) {
      this.line(points.slice(0, index + 1), color, { dash });
      this.line(points.slice(index), color, { dash, opacity: kLaterAlpha });
    } else for (let i = 1; i < points.length; ++i)
      this.line(points.slice(i - 1, i + 1), `rgb(${colors[i].map((part) => Math.round(255 * part)).join(" ")})`, { opacity: i <= index ? 1 : kLaterAlpha });
  }

  frustum(camera) {
    const corners = image_corners(camera), eye = camera.pose.slice(0, 3);
    corners.forEach((corner, i) => this.line([eye, corner, corners[(i + 1) % 4]], camera.color, camera));
  }

  outline(body, color, { fill, dash }) {
    const outline = outline_of(this.view, body), { context } = this;
    if (!outline) return;
    with_style(context, { dash: dash ? [6, 4] : [], set: { strokeStyle: color, fillStyle: color, lineWidth: 1.6 } }, () => {
      context.beginPath();
      for (const p of outline.points) context.lineTo(...p);
      context.closePath();
      context.stroke();
      context.globalAlpha = fill;
      context.fill();
    });
  }

  cloud({ positions_mm, colors }) {
    with_style(this.context, { set: { globalAlpha: 0.7 } }, () => colors.forEach((color, i) => {
      const p = in_view(this.view, positions_mm.slice(3 * i, 3 * i + 3).map((mm) => mm / 1000));
      if (p[2] <= this.view.near) return;
      const [x, y] = on_canvas(this.view, p);
      this.context.fillStyle = `#${color.toString(16).padStart(6, "0")}`;
      this.context.fillRect(x, y, kCloudPixels, kCloudPixels);
    }));
  }
}

class Painter {
  constructor(canvas, context) {
    this.renderer = new THREE.WebGLRenderer({ canvas, context, antialias: true, alpha: true });
    this.camera = new THREE.PerspectiveCamera();
    this.camera.matrixAutoUpdate = false;
    this.geometries = new Map(); // of shapes, by what they are
    this.clouds = new Map(); // by scene
  }

  paint(view, look) {
    const scene = new THREE.Scene(), ratio = window.devicePixelRatio || 1;
    this.once = []; // what lives for this picture
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(look.width, look.height, false);
    this.aim(view, look);
    scene.add(new THREE.HemisphereLight(0xffffff, 0x888888, 0.75), this.sun(view));
    scene.add(this.lines(floor_points(look.floor), look.colors.line, { opacity: kFloorAlpha }));
    if (look.cloud) scene.add(this.cloud(look.cloud));
    for (const path of look.paths) scene.add(...this.path(path, look.index));
    for (const camera of look.cameras) scene.add(...this.frustum(camera));
    for (const body of look.bodies) scene.add(...this.body(body));
    for (const ball of look.sigmas) scene.add(this.sigma(ball));
    this.renderer.render(scene, this.camera);
    for (const thing of this.once) thing.dispose();
  }

  // A pinhole with its middle in the canvas' middle; OpenGL's camera looks along -z, y up.
  aim(view, { width, height, size }) {
    const { eye, right, down, forward } = view, far = 100 * size, t = (view.near * height) / 2 / view.focal, r = (view.near * width) / 2 / view.focal;
    this.camera.projectionMatrix.makePerspective(-r, r, t, -t, view.near, far);
    this.camera.projectionMatrixInverse.getInverse(this.camera.projectionMatrix);
    this.camera.matrix.set(right[0], -down[0], -forward[0], eye[0], right[1], -down[1], -forward[1], eye[1], right[2], -down[2], -forward[2], eye[2], 0, 0, 0, 1);
    this.camera.updateMatrixWorld(true);
  }

  sun(view) {
    const light = new THREE.DirectionalLight(0xffffff, 0.45); // over the eye's shoulder
    light.position.set(...v_sub(v_add(view.eye, v_scale(view.right, -1)), v_scale(view.down, 2)));
    light.target.position.set(...v_add(view.eye, view.forward));
    light.target.updateMatrixWorld();
    return light;
  }

  keep(thing) {
    this.once.push(thing);
    return thing;
  }

  lines(points, color, { dash, opacity = 1, colors } = {}) {
    const geometry = this.keep(new THREE.BufferGeometry());
    geometry.setAttribute("position", new THREE.Float32BufferAttribute(points.flat(), 3));
    if (colors) geometry.setAttribute("color", new THREE.Float32BufferAttribute(colors.flat(), 3));
    const options = { color: colors ? 0xffffff : color, opacity, transparent: opacity < 1, vertexColors: colors ? THREE.VertexColors : THREE.NoColors };
    const material = this.keep(dash ? new THREE.LineDashedMaterial({ ...options, dashSize: dash, gapSize: dash * 0.7 }) : new THREE.LineBasicMaterial(options));
    const segments = new THREE.LineSegments(geometry, material);
    if (dash) segments.computeLineDistances();
    return segments;
  }

  cloud({ scene, positions_mm, colors }) {
    if (!this.clouds.has(scene)) {
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute("position", new THREE.Float32BufferAttribute(positions_mm.map((mm) => mm / 1000), 3));
      geometry.setAttribute("color", new THREE.Float32BufferAttribute(colors.flatMap((c) => [(c >> 16) / 255, ((c >> 8) & 255) / 255, (c & 255) / 255]), 3));
      this.clouds.set(scene, new THREE.Points(geometry, new THREE.PointsMaterial({ size: kCloudPixels, sizeAttenuation: false, vertexColors: THREE.VertexColors, transparent: true, opacity: 0.7 })));
    }
    return this.clouds.get(scene);
  }

  // A trajectory: strong up to now, faint after.
  path({ points, color, dash, colors }, index) {
    const segments = (from, to) => {
      const ends = [];
      for (let i = Math.max(1, from); i <= Math.min(to, points.length - 1); ++i) if (points[i - 1] && points[i]) ends.push(i - 1, i);
      return ends;
    };
    return [[segments(1, index), 1], [segments(index + 1, points.length), kLaterAlpha]].filter(([ends]) => ends.length > 0)
      .map(([ends, opacity]) => this.lines(ends.map((i) => points[i]), color, { opacity, dash, colors: colors && ends.map((i) => colors[i]) }));
  }

  // A camera as a pyramid along its z axis, with its image in the base.
  frustum(camera) {
    const { pose, color, dash, depth, image } = camera, corners = image_corners(camera), eye = pose.slice(0, 3);
    const edges = corners.flatMap((c, i) => [c, corners[(i + 1) % 4], eye, c]);
    return [this.lines(edges, color, { dash: dash && depth / 8 }), ...(image && image.complete && image.naturalWidth ? [this.picture(corners, image)] : [])];
  }

  picture(corners, image) {
    const geometry = this.keep(new THREE.BufferGeometry()), texture = this.keep(new THREE.Texture(image));
    geometry.setAttribute("position", new THREE.Float32BufferAttribute([0, 3, 2, 0, 2, 1].flatMap((i) => corners[i]), 3));
    geometry.setAttribute("uv", new THREE.Float32BufferAttribute([0, 1, 0, 0, 1, 0, 0, 1, 1, 0, 1, 1], 2));
    Object.assign(texture, { needsUpdate: true, generateMipmaps: false, minFilter: THREE.LinearFilter });
    return new THREE.Mesh(geometry, this.keep(new THREE.MeshBasicMaterial({ map: texture, side: THREE.DoubleSide, transparent: true, opacity: 0.9 })));
  }

  // The surface, its normals and its sharp edges, made once a shape.
  geometry({ mesh, key }) {
    if (!this.geometries.has(key)) {
      const surface = new THREE.BufferGeometry();
      surface.setAttribute("position", new THREE.Float32BufferAttribute(mesh.triangles.flatMap((i) => mesh.points[i]), 3));
      surface.computeVertexNormals(); // flat: true meshes have corners
      this.geometries.set(key, { surface, edges: new THREE.EdgesGeometry(surface, 30) });
    }
    return this.geometries.get(key);
  }

  // The estimate solid with edges, the truth faint with strong edges.
  body(body) {
    const { surface, edges } = this.geometry(body), [x, y, z] = pose_axes(body.pose), [a, b, c] = body.scale, p = body.pose, matrix = new THREE.Matrix4();
    matrix.set(x[0] * a, y[0] * b, z[0] * c, p[0], x[1] * a, y[1] * b, z[1] * c, p[1], x[2] * a, y[2] * b, z[2] * c, p[2], 0, 0, 0, 1);
    const material = this.keep(new THREE.MeshLambertMaterial({ color: body.color, transparent: true, opacity: body.truth ? 0.16 : 0.5, side: THREE.DoubleSide, depthWrite: false }));
    const lines = new THREE.LineSegments(edges, this.keep(new THREE.LineBasicMaterial({ color: body.color, transparent: true, opacity: body.truth ? 0.9 : 0.8 })));
    const parts = [new THREE.Mesh(surface, material), lines];
    for (const part of parts) Object.assign(part, { matrixAutoUpdate: false, frustumCulled: false }).matrix.copy(matrix);
    return parts;
  }

  sigma({ center, sigmas_m, color }) {
    this.ball ??= new THREE.SphereBufferGeometry(1, 24, 16);
    const mesh = new THREE.Mesh(this.ball, this.keep(new THREE.MeshBasicMaterial({ color, wireframe: true, transparent: true, opacity: 0.6 })));
    mesh.position.set(...center);
    mesh.scale.set(...sigmas_m);
    return mesh;
  }
}

function with_style(context, style, paint) {
  context.save();
  context.setLineDash(style.dash ?? []);
  Object.assign(context, { lineCap: "round", lineJoin: "round", ...style.set });
  paint();
  context.restore();
}

function paint_text(context, text, x, y, color, paper) {
  with_style(context, { set: { font: "12px system-ui, 'DejaVu Sans', sans-serif", textAlign: "center", fillStyle: color,
    strokeStyle: paper, lineWidth: 3 } }, () => {
    context.strokeText(text, x, y);
    context.fillText(text, x, y);
  });
}

// The world's axes in the lower left corner.
function paint_compass(context, view, height, color, paper) {
  const origin = [38, height - 38];
  [[1, 0, 0], [0, 1, 0], [0, 0, 1]].forEach((direction, i) => {
    const x = v_dot(view.right, direction), y = v_dot(view.down, direction);
    with_style(context, { set: { strokeStyle: color, lineWidth: 1.5 } }, () => {
      context.beginPath();
      context.moveTo(...origin);
      context.lineTo(origin[0] + 20 * x, origin[1] + 20 * y);
      context.stroke();
    });
    paint_text(context, "xyz"[i], origin[0] + 29 * x, origin[1] + 29 * y + 4, color, paper);
  });
}

// Names of the true bodies, over the picture.
function paint_names(context, view, bodies, look) {
  context.clearRect(0, 0, look.width, look.height);
  for (const body of bodies.filter((b) => b.truth)) {
    const top = body.outline.points.reduce((a, b) => (b[1] < a[1] ? b : a));
    paint_text(context, body.object, top[0], top[1] - 8, look.colors.ink, look.colors.paper);
  }
  paint_compass(context, view, look.height, look.colors.soft, look.colors.paper);
}
