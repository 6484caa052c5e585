// The page: time, keys, choices, names, events, the film, and results that still grow.
const SPEEDS = [0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100];
const MAGNIFICATIONS = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000];
const LONGEST = 100; // [ms] between two pictures: a film skips nothing while the machine is busy or the page hidden
const KEYS = `space: play, pause
\u2190 \u2192: one frame (with shift: ten)    home, end: first, last
n, p: next, previous event
f: fit the view    1, 2, 3: from the front, the side, above
+, -: magnify deformation    a: forces    x: axes    c: colour    l: follow
m: record a film    ?: these keys
drag: rotate    right drag: move    wheel: zoom    hover: names`;

const player = { frame: 0, playing: false, clock: 0, last: null };
let motion, solids, stage, curves, dirty = true;

function load(fresh) {
  const ended = motion && player.frame >= motion.count - 1;
  Object.assign(data, fresh);
  motion = new Motion(data);
  motion.follow = stage && stage.solids ? byId("follow").checked : data.follow;
  motion.magnification = Number(byId("magnify").value || 1);
  solids = new Solids(motion, data);
  stage.put(solids, data);
  byId("slider").max = motion.count - 1;
  labels();
  showEvents();
  if (curves) curves.exchange(data, motion); else curves = new Curves(byId("plots"), data, motion, frame => { play(false); show(frame); });
  choose();
  show(ended ? motion.count - 1 : Math.min(player.frame, motion.count - 1));
}

function labels() {
  document.title = byId("title").textContent = data.title;
  byId("status").textContent = data.status;
  byId("status").className = data.sound ? "" : "bad";
  const still = motion.count < 2;
  for (const id of ["slider", "play", "film"]) byId(id).hidden = still;
  byId("speed").parentElement.hidden = byId("follow").parentElement.hidden = still;
  byId("magnify").parentElement.hidden = still || !motion.shapes.some(shape => shape.rest);
  byId("forces").parentElement.hidden = !solids.largest;
  byId("axes").parentElement.hidden = !solids.axes;
  const chosen = byId("colour").value;
  byId("colour").replaceChildren(...["none", ...data.quantities.map(q => q[0])].map(name => new Option(name, name)));
  byId("colour").value = data.quantities.some(q => q[0] === chosen) ? chosen : "none";
  byId("colour").parentElement.hidden = !data.quantities.length;
}

// Events as ticks over the slider, each name with a colour of its own; ticks of frequent ones are short, and not in the curves.
const MOST_MARKS = 12;
function showEvents() {
  const names = [...new Set(data.events.map(event => event.name))], span = motion.times[motion.count - 1] - motion.times[0];
  const counts = new Map(), keyOf = event => `${event.element}: ${event.name}`;
  for (const event of data.events) counts.set(keyOf(event), (counts.get(keyOf(event)) || 0) + 1);
  for (const event of data.events) {
    event.colour = INKS[names.indexOf(event.name) % INKS.length];
    event.repeated = counts.get(keyOf(event)) > MOST_MARKS;
  }
  byId("ticks").replaceChildren(...data.events.map(event => {
    const tick = element("i");
    tick.style.left = `${span ? (100 * (event.time - motion.times[0])) / span : 0}%`;
    tick.style.background = event.colour;
    tick.className = event.repeated ? "repeated" : "";
    tick.title = `${number(event.time)} ${data.axis[1]}: ${event.element}: ${event.name}`;
    tick.addEventListener("click", () => { play(false); show(motion.frameAt(event.time)); });
    return tick;
  }));
  byId("legend").replaceChildren(...names.map(name => {
    const of = data.events.filter(event => event.name === name), entry = element("button"), swatch = element("i");
    swatch.style.background = of[0].colour;
    entry.append(swatch, of.length > 1 ? `${name} (${of.length})` : name);
    entry.title = of.slice(0, 12).map(event => `${number(event.time)} ${data.axis[1]}: ${event.element}`).join("\n");
    entry.addEventListener("click", () => jump(1, name));
    return entry;
  }));
  byId("ticks").hidden = !names.length;
}

