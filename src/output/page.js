"use strict";
// Adds to a page what it does without: values under the pointer and zoom in charts, a film that can
// be paused, and the table of the series. All data are on the page; nothing is fetched.

function element(tag, properties, ...children) {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children);
  return made;
}

// A number with at most six digits.
function short(v) {
  if (v === null || !Number.isFinite(v)) return "–";
  const text = String(Number(v.toPrecision(6)));
  return text.replace("e+", "e").replace(/-/g, "−");
}

// ---- Charts: values under the pointer, zoom -------------------------------------------------

// Round numbers in [low, high], about six of them; on a logarithmic axis powers of ten where there
// are at least two.
function ticks(low, high, log) {
  if (log && Math.floor(Math.log10(high)) > Math.ceil(Math.log10(low))) {
    const [a, b] = [Math.ceil(Math.log10(low)), Math.floor(Math.log10(high))];
    const stride = Math.max(1, Math.ceil((b - a) / 6));
    return Array.from({ length: Math.floor((b - a) / stride) + 1 }, (_, k) => 10 ** (a + k * stride));
  }
  const decade = 10 ** Math.floor(Math.log10((high - low) / 5));
  const step = decade * [1, 2, 5, 10].find((m) => m * decade >= (high - low) / 6);
  const first = Math.ceil(low / step);
  return Array.from({ length: 12 }, (_, k) => (first + k) * step).filter((v) => v <= high);
}

class Chart {
  constructor(svg, number) {
    const data = JSON.parse(svg.dataset.chart);
    Object.assign(this, { svg, data, number, shown: { x: data.x, y: data.y } });
    [this.left, this.right, this.top, this.bottom] = data.frame;
    data.curves.forEach((c, k) => (c.x ??= data.curves[k - 1].x));
    this.groups = [...svg.querySelectorAll("g.curve")].map((g) => [g, g.innerHTML]);
    this.axes = svg.querySelector("g.ticks");
    this.reading = element("div", { className: "reading" });
    this.back = element("button", { type: "button", hidden: true, textContent: "Whole range" });
    this.back.addEventListener("click", () => this.zoom(data.x, data.y));
    svg.after(this.reading, this.back);
    this.over = this.draw("g", { class: "over", "pointer-events": "none" }, svg);
    this.rest();
    this.listen();
  }

  draw(tag, attributes, parent, text = "") {
    const made = document.createElementNS(this.svg.namespaceURI, tag);
    Object.entries(attributes).forEach(([name, value]) => made.setAttribute(name, value));
    made.textContent = text;
    parent.append(made);
    return made;
  }

  // Places in the drawing of values, and the value at a place.
  along(v, axis) {
    const [low, high] = this.shown[axis];
    const f = (w) => (this.data.log[axis === "x" ? 0 : 1] ? Math.log10(w) : w);
    return (f(v) - f(low)) / (f(high) - f(low));
  }
  px(x) { return this.left + this.along(x, "x") * (this.right - this.left); }
  py(y) { return this.bottom + this.along(y, "y") * (this.top - this.bottom); }
  value(px) {
    const [low, high] = this.shown.x;
    const part = Math.min(1, Math.max(0, (px - this.left) / (this.right - this.left)));
    return this.data.log[0] ? low * (high / low) ** part : low + part * (high - low);
  }
  pointer(event) {
    const box = this.svg.getBoundingClientRect();
    return ((event.clientX - box.left) / box.width) * this.svg.viewBox.baseVal.width;
  }

  // The plot between two abscissas in the drawing.
  box(x, to) { return { x, width: to - x, y: this.top, height: this.bottom - this.top }; }

  // The number of the value of a curve that is nearest to an abscissa in the drawing.
  nearest(curve, px) {
    let best = -1, distance = Infinity;
    curve.x.forEach((x, k) => {
      const d = Math.abs(this.px(x) - px);
      if (curve.y[k] !== null && d < distance) [best, distance] = [k, d];
    });
    return distance <= 0.03 * (this.right - this.left) ? best : -1;
  }

