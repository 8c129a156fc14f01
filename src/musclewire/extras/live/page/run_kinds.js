/** The kinds of runs that the page can start: their fields, and the command that these make. */

import { loopCommands } from "./guide.js";
import { QUANTITIES } from "./format.js";

const number = (name, label, unit, value, more = {}) => ({ name, label, unit, value, ...more });

/** Return the unit, factor and range of targets for a state. */
export function targetScale(state) {
  const shown = QUANTITIES[state.model?.quantity ?? "strain"];
  const lowest = (state.model?.lowest ?? 0) * shown.factor;
  const highest = (state.model?.highest ?? 0) * shown.factor;
  return { ...shown, lowest, highest, round: (value) => Number(value.toFixed(shown.digits)) };
}

/** Return limits that a field of a target has: those of the model, inwards to the digits that are shown. */
function within(scale) {
  const grain = 10 ** -scale.digits;
  return { min: Number((Math.ceil(scale.lowest / grain - 1e-9) * grain).toFixed(scale.digits)), max: Number((Math.floor(scale.highest / grain + 1e-9) * grain).toFixed(scale.digits)) };
}

function closedLoop(values, reference) {
  return [{ do: "control", controller: values.controller || null, estimator: values.estimator || null, settings: null, reference }];
}

const choices = (state) => [
  { name: "controller", label: "Controller", options: ["", ...(state.controllers ?? [])] },
  { name: "estimator", label: "Estimator", options: ["", ...(state.estimators ?? [])] },
];

/** The kinds in their order; `needsModel` says which close the loop. */
export const KINDS = [
  {
    key: "steer", label: "Slider", needsModel: true, button: "Follow the slider", focusSlider: true,
    hint: "The target goes where you move the slider, until you end the run.",
    fields: choices,
    commands: (values) => closedLoop(values, { kind: "steer", start: null }),
  },
  {
    key: "staircase", label: "Staircase", needsModel: true, button: "Start the staircase",
    hint: "Steps up and back down.",
    fields: (state) => {
      const scale = targetScale(state);
      const wide = scale.highest - scale.lowest;
      const target = { step: 10 ** -scale.digits, ...within(scale) };
      return [
        number("start", "From", scale.unit, scale.round(scale.lowest + 0.2 * wide), target),
        number("stop", "To", scale.unit, scale.round(scale.lowest + 0.8 * wide), target),
        number("step", "Step", scale.unit, scale.round(0.15 * wide), { step: 10 ** -scale.digits, min: 10 ** -scale.digits }),
        number("hold_s", "Hold each", "s", 6, { step: 0.5, min: 0.5 }),
        ...choices(state),
      ];
    },
    commands: (v, { factor }) => closedLoop(v, { kind: "staircase", start: v.start / factor, stop: v.stop / factor, step: v.step / factor, hold_s: v.hold_s }),
  },
  {
    key: "sine", label: "Sine", needsModel: true, button: "Start the sine",
    fields: (state) => {
      const scale = targetScale(state);
      const wide = scale.highest - scale.lowest;
      return [
        number("middle", "Middle", scale.unit, scale.round(scale.lowest + 0.5 * wide), { step: 10 ** -scale.digits, ...within(scale) }),
        number("amplitude", "Amplitude", scale.unit, scale.round(0.25 * wide), { step: 10 ** -scale.digits, min: 10 ** -scale.digits }),
        number("period_s", "Period", "s", 20, { step: 1, min: 0.5 }),
        number("cycles", "Cycles", "", 3, { step: 1, min: 1, max: 1000, whole: true }),
        ...choices(state),
      ];
    },
    commands: (v, { factor }) => closedLoop(v, { kind: "sine", middle: v.middle / factor, amplitude: v.amplitude / factor, period_s: v.period_s, cycles: v.cycles }),
  },
  {
    key: "path", label: "Drawn path", needsModel: true, button: "Follow the path", drawsPath: true,
    fields: (state) => [number("duration_s", "Duration", "s", 30, { step: 1, min: 2, max: 3600 }), ...choices(state)],
    commands: (v, { factor }) => closedLoop(v, { kind: "path", time_s: v.points.map(([time]) => time), target: v.points.map(([, target]) => target / factor) }),
  },
  {
    key: "loop", label: "Slow loop", button: "Record the loop and fit",
    hint: "Slow sine of the drive up to the amplitude; the model is fitted to it.",
    fields: (state) => [
      number("amplitude_v", "Amplitude", "V", state.rig?.drive_amplitude_v ?? null, { step: 0.01, min: 0.01, max: state.rig?.maximum_voltage_v ?? null, optional: true }),
      number("period_s", "Period", "s", 90, { step: 1, min: 1 }),
      number("cycles", "Cycles", "", 2, { step: 1, min: 1, max: 100, whole: true }),
      { name: "quantity", label: "Model of", options: ["strain", "displacement", "force"] },
    ],
    commands: (v, _, state) => loopCommands(state, { do: "characterize", amplitude_v: v.amplitude_v, period_s: v.period_s, cycles: v.cycles }, v.quantity),
  },
  {
    key: "home", label: "Home", needsModel: true, button: "Make a home move",
    hint: "One sweep at the known load brings the model up to date with the wire of today.",
    fields: () => [],
    commands: () => [{ do: "home" }],
  },
  {
    key: "pretension", label: "Pretension", needsStage: true, button: "Sweep the pretension",
    hint: "Characterizes the wire at several pretensions and compares the gaps of the loops.",
    fields: () => [{ name: "pretensions_n", label: "Pretensions, between spaces (empty: the usual ones)", unit: "N", text: true }],
    commands: (v, _, state) => {
      const sweep = { do: "sweep_pretension", pretensions_n: v.pretensions_n };
      if (!state.rig?.simulated) return [sweep];
      return [{ do: "clock_speed", factor: 100 }, sweep, { do: "clock_speed", factor: 1 }];
    },
    shows: "pretensions",
  },
  {
    key: "pulse", label: "Warm pulse", button: "Warm the wire",
    hint: "Leave the voltage empty for the bench's safe part of the amplitude.",
    fields: (state) => [
      number("drive_voltage_v", "Voltage", "V", null, { step: 0.01, min: 0.01, max: state.rig?.maximum_voltage_v ?? null, optional: true }),
      number("duration_s", "Duration", "s", 1, { step: 0.1, min: 0.1, max: 10 }),
    ],
    commands: (v) => [{ do: "pulse", drive_voltage_v: v.drive_voltage_v, duration_s: v.duration_s }],
  },
  { key: "doctor", label: "Check wiring", button: "Check the wiring", hint: "Nothing is heated.", fields: () => [], commands: () => [{ do: "doctor" }] },
];

