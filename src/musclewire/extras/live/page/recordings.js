/** The recordings of the session: names, download, and one of them laid over the plots. */

import { el, renew, setText } from "./dom.js";
import { bytes } from "./format.js";
import { recordedColumns } from "./rows.js";

const SHOWN = 12;

/** Return the address at which a recording is downloaded. */
export function recordingAddress(name) {
  return `/api/v1/recordings/${encodeURIComponent(name)}`;
}

/** Return a recording's columns as the page plots them. Throws a sentence if the server has none. */
export async function fetchColumns(name, options, points = 1000) {
  const response = await fetch(`${recordingAddress(name)}/rows?points=${points}`);
  const answer = await response.json().catch(() => ({}));
  if (!response.ok) throw new Error(answer.problem ?? answer.detail ?? `The server could not read ${name}.`);
  const metadata = answer.metadata ?? {};
  const shunt_resistance_ohm = Number(metadata.shunt_resistance_ohm) || options.shunt_resistance_ohm;
  return recordedColumns(answer, { ...options, shunt_resistance_ohm });
}

/** Return recordings by the time in their names, the newest first. Pure. */
export function newestFirst(recordings) {
  const time = ({ name }) => /\d{8}-\d{6}/.exec(name)?.[0] ?? "";
  return [...recordings].sort((one, other) => time(other).localeCompare(time(one)) || other.name.localeCompare(one.name));
}

export class Recordings {
  /** `compare` is called with columns and name, or null; `options` returns how rows are read. */
  constructor(root, note, { compare, options }) {
    this.root = root;
    this.note = note;
    this.compare = compare;
    this.options = options;
    this.compared = null;
    this.showsAll = false;
  }

  follow(recordings = []) {
    this.recordings = recordings;
    const newest = newestFirst(recordings);
    const shown = this.showsAll ? newest : newest.slice(0, SHOWN);
    const focused = document.activeElement?.dataset?.recording;
    const changed = renew(this.root, JSON.stringify([shown, this.compared, recordings.length]), () => this.content(shown, recordings.length));
    if (changed && focused) this.root.querySelector(`[data-recording="${CSS.escape(focused)}"]`)?.focus();
  }

  content(shown, count) {
    if (!count) return [el("p", { class: "hint" }, "None yet.")];
    const heads = ["Name", "Size", "Compare"].map((text) => el("th", { scope: "col" }, text));
    const rows = shown.map((each) => el("tr", {}, el("td", { class: "recording-name" }, el("a", { href: recordingAddress(each.name), download: each.name, title: "Download" }, each.name)), el("td", { class: "number-cell" }, bytes(each.bytes)), el("td", {}, this.toggle(each.name))));
    const more = count > shown.length ? [el("button", { type: "button", class: "quiet small", onclick: () => { this.showsAll = true; this.follow(this.recordings); } }, `Show all ${count}`)] : [];
    return [el("table", { class: "recordings" }, el("caption", { class: "unseen" }, "Recordings; a name downloads its file"), el("thead", {}, el("tr", {}, ...heads)), el("tbody", {}, ...rows)), ...more];
  }

  toggle(name) {
    const isOn = this.compared === name;
    return el("button", { type: "button", class: isOn ? "small primary" : "small", "data-recording": name, "aria-pressed": String(isOn), "aria-label": `Compare with ${name}`, onclick: () => this.choose(isOn ? null : name) }, isOn ? "Shown" : "Compare");
  }

  async choose(name) {
    this.compared = name;
    this.follow(this.recordings);
    setText(this.note, name ? `Reading ${name}.` : "");
    if (!name) {
      this.compare(null, "");
      return;
    }
    try {
      const columns = await fetchColumns(name, this.options());
      if (this.compared !== name) return;
      this.compare(columns, name);
      setText(this.note, `Dotted in the plots: ${name}, from its first row on.`);
    } catch (problem) {
      this.compared = null;
      this.follow(this.recordings);
      setText(this.note, problem.message);
    }
  }
}