  read(px) {
    const found = this.data.curves.map((c) => [c, this.nearest(c, px)]).filter(([, k]) => k >= 0);
    this.over.replaceChildren();
    if (!found.length) return this.rest();
    const [first, k] = found[0];
    this.at = first.x[k];
    const x = this.px(this.at);
    const line = { d: `M${x} ${this.top}V${this.bottom}`, stroke: "currentColor", "stroke-opacity": 0.5 };
    this.draw("path", line, this.over);
    this.reading.replaceChildren(element("span", { textContent: `${this.data.labels[0]} ${short(this.at)}` }));
    for (const [curve, i] of found) {
      const [cx, cy] = [this.px(curve.x[i]), this.py(curve.y[i])];
      if (cy >= this.top - 1 && cy <= this.bottom + 1)
        this.draw("circle", { cx, cy, r: 4, fill: "none", stroke: curve.colour, "stroke-width": 2 }, this.over);
      const value = element("b", { textContent: short(curve.y[i]) });
      const name = this.data.curves.length > 1 ? curve.name : this.data.labels[1];
      const entry = element("span", { className: "of-curve" }, `${name} `, value);
      entry.style.setProperty("--curve", curve.colour);
      this.reading.append(entry);
    }
  }
  rest() {
    this.over.replaceChildren();
    this.at = undefined;
    this.reading.textContent = "Point at the chart for its values; drag along it to zoom.";
  }

  // Shows the abscissas x; without y, the ordinates that lie there.
  zoom(x, y) {
    const values = this.data.curves.flatMap((c) =>
      c.y.filter((v, k) => v !== null && c.x[k] >= x[0] && c.x[k] <= x[1]));
    if (!y && !values.length) return;
    const [low, high] = [Math.min(...values), Math.max(...values)];
    const room = high > low ? 0.05 * (high - low) : 0.05 * Math.abs(high) || 1;
    const log = this.data.log[1];
    this.shown = { x, y: y ?? (log ? [low / 1.1, high * 1.1] : [low - room, high + room]) };
    this.back.hidden = x === this.data.x;
    this.svg.querySelectorAll(".zoomed").forEach((e) => e.remove());
    this.axes.style.display = this.back.hidden ? "" : "none";
    this.groups.forEach(([g, whole]) => (g.innerHTML = whole));
    if (!this.back.hidden) this.redraw();
    this.rest();
  }
  redraw() {
    const axes = this.draw("g", { class: "zoomed" }, this.svg);
    this.axes.after(axes);
    const line = { stroke: "#888888", "stroke-width": 0.6, "stroke-opacity": 0.5 };
    for (const v of ticks(...this.shown.x, this.data.log[0])) {
      const x = this.px(v);
      this.draw("path", { d: `M${x} ${this.top}V${this.bottom + 5}`, ...line }, axes);
      this.draw("text", { x, y: this.bottom + 20, "font-size": 12, "text-anchor": "middle" }, axes, short(v));
    }
    for (const v of ticks(...this.shown.y, this.data.log[1])) {
      const y = this.py(v);
      this.draw("path", { d: `M${this.left - 5} ${y}H${this.right}`, ...line }, axes);
      this.draw("text", { x: this.left - 8, y: y + 4, "font-size": 12, "text-anchor": "end" }, axes, short(v));
    }
    const clip = this.draw("clipPath", { id: `plot-${this.number}`, class: "zoomed" }, this.svg);
    this.draw("rect", this.box(this.left, this.right), clip);
    this.groups.forEach(([g], k) => this.redrawCurve(g, this.data.curves[k]));
  }
  redrawCurve(g, curve) {
    g.replaceChildren();
    const inside = this.draw("g", { "clip-path": `url(#plot-${this.number})` }, g);
    const places = curve.x.map((x, k) => (curve.y[k] === null ? null : [this.px(x), this.py(curve.y[k])]));
    if (!curve.points) {
      const step = (p, k) => (p ? `${places[k - 1] ? "L" : "M"}${p[0]} ${p[1]}` : "");
      const style = { fill: "none", stroke: curve.colour, "stroke-width": 1.8, "stroke-dasharray": curve.dash };
      this.draw("path", { d: places.map(step).join(""), ...style }, inside);
    }
    if (curve.points || places.length < 200)
      places.filter((p) => p).forEach(([cx, cy]) =>
        this.draw("circle", { cx, cy, r: curve.points ? 3.8 : 2, fill: curve.colour }, inside));
  }

