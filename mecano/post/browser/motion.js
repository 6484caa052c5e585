// The motion as numbers: what mecano/post/animation.py wrote, decoded; lengths are over data.size, about an origin that
// goes along with the mechanism or stays.
const bytes = text => Uint8Array.from(atob(text), c => c.charCodeAt(0)).buffer;
const floats = text => new Float32Array(bytes(text));
const STEPS = 32767.5; // of rounded coordinates in a length of data.size

class Motion {
  constructor(data) {
    this.times = floats(data.times);
    this.count = this.times.length;
    const gap = (this.times[this.count - 1] - this.times[0]) / this.count;
    this.digits = gap > 0 ? Math.min(Math.max(Math.ceil(1 - Math.log10(gap)), 0), 9) : 4; // of times
    this.middle = floats(data.middle);
    this.size = data.size;
    this.follow = data.follow;
    this.followed = data.follow ? data.followed : [true, true, true]; // axes, where the choice is to follow
    this.magnification = 1;
    this.whole = [0, 1, 2].map(k => {
      let low = Infinity, high = -Infinity;
      for (let i = k; i < this.middle.length; i += 3) { low = Math.min(low, this.middle[i]); high = Math.max(high, this.middle[i]); }
      return 0.5 * (low + high);
    });
    this.groups = data.groups.map(group => ({ places: floats(group.places), turns: floats(group.turns) }));
    this.shapes = data.shapes.map((shape, number) => ({
      ...shape, number, rounded: shape.exact ? null : new Uint16Array(bytes(shape.points)), exact: shape.exact ? floats(shape.exact) : null,
      rest: shape.rest ? floats(shape.rest) : null, turn: shape.turn ? floats(shape.turn) : null,
      axis: shape.axis ? floats(shape.axis) : null,
      colours: Object.fromEntries(Object.entries(shape.colours).map(([name, values]) => [name, floats(values)])),
    }));
    this.arrows = data.arrows.map(arrow => ({ ...arrow, places: floats(arrow.places), values: floats(arrow.values) }));
    this.grounds = data.grounds.map(lines => lines.map(floats));
  }

  // Inertial coordinate k of the middle at a frame, from the origin of the view.
  shift(frame, k) {
    return this.follow && this.followed[k] ? 0 : (this.middle[3 * frame + k] - this.whole[k]) / this.size;
  }

  // Point i of a shape at a frame, into the THREE.Vector3 out.
  point(shape, i, frame, out) {
    const at = 3 * (shape.count * frame + i), values = shape.exact || shape.rounded;
    const read = k => (shape.exact ? values[at + k] : values[at + k] / STEPS - 1);
    out.set(read(0), read(1), read(2));
    if (this.magnification !== 1 && shape.rest) this.magnify(shape, i, frame, out);
    return out.set(out.x + this.shift(frame, 0), out.y + this.shift(frame, 1), out.z + this.shift(frame, 2));
  }

  // Whether a shape is there at a frame: a joint or cable that has been released is not.
  there(shape, frame) {
    return !shape.shown || shape.shown[frame];
  }

  // Move a point away from where its body, undeformed, has it.
  magnify(shape, i, frame, out) {
    const group = this.groups[shape.group], rest = shape.rest;
    SPOT.set(rest[3 * i], rest[3 * i + 1], rest[3 * i + 2]).applyQuaternion(quaternion(group.turns, frame));
    SPOT.x += group.places[3 * frame];
    SPOT.y += group.places[3 * frame + 1];
    SPOT.z += group.places[3 * frame + 2];
    out.sub(SPOT).multiplyScalar(this.magnification).add(SPOT);
  }

  // Three numbers of a frame, of places with the shift of the origin.
  vector(values, frame, out, placed) {
    out.set(values[3 * frame], values[3 * frame + 1], values[3 * frame + 2]);
    return placed ? out.set(out.x + this.shift(frame, 0), out.y + this.shift(frame, 1), out.z + this.shift(frame, 2)) : out;
  }

  // The last frame that is not after a time.
  frameAt(t) {
    let low = 0, high = this.count - 1;
    while (low < high) { const m = (low + high + 1) >> 1; if (this.times[m] <= t) low = m; else high = m - 1; }
    return low;
  }
}

const SPOT = new THREE.Vector3(), TURN = new THREE.Quaternion();
const quaternion = (values, frame) =>
  TURN.set(values[4 * frame + 1], values[4 * frame + 2], values[4 * frame + 3], values[4 * frame]);

// Factor and unit in which numbers of a size are shown.
function unitOf(largest, unit) {
  for (const [factor, prefix] of [[1e9, "G"], [1e6, "M"], [1e3, "k"]])
    if (["N", "N m", "Pa", "J", "W"].includes(unit) && largest >= 2 * factor) return [factor, prefix + unit];
  return [1, unit === "-" ? "" : unit];
}
const number = x => Number(x.toPrecision(4)).toString();
const byId = id => document.getElementById(id);
const element = (tag, text) => Object.assign(document.createElement(tag), { textContent: text || "" });
const styled = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
