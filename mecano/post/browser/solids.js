// The mechanism as solids of three.js: what is built once, and what is moved from frame to frame.
const PLAIN = {
  rod: 0x3b7fb5, cable: 0x3b7fb5, spring: 0xd55e00, body: 0x8a94a0, wheel: 0x30343a, hub: 0xb9c0c8, guide: 0x009e73, gear: 0x009e73, mass: 0x8a94a0,
  joint: 0xe0a030, support: 0x7a7f85, ground: 0xc9bda6, arrow: 0xcc3355, axis: 0xcc79a7,
};
const RADIUS = { rod: 0.018, cable: 0.006, guide: 0.006, gear: 0.006 }; // over the size of the mechanism
const BODY_RADIUS = 0.03, MASS_RADIUS = 0.035, JOINT_RADIUS = 0.018, ARROW = 0.5, AXIS = 0.2;
const BEYOND = 6; // sizes of the mechanism by which lines of no ground extend beyond its path
const MANY = 80; // lines and joints: of more, all are thinner
const TYRE = { width: 0.17, depth: 0.32, around: 12 }; // over the radius of the wheel
const MAP = [[72, 92, 214], [143, 70, 190], [206, 75, 120], [243, 135, 66], [250, 222, 70]]; // plasma, its dark end lighter
const Y = new THREE.Vector3(0, 1, 0), A = new THREE.Vector3(), B = new THREE.Vector3(), C = new THREE.Vector3(), D = new THREE.Vector3();
const M = new THREE.Matrix4(), Q = new THREE.Quaternion(), SHADE = new THREE.Color();
const paint = (colour, more) => new THREE.MeshLambertMaterial({ color: colour, ...more });

// The colour of u in 0...1.
function mapped(u) {
  const at = Math.min(Math.max(u, 0), 1) * (MAP.length - 1), i = Math.min(Math.floor(at), MAP.length - 2);
  const [r, g, b] = MAP[i].map((c, k) => Math.round(c + (at - i) * (MAP[i + 1][k] - c)));
  return SHADE.setStyle(`rgb(${r},${g},${b})`);
}

// Matrix that puts a solid of height and radius one, along y, between two points.
function between(a, b, radius) {
  D.subVectors(b, a);
  const length = D.length();
  Q.setFromUnitVectors(Y, length > 0 ? D.multiplyScalar(1 / length) : Y);
  return M.compose(C.addVectors(a, b).multiplyScalar(0.5), Q, D.set(radius, Math.max(length, 1e-9), radius));
}

class Solids {
  constructor(motion, data) {
    this.motion = motion;
    this.up = new THREE.Vector3(...data.up);
    this.group = new THREE.Group();
    this.quantity = null;
    this.moving = []; // functions of the frame
    const of = (...styles) => motion.shapes.filter(shape => styles.includes(shape.style));
    this.thin = Math.min(1, Math.sqrt(MANY / Math.max(1, of("rod", "cable", "joint").length)));
    this.addLines(of("rod", "cable", "guide", "gear"));
    of("spring").forEach(shape => this.addSpring(shape));
    of("body").forEach(shape => this.addBody(shape));
    of("wheel").forEach(shape => this.addWheel(shape));
    this.addDots(of("mass"), new THREE.SphereGeometry(MASS_RADIUS, 32, 20), PLAIN.mass);
    this.addDots(of("joint").filter(shape => !shape.axis), new THREE.SphereGeometry(JOINT_RADIUS * this.thin, 14, 10), PLAIN.joint);
    this.addAxes(of("joint").filter(shape => shape.axis));
    this.addSupports(of("support"));
    motion.grounds.forEach(ground => this.addGround(ground));
    if (!motion.grounds.length && (data.follow || !of("support", "guide").length)) this.addGrid(data.eye);
    this.addArrows();
  }

  add(mesh, shapeOf) {
    mesh.frustumCulled = false;
    mesh.userData.shapeOf = shapeOf; // number of the instance -> shape, for names
    this.group.add(mesh);
    return mesh;
  }

  addLines(shapes) {
    const pieces = shapes.flatMap(shape => Array.from({ length: shape.count - 1 }, (_, i) => [shape, i]));
    if (!pieces.length) return;
    const mesh = new THREE.InstancedMesh(new THREE.CylinderGeometry(1, 1, 1, 10), paint(0xffffff), pieces.length);
    this.add(mesh, i => pieces[i][0]);
    this.moving.push(frame => {
      pieces.forEach(([shape, i], n) => {
        const radius = RADIUS[shape.style] * this.thin * this.motion.there(shape, frame);
        mesh.setMatrixAt(n, between(this.motion.point(shape, i, frame, A), this.motion.point(shape, i + 1, frame, B), radius));
        mesh.setColorAt(n, this.colour(shape, i, frame));
      });
      mesh.instanceMatrix.needsUpdate = mesh.instanceColor.needsUpdate = true;
      mesh.boundingSphere = null;
    });
  }

