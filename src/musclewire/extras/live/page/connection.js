/** The WebSocket to the server: answers its pings, sends commands and receives their answers, comes back when lost. */

const RETRY_S = [0.3, 0.6, 1, 2, 3];
const ANSWER_S = 20;
// The server pings every 0.15 s: so long without any message, and what is shown is old.
export const SILENCE_S = 1.0;

export class Connection extends EventTarget {
  constructor(url) {
    super();
    this.url = url;
    this.isOpen = false;
    this.heard_ms = 0;
    this.tries = 0;
    this.nextId = 1;
    this.waiting = new Map();
  }

  open() {
    const socket = new WebSocket(this.url);
    this.socket = socket;
    socket.onmessage = (event) => this.receive(event.data, socket);
    socket.onclose = () => this.closed(socket);
  }

  /** Take a message in. The pong goes out before anything else, from this very event: a lease hangs on it. */
  receive(text, socket) {
    const message = JSON.parse(text);
    this.heard_ms = performance.now();
    if (message.type === "ping") {
      socket.send(`{"type":"pong","n":${message.n}}`);
      return;
    }
    if (message.type === "hello") {
      this.isOpen = true;
      this.tries = 0;
    }
    if (message.type === "answer") this.settle(message.id, message);
    this.dispatchEvent(new CustomEvent(message.type, { detail: message }));
  }

  closed(socket) {
    if (socket !== this.socket) return;
    this.isOpen = false;
    for (const id of [...this.waiting.keys()]) this.settle(id, { accepted: false, message: "the connection was lost" });
    this.dispatchEvent(new Event("lost"));
    const delay_s = RETRY_S[Math.min(this.tries, RETRY_S.length - 1)];
    this.tries += 1;
    setTimeout(() => this.open(), delay_s * 1000);
  }

  settle(id, answer) {
    const waiting = this.waiting.get(id);
    if (!waiting) return;
    clearTimeout(waiting.timer);
    this.waiting.delete(id);
    waiting.resolve({ accepted: answer.accepted, message: answer.message });
  }

  /** Send a message; return whether there was a connection to send it on. */
  send(message) {
    if (!this.socket || this.socket.readyState !== WebSocket.OPEN) return false;
    this.socket.send(JSON.stringify(message));
    return true;
  }

  /** Send a command to a bench; return a promise of {accepted, message}. */
  command(bench, command) {
    const id = this.nextId++;
    return new Promise((resolve) => {
      const timer = setTimeout(() => this.settle(id, { accepted: false, message: "the server has not answered" }), ANSWER_S * 1000);
      this.waiting.set(id, { resolve, timer });
      if (!this.send({ type: "command", id, bench, command })) this.settle(id, { accepted: false, message: "there is no connection" });
    });
  }
}

/** Return the address of the live WebSocket for the address of the page. */
export function liveAddress(location) {
  return `${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/api/v1/live`;
}