// To the next event, or the previous one, of a name or any; round at the end.
function jump(direction, name) {
  const now = motion.times[player.frame], frames = data.events.filter(event => !name || event.name === name).map(event => motion.frameAt(event.time));
  const ahead = frames.filter(frame => (frame - player.frame) * direction > 0);
  if (!frames.length || !Number.isFinite(now)) return;
  play(false);
  show(ahead.length ? (direction > 0 ? Math.min(...ahead) : Math.max(...ahead)) : direction > 0 ? Math.min(...frames) : Math.max(...frames));
}

function show(frame) {
  player.frame = Math.min(Math.max(frame, 0), motion.count - 1);
  byId("slider").value = player.frame;
  byId("time").textContent = motion.count > 1 ? `${data.axis[0]} ${motion.times[player.frame].toFixed(motion.digits)} ${data.axis[1]}` : "";
  solids.show(player.frame);
  if (curves) curves.show(player.frame);
  dirty = true;
}

// What the choices below the view ask for.
function choose() {
  const found = data.quantities.find(q => q[0] === byId("colour").value);
  solids.quantity = found ? { name: found[0], low: found[2], high: found[3] } : null;
  motion.magnification = Number(byId("magnify").value || 1);
  solids.arrows.visible = byId("forces").checked;
  if (solids.axes) solids.axes.visible = byId("axes").checked;
  showScale(found);
  solids.show(player.frame);
  dirty = true;
}

function showScale(found) {
  const place = byId("scale"), lines = [];
  if (found) {
    const [factor, unit] = unitOf(Math.max(Math.abs(found[2]), Math.abs(found[3])), found[1]), bar = element("div"), ends = element("div");
    bar.className = "bar";
    bar.style.background = `linear-gradient(90deg, ${MAP.map(colour => `rgb(${colour})`)})`;
    ends.className = "ends";
    ends.append(element("span", number(found[2] / factor)), element("span", number(found[3] / factor)));
    lines.push(element("div", found[0] + (unit ? ` [${unit}]` : "")), bar, ends);
  }
  if (byId("forces").checked && solids.largest) {
    const [factor, unit] = unitOf(solids.largest, "N");
    lines.push(element("div", `longest arrow: ${number(solids.largest / factor)} ${unit}`));
  }
  if (motion.magnification !== 1) lines.push(element("div", `deformation \u00d7 ${motion.magnification}`));
  place.replaceChildren(...lines);
  place.hidden = !lines.length;
}

function play(on) {
  if (player.playing === on) return;
  player.playing = on && motion.count > 1;
  byId("play").textContent = player.playing ? "Pause" : "Play";
  player.last = null;
  player.clock = player.frame >= motion.count - 1 ? motion.times[0] : motion.times[player.frame];
}

function tick(now) {
  if (player.playing) {
    player.clock += player.last === null ? 0 : (Math.min(now - player.last, LONGEST) / 1000) * byId("speed").value;
    player.last = now;
    if (player.clock > motion.times[motion.count - 1]) {
      if (film.recorder) film.stop();
      player.clock = motion.times[0];
    }
    const next = motion.frameAt(player.clock);
    if (next !== player.frame) show(next);
  }
  if (dirty || stage.fitted()) {
    dirty = false;
    if (stage.width && stage.untouched && stage.aspect !== stage.camera.aspect) { stage.aspect = stage.camera.aspect; stage.home(); }
    stage.render();
    if (film.recorder) film.draw();
  }
  requestAnimationFrame(tick);
}

