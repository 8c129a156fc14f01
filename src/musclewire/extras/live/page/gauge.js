/** The wire itself, drawn: its moving end over a scale, the target above, its colour by the estimated temperature. */

import { svg } from "./dom.js";
import { fixed, QUANTITIES, tickDigits, ticks } from "./format.js";

const HEIGHT = 86;
const EDGE = 44;

/** Return the colour of a wire between cold, grey as metal, and its limit. */
function heatColour(temperature, limit) {
  const share = Math.max(0, Math.min(1, (temperature - 22) / Math.max(20, (limit ?? 150) - 22)));
  return `color-mix(in oklab, var(--heating) ${Math.round(100 * share)}%, var(--line-strong))`;
}

export class Gauge {
  constructor(root) {
    this.root = root;
    this.parts = {
      scale: svg("g"),
      wire: svg("path", { class: "wire-line", fill: "none" }),
      spring: svg("path", { class: "spring" }),
      block: svg("rect", { class: "block", width: 12, height: 26, y: 32, rx: 2 }),
      instrument: svg("line", { class: "instrument-mark", y1: 29, y2: 61 }),
      target: svg("path", { class: "target-mark", d: "M-8 6h16l-8 13z" }),
      anchors: svg("g", {}, svg("rect", { class: "anchor", x: 0, y: 28, width: 7, height: 34, rx: 2 })),
    };
    this.far = svg("rect", { class: "anchor", y: 28, width: 7, height: 34, rx: 2 });
    this.parts.anchors.append(this.far);
    root.append(...Object.values(this.parts));
    this.setScale("strain", 0, 0.05, null);
    new ResizeObserver(() => this.layOut()).observe(root);
  }

  /** Set the scale in SI, and the range of the model on it. */
  setScale(quantity, lowest, highest, range) {
    const key = [quantity, lowest, highest, range].join();
    if (key === this.key) return;
    this.key = key;
    const { factor } = QUANTITIES[quantity];
    this.quantity = quantity;
    this.low = lowest * factor;
    this.high = highest * factor;
    this.range = range?.map((value) => value * factor) ?? null;
    this.layOut();
  }

  layOut() {
    this.width = this.root.clientWidth || 400;
    this.root.setAttribute("viewBox", `0 0 ${this.width} ${HEIGHT}`);
    this.far.setAttribute("x", this.width - 7);
    const marks = ticks(this.low, this.high, Math.max(3, this.width / 75));
    const digits = tickDigits(marks);
    const children = [];
    if (this.range) {
      const [from, to] = this.range.map((value) => this.x(value));
      children.push(svg("rect", { class: "range", x: from, y: 62, width: Math.max(0, to - from), height: 6, rx: 2 }));
    }
    for (const value of marks) {
      const text = svg("text", { x: this.x(value), y: 83, "text-anchor": "middle" });
      text.textContent = `${fixed(value, digits)}${value === marks.at(-1) ? `\u202f${QUANTITIES[this.quantity].unit}` : ""}`;
      children.push(svg("line", { class: "tick", x1: this.x(value), x2: this.x(value), y1: 62, y2: 70 }), text);
    }
    this.parts.scale.replaceChildren(...children);
    if (this.shown) this.draw(this.shown);
  }

  /** Return the place of a value: a contracted wire is short, and its moving end goes left; larger values lie left. */
  x(value) {
    const share = (value - this.low) / (this.high - this.low || 1);
    const usable = this.width - 2 * EDGE - 70;
    return EDGE + 50 + (1 - Math.max(-0.03, Math.min(1.03, share))) * usable;
  }

  /** Draw {target, estimate, instrument, temperature, limit} in the units shown; null for what is unknown. */
  draw(shown) {
    this.shown = shown;
    const { parts } = this;
    const place = shown.estimate ?? shown.instrument;
    const end = place === null ? this.x(this.low) : this.x(place);
    parts.block.setAttribute("x", end - 6);
    parts.block.style.opacity = place === null ? 0.35 : 1;
    parts.wire.setAttribute("d", `M7 45H${end.toFixed(1)}`);
    parts.wire.style.stroke = shown.temperature === null ? "var(--line-strong)" : heatColour(shown.temperature, shown.limit);
    parts.spring.setAttribute("d", spring(end + 6, this.width - 7));
    mark(parts.target, shown.target, (value) => `translate(${this.x(value).toFixed(1)} 8)`);
    mark(parts.instrument, shown.estimate === null ? null : shown.instrument, (value) => `translate(${this.x(value).toFixed(1)} 0)`);
  }
}

function mark(element, value, transform) {
  element.style.display = value === null ? "none" : "";
  if (value !== null) element.setAttribute("transform", transform(value));
}

function spring(from, to) {
  const turns = 9;
  const straight = 8;
  const step = (to - from - 2 * straight) / turns;
  let path = `M${from.toFixed(1)} 45h${straight}`;
  for (let n = 0; n < turns; n += 1) path += `l${(step / 4).toFixed(2)} -8l${(step / 2).toFixed(2)} 16l${(step / 4).toFixed(2)} -8`;
  return `${path}H${to}`;
}
