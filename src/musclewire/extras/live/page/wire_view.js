/** One wire on the page: takes its states and rows in, and keeps all its parts true. */

import { announce } from "./announce.js";
import { el, partsOf, setText, show } from "./dom.js";
import { fixed, KELVIN, QUANTITIES } from "./format.js";
import { Gauge } from "./gauge.js";
import { Guide, limitsTable } from "./guide.js";
import { isOff, Numbers, numberTiles } from "./numbers.js";
import { ControllerPanel, plotTable, ProtectionPanel, showMessages, showNotes } from "./panels.js";
import { Plane } from "./plane.js";
import { PlaneCurves } from "./plane_curves.js";
import { Recordings } from "./recordings.js";
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
// Between two samples the plots go on for so long; then what is shown stands still.
const MOVING_MS = 150;
const calm = matchMedia("(prefers-reduced-motion: reduce)");
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
    this.rows_ms = 0;
    this.end_s = 0;
    this.state = null;
    this.rules = null;
    this.build();
  }

  build() {
    const { parts } = this;
    const refuse = (this.refuse = (text) => setText(parts.refusal, text));
    this.sequence = new Sequence((command) => this.send(command), (message) => this.refused(message), () => this.refresh());
    const run = (commands, focusSlider = false) => this.run(commands, focusSlider);
    this.numbers = new Numbers(parts.numbers);
    this.gauge = new Gauge(parts.gauge);
    this.plots = new TimePlots(parts.plots, this.history);
    this.plots.showQuantity(this.quantity);
    this.plane = new Plane(parts.plane);
    this.curves = new PlaneCurves(this.plane, parts, () => this.reading());
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
    this.curves.follow(state, this.quantity);
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
    showNotes(parts["model-notes"], state.model?.warnings ?? []);
    showMessages(parts.messages, state);
    if (state.phase !== "busy") this.controller.showRules(null);
    this.isNew = this.dirty = true;
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
    for (const row of rows) this.addRow(known.read(row));
    if (rules !== undefined) this.rules = rules;
    this.rows_ms = performance.now();
    this.isNew = this.dirty = true;
  }

  addRow(row) {
    const run_s = row[COLUMN.run];
    const before_s = this.history.recent.last(COLUMN.run);
    if (run_s !== null && (before_s === null || run_s < before_s)) this.runBegins(row[COLUMN.time] - run_s);
    this.history.push(row);
  }

  /** A run that is shown for comparison begins where the present one begins. */
  runBegins(begin_s) {
    this.begin_s = begin_s;
    if (this.plots.compared) this.plots.compared.begin_s = begin_s;
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
    this.numbersDue = true;
    this.plots.draw(this.endOfWindow(now_ms));
    if (this.isNew) {
      this.plane.draw(this.history);
      this.gauge.draw(this.shown());
    }
    this.isNew = false;
    this.dirty = now_ms - this.rows_ms < MOVING_MS;
    return true;
  }

  /** Return the time at the right edge: it goes on with the rig's clock between two samples, so that plots glide. */
  endOfWindow(now_ms) {
    const last = this.history.recent.last(COLUMN.time) ?? 0;
    const gone_s = (Math.max(0, now_ms - this.rows_ms) / 1000) * (this.state.clock_speed || 1);
    const most_s = (MOVING_MS / 1000) * (this.state.clock_speed || 1);
    const end = last + (calm.matches || isOff(this.state) ? 0 : Math.min(gone_s, most_s));
    // It never goes back by so little; a clock that began again goes back by more.
    this.end_s = end < this.end_s && this.end_s - end <= 2 * most_s ? this.end_s : end;
    return this.end_s;
  }

  shown() {
    const last = (column) => this.history.recent.last(column);
    return { target: last(COLUMN.target), estimate: last(COLUMN.estimate), instrument: last(COLUMN.instrument), temperature: last(COLUMN.temperature), limit: this.plots.limit };
  }

  writeNumbers() {
    const { state } = this;
    const shown = this.shown();
    this.numbers.write(numberTiles(this.history.recent, shown, state, this.quantity));
    this.steering.followRow(shown.target);
    this.plots.writeValues();
    this.protection.draw(isOff(state) ? null : shown.temperature);
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
    const begin_s = this.begin_s ?? this.history.recent.last(COLUMN.time) ?? 0;
    this.plots.compared = columns && { columns, begin_s };
    this.curves.compare(columns && { columns, name });
    this.dirty = true;
  }

  recolour() {
    this.plots.recolour();
    this.plane.draw();
    this.dirty = true;
  }
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
