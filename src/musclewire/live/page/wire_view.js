/** One wire on the page: takes its states and rows in, and keeps all its parts true. */

import { announce } from "./announce.js";
import { el, partsOf, setText, show } from "./dom.js";
import { fixed, KELVIN, QUANTITIES } from "./format.js";
import { Gauge, Numbers } from "./gauge.js";
import { Guide, limitsTable } from "./guide.js";
import { ControllerPanel, plotTable, ProtectionPanel, showMessages } from "./panels.js";
import { Plane } from "./plane.js";
import { fetchColumns, Recordings } from "./recordings.js";
import { History } from "./ring_buffers.js";
import { COLUMN, quantityOf, rowReader, WIDTH } from "./rows.js";
import { RunPanel } from "./run_panel.js";
import { Sequence } from "./sequence.js";
import { Steering } from "./steering.js";
import { TimePlots } from "./time_plots.js";
import { clockWords, doingWords, holderWords, modelWords, PHASES, verdictOf } from "./words.js";

const WINDOWS = [[20, "20 s"], [60, "1 min"], [180, "3 min"], [600, "10 min"]];
const SPEEDS = [1, 2, 5, 10, 20];
const NUMBERS_MS = 150;
const STEER = { do: "control", controller: null, estimator: null, settings: null, reference: { kind: "steer", start: null } };

export class WireView {
  /** `office` has command(bench, command), control of each bench, and stop(wire). */
  constructor(bench, template, office) {
    this.bench = bench;
    this.office = office;
    this.root = template.content.firstElementChild.cloneNode(true);
    this.parts = partsOf(this.root);
    this.control = { holder: null, you_hold: false, asked_by: null };
    this.layouts = new Map();
    this.history = new History(WIDTH);
    this.quantity = "strain";
    this.numbers_ms = 0;
    this.state = null;
    this.rules = null;
    this.loopColumns = null;
    this.build();
  }

  build() {
    const { parts } = this;
    const refuse = (text) => setText(parts.refusal, text);
    this.refuse = refuse;
    this.sequence = new Sequence((command) => this.send(command), (message) => this.refused(message));
    const run = (commands, focusSlider = false) => this.run(commands, focusSlider);
    this.numbers = new Numbers(parts.numbers);
    this.gauge = new Gauge(parts.gauge);
    this.plots = new TimePlots(parts.plots, this.history);
    this.plots.showQuantity(this.quantity);
    this.plane = new Plane(parts.plane);
    this.guide = new Guide(parts.steps, parts["guide-card"], run);
    this.runs = new RunPanel(parts, this.bench, run, refuse);
    this.steering = new Steering(parts, { send: (value) => this.send({ do: "target", value }), start: () => run([STEER], true), refuse });
    this.recordings = new Recordings(parts.recordings, parts.comparison, { compare: (columns, name) => this.compare(columns, name), options: () => this.reading() });
    this.protection = new ProtectionPanel(parts);
    this.controller = new ControllerPanel(parts);
    parts.window.append(...WINDOWS.map(([value, text]) => el("option", { value, selected: value === 60 }, text)));
    parts.window.addEventListener("change", () => { this.plots.window_s = Number(parts.window.value); this.dirty = true; });
    parts["clock-speed"].append(...SPEEDS.map((value) => el("option", { value }, `\u00d7\u202f${value}`)));
    parts["clock-speed"].addEventListener("change", () => this.order({ do: "clock_speed", factor: Number(parts["clock-speed"].value) }));
    parts.end.addEventListener("click", () => { this.sequence.cancel(); this.order({ do: "end" }); });
    parts["stop-one"].addEventListener("click", () => this.office.stop(this));
    parts.ask.addEventListener("click", () => this.office.askOrGiveUp(this));
    parts.give.addEventListener("click", () => this.office.answer(this, true));
    parts.keep.addEventListener("click", () => this.office.answer(this, false));
    const renewTable = () => parts.table.replaceChildren(plotTable(this.history, QUANTITIES[this.quantity].name, QUANTITIES[this.quantity].unit));
    parts["table-alternative"].addEventListener("toggle", () => parts["table-alternative"].open && renewTable());
    parts["table-renew"].addEventListener("click", renewTable);
    setText(parts.name, this.bench);
  }

