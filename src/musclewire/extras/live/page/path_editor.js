/** A path over time: drawn by pointer, or written into a table of points; both are the same points. */

import { el } from "./dom.js";
import { fixed, ticks } from "./format.js";
import { colour } from "./theme.js";

const FEWEST_PX = 4;

/** Return drawn places ordered in time, each time once, with the first at 0 and the last at the duration. Pure. */
export function asPath(points, duration_s) {
  const inside = points.map(([time, target]) => [Math.max(0, Math.min(duration_s, time)), target]).sort((a, b) => a[0] - b[0]);
  const path = [];
  for (const point of inside) {
    if (path.length && point[0] - path.at(-1)[0] < 1e-3) path[path.length - 1] = [path.at(-1)[0], point[1]];
    else path.push(point);
  }
  if (!path.length) return path;
  if (path[0][0] > 0) path.unshift([0, path[0][1]]);
  if (path.at(-1)[0] < duration_s) path.push([duration_s, path.at(-1)[1]]);
  return path;
}

/** Return a path of at most so many points, evenly chosen, ends kept. Pure. */
export function thinnedPath(path, most) {
  if (path.length <= most) return path;
  return Array.from({ length: most }, (_, n) => path[Math.round((n * (path.length - 1)) / (most - 1))]);
}

export class PathEditor {
  constructor(scale, duration) {
    this.scale = scale;
    this.duration = duration;
    this.canvas = el("canvas", {
      class: "drawing", role: "img",
      "aria-label": "Path of the target over time; draw it here with a pointer, or write its points into the table below",
      onpointerdown: (event) => this.begin(event), onpointermove: (event) => this.move(event), onpointerup: () => { this.last = null; this.fill(); },
    });
    this.body = el("tbody");
    const add = el("button", { type: "button", class: "quiet", onclick: () => this.addRow() }, "Add a point");
    const heads = el("tr", {}, el("th", { scope: "col" }, "Time [s]"), el("th", { scope: "col" }, `Target [${scale.unit}]`), el("th", { scope: "col" }, el("span", { class: "unseen" }, "Remove")));
    const points = el("table", { class: "points" }, el("caption", { class: "unseen" }, "Points of the path"), el("thead", {}, heads), this.body);
    this.root = el("div", {}, el("p", { class: "hint" }, "Draw the path from left to right, or write its points."), this.canvas, el("details", {}, el("summary", {}, "Points as a table"), points, add));
    const middle = (scale.lowest + scale.highest) / 2;
    const wide = scale.highest - scale.lowest;
    this.path = [[0, scale.round(middle - 0.3 * wide)], [0.3, scale.round(middle + 0.3 * wide)], [0.6, scale.round(middle)], [1, scale.round(middle - 0.3 * wide)]]
      .map(([share, target]) => [share * duration(), target]);
    this.fill();
    new ResizeObserver(() => this.draw()).observe(this.canvas);
  }

  place(event) {
    const box = this.canvas.getBoundingClientRect();
    const { lowest, highest } = this.scale;
    const share = Math.max(0, Math.min(1, 1 - (event.clientY - box.top) / box.height));
    return [((event.clientX - box.left) / box.width) * this.duration(), lowest + share * (highest - lowest)];
  }

  begin(event) {
    this.canvas.setPointerCapture(event.pointerId);
    this.path = [this.place(event)];
    this.last = event.clientX;
    this.draw();
  }

  /** A path goes on in time: what is drawn backwards takes away what it passes. */
  move(event) {
    if (this.last === null || this.last === undefined || Math.abs(event.clientX - this.last) < FEWEST_PX) return;
    const point = this.place(event);
    this.path = [...this.path.filter(([time]) => time < point[0]), point];
    this.last = event.clientX;
    this.draw();
  }

  durationChanged() {
    const before = this.path.at(-1)?.[0] || 1;
    this.path = this.path.map(([time, target]) => [(time / before) * this.duration(), target]);
    this.fill();
  }

  /** Write the path into the table, thinned to what a person reads. */
  fill() {
    this.path = asPath(this.path, this.duration());
    const readable = thinnedPath(this.path, 24);
    this.body.replaceChildren(...readable.map(([time, target]) => this.row(Number(time.toFixed(2)), this.scale.round(target))));
    this.draw();
  }

  row(time, target) {
    const input = (value, label) => el("input", { type: "number", step: "any", value, "aria-label": label, onchange: () => this.read() });
    const row = el("tr", {}, el("td", {}, input(time, "Time in seconds")), el("td", {}, input(target, `Target in ${this.scale.unit}`)));
    row.append(el("td", {}, el("button", { type: "button", class: "small", "aria-label": `Remove the point at ${time} s`, onclick: () => { row.remove(); this.read(); } }, "\u2715")));
    return row;
  }

  addRow() {
    const last = this.path.at(-1) ?? [0, this.scale.lowest];
    this.body.append(this.row(Number(last[0].toFixed(2)), this.scale.round(last[1])));
    this.body.lastElementChild.querySelector("input").focus();
  }

  read() {
    const rows = [...this.body.rows].map((row) => [...row.querySelectorAll("input")].map((input) => Number(input.value)));
    this.path = asPath(rows.filter(([time, target]) => Number.isFinite(time) && Number.isFinite(target)), this.duration());
    this.draw();
  }

  /** Return the points [time s, target]. Throws a sentence if there are too few. */
  points() {
    const path = asPath(this.path, this.duration());
    if (path.length < 2) throw new Error("Draw a path first, or write at least two points.");
    return thinnedPath(path, 2000);
  }

  draw() {
    const { canvas, scale } = this;
    const ratio = devicePixelRatio || 1;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    if (!width) return;
    canvas.width = width * ratio;
    canvas.height = height * ratio;
    const ctx = canvas.getContext("2d");
    ctx.scale(ratio, ratio);
    const x = (time) => (time / this.duration()) * width;
    const y = (target) => height * (1 - (target - scale.lowest) / (scale.highest - scale.lowest || 1));
    ctx.font = '11px "Inter", system-ui, sans-serif';
    ctx.strokeStyle = colour("grid");
    ctx.fillStyle = colour("quiet-text");
    for (const target of ticks(scale.lowest, scale.highest, 5)) {
      ctx.fillRect(0, y(target), 5, 1);
      ctx.fillText(`${fixed(target, scale.digits > 2 ? 2 : 1)} ${scale.unit}`, 8, y(target) + 4);
    }
    for (const time of ticks(0, this.duration(), 6).slice(1)) ctx.fillText(`${time} s`, x(time) - 24, height - 5);
    ctx.beginPath();
    this.path.forEach(([time, target], n) => (n ? ctx.lineTo(x(time), y(target)) : ctx.moveTo(x(time), y(target))));
    ctx.strokeStyle = colour("target");
    ctx.lineWidth = 2.5;
    ctx.lineJoin = "round";
    ctx.stroke();
  }
}