// The motion from its start to its end, at the chosen speed, as a file of moving pictures.
const film = {
  start() {
    const type = ["video/mp4;codecs=avc1", "video/webm;codecs=vp9", "video/webm"].find(t => window.MediaRecorder && MediaRecorder.isTypeSupported(t));
    if (!type || !stage.canvas) { byId("status").textContent = "this browser cannot record films"; return; }
    this.reel = document.createElement("canvas");
    this.reel.width = 2 * Math.round(stage.canvas.width / 2);
    this.reel.height = 2 * Math.round(stage.canvas.height / 2);
    const pieces = [];
    this.recorder = new MediaRecorder(this.reel.captureStream(30), { mimeType: type, videoBitsPerSecond: 8e6 });
    this.recorder.addEventListener("dataavailable", e => pieces.push(e.data));
    this.recorder.addEventListener("stop", () => {
      const link = document.createElement("a");
      link.href = URL.createObjectURL(new Blob(pieces, { type }));
      link.download = `${data.title.replace(/[^\w-]+/g, "_")}.${type.includes("mp4") ? "mp4" : "webm"}`;
      link.click();
      setTimeout(() => URL.revokeObjectURL(link.href), 10000);
      this.saved = pieces.reduce((sum, piece) => sum + piece.size, 0);
    });
    play(false);
    show(0);
    this.recorder.start();
    byId("film").textContent = "Stop";
    play(true);
  },
  draw() {
    const context = this.reel.getContext("2d"), { width, height } = this.reel;
    context.drawImage(stage.canvas, 0, 0, width, height);
    context.font = `${Math.round(height / 28)}px system-ui`;
    context.fillStyle = styled("--ink");
    context.fillText(`${data.title}   ${byId("time").textContent}`, height / 40, height / 20);
  },
  stop() {
    const { recorder } = this;
    this.recorder = null;
    byId("film").textContent = "Film";
    play(false);
    recorder.stop();
  },
};

function hover(event) {
  const label = byId("name"), shape = event.buttons ? null : stage.shapeAt(event.clientX, event.clientY);
  label.hidden = !shape;
  if (!shape) return;
  const box = byId("view").getBoundingClientRect(), values = [];
  for (const [name, unit] of data.quantities) {
    const of = shape.colours && shape.colours[name];
    if (!of) continue;
    const m = of.length / motion.count, now = of.slice(m * player.frame, m * (player.frame + 1));
    const largest = now.reduce((a, b) => (Math.abs(b) > Math.abs(a) ? b : a), 0), [factor, shown] = unitOf(Math.abs(largest), unit);
    values.push(`\n${name} ${number(largest / factor)} ${shown}`);
  }
  if (shape.values) {
    const [x, y, z] = shape.values.slice(3 * player.frame), size = Math.hypot(x, y, z), [factor, unit] = unitOf(size, "N");
    values.push(`\n${number(size / factor)} ${unit}`);
  }
  label.textContent = `${shape.kind} ${shape.name}`.trim() + values.join("");
  label.style.left = `${Math.min(event.clientX - box.left + 12, box.width - label.offsetWidth - 4)}px`;
  label.style.top = `${Math.min(event.clientY - box.top + 14, box.height - label.offsetHeight - 4)}px`;
}

function step(select, by) {
  const { options } = select;
  select.selectedIndex = Math.min(Math.max(select.selectedIndex + by, 0), options.length - 1);
  choose();
}

function toggle(id) {
  byId(id).checked = !byId(id).checked;
  if (id === "follow") { motion.follow = byId("follow").checked; stage.home(); }
  choose();
}

// Directions of the views 1, 2, 3: horizontal axes, and the vertical one.
function direction(i) {
  const up = stage.up.toArray().findIndex(x => x), [first, second] = [0, 1, 2].filter(k => k !== up);
  const found = [0, 0, 0];
  found[[first, second, up][i]] = i === 1 ? -1 : i === 2 ? stage.up.toArray()[up] : 1;
  return new THREE.Vector3(...found);
}

