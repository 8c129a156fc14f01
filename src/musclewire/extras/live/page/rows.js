/** From the columns that the server sends to those that the page shows, in the units it shows. Pure. */

import { KELVIN, QUANTITIES } from "./format.js";

/** The page's own columns, in the order of every row it keeps. */
export const COLUMN = {
  time: 0, run: 1, drive: 2, voltage: 3, current: 4, power: 5, resistance: 6, target: 7, estimate: 8, instrument: 9, temperature: 10,
  kp: 11, ki: 12, kd: 13, valid: 14,
};
export const WIDTH = Object.keys(COLUMN).length;

/** Return the name of the estimated quantity among columns, or null. */
export function quantityOf(columns) {
  for (const name of columns) {
    const found = /^(?:target|estimated)_(strain|displacement|force)(?:_m|_n)?$/.exec(name);
    if (found) return found[1];
  }
  return null;
}

/** Return a function from a row of the server, or of a recording, to a row of the page.

`quantity` is what is plotted; `leg_length_m` turns a displacement into a strain where no strain was measured. */
export function rowReader(columns, { quantity, leg_length_m = null, shunt_resistance_ohm = null, minimum_current_a = 1e-4 }) {
  const place = (name) => columns.indexOf(name);
  const shown = QUANTITIES[quantity];
  const ending = { strain: "", displacement: "_m", force: "_n" }[quantity];
  const at = {
    time: place("time_s"), run: place("run_s"), drive: place("drive_voltage_v"), voltage: place("wire_voltage_v"),
    shunt: place("shunt_voltage_v"), current: place("current_a"), power: place("power_w"), resistance: place("resistance_ohm"),
    target: place(`target_${quantity}${ending}`), estimate: place(`estimated_${quantity}${ending}`),
    instrument: place(shown.instrument), displacement: quantity === "strain" ? place("displacement_m") : -1,
    temperature: place("protection_temperature_k"), kp: place("proportional_gain"), ki: place("integral_gain"),
    kd: place("derivative_gain"), valid: place("valid"),
  };
  return (row) => pageRow(row, at, { factor: shown.factor, leg_length_m, shunt_ohm: shunt_resistance_ohm, minimum_current_a });
}

function pageRow(row, at, { factor, leg_length_m, shunt_ohm, minimum_current_a }) {
  const get = (place) => (place < 0 ? null : row[place] ?? null);
  const times = (value, by) => (value === null ? null : value * by);
  const voltage = get(at.voltage);
  let current = get(at.current);
  if (current === null && at.current < 0 && shunt_ohm) current = times(get(at.shunt), 1 / shunt_ohm);
  // Below the current that the rig needs to sense, a resistance is noise divided by noise.
  const isFlowing = current !== null && Math.abs(current) >= minimum_current_a && voltage !== null;
  const power = get(at.power) ?? (isFlowing ? voltage * current : null);
  const resistance = isFlowing ? get(at.resistance) ?? voltage / current : null;
  let instrument = get(at.instrument);
  if (instrument === null && at.displacement >= 0 && leg_length_m) instrument = times(get(at.displacement), 1 / leg_length_m);
  const temperature = get(at.temperature);
  return [
    get(at.time), get(at.run), get(at.drive), voltage, times(current, 1e3), times(power, 1e3), resistance,
    times(get(at.target), factor), times(get(at.estimate), factor), times(instrument, factor),
    temperature === null ? null : temperature - KELVIN, get(at.kp), get(at.ki), get(at.kd), get(at.valid),
  ];
}

/** Return the page's columns of a recording as the server sends it: {columns: {name: values}}. */
export function recordedColumns(recording, options) {
  const names = Object.keys(recording.columns);
  const read = rowReader(names, options);
  const kept = Array.from({ length: WIDTH }, () => []);
  const count = names.length ? recording.columns[names[0]].length : 0;
  for (let n = 0; n < count; n += 1) {
    const row = read(names.map((name) => recording.columns[name][n]));
    for (let place = 0; place < WIDTH; place += 1) kept[place].push(row[place]);
  }
  return kept;
}
