/** The guided first use: a short list of steps, the next one large, each with what it does and one button. */

import { el, renew, show, table } from "./dom.js";
import { namedValue, sentence, withUnit } from "./format.js";

const SLOW_LOOP = { do: "characterize", amplitude_v: null, period_s: 90, cycles: 2 };
// A simulated rig need not keep anybody waiting for its slow loop.
const QUICK = 20;

/** Return the commands that record the slow loop and fit the model; a simulated rig runs faster meanwhile. */
export function loopCommands(state, loop = SLOW_LOOP, quantity = "strain") {
  const fit = { do: "fit", quantity };
  if (!state.rig?.simulated) return [loop, fit];
  const usual = state.clock_speed ?? 1;
  return [{ do: "clock_speed", factor: Math.max(QUICK, usual) }, loop, { do: "clock_speed", factor: usual > 1 ? 1 : usual }, fit];
}

const STEPS = [
  {
    key: "switched_on", title: "Wire it up", button: "Switch on and check the wiring",
    body: (state) => [
      el("p", {}, "What to wire, with the supply off:"),
      el("ul", {}, ...(state.rig?.wiring ?? state.wiring ?? []).map((line) => el("li", {}, line))),
      el("p", {}, "Switching on senses at a small voltage. Nothing is heated."),
    ],
    commands: () => [{ do: "switch_on" }, { do: "doctor" }],
  },
  {
    key: "doctor", title: "Check the wiring", button: "Check the wiring",
    body: (state) => [state.doctor ? findings(state.doctor) : el("p", {}, "Wiring, noise, polarity and sample clock are measured. Nothing is heated.")],
    commands: () => [{ do: "doctor" }],
    done: (state, goesOn) => Boolean(state.doctor) && (goesOn || (state.steps.doctor && state.doctor.ok !== false)),
  },
  {
    key: "pulse", title: "Safe limits, then a warm pulse", button: "Warm the wire for 1 s",
    body: (state) => [
      el("p", {}, "The bench switches the drive off beyond these limits, whatever a page asks for:"),
      limitsTable(state, MAIN_LIMITS),
      el("p", {}, "The pulse is a part of the slow loop's voltage. Watch the wire, or the plot of resistance, move a little."),
    ],
    commands: () => [{ do: "pulse", drive_voltage_v: null, duration_s: 1.0 }],
  },
  {
    key: "loop", title: "Record the first loop", button: "Record the slow loop",
    body: (state) => [
      el("p", {}, `Two slow cycles of 90 s up to ${withUnit(state.rig?.drive_amplitude_v, 2, "V")} show what the resistance says of the strain.`),
      state.rig?.simulated ? el("p", {}, `This rig is simulated: the loop runs ${QUICK} times as fast as the clock.`) : null,
    ],
    commands: (state) => loopCommands(state),
  },
  {
    key: "model", title: "Fit the model", button: "Fit the model",
    body: () => [el("p", {}, "Two branches, heating and cooling, through the recorded loop.")],
    commands: () => [{ do: "fit", quantity: "strain" }],
  },
  {
    key: "moved", title: "Move the wire", button: "Follow the slider",
    body: (state) => [el("p", {}, state.doing?.steering ? "The wire follows: move the slider, or use the arrow keys." : "The loop closes by the resistance alone. Then move the slider, or use the arrow keys.")],
    commands: () => [{ do: "control", controller: null, estimator: null, settings: null, reference: { kind: "steer", start: null } }],
    thenFocus: true,
  },
];

const AGAIN = -2; // in the place of a step's number: the rig is to be switched on again
const MAIN_LIMITS = /temperature|voltage|current|power|force/;

function isDone(step, state, goesOn) {
  return Boolean(step.done ? step.done(state, goesOn) : state.steps?.[step.key]);
}

/** Return the table of the limits whose names match. */
export function limitsTable(state, names = /./) {
  const rows = Object.entries(state.rig?.limits ?? {}).filter(([name, value]) => names.test(name) && value !== null);
  if (state.rig?.maximum_force_n) rows.push(["maximum_force_n", state.rig.maximum_force_n]);
  if (!rows.length) return el("p", { class: "hint" }, "Shown once the rig is switched on.");
  return table("Safe limits of this wire", [{ text: "Limit" }, { text: "Value", number: true }], rows.map(([name, value]) => namedValue(name, value)));
}

