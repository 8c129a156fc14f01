/** States in words. Pure. */

import { fixed, sentence, span } from "./format.js";

export const PHASES = {
  starting: "Starting", off: "Off", ready: "Ready", busy: "Running", ending: "Ending", stopped: "Stopped", failed: "Failed",
};

/** Return the large word and the sentence of a state in which the wire is not driven, or null. */
export function verdictOf(state) {
  if (state.phase === "stopped") return ["STOPPED", closed(state.why || "the drive is off; switch on again when you know why")];
  if (state.phase === "failed") return ["FAILED", closed(state.why || "the rig has failed and the drive is off; see the messages")];
  return null;
}

/** Return a line as a sentence. */
function closed(line) {
  const text = sentence(line);
  return /[.!?]$/.test(text) ? text : `${text}.`;
}

/** Return how fast the clock of the rig runs, in words. */
export function clockWords(state) {
  const speed = state.clock_speed ?? 1;
  if (speed === 1) return "Simulated rig, as fast as the clock";
  return `Simulated rig, ${short(speed)} times as fast as the clock`;
}

function short(speed) {
  return Number.isInteger(speed) ? String(speed) : fixed(speed, 1);
}

/** Return who has control, in words. */
export function holderWords(control) {
  if (control.you_hold) return "You have control";
  return control.holder ? `${control.holder} has control, you watch` : "Nobody has control";
}

const GUARD = {
  off: "Protection: the output is off",
  armed: "Protection: armed, nothing is driven",
  run: "Protection: all in order",
  hold: "Protection holds the drive",
  degraded: "Protection has gone to the sense voltage",
  tripped: "Protection has switched the drive off",
};
const OFF = new Set(["off", "stopped", "failed"]);
const CALM = new Set(["off", "armed", "run"]);

/** Return the state of the protection, in words. */
export function guardWords(protection, phase) {
  if (!protection) return "Protection: not running";
  if (OFF.has(phase) && protection.state !== "tripped") return GUARD.off;
  const parts = [GUARD[protection.state] ?? `Protection: ${protection.state}`];
  const event = [protection.event, protection.cause].filter(Boolean).join(", ");
  if (event && !CALM.has(protection.state)) parts.push(event);
  if (protection.remedy && !CALM.has(protection.state)) parts.push(protection.remedy);
  return parts.join(". ");
}

/** Return what runs, with the time that is left on the clock on the wall. */
export function doingWords(state, run_s) {
  const { doing } = state;
  if (!doing) return "";
  if (doing.steering || !doing.duration_s || !Number.isFinite(run_s)) return doing.title;
  const left_s = Math.max(0, doing.duration_s - run_s) / (state.clock_speed || 1);
  return `${doing.title}, ${span(left_s)} left`;
}

/** Return what the fit of a model says of itself, in words. */
export function modelWords(model, loop) {
  if (model) {
    const gap = model.gap_pct === null || model.gap_pct === undefined ? "" : `, gap of the loop ${fixed(model.gap_pct, 2)}\u202f%`;
    return `Model ${model.file}${gap}.`;
  }
  if (!loop) return "No loop has been recorded in this session.";
  if (loop.shows_c === false) return `Loop ${loop.recording}: it does not reach the end of the transformation.`;
  return `Loop ${loop.recording}, no model fitted yet.`;
}