  /** Send a command, taking control before if nobody has it. */
  async send(command) {
    const free = await this.office.haveControl(this);
    return free ? this.office.command(this.bench, command) : { accepted: false, message: `${this.control.holder ?? "Somebody else"} has control: ask for it first.` };
  }

  async order(command) {
    const answer = await this.send(command);
    if (!answer.accepted) this.refused(answer.message);
    this.refresh();
  }

  run(commands, focusSlider) {
    this.refuse("");
    this.steering.focusWhenSteering = focusSlider;
    this.sequence.start(commands);
    this.refresh();
  }

  refused(message) {
    this.refuse(message);
    announce(message);
    this.refresh();
  }

  stopPressed() {
    this.sequence.cancel();
    this.steering.focusWhenSteering = false;
  }

  /** Take a whole state in. */
  setState(state) {
    const before = this.state;
    if (before && state.revision < before.revision) return;
    this.state = state;
    this.sequence.follow(state);
    if (state.model) this.useQuantity(state.model.quantity);
    if (state.model !== before?.model || state.loop?.recording !== before?.loop?.recording) this.setCurves(before);
    if (before?.phase !== state.phase) this.phaseChanged(state);
    if (state.metrics?.text && state.metrics.text !== before?.metrics?.text) announce(state.metrics.text);
    this.refresh();
  }

  phaseChanged(state) {
    for (const layout of this.layouts.values()) layout.read = null; // a rig that was opened again may be another
    const verdict = verdictOf(state);
    if (!verdict) announce(`${this.bench}: ${state.phase === "busy" ? state.doing?.title ?? "running" : PHASES[state.phase]}`);
    this.parts.verdict.replaceChildren(...(verdict ? [el("strong", {}, verdict[0]), el("span", {}, verdict[1])] : []));
  }

  setControl(control) {
    this.control = control;
    this.refresh();
  }

  /** Write everything that follows from the state; the rows have their own time. */
  refresh() {
    const { state, parts, control } = this;
    if (!state) return;
    const isRunning = this.sequence.isRunning;
    this.root.dataset.phase = state.phase;
    this.root.toggleAttribute("data-model", Boolean(state.model));
    setText(parts.name, state.rig?.name ?? this.bench);
    setText(parts.subtitle, subtitle(state));
    setText(parts.phase, PHASES[state.phase] ?? state.phase);
    show(parts.end, state.phase === "busy");
    parts.end.disabled = !control.you_hold;
    this.showClock(state);
    setText(parts.holder, holderWords(control));
    parts.holder.classList.toggle("mine", control.you_hold);
    setText(parts.ask, control.you_hold ? "Give it up" : control.holder ? "Ask for control" : "Take control");
    show(parts.asked, control.you_hold && Boolean(control.asked_by));
    setText(parts["asked-text"], control.asked_by ? `${control.asked_by} asks for control.` : "");
    this.guide.follow(state, isRunning);
    this.runs.follow(state, isRunning);
    this.steering.follow(state, control, isRunning);
    this.recordings.follow(state.recordings);
    this.protection.follow(state);
    this.plots.limit = this.protection.limit ? this.protection.limit - KELVIN : null;
    const range = state.model ? [state.model.lowest, state.model.highest] : null;
    this.gauge.setScale(this.quantity, Math.min(0, range?.[0] ?? 0), (range?.[1] ?? 0.045) * 1.08, range);
    parts.limits.replaceChildren(limitsTable(state));
    setText(parts["model-words"], modelWords(state.model, state.loop));
    showMessages(parts.messages, state);
    if (state.phase !== "busy") this.controller.showRules(null);
    this.dirty = true;
  }