/** Return why a kind of run cannot be started now, or "". */
export function obstacle(kind, state) {
  if (!["ready", "busy", "ending"].includes(state.phase)) return "Switch on first.";
  if (kind.needsModel && !state.model) return "Fit a model first: record the slow loop.";
  if (kind.needsStage && !state.rig?.has_stage) return "This rig has no stage that sets the pretension.";
  return "";
}

/** Return the value of a field's text: a number, a list of numbers, null if it may be empty. Throws a sentence for anything else. */
export function readField(field, text) {
  const trimmed = text.trim();
  if (field.options) return trimmed;
  if (field.text) {
    if (!trimmed) return null;
    const values = trimmed.split(/[\s;]+/).map((each) => Number(each.replace(",", ".")));
    if (values.some((value) => !(value > 0))) throw new Error(`${field.label}: write numbers above 0, as "1.2 1.5 1.8".`);
    return values;
  }
  if (!trimmed && field.optional) return null;
  const value = Number(trimmed.replace(",", "."));
  if (!trimmed || !Number.isFinite(value)) throw new Error(`${field.label}: write a number.`);
  if (field.min !== undefined && field.min !== null && value < field.min) throw new Error(`${field.label}: at least ${field.min} ${field.unit}.`);
  if (field.max !== undefined && field.max !== null && value > field.max) throw new Error(`${field.label}: at most ${field.max} ${field.unit}.`);
  if (field.whole && !Number.isInteger(value)) throw new Error(`${field.label}: write a whole number.`);
  return value;
}
