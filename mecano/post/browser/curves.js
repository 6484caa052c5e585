// Plots over the time, drawn by uPlot; a line shows the instant that the mechanism is at.
const INKS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8a79c8", "#a5725a"];
const ROUNDING = 1e-9; // of the largest value of a panel: smaller ones are rounding errors, shown as 0

class Curves {
  constructor(place, data, motion, seek) {
    Object.assign(this, { place, data, motion, seek });
    this.frame = 0;
    this.draw();
    new ResizeObserver(() => this.plots.forEach(({ box, plot }) => plot.setSize(this.sizeOf(box, plot)))).observe(place);
  }

  exchange(data, motion) {
    Object.assign(this, { data, motion });
    this.draw();
  }

  draw() {
    this.place.replaceChildren();
    this.plots = this.data.plots.map(panel => this.plotOf(panel));
    this.show(this.frame);
  }

  sizeOf(box, plot) {
    const legend = plot ? plot.root.querySelector(".u-legend").offsetHeight : 26 + 8 * (box.childCount || 0);
    box.style.minHeight = `${Math.max(170, legend + 26 + 90)}px`; // a legend of many lines makes its panel higher
    return { width: Math.max(box.clientWidth, 120), height: Math.max(box.clientHeight - legend - 26, 90) };
  }

  plotOf(panel) {
    const box = element("div"), values = panel.curves.map(([, text]) => floats(text));
    box.className = "plot";
    this.place.append(box);
    let largest = 0;
    for (const one of values) for (const v of one) if (Number.isFinite(v)) largest = Math.max(largest, Math.abs(v));
    const [factor, unit] = unitOf(largest, panel.unit), label = element("div", panel.label + (unit ? ` [${unit}]` : ""));
    label.className = "label";
    box.append(label);
    const columns = values.map(one => Array.from(one, v => (Number.isFinite(v) ? v / factor : null)));
    const axis = { stroke: styled("--faint"), grid: { stroke: styled("--line"), width: 1 }, ticks: { stroke: styled("--line"), width: 1 }, font: "12px system-ui", values: (_, places) => places.map(atAxis) };
    const [named, of] = this.data.axis;
    const options = {
      ...this.sizeOf(box), padding: [6, 10, 0, 0], cursor: { y: false, drag: { x: false, y: false } }, legend: { live: true },
      scales: { x: { time: false }, y: { range: (_, low, high) => spread(low, high) } },
      axes: [{ ...axis, size: 26 }, { ...axis, size: 58, space: 16 }], // low panels, too, have two numbers
      series: [{ label: named, value: (_, v) => (v === null ? "" : `${number(v)} ${of}`) }, ...panel.curves.map(([name, , reference], i) => ({
        label: name, stroke: INKS[i % INKS.length] + (reference ? "66" : ""), width: reference ? 4 : 1.5, points: { show: false }, pxAlign: 0,
        value: (_, v) => (v === null ? "" : number(Math.abs(v) * factor < ROUNDING * largest ? 0 : v)),
      }))],
      hooks: { draw: [plot => this.mark(plot)], ready: [plot => this.point(plot)] },
    };
    const plot = new uPlot(options, [Array.from(this.motion.times), ...columns], box);
    plot.over.addEventListener("pointerdown", e => this.seekAt(plot, e));
    plot.over.addEventListener("pointermove", e => { if (e.buttons) this.seekAt(plot, e); });
    plot.over.addEventListener("mouseleave", () => this.show(this.frame));
    plot.setSize(this.sizeOf(box, plot));
    return { box, plot };
  }

  seekAt(plot, event) {
    this.seek(this.motion.frameAt(plot.posToVal(event.clientX - plot.over.getBoundingClientRect().left, "x")));
  }

  // Events and the instant shown, over the curves.
  mark(plot) {
    const { ctx, bbox } = plot, line = (t, colour, width) => {
      const x = plot.valToPos(t, "x", true);
      ctx.strokeStyle = colour;
      ctx.lineWidth = width * (window.devicePixelRatio || 1);
      ctx.beginPath();
      ctx.moveTo(x, bbox.top);
      ctx.lineTo(x, bbox.top + bbox.height);
      ctx.stroke();
    };
    ctx.save();
    for (const event of this.data.events) if (!event.repeated) line(event.time, event.colour + "70", 1);
    line(this.motion.times[this.frame], styled("--ink"), 1.2);
    ctx.restore();
  }

  show(frame) {
    this.frame = Math.min(frame, this.motion.count - 1);
    for (const { plot } of this.plots) {
      plot.redraw(false);
      this.point(plot);
    }
  }

  // Put the cursor, whose values stand in the legend, to the instant.
  point(plot) {
    plot.setCursor({ left: plot.valToPos(this.motion.times[this.frame], "x"), top: 0 });
  }
}

// The number at a place of an axis.
function atAxis(x) {
  const rounded = Number(x.toPrecision(6));
  return rounded && Math.abs(rounded) < 1e-3 ? rounded.toExponential() : rounded.toString();
}

// Ends of an axis for values between two.
function spread(low, high) {
  if (low === null || high === null) return [0, 1];
  const room = high > low ? 0.06 * (high - low) : 0.1 * Math.abs(high) || 1;
  return [low - room, high + room];
}