  showClock(state) {
    const { parts } = this;
    show(parts.clock, Boolean(state.rig?.simulated));
    parts.clock.dataset.speed = String(state.clock_speed ?? 1);
    setText(parts["clock-text"], clockWords(state));
    const select = parts["clock-speed"];
    const speed = String(state.clock_speed ?? 1);
    if (document.activeElement === select) return;
    if (![...select.options].some((option) => option.value === speed)) select.append(el("option", { value: speed }, `\u00d7\u202f${speed}`));
    select.value = speed;
  }

  /** Take rows of the server in. */
  addRows({ layout, columns, rows, rules }) {
    if (columns) this.layouts.set(layout, { columns, read: null });
    const known = this.layouts.get(layout);
    if (!known) return;
    const sensed = quantityOf(known.columns);
    if (sensed) this.useQuantity(sensed);
    known.read ??= rowReader(known.columns, this.reading());
    for (const row of rows) this.history.push(known.read(row));
    if (rules !== undefined) this.rules = rules;
    this.dirty = true;
  }

  reading() {
    const rig = this.state?.rig;
    return { quantity: this.quantity, leg_length_m: rig?.leg_length_m ?? null, shunt_resistance_ohm: rig?.shunt_resistance_ohm ?? null, minimum_current_a: rig?.limits?.minimum_current_a ?? 1e-4 };
  }

  useQuantity(quantity) {
    if (quantity === this.quantity || !(quantity in QUANTITIES)) return;
    this.quantity = quantity;
    for (const layout of this.layouts.values()) layout.read = null;
    this.history.clear();
    this.plots.showQuantity(quantity);
    setText(this.parts["plane-title"], `${QUANTITIES[quantity].name} over resistance`);
  }

  /** Draw what has come since the last time. `now_ms` is the time of the frame. */
  draw(now_ms) {
    if (!this.state) return false;
    if (this.numbersDue && now_ms - this.numbers_ms >= NUMBERS_MS) {
      this.numbersDue = false;
      this.numbers_ms = now_ms;
      this.writeNumbers();
    }
    if (!this.dirty) return false;
    this.dirty = false;
    this.numbersDue = true;
    this.plots.draw();
    this.plane.draw(this.history);
    this.gauge.draw(this.shown());
    return true;
  }

  shown() {
    const last = (column) => this.history.recent.last(column);
    return { target: last(COLUMN.target), estimate: last(COLUMN.estimate), instrument: last(COLUMN.instrument), temperature: last(COLUMN.temperature), limit: this.plots.limit };
  }

  writeNumbers() {
    const { state } = this;
    const last = (column) => this.history.recent.last(column);
    const { target, estimate, instrument, temperature, limit } = this.shown();
    const { name, unit, digits } = QUANTITIES[this.quantity];
    const value = estimate ?? instrument;
    const margin = temperature === null || limit === null ? null : limit - temperature;
    this.numbers.write({
      value: { name: estimate === null ? `${name}, instrument` : `${name}, estimated`, figure: fixed(value, digits), unit, below: besides(target, estimate, instrument, digits) },
      resistance: { figure: fixed(last(COLUMN.resistance), 2), unit: "\u03a9", below: last(COLUMN.resistance) === null ? "no current to sense with" : "" },
      drive: { figure: fixed(last(COLUMN.drive), 2), unit: "V", below: state.rig ? `of ${fixed(state.rig.maximum_voltage_v, 2)}\u202fV at most` : "" },
      current: { figure: fixed(last(COLUMN.current), 0), unit: "mA" },
      power: { figure: fixed(last(COLUMN.power), 0), unit: "mW" },
      temperature: { figure: fixed(temperature, 0), unit: "\u00b0C", below: margin === null ? "" : `${fixed(margin, 0)}\u202fK to the limit`, near: margin !== null && margin < 15 },
    });
    this.plots.writeValues();
    this.protection.draw(temperature);
    this.controller.draw(this.history, state.gains);
    if (state.phase === "busy") this.controller.showRules(this.rules);
    this.showProgress();
  }

