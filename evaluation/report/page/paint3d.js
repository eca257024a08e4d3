// Paints the 3D view with three.js: `look` says what and in which colours, `view` from where (space.js). Without
// WebGL there is no painter.
const kFloorAlpha = 0.6, kCloudPixels = 2;

function make_painter(canvas) {
  try {
    return new Painter(canvas);
  } catch {
    return null; // three.js throws where the browser has no WebGL
  }
}

class Painter {
  constructor(canvas) {
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true });
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
    scene.add(this.floor(look.floor, look.colors.line));
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

  floor({ x, y, z, step }, color) {
    const points = [];
    for (let at = x[0]; at <= x[1] + step / 2; at += step) points.push([at, y[0], z], [at, y[1], z]);
    for (let at = y[0]; at <= y[1] + step / 2; at += step) points.push([x[0], at, z], [x[1], at, z]);
    return this.lines(points, color, { opacity: kFloorAlpha });
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
    return [[segments(1, index), 1], [segments(index + 1, points.length), 0.3]].filter(([ends]) => ends.length > 0)
      .map(([ends, opacity]) => this.lines(ends.map((i) => points[i]), color, { opacity, dash, colors: colors && ends.map((i) => colors[i]) }));
  }

  // A camera as a pyramid along its z axis, with its image in the base.
  frustum({ pose, color, dash, depth, half_width, half_height, image }) {
    const [right, down, forward] = pose_axes(pose), eye = pose.slice(0, 3);
    const corner = (x, y) => v_add(eye, v_add(v_scale(forward, depth), v_add(v_scale(right, x * half_width * depth), v_scale(down, y * half_height * depth))));
    const corners = [corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1)];
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
