/** Several commands one after the other, each when the bench is ready again; a stop or a refusal ends the sequence. */

const ENDS = new Set(["stopped", "failed", "off"]);
// A command that is over at once may never show another phase than "ready".
const SETTLED_MS = 700;

export class Sequence {
  /** `send` sends a command and returns a promise of its answer; `refused` is called with the reason why one was not
  accepted, `ended` when all are done. */
  constructor(send, refused, ended) {
    this.ended = ended;
    this.send = send;
    this.refused = refused;
    this.rest = [];
    this.current = null;
  }

  get isRunning() {
    return this.current !== null;
  }

  /** Begin; what was still waiting is dropped. */
  start(commands) {
    this.rest = [...commands];
    this.current = null;
    return this.next();
  }

  cancel() {
    this.rest = [];
    this.current = null;
  }

  async next() {
    const command = this.rest.shift();
    if (!command) {
      this.current = null;
      this.ended();
      return;
    }
    const step = { command, wasOther: false, accepted: false, accepted_ms: 0 };
    this.current = step;
    const answer = await this.send(command);
    if (this.current !== step) return;
    // A clock that cannot run faster costs time and nothing else: what was asked for goes on.
    if (!answer.accepted && command.do === "clock_speed") {
      await this.next();
      return;
    }
    if (!answer.accepted) {
      this.cancel();
      this.refused(answer.message);
      return;
    }
    step.accepted = true;
    step.accepted_ms = performance.now();
    if (command.do === "clock_speed") await this.next();
    else setTimeout(() => this.current === step && this.state && this.follow(this.state), SETTLED_MS + 50);
  }

  /** Follow the bench's state. */
  follow(state) {
    this.state = state;
    const step = this.current;
    if (!step) return;
    const { phase } = state;
    if (phase !== "ready") step.wasOther = true;
    if (!step.accepted) return;
    if (ENDS.has(phase) && (step.command.do !== "switch_on" || phase === "failed")) {
      this.cancel();
      return;
    }
    if (phase === "ready" && (step.wasOther || performance.now() - step.accepted_ms > SETTLED_MS)) this.next();
  }
}