  // Of piece i of a line: by the chosen quantity, or its own.
  colour(shape, i, frame) {
    const chosen = this.quantity, values = chosen && shape.colours[chosen.name];
    if (!chosen) return SHADE.setHex(PLAIN[shape.style]);
    if (!values) return SHADE.setHex(0x9a9a9a);
    const m = values.length / this.motion.count, piece = Math.min(Math.floor((i * m) / (shape.count - 1)), m - 1);
    return mapped((values[m * frame + piece] - chosen.low) / (chosen.high - chosen.low || 1));
  }

  addSpring(shape) {
    const mesh = this.add(new THREE.Mesh(helix(), paint(PLAIN.spring)), () => shape);
    const core = this.add(new THREE.Mesh(new THREE.CylinderGeometry(1, 1, 1, 12), paint(0x9aa2ab)), () => shape);
    mesh.matrixAutoUpdate = core.matrixAutoUpdate = false;
    this.moving.push(frame => {
      const a = this.motion.point(shape, 0, frame, A), b = this.motion.point(shape, 1, frame, B);
      mesh.visible = core.visible = this.motion.there(shape, frame);
      const radius = Math.min(0.045, Math.max(0.25 * a.distanceTo(b), 0.012)) * this.thin;
      mesh.matrix.copy(between(a, b, radius));
      core.matrix.copy(between(a, b, 0.35 * radius));
      const values = this.quantity && shape.colours[this.quantity.name];
      mesh.material.color.copy(values ? this.colour(shape, 0, frame) : SHADE.setHex(PLAIN.spring));
    });
  }

  // The rounded hull of the points of a body, which moves with its first one.
  addBody(shape) {
    const round = new THREE.IcosahedronGeometry(BODY_RADIUS * this.thin, 1).getAttribute("position"), hull = [];
    const start = this.motion.point(shape, 0, 0, new THREE.Vector3());
    for (let i = 0; i < shape.count; i++) {
      const place = this.motion.point(shape, i, 0, A).sub(start);
      for (let k = 0; k < round.count; k++) hull.push(new THREE.Vector3().fromBufferAttribute(round, k).add(place));
    }
    const mesh = this.add(new THREE.Mesh(new THREE.ConvexGeometry(hull), paint(PLAIN.body, { transparent: true, opacity: 0.85 })), () => shape);
    this.moving.push(frame => {
      mesh.position.copy(this.motion.point(shape, 0, frame, A));
      mesh.quaternion.copy(quaternion(shape.turn, frame));
    });
  }

  // Tyre as the rim has it, flattened by the ground; hub with spokes that turns.
  addWheel(shape) {
    const n = shape.count - 1, around = TYRE.around, index = [];
    for (let i = 0; i + 1 < n; i++)
      for (let j = 0; j < around; j++) {
        const a = i * around + j, b = i * around + (j + 1) % around;
        index.push(a, b, a + around, b, b + around, a + around);
      }
    const tyre = surfaceOf(3 * n * around, index); // of zeros, until it is shown
    const rubber = this.add(new THREE.Mesh(tyre, paint(PLAIN.wheel, { side: THREE.DoubleSide })), () => shape);
    const radius = shape.radius / this.motion.size, hub = hubOf(radius);
    hub.children.forEach(part => { part.userData.shapeOf = () => shape; });
    this.group.add(hub);
    this.moving.push(frame => {
      const centre = this.motion.point(shape, n, frame, new THREE.Vector3());
      const axis = this.motion.vector(shape.axis, frame, new THREE.Vector3(), false).normalize();
      const places = tyre.getAttribute("position");
      for (let i = 0; i < n; i++) {
        const out = this.motion.point(shape, i, frame, A).sub(centre), length = out.length();
        out.multiplyScalar(1 / (length || 1));
        for (let j = 0; j < around; j++) {
          const angle = (2 * Math.PI * j) / around, bulge = 0.5 * TYRE.depth * radius;
          C.copy(centre).addScaledVector(out, length - bulge * (1 - Math.cos(angle))).addScaledVector(axis, TYRE.width * radius * Math.sin(angle));
          places.setXYZ(i * around + j, C.x, C.y, C.z);
        }
      }
      places.needsUpdate = true;
      tyre.computeVertexNormals();
      tyre.boundingSphere = null;
      hub.position.copy(centre);
      Q.setFromUnitVectors(Y, B.set(shape.axis[0], shape.axis[1], shape.axis[2]).normalize());
      hub.quaternion.copy(quaternion(shape.turn, frame)).multiply(Q);
    });
  }

