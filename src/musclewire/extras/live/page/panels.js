/** Protection and its margin, gains and fired rules, messages: what a wire's state says in words and small tables. */

import { el, renew, setText, show, table } from "./dom.js";
import { fixed, KELVIN, sentence, short, timeOfDay } from "./format.js";
import { COLUMN } from "./rows.js";
import { guardWords } from "./words.js";

const SETS = ["NB", "NM", "NS", "ZO", "PS", "PM", "PB"];
const SET_WORDS = { NB: "negative big", NM: "negative medium", NS: "negative small", ZO: "zero", PS: "positive small", PM: "positive medium", PB: "positive big" };

export class ProtectionPanel {
  constructor(parts) {
    this.parts = parts;
    this.fill = el("i", {});
    this.words = [el("span", {}), el("span", {})];
    this.bar = el("div", { class: "margin-bar" }, this.fill);
    parts.margin.append(this.bar, el("div", { class: "margin-words" }, ...this.words));
  }

  follow(state) {
    const { guard, health } = this.parts;
    setText(guard, guardWords(state.protection, state.phase));
    guard.dataset.state = ["ready", "busy", "ending"].includes(state.phase) || state.protection?.state === "tripped" ? state.protection?.state ?? "none" : "none";
    setText(health, state.health ? `Health: ${state.health}` : "Health: nothing known against it.");
    this.limit = state.protection?.maximum_temperature_k ?? state.rig?.limits?.maximum_temperature_k ?? null;
  }

  /** Draw the estimated temperature [degC] against the limit. */
  draw(temperature) {
    const limit = this.limit === null || this.limit === undefined ? null : this.limit - KELVIN;
    const known = temperature !== null && limit !== null;
    this.fill.style.transform = `scaleX(${known ? Math.max(0, Math.min(1, (temperature - 20) / (limit - 20))) : 0})`;
    setText(this.words[0], known ? `${fixed(temperature, 0)}\u202f\u00b0C, margin ${fixed(limit - temperature, 0)}\u202fK` : "Temperature not estimated");
    setText(this.words[1], limit === null ? "" : `limit ${fixed(limit, 0)}\u202f\u00b0C`);
  }
}

export class ControllerPanel {
  constructor(parts) {
    this.parts = parts;
    this.gains = ["Proportional", "Integral", "Derivative"].map((name) => this.gain(name));
    parts.gains.append(...this.gains.map(({ box }) => box));
    this.cells = new Map();
    parts.rules.append(this.grid());
    show(parts.gains, false);
    show(parts.rules, false);
    this.showRules(null);
  }

  gain(name) {
    const value = el("p", { class: "value" }, "\u2013");
    const fill = el("i", {});
    return { value, fill, box: el("div", { class: "gain" }, el("p", { class: "name" }, name), value, el("div", { class: "gain-bar" }, fill)) };
  }

  /** The table of rules: error down, its change across; a fired rule is lit and says what it makes of each gain. */
  grid() {
    const head = el("tr", {}, el("th", { scope: "col" }, "e \\ \u0394e"), ...SETS.map((name) => el("th", { scope: "col", title: SET_WORDS[name] }, name)));
    const rows = SETS.map((error) => el("tr", {}, el("th", { scope: "row", title: SET_WORDS[error] }, error), ...SETS.map((change) => {
      const cell = el("td", {}, "\u00b7");
      this.cells.set(`${error} ${change}`, cell);
      return cell;
    })));
    return el("table", { class: "rules" }, el("caption", { class: "unseen" }, "Fuzzy rules: rows are the error, columns its change; fired rules show their weight in percent"), el("thead", {}, head), el("tbody", {}, ...rows));
  }

  showRules(rules) {
    const weights = new Map((rules ?? []).filter((rule) => rule.weight >= 0.005).map((rule) => [`${rule.error} ${rule.change}`, rule]));
    for (const [place, cell] of this.cells) {
      const rule = weights.get(place);
      const text = rule ? fixed(100 * rule.weight, 0) : "\u00b7";
      if (cell.textContent === text) continue;
      cell.textContent = text;
      cell.className = rule ? (rule.weight >= 0.3 ? "fired" : "fired faint") : "";
    }
    const strongest = rules?.[0];
    setText(this.parts["rules-words"], strongest
      ? `Strongest rule, weight ${fixed(strongest.weight, 2)}: error ${SET_WORDS[strongest.error] ?? strongest.error}, change ${SET_WORDS[strongest.change] ?? strongest.change}; Kp ${strongest.kp}, Ki ${strongest.ki}, Kd ${strongest.kd}.`
      : "By default the gains in the model close the loop (inverse-model). With the controller fuzzy-pid its gains and rules show here: rows are the error, columns its change.");
  }

  /** Show the gains of the newest row in their ranges. */
  draw(history, ranges) {
    const columns = [COLUMN.kp, COLUMN.ki, COLUMN.kd];
    const fuzzy = history.recent.last(COLUMN.kp) !== null;
    show(this.parts.gains, fuzzy);
    show(this.parts.rules, fuzzy);
    const names = ["kp_range", "ki_range", "kd_range"];
    this.gains.forEach(({ value, fill }, place) => {
      const gain = history.recent.last(columns[place]);
      setText(value, short(gain));
      const [low, high] = ranges?.[names[place]] ?? [0, 0];
      const share = gain !== null && high > low ? Math.max(0, Math.min(1, (gain - low) / (high - low))) : 0;
      fill.style.transform = `scaleX(${share})`;
    });
  }
}

/** Show the messages of a bench, the newest on top; `metrics` of the last closed loop below them. */
export function showMessages(root, state) {
  const messages = state.messages ?? [];
  renew(root, JSON.stringify(messages), () => messages.map(({ level, text, at }) => el("li", { class: level }, el("time", { datetime: at }, timeOfDay(at)), el("span", {}, level === "info" ? "" : `${level}: `, text))));
}

/** Show what the fit of a model remarks, folded up; nothing if it remarks nothing. */
export function showNotes(details, notes) {
  show(details, notes.length > 0);
  const [summary, list] = details.children;
  setText(summary, notes.length === 1 ? "1 note on the model" : `${notes.length} notes on the model`);
  renew(list, JSON.stringify(notes), () => notes.map((note) => el("li", {}, sentence(note))));
}

/** Return the last rows as a table, one each second: what the plots show, for who does not see them. */
export function plotTable(history, quantityName, unit) {
  const { recent } = history;
  const heads = [
    ["Time", "s", COLUMN.time, 1], ["Target", unit, COLUMN.target, 2], ["Estimate", unit, COLUMN.estimate, 2], ["Instrument", unit, COLUMN.instrument, 2], ["Resistance", "\u03a9", COLUMN.resistance, 2],
    ["Voltage", "V", COLUMN.voltage, 2], ["Current", "mA", COLUMN.current, 0], ["Power", "mW", COLUMN.power, 0], ["Temperature", "\u00b0C", COLUMN.temperature, 0],
  ];
  const chosen = [];
  for (let n = recent.length - 1; n >= 0 && chosen.length < 30; n -= 1) {
    if (!chosen.length || recent.value(COLUMN.time, chosen.at(-1)) - recent.value(COLUMN.time, n) >= 0.999) chosen.push(n);
  }
  return table(`${quantityName} and electrical values, the newest first, one row a second`, heads.map(([name, of]) => ({ text: `${name} [${of}]`, number: true })),
    chosen.map((n) => heads.map(([, , place, digits]) => fixed(recent.value(place, n), digits))));
}