/** Return the doctor's findings as a list. */
function findings(doctor) {
  const line = (kind, name, text) => el("li", { class: `finding ${kind}` }, el("span", {}, el("b", {}, sentence(name.replaceAll("_", " "))), text ? `: ${text}` : ""));
  return el(
    "ul", { class: "findings" },
    ...doctor.checks.map((check) => line(check.ok ? "" : "bad", check.name, check.text)),
    ...doctor.skipped.map((check) => line("skipped", check.name, check.text)),
  );
}

export class Guide {
  /** `run` is called with commands, and whether the slider is to be focused once they run. */
  constructor(list, card, run) {
    this.list = list;
    this.card = card;
    this.run = run;
    this.goesOn = false;
  }

  follow(state, isRunning) {
    show(this.card, Boolean(state.steps)); // a bench whose process has not yet spoken has none
    if (!state.steps) return;
    this.state = state;
    if (state.doctor?.ok) this.goesOn = false;
    const next = STEPS.findIndex((step) => !isDone(step, state, this.goesOn));
    const off = !["ready", "busy", "ending", "starting"].includes(state.phase);
    const shown = off && next !== 0 ? AGAIN : next;
    const canGo = !isRunning && ["ready", "off", "stopped", "failed"].includes(state.phase);
    const key = JSON.stringify([shown, this.goesOn, canGo, isRunning, state.phase, state.doctor, state.steps, Boolean(state.rig), state.wiring, state.rig?.limits, state.doing?.steering]);
    this.keepsFocus ||= this.list.contains(document.activeElement);
    renew(this.list, key, () => this.items(state, shown, canGo, isRunning));
    // A button that was pressed and is made again would leave the keyboard nowhere: the next one takes its place.
    const nextButton = this.list.querySelector(".primary:not(:disabled)");
    if (this.keepsFocus && nextButton && document.activeElement === document.body) nextButton.focus();
    if (document.activeElement !== document.body) this.keepsFocus = this.list.contains(document.activeElement);
    // What has been done once needs no room any more, unless the rig is to be switched on again.
    show(this.card, next >= 0 || off);
  }

  items(state, next, canGo, isRunning) {
    const again = next === AGAIN ? [this.againItem(canGo)] : [];
    return [...again, ...STEPS.map((step, place) => this.item(step, state, place === next, canGo, isRunning))];
  }

  /** A finding may be known and harmless, as a sample that comes late on a busy machine: a person may go on. */
  goOn(canGo) {
    const go = () => {
      this.goesOn = true;
      this.follow(this.state, false);
    };
    return el("button", { type: "button", class: "quiet", disabled: !canGo, onclick: go }, "I have read this: go on");
  }

  againItem(canGo) {
    const button = el("button", { type: "button", class: "primary", disabled: !canGo, onclick: () => this.run([{ do: "switch_on" }]) }, "Switch on again");
    return el("li", { class: "step again", "data-state": "next" }, el("div", {}, el("h3", {}, "Switch on again"), el("p", {}, "What was found out so far is kept."), button));
  }

  item(step, state, isNext, canGo, isRunning) {
    const done = isDone(step, state, this.goesOn);
    const body = el("div", {}, el("h3", {}, step.title, el("span", { class: "unseen" }, done ? ", done" : isNext ? ", next" : ", later")));
    if (isNext) {
      body.append(...step.body(state).filter(Boolean));
      const text = isRunning || state.phase === "busy" ? (state.doing?.steering ? "Now move the slider" : "Running\u2026") : step.button;
      body.append(el("button", { type: "button", class: "primary", disabled: !canGo, onclick: () => this.run(step.commands(state), step.thenFocus) }, text));
      if (step.key === "doctor" && state.doctor?.ok === false) body.append(this.goOn(canGo));
    } else if (step.key === "doctor" && state.doctor) {
      body.append(el("details", {}, el("summary", {}, state.doctor.count), findings(state.doctor)));
    }
    return el("li", { class: "step", "data-state": done ? "done" : isNext ? "next" : "later" }, body);
  }
}