  showProgress() {
    const { state, parts } = this;
    const run_s = this.history.recent.last(COLUMN.run) ?? NaN;
    setText(parts.doing, state.phase === "busy" ? doingWords(state, run_s) : state.metrics?.text ?? "");
    const length_s = state.phase === "busy" && !state.doing?.steering ? state.doing?.duration_s : null;
    show(parts.progress, Boolean(length_s));
    if (length_s && Number.isFinite(run_s)) parts.progress.value = Math.min(1, run_s / length_s);
  }

  /** Lay an earlier run over the plots, from the beginning of the present run; null takes it away. */
  compare(columns, name) {
    const recent = this.history.recent;
    const begin_s = (recent.last(COLUMN.time) ?? 0) - (recent.last(COLUMN.run) ?? recent.last(COLUMN.time) ?? 0);
    this.plots.compared = columns && { columns, begin_s };
    this.compared = columns && { columns, name };
    this.setCurves(this.state);
    this.dirty = true;
  }

  /** Set the curves of the plane: the model's branches, the recorded loop, the run to compare with. */
  setCurves(before) {
    const { model, loop } = this.state;
    const { factor } = QUANTITIES[this.quantity];
    const curves = [];
    if (loop?.recording && loop.recording !== this.loopName) this.fetchLoop(loop.recording);
    if (this.loopColumns) curves.push({ ...planeCurve(this.loopColumns), colour: "line-strong", width: 1.2 });
    if (this.compared) curves.push({ ...planeCurve(this.compared.columns), colour: "compared", width: 1.4, dash: [2, 3] });
    for (const [name, branch] of Object.entries(model?.branches ?? {})) {
      curves.push({ x: branch.resistance_ohm, y: branch.value.map((value) => value * factor), colour: name, width: 2.6 });
    }
    this.plane.setCurves(this.quantity, curves);
    const key = (kind, text) => el("li", { class: `key ${kind}` }, text);
    this.parts["plane-legend"].replaceChildren(
      key("key-target dot", "now"), key("key-text", "lately"),
      ...(model ? [key("key-heating", "heating branch"), key("key-cooling", "cooling branch")] : []),
      ...(this.loopColumns ? [key("key-loop", "recorded loop")] : []), ...(this.compared ? [key("key-compared dashed", this.compared.name)] : []),
    );
    const words = `${QUANTITIES[this.quantity].name} over resistance: ${model ? "both branches of the model, " : ""}${this.loopColumns ? "the recorded loop, " : ""}the last values and the present point`;
    this.parts.plane.setAttribute("aria-label", words);
    return before;
  }

  async fetchLoop(name) {
    this.loopName = name;
    try {
      this.loopColumns = await fetchColumns(name, this.reading(), 800);
      this.setCurves(this.state);
    } catch (problem) {
      this.loopColumns = null;
    }
  }

  recolour() {
    this.plots.recolour();
    this.plane.draw();
    this.dirty = true;
  }
}

function planeCurve(columns) {
  const measured = columns[COLUMN.instrument];
  const y = measured.some((value) => value !== null) ? measured : columns[COLUMN.estimate];
  return { x: columns[COLUMN.resistance], y };
}

function subtitle({ rig }) {
  if (!rig) return "";
  const parts = [];
  if (rig.wire) parts.push(rig.wire);
  if (rig.wire_diameter_m) parts.push(`\u00d8 ${fixed(rig.wire_diameter_m * 1e6, 0)}\u202f\u00b5m`);
  if (rig.wire_length_m) parts.push(`${fixed(rig.wire_length_m * 1e3, 0)}\u202fmm`);
  if (rig.pretension_n) parts.push(`pretension ${fixed(rig.pretension_n, 2)}\u202fN`);
  return parts.join(", ");
}

function besides(target, estimate, instrument, digits) {
  const parts = [];
  if (target !== null) parts.push(`target ${fixed(target, digits)}`);
  if (estimate !== null && instrument !== null) parts.push(`instrument ${fixed(instrument, digits)}`);
  return parts.join(", ");
}
