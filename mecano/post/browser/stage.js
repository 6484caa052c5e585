// Where the solids stand: light, camera, what the pointer is on.
const HALF_ANGLE = (15 * Math.PI) / 180, ROOM = 1.06, FRAMES_FITTED = 60;

class Stage {
  constructor(canvas) {
    this.canvas = canvas;
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true });
    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(2 * (HALF_ANGLE * 180) / Math.PI, 1, 0.01, 2000);
    this.scene.add(new THREE.HemisphereLight(0xffffff, 0x8d8d95, 1.9));
    this.sun = new THREE.DirectionalLight(0xffffff, 1.7);
    this.scene.add(this.sun, this.sun.target);
    this.controls = new THREE.OrbitControls(this.camera, canvas);
    this.untouched = true;
    this.controls.addEventListener("start", () => { this.untouched = false; });
    this.controls.addEventListener("change", () => this.changed());
    this.changed = () => {};
  }

  // Exchange the mechanism; the view stays where it was, but for the first time.
  put(solids, data) {
    const first = !this.solids;
    if (this.solids) { this.scene.remove(this.solids.group); this.solids.dispose(); }
    this.solids = solids;
    this.scene.add(solids.group);
    this.eye = new THREE.Vector3(...data.eye);
    this.up = solids.up;
    this.camera.up.copy(this.up);
    if (first) this.home();
  }

  // Look from where the model is best seen, or from a direction, at the whole motion.
  home(direction) {
    const back = (direction || this.eye).clone().normalize(), camera = this.camera;
    const right = new THREE.Vector3().crossVectors(this.up, back);
    if (right.lengthSq() < 1e-6) right.set(this.up.y, this.up.z, this.up.x).cross(back);
    right.normalize();
    const above = new THREE.Vector3().crossVectors(back, right), points = this.cloud();
    const tangent = Math.tan(HALF_ANGLE), wide = tangent * camera.aspect;
    const extent = axis => points.reduce(([low, high], p) => { const x = p.dot(axis); return [Math.min(low, x), Math.max(high, x)]; }, [Infinity, -Infinity]);
    const centre = [right, above, back].map(axis => { const [low, high] = extent(axis); return 0.5 * (low + high); });
    const distance = points.reduce((most, p) => Math.max(most, p.dot(back) - centre[2] +
      Math.max(Math.abs(p.dot(right) - centre[0]) / wide, Math.abs(p.dot(above) - centre[1]) / tangent)), 0.1);
    const target = new THREE.Vector3();
    [right, above, back].forEach((axis, i) => target.addScaledVector(axis, centre[i]));
    this.controls.target.copy(target);
    camera.position.copy(target).addScaledVector(back, ROOM * distance);
    this.controls.update();
    this.untouched = !direction;
  }

  // Points of some frames, with the radius of what is drawn there.
  cloud() {
    const motion = this.solids.motion, found = [], step = Math.max(1, Math.floor(motion.count / FRAMES_FITTED));
    const room = motion.shapes.length > 1 || motion.shapes[0].count > 1 ? 0.06 : 0.5; // a single point has no size
    const offsets = [[room, 0, 0], [-room, 0, 0], [0, room, 0], [0, -room, 0], [0, 0, room], [0, 0, -room]].map(o => new THREE.Vector3(...o));
    for (let frame = 0; frame < motion.count; frame += step)
      for (const shape of motion.shapes) {
        if (shape.style === "guide" && motion.follow) continue;
        const last = shape.count - 1, stride = Math.max(1, Math.floor(shape.count / 12));
        for (let i = 0; i <= last; i += stride) found.push(motion.point(shape, i, frame, new THREE.Vector3()));
      }
    return found.flatMap(p => offsets.map(o => p.clone().add(o)));
  }

  // Fit the canvas to its place; true where its size is new.
  fitted() {
    const width = this.canvas.clientWidth, height = this.canvas.clientHeight, ratio = Math.min(window.devicePixelRatio || 1, 2);
    if (!width || !height || (this.width === width && this.height === height && this.ratio === ratio)) return false;
    Object.assign(this, { width, height, ratio });
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    return true;
  }

  render() {
    if (this.fitted() && this.solids && this.untouched) this.home();
    this.scene.background = new THREE.Color(styled("--sky") || "#ffffff");
    this.sun.position.copy(this.camera.position).addScaledVector(this.up || Y, 4);
    this.sun.target.position.copy(this.controls.target);
    this.renderer.render(this.scene, this.camera);
    this.drawCompass(byId("compass").getContext("2d"));
  }

  drawCompass(context) {
    context.clearRect(0, 0, 160, 160);
    context.font = "600 22px system-ui";
    context.lineWidth = 4;
    const inverse = this.camera.quaternion.clone().invert();
    const arms = [["x", "#d55e00"], ["y", "#009e73"], ["z", "#4f8fd0"]].map(([name, colour], i) =>
      ({ name, colour, end: new THREE.Vector3(+(i === 0), +(i === 1), +(i === 2)).applyQuaternion(inverse) }));
    for (const { name, colour, end } of arms.sort((a, b) => a.end.z - b.end.z)) {
      context.strokeStyle = context.fillStyle = colour;
      context.beginPath();
      context.moveTo(80, 80);
      context.lineTo(80 + 48 * end.x, 80 - 48 * end.y);
      context.stroke();
      context.fillText(name, 80 + 62 * end.x - 6, 80 - 62 * end.y + 7);
    }
  }

  // What is seen at a place of the window, or null.
  shapeAt(x, y) {
    const box = this.canvas.getBoundingClientRect(), ray = new THREE.Raycaster();
    ray.setFromCamera(new THREE.Vector2((2 * (x - box.left)) / box.width - 1, 1 - (2 * (y - box.top)) / box.height), this.camera);
    const hit = ray.intersectObject(this.solids.group, true).find(({ object }) => object.userData.shapeOf && visible(object));
    return hit ? hit.object.userData.shapeOf(hit.instanceId) : null;
  }
}

const visible = part => !part || (part.visible && visible(part.parent));