  listen() {
    let from = null;
    const { svg } = this;
    svg.tabIndex = 0;
    svg.addEventListener("pointerdown", (e) => {
      if (e.button !== 0) return;
      from = this.pointer(e);
      svg.setPointerCapture?.(e.pointerId);
    });
    svg.addEventListener("pointermove", (e) => {
      const px = this.pointer(e);
      this.read(px);
      if (from === null) return;
      const place = this.box(Math.min(from, px), Math.max(from, px));
      this.draw("rect", { ...place, fill: "currentColor", "fill-opacity": 0.12 }, this.over);
    });
    svg.addEventListener("pointerup", (e) => {
      const px = this.pointer(e);
      const ends = [from ?? px, px].map((p) => this.value(p)).sort((a, b) => a - b);
      const far = from !== null && Math.abs(px - from) > 10;
      from = null;
      far ? this.zoom(ends) : this.read(px);
    });
    svg.addEventListener("pointercancel", () => (from = null));
    svg.addEventListener("pointerleave", () => from === null && this.rest());
    svg.addEventListener("dblclick", () => this.zoom(this.data.x, this.data.y));
    svg.addEventListener("keydown", (e) => this.key(e));
  }
  // Arrows go from value to value, Escape back to the whole.
  key(event) {
    const { x } = this.data.curves[0];
    if (event.key === "Escape") this.zoom(this.data.x, this.data.y);
    const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (!step) return;
    event.preventDefault();
    const next = this.at === undefined ? 0 : x.indexOf(this.at) + step;
    this.read(this.px(x[Math.min(x.length - 1, Math.max(0, next))]));
  }
}

// ---- Film: a GIF whose pictures are shown one by one ----------------------------------------

// The pictures of a GIF, as places in its bytes.
function pictures(bytes) {
  const word = (at) => bytes[at] | (bytes[at + 1] << 8);
  const table = (flags) => (flags & 128 ? 3 * (2 << (flags & 7)) : 0);
  const found = [];
  let at = 13 + table(bytes[10]), delay = 10;
  while (at < bytes.length && bytes[at] !== 0x3b) {
    if (bytes[at] === 0x21) {
      if (bytes[at + 1] === 0xf9) delay = word(at + 4);
      at += 2;
    } else {
      const flags = bytes[at + 9], palette = flags & 128 ? at + 10 : 13;
      const data = at + 10 + table(flags);
      found.push({ x: word(at + 1), y: word(at + 3), width: word(at + 5), height: word(at + 7), palette, data, delay });
      at = data + 1;
    }
    while (bytes[at]) at += bytes[at] + 1;
    at += 1;
  }
  return found;
}