  addDots(shapes, geometry, colour) {
    if (!shapes.length) return;
    const mesh = this.add(new THREE.InstancedMesh(geometry, paint(colour), shapes.length), i => shapes[i]);
    this.moving.push(frame => {
      shapes.forEach((shape, n) => mesh.setMatrixAt(n, M.identity().setPosition(this.motion.point(shape, 0, frame, A))));
      mesh.instanceMatrix.needsUpdate = true;
      mesh.boundingSphere = null;
    });
  }

  // Joints with an axis: a pin, and a line along the axis that can be shown.
  addAxes(shapes) {
    if (!shapes.length) return;
    const pins = new THREE.InstancedMesh(new THREE.CylinderGeometry(1, 1, 1, 16), paint(PLAIN.joint), shapes.length);
    this.add(pins, i => shapes[i]);
    this.axes = this.add(new THREE.InstancedMesh(new THREE.CylinderGeometry(1, 1, 1, 8), paint(PLAIN.axis), shapes.length), i => shapes[i]);
    this.axes.visible = false;
    this.moving.push(frame => {
      shapes.forEach((shape, n) => {
        const axis = this.motion.vector(shape.axis, frame, new THREE.Vector3(), false).normalize();
        const there = this.motion.there(shape, frame) ? 1 : 0;
        for (const [mesh, half, radius] of [[pins, 1.5 * JOINT_RADIUS, JOINT_RADIUS], [this.axes, AXIS, 0.25 * JOINT_RADIUS]]) {
          const place = this.motion.point(shape, 0, frame, A), length = half * this.thin;
          mesh.setMatrixAt(n, between(B.copy(place).addScaledVector(axis, -length), place.addScaledVector(axis, length), radius * this.thin * there));
        }
      });
      for (const mesh of [pins, this.axes]) { mesh.instanceMatrix.needsUpdate = true; mesh.boundingSphere = null; }
    });
  }

  addSupports(shapes) {
    const cone = new THREE.ConeGeometry(0.035 * this.thin, 0.05 * this.thin, 4).translate(0, -0.025 * this.thin, 0);
    shapes.forEach(shape => {
      const mesh = this.add(new THREE.Mesh(cone, paint(PLAIN.support)), () => shape);
      mesh.quaternion.setFromUnitVectors(Y, this.up);
      this.moving.push(frame => {
        mesh.position.copy(this.motion.point(shape, 0, frame, A));
        mesh.visible = this.motion.there(shape, frame);
      });
    });
  }

  // A strip between two lines, with bars across it that show how fast it passes.
  addGround([sides, bars]) {
    const n = sides.length / 6, index = [], place = (x, i) => (x - this.motion.whole[i % 3]) / this.motion.size;
    for (let k = 0; k + 1 < n; k++) index.push(k, k + 1, n + k, k + 1, n + k + 1, n + k);
    const ground = paint(PLAIN.ground, { side: THREE.DoubleSide, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 });
    this.stand(new THREE.Mesh(surfaceOf(sides.map(place), index), ground));
    const up = this.up.toArray();
    this.stand(linesOf(bars.map((x, i) => place(x, i) + 0.002 * up[i % 3]), 0x8c8373));
  }

  // Lines behind or below a mechanism that travels over no ground, across the axis along which it travels least.
  addGrid(eye) {
    const { motion } = this, low = [0, 0, 0], high = [0, 0, 0], places = [];
    for (let i = 0; i < motion.middle.length; i++) {
      const k = i % 3, x = (motion.middle[i] - motion.whole[k]) / motion.size;
      low[k] = Math.min(low[k], x);
      high[k] = Math.max(high[k], x);
    }
    const [normal, a, b] = [0, 1, 2].sort((i, j) => Math.round(high[i] - low[i] - high[j] + low[j]) || Math.abs(eye[j]) - Math.abs(eye[i]));
    const level = 1.1 * (eye[normal] > 0 ? low[normal] - 1 : high[normal] + 1), step = Math.max(0.5, 0.002 * Math.max(high[a] - low[a], high[b] - low[b]));
    for (const [across, along] of [[a, b], [b, a]])
      for (let x = low[across] - BEYOND; x <= high[across] + BEYOND; x += step)
        for (let y = low[along] - BEYOND; y <= high[along] + BEYOND; y += 4 * step) // not long lines, of which one end is behind the eye
          for (const end of [y, y + 4 * step]) places.push(...[0, 1, 2].map(k => (k === across ? x : k === along ? end : level)));
    this.stand(linesOf(places, 0x9aa0a6));
  }

