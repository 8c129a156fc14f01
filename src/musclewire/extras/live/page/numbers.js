/** The present values in large figures with their units. */

import { el, setText } from "./dom.js";
import { fixed, QUANTITIES } from "./format.js";
import { COLUMN } from "./rows.js";

const NEAR_K = 15;

/** Return whether the drive is off: no reading is of now. */
export function isOff(state) {
  return ["off", "stopped", "failed"].includes(state.phase);
}

/** Return what the tiles show: of a driven wire its newest row, of one that is off nothing but that. Pure. */
export function numberTiles(rows, shown, state, quantity) {
  const { name, unit, digits } = QUANTITIES[quantity];
  const off = isOff(state);
  const { target, estimate, instrument, temperature, limit } = shown;
  const margin = temperature === null || limit === null ? null : limit - temperature;
  const tile = (value, places, ofUnit, below, more) => (off
    ? { figure: "\u2013", unit: ofUnit, below: value === null ? "" : `last ${fixed(value, places)}`, ...more }
    : { figure: fixed(value, places), unit: ofUnit, below, ...more });
  const resistance = rows.last(COLUMN.resistance);
  return {
    value: tile(estimate ?? instrument, digits, unit, besides(target, estimate, instrument, digits), { name, kind: estimate === null ? "instrument" : "estimated" }),
    resistance: tile(resistance, 2, "\u03a9", resistance === null ? "too little current" : ""),
    drive: off ? { figure: "0", unit: "V", below: "the drive is off" } : { figure: fixed(rows.last(COLUMN.drive), 2), unit: "V", below: `max. ${fixed(state.rig?.maximum_voltage_v, 2)}\u202fV` },
    current: tile(rows.last(COLUMN.current), 0, "mA", ""),
    power: tile(rows.last(COLUMN.power), 0, "mW", ""),
    temperature: tile(temperature, 0, "\u00b0C", margin === null ? "" : `margin ${fixed(margin, 0)}\u202fK`, { near: !off && margin !== null && margin < NEAR_K }),
  };
}

function besides(target, estimate, instrument, digits) {
  const parts = [];
  if (target !== null) parts.push(`target ${fixed(target, digits)}`);
  else if (estimate !== null && instrument !== null) parts.push(`instrument ${fixed(instrument, digits)}`);
  return parts.join(", ");
}

/** The present values in large figures. */
export class Numbers {
  constructor(root) {
    this.items = {};
    for (const [key, name] of Object.entries({ value: "Strain", resistance: "Resistance", drive: "Drive", current: "Current", power: "Power", temperature: "Temperature" })) {
      const item = {
        box: el("div", { class: key === "value" ? "number first" : "number" }), name: el("span", {}, name), kind: el("span", { class: "kind" }),
        figure: el("span", {}), unit: el("span", { class: "unit" }), below: el("p", { class: "below" }),
      };
      item.box.append(el("p", { class: "name" }, item.name, " ", item.kind), el("p", { class: "value" }, item.figure, item.unit), item.below);
      root.append(item.box);
      this.items[key] = item;
    }
  }

  /** Write {key: {name, figure, unit, below, near}}. */
  write(values) {
    for (const [key, value] of Object.entries(values)) {
      const item = this.items[key];
      if (value.name) setText(item.name, value.name);
      setText(item.kind, value.kind ?? "");
      setText(item.figure, value.figure);
      setText(item.unit, value.unit);
      setText(item.below, value.below ?? "");
      item.box.classList.toggle("near-limit", Boolean(value.near));
    }
  }
}
