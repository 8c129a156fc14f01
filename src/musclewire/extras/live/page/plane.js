/** The plane of the sensed quantity over the resistance: branches of the model, recorded loop, trail, present point. */

import { fixed, QUANTITIES, tickDigits, ticks } from "./format.js";
import { COLUMN } from "./rows.js";
import { colour } from "./theme.js";

const EDGE = { left: 46, right: 12, top: 10, bottom: 34 };
const TRAIL_ROWS = 500;

export class Plane {
  constructor(canvas) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
    this.quantity = "strain";
    this.curves = [];
    this.sizes = new ResizeObserver(() => this.resize());
    this.sizes.observe(canvas);
  }

  resize() {
    const scale = devicePixelRatio || 1;
    this.canvas.width = Math.round(this.canvas.clientWidth * scale);
    this.canvas.height = Math.round(this.canvas.clientHeight * scale);
    this.draw();
  }

  /** Set the curves that stand still: [{x, y, colour, width, dash}]. */
  setCurves(quantity, curves) {
    this.quantity = quantity;
    this.curves = curves;
    this.bounds = null;
  }

  /** Draw, with the newest rows of a history if given. */
  draw(history = this.history) {
    this.history = history;
    const { context: ctx, canvas } = this;
    if (!canvas.width || !history) return;
    const scale = devicePixelRatio || 1;
    ctx.setTransform(scale, 0, 0, scale, 0, 0);
    const size = { width: canvas.width / scale, height: canvas.height / scale };
    ctx.clearRect(0, 0, size.width, size.height);
    const trail = this.trail(history);
    this.fit(trail);
    const place = this.placing(size);
    this.drawAxes(ctx, place, size);
    ctx.save();
    ctx.beginPath();
    ctx.rect(EDGE.left, EDGE.top, size.width - EDGE.left - EDGE.right, size.height - EDGE.top - EDGE.bottom);
    ctx.clip();
    for (const curve of this.curves) line(ctx, place, curve);
    line(ctx, place, { ...trail, colour: "text", width: 1.6, alpha: 0.75 });
    ctx.restore();
    this.drawPoint(ctx, place, trail);
  }

  /** Return the newest rows that have both values: the estimate if there is one, else the instrument's. */
  trail(history) {
    const { recent } = history;
    const x = [];
    const y = [];
    for (let n = Math.max(0, recent.length - TRAIL_ROWS); n < recent.length; n += 1) {
      const value = recent.value(COLUMN.estimate, n) ?? recent.value(COLUMN.instrument, n);
      const resistance = recent.value(COLUMN.resistance, n);
      if (value === null || resistance === null) continue;
      x.push(resistance);
      y.push(value);
    }
    return { x, y };
  }

  /** Widen the bounds to all that is shown; they only grow until the curves change, so that the picture stands still. */
  fit(trail) {
    const bounds = this.bounds ?? { left: Infinity, right: -Infinity, low: Infinity, high: -Infinity };
    const curves = this.bounds ? [] : this.curves;
    for (const { x, y } of [...curves, { x: trail.x.slice(-60), y: trail.y.slice(-60) }]) {
      for (let n = 0; n < x.length; n += 1) {
        if (x[n] === null || y[n] === null) continue;
        bounds.left = Math.min(bounds.left, x[n]);
        bounds.right = Math.max(bounds.right, x[n]);
        bounds.low = Math.min(bounds.low, y[n]);
        bounds.high = Math.max(bounds.high, y[n]);
      }
    }
    this.bounds = bounds;
  }

  placing({ width, height }) {
    const { least } = QUANTITIES[this.quantity];
    let { left, right, low, high } = Number.isFinite(this.bounds.left) ? this.bounds : { left: 0, right: 1, low: 0, high: 1 };
    [left, right] = widened(left, right, 0.4);
    [low, high] = widened(low, high, least);
    return {
      left, right, low, high,
      x: (value) => EDGE.left + ((value - left) / (right - left)) * (width - EDGE.left - EDGE.right),
      y: (value) => height - EDGE.bottom - ((value - low) / (high - low)) * (height - EDGE.top - EDGE.bottom),
    };
  }

  drawAxes(ctx, place, { width, height }) {
    ctx.font = '11px "Inter", system-ui, sans-serif';
    ctx.lineWidth = 1;
    ctx.strokeStyle = colour("grid");
    ctx.fillStyle = colour("quiet-text");
    const across = ticks(place.left, place.right, width / 80);
    const up = ticks(place.low, place.high, height / 46);
    ctx.beginPath();
    for (const value of across) {
      ctx.moveTo(place.x(value), EDGE.top);
      ctx.lineTo(place.x(value), height - EDGE.bottom);
    }
    for (const value of up) {
      ctx.moveTo(EDGE.left, place.y(value));
      ctx.lineTo(width - EDGE.right, place.y(value));
    }
    ctx.stroke();
    ctx.textAlign = "center";
    for (const value of across) ctx.fillText(fixed(value, tickDigits(across)), place.x(value), height - EDGE.bottom + 14);
    ctx.fillText("Resistance [\u03a9]", (EDGE.left + width - EDGE.right) / 2, height - 4);
    ctx.textAlign = "right";
    for (const value of up) ctx.fillText(fixed(value, tickDigits(up)), EDGE.left - 6, place.y(value) + 4);
    const { name, unit } = QUANTITIES[this.quantity];
    ctx.save();
    ctx.translate(11, (EDGE.top + height - EDGE.bottom) / 2);
    ctx.rotate(-Math.PI / 2);
    ctx.textAlign = "center";
    ctx.fillText(`${name} [${unit}]`, 0, 0);
    ctx.restore();
  }

  drawPoint(ctx, place, { x, y }) {
    if (!x.length) return;
    const [px, py] = [place.x(x.at(-1)), place.y(y.at(-1))];
    ctx.beginPath();
    ctx.arc(px, py, 6.5, 0, 2 * Math.PI);
    ctx.fillStyle = colour("target");
    ctx.fill();
    ctx.lineWidth = 2;
    ctx.strokeStyle = colour("panel");
    ctx.stroke();
  }
}

function widened(low, high, least) {
  const wide = Math.max(high - low, least) * 1.1;
  const middle = (low + high) / 2;
  return [middle - wide / 2, middle + wide / 2];
}

function line(ctx, place, { x, y, colour: name, width = 1.5, dash = [], alpha = 1 }) {
  ctx.save();
  ctx.globalAlpha = alpha;
  ctx.strokeStyle = colour(name);
  ctx.lineWidth = width;
  ctx.lineJoin = "round";
  ctx.setLineDash(dash);
  ctx.beginPath();
  let isDown = false;
  for (let n = 0; n < x.length; n += 1) {
    if (x[n] === null || y[n] === null) {
      isDown = false;
      continue;
    }
    if (isDown) ctx.lineTo(place.x(x[n]), place.y(y[n]));
    else ctx.moveTo(place.x(x[n]), place.y(y[n]));
    isDown = true;
  }
  ctx.stroke();
  ctx.restore();
}
