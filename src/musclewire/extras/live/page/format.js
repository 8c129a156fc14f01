/** Numbers and units as the page writes them. Pure functions. */

export const KELVIN = 273.15;
const NONE = "\u2013";

/** What can be sensed: its name, and how its SI unit is shown. */
export const QUANTITIES = {
  strain: { name: "Strain", factor: 100, unit: "%", digits: 2, step: 0.01, least: 0.2, instrument: "reference_strain" },
  displacement: { name: "Displacement", factor: 1000, unit: "mm", digits: 3, step: 0.01, least: 0.3, instrument: "displacement_m" },
  force: { name: "Force", factor: 1, unit: "N", digits: 3, step: 0.01, least: 0.05, instrument: "force_n" },
};

const UNITS = { s: "s", v: "V", a: "A", ohm: "\u03a9", m: "mm", n: "N", k: "\u00b0C", w: "W", j: "J", hz: "Hz", pct: "%", pa: "MPa" };
const SHOWN = { m: (value) => value * 1e3, k: (value) => value - KELVIN, pa: (value) => value / 1e6 };

/** Return a number with so many digits after the point and a true minus; a dash for what is unknown. */
export function fixed(value, digits) {
  if (value === null || value === undefined || !Number.isFinite(value)) return NONE;
  const text = value.toFixed(digits);
  return Number(text) === 0 ? text.replace("-", "") : text.replace("-", "\u2212");
}

/** Return a number with its unit. */
export function withUnit(value, digits, unit) {
  return `${fixed(value, digits)}\u202f${unit}`;
}

/** Return a number with about three significant digits. */
export function short(value) {
  if (value === null || value === undefined || !Number.isFinite(value)) return NONE;
  const size = Math.abs(value);
  if (size !== 0 && (size < 1e-3 || size >= 1e5)) return value.toExponential(2).replace("-", "\u2212");
  return fixed(value, size >= 100 ? 0 : size >= 10 ? 1 : size >= 1 ? 2 : 3);
}

/** Return the words and the value with unit of an SI name such as maximum_temperature_k: ["Maximum temperature", "150 °C"]. */
export function namedValue(name, value) {
  const words = name.split("_");
  const unit = words.at(-1);
  if (words.length < 2 || !(unit in UNITS)) return [sentence(words.join(" ")), short(value)];
  const isSpan = unit === "k" && /margin|change|rise|step|hysteresis/.test(name);
  const shown = isSpan || !(unit in SHOWN) ? value : SHOWN[unit](value);
  return [sentence(words.slice(0, -1).join(" ")), `${short(shown)}\u202f${isSpan ? "K" : UNITS[unit]}`];
}

/** Return a text that begins with a capital letter. */
export function sentence(text) {
  return text ? text[0].toUpperCase() + text.slice(1) : "";
}

/** Return a time span in words: "45 s", "3 min 05 s". */
export function span(seconds) {
  if (!Number.isFinite(seconds)) return NONE;
  const whole = Math.max(0, Math.round(seconds));
  if (whole < 100) return `${whole}\u202fs`;
  return `${Math.floor(whole / 60)}\u202fmin ${String(whole % 60).padStart(2, "0")}\u202fs`;
}

/** Return a number of bytes as people say it. */
export function bytes(count) {
  if (!Number.isFinite(count)) return NONE;
  if (count < 1e3) return `${count}\u202fB`;
  return count < 1e6 ? `${(count / 1e3).toFixed(0)}\u202fkB` : `${(count / 1e6).toFixed(1)}\u202fMB`;
}

/** Return the time of day of a date in ISO form. */
export function timeOfDay(iso) {
  const date = new Date(iso);
  return Number.isNaN(date.getTime()) ? "" : date.toLocaleTimeString([], { hour12: false });
}

/** Return round values for the ticks of an axis, about as many as asked. */
export function ticks(low, high, about) {
  if (!(high > low)) return [];
  const rough = (high - low) / Math.max(1, about);
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 2.5, 5, 10].map((each) => each * power).find((each) => each >= rough);
  const found = [];
  for (let n = Math.ceil(low / step - 1e-9); n * step <= high + step * 1e-9; n += 1) found.push(n * step);
  return found;
}

/** Return how many digits after the point the ticks of this distance need. */
export function tickDigits(values) {
  if (values.length < 2) return 2;
  return Math.max(0, Math.min(6, -Math.floor(Math.log10(values[1] - values[0]) + 1e-9) + (/[24]5$/.test(String(values[1] - values[0])) ? 1 : 0)));
}
