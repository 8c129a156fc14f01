/** The five plots over time, drawn by uPlot. Made once; only their data and their colours change. */

import uPlot from "./vendor/uPlot.esm.js";
import { el, setText } from "./dom.js";
import { fixed, QUANTITIES } from "./format.js";
import { COLUMN } from "./rows.js";
import { colour } from "./theme.js";

const AXIS_FONT = '11px "Inter", system-ui, sans-serif';

/** Return what the plots show for a quantity; the first is drawn taller. */
function definitions(quantity) {
  const { name, unit, digits, least } = QUANTITIES[quantity];
  return [
    {
      title: name, unit, digits, least, tall: true, keep: 0,
      series: [
        { name: "target", column: COLUMN.target, colour: "target", dash: [7, 4] },
        { name: "instrument", column: COLUMN.instrument, colour: "instrument" },
        { name: "estimate", column: COLUMN.estimate, colour: "trace" },
      ],
    },
    { title: "Resistance", unit: "\u03a9", digits: 2, least: 0.4, series: [{ name: "wire", column: COLUMN.resistance, colour: "cooling" }] },
    {
      title: "Voltage and current", unit: "V", digits: 2, least: 0.5, keep: 0, right: { unit: "mA", digits: 0, least: 20 },
      series: [
        { name: "wire voltage", column: COLUMN.voltage, colour: "trace" },
        { name: "current", column: COLUMN.current, colour: "target", right: true },
      ],
    },
    { title: "Power", unit: "mW", digits: 0, least: 50, keep: 0, series: [{ name: "in the wire", column: COLUMN.power, colour: "heating" }] },
    {
      title: "Temperature, estimated", unit: "\u00b0C", digits: 0, least: 40, keep: 20, limit: true, lowest: true,
      series: [{ name: "wire", column: COLUMN.temperature, colour: "heating" }],
    },
  ];
}

export class TimePlots {
  constructor(container, history) {
    this.container = container;
    this.history = history;
    this.window_s = 60;
    this.end_s = 0;
    this.limit = null;
    this.compared = null;
    this.plots = [];
    this.sizes = new ResizeObserver(() => this.resize());
    this.sizes.observe(container);
  }

  /** Make the plots for a quantity; nothing if they are there already. */
  showQuantity(quantity) {
    if (this.quantity === quantity) return;
    this.quantity = quantity;
    for (const plot of this.plots) plot.drawn.destroy();
    this.container.replaceChildren();
    this.plots = definitions(quantity).map((each) => this.make(each));
    this.resize();
  }

  make(definition) {
    const values = definition.series.map((each) => {
      const value = el("span", {});
      return { each, value, key: el("span", { class: "key" }, `${each.name}\u00a0`, value) };
    });
    values.forEach(({ each, key }) => key.style.setProperty("--key", `var(--${each.colour})`));
    const area = el("div", { class: "plot-area", role: "img", "aria-label": `${definition.title} over time; the values are in "Plots as a table"` });
    const units = definition.right ? ` ${definition.unit}, ${definition.right.unit}` : ` ${definition.unit}`;
    const title = el("div", { class: "plot-title" }, el("h3", {}, definition.title, el("span", {}, units)), ...values.map(({ key }) => key));
    this.container.append(el("div", { class: definition.tall ? "plot tall" : "plot" }, title, area));
    const drawn = new uPlot(this.options(definition), [[], ...definition.series.map(() => [])], area);
    return { definition, area, drawn, values };
  }

  options(definition) {
    const axis = { stroke: () => colour("quiet-text"), font: AXIS_FONT, ticks: { show: false }, grid: { stroke: () => colour("grid"), width: 1 } };
    const written = (digits) => (_, splits) => splits.map((value) => fixed(value, splits.length > 1 && splits[1] - splits[0] < 10 ** -digits ? digits + 1 : digits));
    const scales = { x: { time: false, range: () => this.range() }, y: { range: (_, low, high) => padded(low, high, definition) } };
    const axes = [
      // The time is written once, below the lowest plot.
      { ...axis, size: definition.lowest ? 22 : 5, gap: 2, values: (_, splits) => splits.map((value) => (definition.lowest ? `${value} s` : "")) },
      { ...axis, size: 46, gap: 4, space: 17, values: written(Math.min(definition.digits, 1)) },
    ];
    if (definition.right) {
      scales.right = { range: (_, low, high) => padded(low, high, { ...definition.right, keep: 0 }) };
      axes.push({ ...axis, size: 40, gap: 4, space: 17, side: 1, scale: "right", grid: { show: false }, values: written(0) });
    } else axes.push({ ...axis, size: 40, side: 1, scale: "y", grid: { show: false }, values: (_, splits) => splits.map(() => "") });
    const series = definition.series.map((each) => ({
      label: each.name, stroke: () => colour(each.colour), width: 1.8, dash: each.dash, scale: each.right ? "right" : "y", points: { show: false },
    }));
    return {
      width: 300, height: 100, padding: [7, 0, 0, 0], legend: { show: false }, scales, axes, series: [{}, ...series],
      cursor: { sync: { key: "time" }, drag: { x: false, y: false }, points: { size: 7 } },
      hooks: { drawClear: [(plot) => definition.limit && this.drawLimit(plot)], draw: [(plot) => this.drawCompared(plot, definition)] },
    };
  }

