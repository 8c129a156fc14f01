/** The stop button: Escape and the button, for everybody, at once; over the WebSocket and over HTTP, whichever works. */

import { setText } from "./dom.js";

// So long after the press without word that the drive is off, the page says so.
const CONFIRM_MS = 1000;
const OFF = new Set(["stopped", "failed", "off"]);

/** Return what the button shows for the phases of the wires: "idle" or "off". */
export function restingState(phases) {
  return phases.length && phases.every((phase) => OFF.has(phase)) ? "off" : "idle";
}

const WORDS = {
  idle: ["STOP", "drive off, key Esc"],
  pressed: ["STOPPING", "waiting for the drive to be off"],
  off: ["DRIVE OFF", "press to send a stop again, key Esc"],
  unconfirmed: ["NOT CONFIRMED", "switch the supply off"],
};

export class StopButton {
  /** `wires` returns the views of all wires; `connection` sends. */
  constructor(button, connection, wires, say) {
    this.button = button;
    this.word = button.querySelector("#stop-word");
    this.note = button.querySelector("#stop-note");
    this.connection = connection;
    this.wires = wires;
    this.say = say;
    this.pending = new Set();
    // At the press, not at the release; a press by keyboard or a screen reader comes as a click without a pointer before.
    button.addEventListener("pointerdown", (event) => event.button === 0 && this.stopAll());
    button.addEventListener("click", (event) => event.detail === 0 && this.stopAll());
    addEventListener("keydown", (event) => this.key(event), { capture: true });
  }

  key(event) {
    if (event.key !== "Escape") return;
    event.preventDefault();
    if (!event.repeat) this.stopAll();
  }

  stopAll() {
    for (const wire of this.wires()) this.stop(wire);
  }

  /** Stop one wire: first over the open socket, then by a request that needs none. */
  stop(wire) {
    const { bench } = wire;
    this.connection.command(bench, { do: "stop" });
    fetch(`/api/v1/benches/${encodeURIComponent(bench)}/stop`, { method: "POST", keepalive: true })
      .then((response) => (response.ok ? response.json() : null))
      .then((answer) => answer && OFF.has(answer.phase) && this.confirmed(bench))
      .catch(() => {});
    wire.stopPressed();
    this.pending.add(bench);
    this.draw("pressed");
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.late(), CONFIRM_MS);
  }

  late() {
    if (!this.pending.size) return;
    this.draw("unconfirmed");
    this.say("The server has not confirmed that the drive is off. Switch the supply off.");
  }

  confirmed(bench) {
    if (!this.pending.delete(bench)) return;
    if (!this.pending.size) this.draw(restingState(this.wires().map((wire) => wire.state?.phase)));
  }

  /** Follow the states of the wires: a pending stop is confirmed by them. */
  follow() {
    const wires = this.wires();
    for (const wire of wires) if (OFF.has(wire.state?.phase)) this.confirmed(wire.bench);
    if (!this.pending.size) this.draw(restingState(wires.map((wire) => wire.state?.phase)));
  }

  /** The connection is lost: nothing is known of the drives, so the button claims nothing. */
  unknown() {
    if (!this.pending.size) this.draw("idle");
  }

  draw(state) {
    this.button.dataset.state = state;
    setText(this.word, state === "idle" && this.wires().length > 1 ? "STOP ALL" : WORDS[state][0]);
    setText(this.note, WORDS[state][1]);
  }
}
