/** The slider of the target: keyboard arrows, a numeric field, the limits of the model; sends the newest value only. */

import { fixed } from "./format.js";
import { setText, show } from "./dom.js";
import { targetScale } from "./run_kinds.js";

const BETWEEN_MS = 50;

export class Steering {
  /** `send` sends a target in SI and returns a promise of its answer; `start` begins a loop that follows the slider. */
  constructor(parts, { send, start, refuse }) {
    this.parts = parts;
    this.send = send;
    this.refuse = refuse;
    this.waiting = null;
    this.isSending = false;
    const { slider } = parts;
    const field = parts["slider-number"];
    slider.addEventListener("input", () => this.moved(Number(slider.value)));
    field.addEventListener("change", () => this.moved(Number(field.value)));
    field.addEventListener("keydown", (event) => event.key === "Enter" && this.moved(Number(field.value)));
    parts.steer.addEventListener("click", start);
  }

  moved(value) {
    if (!this.canSteer || !Number.isFinite(value)) return;
    const { lowest, highest, unit, digits } = this.scale;
    if (value < lowest || value > highest) {
      this.refuse(`The model reaches from ${fixed(lowest, digits)} to ${fixed(highest, digits)} ${unit}.`);
      return;
    }
    this.refuse("");
    this.isUnmoved = false;
    this.show(value);
    this.waiting = value / this.scale.factor;
    if (!this.isSending) this.sendNewest();
  }

  /** Send one value at a time, and what it has been moved to by its answer: however late answers come, the last arrives. */
  async sendNewest() {
    this.isSending = true;
    while (this.waiting !== null) {
      const value = this.waiting;
      this.waiting = null;
      const pause = new Promise((resolve) => setTimeout(resolve, BETWEEN_MS));
      const answer = await this.send(value).catch((problem) => ({ accepted: false, message: String(problem) }));
      if (!answer.accepted && this.waiting === null) {
        this.refuse(answer.message);
        this.isUnmoved = true; // what was refused is not where the loop's target is: the next row shows that
      }
      await pause;
    }
    this.isSending = false;
  }

  /** Take the target of the newest row: where a loop began, and where somebody else moves it. */
  followRow(target) {
    if (target === null || !(this.isOthers || (this.isUnmoved && this.canSteer))) return;
    this.isUnmoved = false;
    this.show(target);
  }

  show(value) {
    const { slider } = this.parts;
    const field = this.parts["slider-number"];
    const { unit, digits } = this.scale;
    slider.value = value;
    if (document.activeElement !== field || Number(field.value) !== value) field.value = value.toFixed(digits);
    slider.setAttribute("aria-valuetext", `${value.toFixed(digits)} ${unit === "%" ? "percent" : unit}`);
  }

  follow(state, control, isRunning) {
    const { parts } = this;
    const { slider } = parts;
    const scale = targetScale(state);
    const limits = [scale.lowest, scale.highest].join();
    if (state.model && limits !== this.limits) {
      this.limits = limits;
      const grain = 10 ** -scale.digits;
      slider.min = Math.ceil(scale.lowest / grain) * grain;
      slider.max = Math.floor(scale.highest / grain) * grain;
      slider.step = scale.step;
      Object.assign(parts["slider-number"], { min: slider.min, max: slider.max, step: scale.step });
    }
    this.scale = scale;
    const isSteering = state.phase === "busy" && Boolean(state.doing?.steering);
    const began = isSteering && !this.wasSteering;
    this.wasSteering = isSteering;
    this.canSteer = isSteering && control.you_hold;
    if (began || !this.canSteer) this.waiting = null; // a target of the loop before is none of this one
    for (const input of [slider, parts["slider-number"]]) input.disabled = !this.canSteer;
    setText(parts["slider-name"], `Target ${scale.name.toLowerCase()}`);
    setText(parts["slider-unit"], scale.unit);
    show(parts.steer, Boolean(state.model) && !isSteering);
    parts.steer.disabled = isRunning || state.phase !== "ready";
    setText(parts["slider-hint"], this.hint(state, control, isSteering));
    this.isOthers = isSteering && !this.canSteer;
    // Where a loop begins that was given no start; a key that is pressed before the first row must not make it jump.
    if (began && this.canSteer) this.show((scale.lowest + scale.highest) / 2);
    if (began) this.isUnmoved = true;
    if (began && this.canSteer && this.focusWhenSteering) {
      this.focusWhenSteering = false;
      slider.focus({ preventScroll: false });
    }
  }

  hint(state, control, isSteering) {
    if (!state.model) return "The slider needs a model: record the slow loop and fit it.";
    const { lowest, highest, digits, unit } = this.scale;
    const range = `The model reaches from ${fixed(lowest, digits)} to ${fixed(highest, digits)} ${unit}.`;
    if (isSteering && !control.you_hold) return `${control.holder ?? "Somebody else"} moves the slider. ${range}`;
    return isSteering ? `Arrow keys: ${this.scale.step} ${unit} a press. ${range}` : range;
  }
}