  range() {
    const end = Math.max(this.end_s, this.window_s);
    return [end - this.window_s, end];
  }

  /** Draw the newest rows; the window ends at `end_s`. */
  draw(end_s) {
    this.end_s = end_s;
    const rows = this.history.rows(this.window_s);
    // What lies left of the window would only be searched through: cut it off.
    const from = Math.max(0, rows.firstFrom(this.range()[0]) - 1);
    const time = rows.column(COLUMN.time, from);
    for (const { definition, drawn } of this.plots) {
      drawn.setData([time, ...definition.series.map((each) => rows.column(each.column, from))]);
    }
  }

  /** Write the newest values next to the names of the traces. */
  writeValues() {
    for (const { definition, values } of this.plots) {
      for (const { each, value } of values) {
        const { digits } = each.right ? definition.right : definition;
        setText(value, fixed(this.history.recent.last(each.column), digits));
      }
    }
  }

  drawLimit(plot) {
    if (this.limit === null) return;
    const { ctx, bbox } = plot;
    const y = plot.valToPos(this.limit, "y", true);
    if (y < bbox.top) return;
    ctx.save();
    ctx.fillStyle = colour("bad");
    ctx.globalAlpha = 0.16;
    ctx.fillRect(bbox.left, bbox.top, bbox.width, y - bbox.top);
    ctx.globalAlpha = 1;
    ctx.fillRect(bbox.left, y, bbox.width, devicePixelRatio);
    ctx.restore();
  }

  /** Draw the earlier run, beginning where the present run begins. */
  drawCompared(plot, definition) {
    if (!this.compared) return;
    const { columns, begin_s } = this.compared;
    const { ctx, bbox } = plot;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    ctx.lineWidth = 1.4 * devicePixelRatio;
    ctx.setLineDash([2 * devicePixelRatio, 3 * devicePixelRatio]);
    for (const each of definition.series) {
      if (each.name === "target") continue;
      ctx.strokeStyle = colour(each.right ? "line-strong" : "compared");
      ctx.beginPath();
      trace(ctx, plot, columns[COLUMN.time], columns[each.column], begin_s, each.right ? "right" : "y");
      ctx.stroke();
    }
    ctx.restore();
  }

  resize() {
    for (const { area, drawn } of this.plots) {
      const width = Math.floor(area.clientWidth);
      const height = Math.floor(area.clientHeight);
      if (width > 40 && height > 30 && (drawn.width !== width || drawn.height !== height)) drawn.setSize({ width, height });
    }
  }

  /** Draw again in other colours. */
  recolour() {
    for (const { drawn } of this.plots) drawn.redraw(false, true);
  }
}

function trace(ctx, plot, time, values, begin_s, scale) {
  let isDown = false;
  for (let n = 0; n < time.length; n += 1) {
    if (values[n] === null) {
      isDown = false;
      continue;
    }
    const x = plot.valToPos(time[n] + begin_s, "x", true);
    const y = plot.valToPos(values[n], scale, true);
    if (isDown) ctx.lineTo(x, y);
    else ctx.moveTo(x, y);
    isDown = true;
  }
}

/** Return a range with room around, at least so wide that noise does not fill it; `keep` is always within. */
function padded(low, high, { least, keep }) {
  if (low === null || high === null || low === undefined) return [keep ?? 0, (keep ?? 0) + least];
  const lowest = keep === undefined ? low : Math.min(low, keep);
  const middle = (lowest + high) / 2;
  const wide = Math.max(high - lowest, least);
  const half = wide * 0.56;
  return keep !== undefined && lowest === keep ? [keep, keep + wide * 1.12] : [middle - half, middle + half];
}