// The entries of the palette of a picture: LZW with codes of growing length.
function unpack(bytes, { data, width, height }) {
  const out = new Uint8Array(width * height), stack = new Uint8Array(4096);
  const prefix = new Uint16Array(4096), suffix = new Uint8Array(4096);
  const least = bytes[data], clear = 1 << least;
  let at = data + 1, left = bytes[at], bits = 0, held = 0;
  let size = least + 1, next = clear + 2, before = -1, first = 0, written = 0;
  for (let k = 0; k < clear; k++) suffix[k] = k;
  while (written < out.length) {
    while (held < size) {
      if (left === 0) left = bytes[++at];
      if (!left) return out;
      bits |= bytes[++at] << held;
      held += 8;
      left -= 1;
    }
    const code = bits & ((1 << size) - 1);
    bits >>= size;
    held -= size;
    if (code === clear) {
      [size, next, before] = [least + 1, clear + 2, -1];
      continue;
    }
    if (code === clear + 1) return out;
    let depth = 0, walk = code;
    if (code >= next) [stack[depth++], walk] = [first, before];
    while (walk >= clear) [stack[depth++], walk] = [suffix[walk], prefix[walk]];
    first = suffix[walk];
    out[written++] = first;
    while (depth) out[written++] = stack[--depth];
    if (before >= 0 && next < 4096) {
      [prefix[next], suffix[next]] = [before, first];
      next += 1;
      if (next === 1 << size && size < 12) size += 1;
    }
    before = code;
  }
  return out;
}

function player(img) {
  const bytes = Uint8Array.from(atob(img.src.split(",")[1]), (c) => c.charCodeAt(0));
  const frames = pictures(bytes);
  if (frames.length < 2) return;
  const size = { width: bytes[6] | (bytes[7] << 8), height: bytes[8] | (bytes[9] << 8) };
  const canvas = element("canvas", size), context = canvas.getContext("2d");
  canvas.setAttribute("role", "img");
  canvas.setAttribute("aria-label", img.alt);
  const button = (textContent, title, act) => {
    const made = element("button", { type: "button", textContent, title });
    made.addEventListener("click", act);
    return made;
  };
  let shown = 0, timer = null;
  const show = (k) => {
    shown = (k + frames.length) % frames.length;
    const frame = frames[shown], entries = unpack(bytes, frame);
    const image = context.createImageData(frame.width, frame.height);
    entries.forEach((entry, i) => {
      const from = frame.palette + 3 * entry;
      image.data.set([bytes[from], bytes[from + 1], bytes[from + 2], 255], 4 * i);
    });
    context.putImageData(image, frame.x, frame.y);
    slider.value = shown;
    place.textContent = `${shown + 1} of ${frames.length}`;
  };
  const play = () => {
    timer = setTimeout(() => { show(shown + 1); play(); }, 10 * frames[shown].delay);
    toggle.textContent = "Pause";
  };
  const pause = () => {
    timer = clearTimeout(timer) ?? null;
    toggle.textContent = "Play";
  };
  const step = (by) => { pause(); show(shown + by); };
  const toggle = button("Play", "Play or pause", () => (timer === null ? play() : pause()));
  const slider = element("input", { type: "range", min: 0, max: frames.length - 1, value: 0 });
  slider.setAttribute("aria-label", "Picture of the film");
  slider.addEventListener("input", () => { pause(); show(Number(slider.value)); });
  const place = element("output", {});
  const steps = [button("‹", "One picture back", () => step(-1)), button("›", "One picture on", () => step(1))];
  img.hidden = true;
  img.after(canvas, element("div", { className: "player" }, toggle, ...steps, slider, place));
  show(0);
  if (!matchMedia("(prefers-reduced-motion: reduce)").matches) play();
}

// ---- The table of the series ----------------------------------------------------------------

function sheet(details) {
  const { columns, rows } = JSON.parse(details.querySelector("script").textContent);
  const cell = (tag) => (text) => element(tag, { className: "number", textContent: text });
  const row = (values) => element("tr", {}, ...values.map(short).map(cell("td")));
  const head = element("thead", {}, element("tr", {}, ...columns.map(cell("th"))));
  const table = element("table", {}, head, element("tbody", {}, ...rows.map(row)));
  details.append(element("div", { className: "scroll rows" }, table));
}

document.querySelectorAll("svg[data-chart]").forEach((svg, k) => new Chart(svg, k));
document.querySelectorAll("figure img[src^='data:image/gif']").forEach(player);
document.querySelectorAll("details.sheet").forEach((details) =>
  details.addEventListener("toggle", () => sheet(details), { once: true }));