  // Add what does not move, in inertial coordinates over the size of the mechanism.
  stand(mesh) {
    const { motion } = this;
    mesh.frustumCulled = false;
    this.group.add(mesh);
    this.moving.push(frame => mesh.position.set(...[0, 1, 2].map(k => motion.shift(frame, k) - (motion.middle[3 * frame + k] - motion.whole[k]) / motion.size)));
  }

  // Forces: the longest of all frames has the length ARROW.
  addArrows() {
    const { arrows } = this.motion;
    this.largest = 0;
    for (const { values } of arrows)
      for (let i = 0; i < values.length; i += 3) this.largest = Math.max(this.largest, Math.hypot(values[i], values[i + 1], values[i + 2]));
    this.arrows = new THREE.Group();
    this.arrows.visible = false;
    this.group.add(this.arrows);
    if (!arrows.length || !this.largest) return;
    const red = paint(PLAIN.arrow, { depthTest: false, transparent: true }); // seen through what they are in
    const shafts = new THREE.InstancedMesh(new THREE.CylinderGeometry(1, 1, 1, 10), red, arrows.length);
    const heads = new THREE.InstancedMesh(new THREE.ConeGeometry(1, 1, 14), red, arrows.length);
    for (const mesh of [shafts, heads]) {
      mesh.renderOrder = 1;
      mesh.frustumCulled = false;
      mesh.userData.shapeOf = i => arrows[i];
      this.arrows.add(mesh);
    }
    this.moving.push(frame => {
      arrows.forEach((arrow, n) => {
        const force = this.motion.vector(arrow.values, frame, new THREE.Vector3(), false), size = force.length() / this.largest;
        const shown = size > 1e-3, tip = this.motion.vector(arrow.places, frame, new THREE.Vector3(), true);
        const head = Math.min(0.06, 0.4 * ARROW * size), from = tip.clone();
        tip.addScaledVector(force.normalize(), ARROW * size);
        const neck = tip.clone().addScaledVector(force, -head);
        shafts.setMatrixAt(n, between(from, neck, shown ? 0.009 : 0));
        heads.setMatrixAt(n, between(neck, tip, shown ? 0.35 * head : 0));
      });
      for (const mesh of [shafts, heads]) { mesh.instanceMatrix.needsUpdate = true; mesh.boundingSphere = null; }
    });
  }

  show(frame) {
    this.moving.forEach(move => move(frame));
  }

  dispose() {
    this.group.traverse(part => { part.geometry?.dispose(); part.material?.dispose(); });
  }
}

function surfaceOf(places, index) {
  const surface = new THREE.BufferGeometry();
  surface.setAttribute("position", new THREE.BufferAttribute(new Float32Array(places), 3));
  surface.setIndex(index);
  surface.computeVertexNormals();
  return surface;
}

function linesOf(places, color) {
  const lines = new THREE.BufferGeometry();
  lines.setAttribute("position", new THREE.BufferAttribute(new Float32Array(places), 3));
  return new THREE.LineSegments(lines, new THREE.LineBasicMaterial({ color }));
}

// A coil of radius and height one along y, as thick as it looks right when it is stretched.
function helix() {
  const turns = 7, steps = 20 * turns, around = 6, places = [], index = [];
  for (let i = 0; i <= steps; i++) {
    const u = i / steps, angle = 2 * Math.PI * turns * u;
    for (let j = 0; j < around; j++) {
      const section = (2 * Math.PI * j) / around, radius = 1 + 0.16 * Math.cos(section);
      places.push(radius * Math.cos(angle), -0.42 + 0.84 * u + 0.018 * Math.sin(section), radius * Math.sin(angle));
      const a = i * around + j, b = i * around + (j + 1) % around;
      if (i < steps) index.push(a, a + around, b, b, a + around, b + around);
    }
  }
  return surfaceOf(places, index);
}

// The hub of a wheel of some radius along y: a disc with five spokes on both sides.
function hubOf(radius) {
  const hub = new THREE.Group(), inner = (1 - TYRE.depth) * radius, width = 0.8 * TYRE.width * radius;
  hub.add(new THREE.Mesh(new THREE.CylinderGeometry(inner, inner, width, 32), paint(PLAIN.hub)));
  hub.add(new THREE.Mesh(new THREE.CylinderGeometry(0.22 * radius, 0.22 * radius, 2.2 * width, 20), paint(0x8f969e)));
  for (let i = 0; i < 5; i++) {
    const spoke = new THREE.Mesh(new THREE.CylinderGeometry(0.06 * radius, 0.06 * radius, 1.25 * width, 10), paint(i ? 0x50565d : 0xd55e00));
    spoke.position.set(0.45 * radius * Math.cos(1.2566 * i), 0, 0.45 * radius * Math.sin(1.2566 * i));
    hub.add(spoke);
  }
  return hub;
}
