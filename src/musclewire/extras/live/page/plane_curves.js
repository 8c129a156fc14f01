/** The curves of the plane that stand still: the model's branches, the recorded loop, the run to compare with. */

import { el, setText } from "./dom.js";
import { QUANTITIES } from "./format.js";
import { fetchColumns } from "./recordings.js";
import { COLUMN } from "./rows.js";

const POINTS = 800;

export class PlaneCurves {
  /** `reading` returns how rows of a recording are read. */
  constructor(plane, parts, reading) {
    this.plane = plane;
    this.parts = parts;
    this.reading = reading;
    this.loop = null;
    this.compared = null;
  }

  /** Follow the state; a loop that was recorded is fetched once. */
  follow(state, quantity) {
    const key = [quantity, state.model?.file, state.loop?.recording].join();
    if (key === this.key) return;
    this.key = key;
    this.model = state.model;
    this.quantity = quantity;
    if (state.loop?.recording) this.fetchLoop(state.loop.recording);
    this.renew();
  }

  async fetchLoop(name) {
    const key = this.key;
    this.loop = null;
    try {
      const columns = await fetchColumns(name, this.reading(), POINTS);
      if (this.key === key) this.loop = columns;
    } catch {
      return; // the plane is true without it, and the list of recordings says what cannot be read
    }
    this.renew();
  }

  /** Show another run's curve, {columns, name}; null takes it away. */
  compare(compared) {
    this.compared = compared;
    this.renew();
  }

  renew() {
    const { model, loop, compared } = this;
    const { name: title, factor } = QUANTITIES[this.quantity ?? "strain"];
    const curves = [];
    if (loop) curves.push({ ...planeCurve(loop), colour: "line-strong", width: 1.2 });
    if (compared) curves.push({ ...planeCurve(compared.columns), colour: "compared", width: 1.4, dash: [2, 3] });
    for (const [name, branch] of Object.entries(model?.branches ?? {})) {
      curves.push({ x: branch.resistance_ohm, y: branch.value.map((value) => value * factor), colour: name, width: 2.6 });
    }
    this.plane.setCurves(this.quantity ?? "strain", curves);
    this.plane.draw();
    const shown = [model && "both branches of the model", loop && "the recorded loop", compared && compared.name, "the last values and the present point"];
    setText(this.parts["plane-title"], `${title} over resistance`);
    this.parts.plane.setAttribute("aria-label", `${title} over resistance: ${shown.filter(Boolean).join(", ")}`);
    this.writeLegend();
  }

  writeLegend() {
    const key = (kind, text) => el("li", { class: `key ${kind}` }, text);
    this.parts["plane-legend"].replaceChildren(
      key("key-target dot", "now"), key("key-text", "lately"),
      ...(this.model ? [key("key-heating", "heating branch"), key("key-cooling", "cooling branch")] : []),
      ...(this.loop ? [key("key-loop", "recorded loop")] : []),
      ...(this.compared ? [key("key-compared dashed", this.compared.name)] : []),
    );
  }
}

/** Return a recording's curve: by its instrument, else by its estimate. */
function planeCurve(columns) {
  const measured = columns[COLUMN.instrument];
  const y = measured.some((value) => value !== null) ? measured : columns[COLUMN.estimate];
  return { x: columns[COLUMN.resistance], y };
}