const ON_KEY = {
  " ": () => play(!player.playing), Home: () => show(0), End: () => show(motion.count - 1),
  ArrowRight: e => show(player.frame + (e.shiftKey ? 10 : 1)), ArrowLeft: e => show(player.frame - (e.shiftKey ? 10 : 1)),
  n: () => jump(1), p: () => jump(-1), f: () => stage.home(), 1: () => stage.home(direction(0)), 2: () => stage.home(direction(1)),
  3: () => stage.home(direction(2)), "+": () => step(byId("magnify"), 1), "-": () => step(byId("magnify"), -1), a: () => toggle("forces"),
  x: () => toggle("axes"), c: () => { byId("colour").selectedIndex = (byId("colour").selectedIndex + 1) % byId("colour").options.length; choose(); },
  l: () => toggle("follow"), m: () => byId("film").click(), "?": () => { byId("help").hidden = !byId("help").hidden; },
};
const STOPS = ["Home", "End", "ArrowRight", "ArrowLeft"];

function listen() {
  byId("slider").addEventListener("input", e => { play(false); show(Number(e.target.value)); });
  byId("play").addEventListener("click", () => play(!player.playing));
  byId("film").addEventListener("click", () => (film.recorder ? film.stop() : film.start()));
  byId("fit").addEventListener("click", () => stage.home());
  byId("keys").addEventListener("click", () => ON_KEY["?"]());
  for (const id of ["colour", "magnify", "forces", "axes"]) byId(id).addEventListener("change", choose);
  byId("follow").addEventListener("change", () => { motion.follow = byId("follow").checked; stage.home(); choose(); });
  byId("view").addEventListener("pointermove", hover);
  byId("view").addEventListener("pointerleave", () => { byId("name").hidden = true; });
  byId("scene").addEventListener("dblclick", () => stage.home());
  document.addEventListener("keydown", e => {
    if (e.target.tagName === "SELECT" || e.ctrlKey || e.metaKey || e.altKey || !ON_KEY[e.key]) return;
    if (e.key === " " && e.target.matches?.("button:focus-visible, [type=checkbox]:focus-visible")) return;
    if (STOPS.includes(e.key)) play(false);
    ON_KEY[e.key](e);
    e.preventDefault();
  });
  window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { curves.draw(); dirty = true; });
}

// Ask for results that have come since; until the run has ended.
async function poll() {
  try {
    const answer = await fetch(`${data.live}&key=${encodeURIComponent(data.key)}`);
    if (answer.status === 200) load(await answer.json());
    if (data.growing) setTimeout(poll, 500);
  } catch {
    byId("status").textContent = "the program that serves this page has ended";
  }
}

// Where there are no 3D graphics, the curves and events remain.
const NO_STAGE = { put(solids) { this.solids = solids; }, home() {}, render() {}, fitted: () => false, shapeAt: () => null, up: new THREE.Vector3(0, 0, 1) };

function start() {
  byId("help").textContent = KEYS;
  for (const m of MAGNIFICATIONS) byId("magnify").add(new Option(`\u00d7${m}`, m));
  for (const s of SPEEDS) byId("speed").add(new Option(`\u00d7${s}`, s));
  try {
    stage = new Stage(byId("scene"));
  } catch {
    stage = NO_STAGE;
    document.body.className = "flat";
    byId("missing").textContent = "no view in space: this browser has no 3D graphics (WebGL)";
  }
  stage.changed = () => { dirty = true; };
  byId("follow").checked = data.follow;
  load(data);
  const natural = (motion.times[motion.count - 1] - motion.times[0]) / 10; // about ten seconds
  byId("speed").value = SPEEDS.reduce((a, b) => (Math.abs(Math.log(b / natural)) < Math.abs(Math.log(a / natural)) ? b : a));
  const members = motion.shapes.find(shape => ["rod", "cable"].includes(shape.style) && Object.keys(shape.colours).length);
  if (members) { byId("colour").value = Object.keys(members.colours)[0]; choose(); }
  if (motion.count < 2) { byId("axes").checked = true; choose(); }
  listen();
  const asked = new URLSearchParams(location.hash.slice(1)).get("t"); // page.html#t=1.5
  show(asked === null ? 0 : motion.frameAt(Number(asked)));
  if (data.live && data.growing) poll();
  requestAnimationFrame(tick);
}
start();
