/** The page: makes the connection, a view for each wire, the stop button, and draws at the pace of the screen. */

import { announce } from "./announce.js";
import { Connection, liveAddress, SILENCE_S } from "./connection.js";
import { el, setText, show } from "./dom.js";
import { StopButton } from "./stop.js";
import { followTheme, forgetColours } from "./theme.js";
import { WireView } from "./wire_view.js";

const NARROWEST_PX = 620; // a wire next to another one needs so much
const CONTROL_MS = 1500;
// More pictures than a screen instrument needs cost a small machine its time; fewer where motion is unwelcome.
const FRAME_MS = 1000 / 32;
const CALM_FRAME_MS = 250;

const byId = (id) => document.getElementById(id);
const connection = new Connection(liveAddress(location));
const views = new Map();
const wires = () => [...views.values()];
const calm = matchMedia("(prefers-reduced-motion: reduce)");
const figures = { frames: 0, rows: 0, longest_draw_ms: 0 };
let you = "";
let shownWire = null;

const office = {
  command: (bench, command) => connection.command(bench, command),
  stop: (wire) => stopButton.stop(wire),
  answer: (wire, give) => connection.send({ type: "answer_control", bench: wire.bench, give }),
  askOrGiveUp(wire) {
    const { bench, control } = wire;
    if (control.you_hold) connection.send({ type: "give_up_control", bench });
    else connection.send({ type: "ask_control", bench, name: you });
    if (control.holder && !control.you_hold) announce(`${control.holder} has been asked for control.`);
  },
  /** Return whether this page has control, after taking it if nobody had it. */
  async haveControl(wire) {
    if (wire.control.you_hold) return true;
    if (wire.control.holder) return false;
    connection.send({ type: "ask_control", bench: wire.bench, name: you });
    const end = performance.now() + CONTROL_MS;
    while (!wire.control.you_hold && !wire.control.holder && performance.now() < end) await new Promise((resolve) => setTimeout(resolve, 15));
    return wire.control.you_hold;
  },
};

const stopButton = new StopButton(byId("stop"), connection, wires, announce);

function viewOf(bench) {
  if (!views.has(bench)) {
    const view = new WireView(bench, byId("wire-template"), office);
    views.set(bench, view);
    byId("waiting")?.remove();
    byId("wires").append(view.root);
    shownWire ??= bench;
    arrange();
  }
  return views.get(bench);
}

/** Put wires next to each other where there is room, else behind tabs. */
function arrange() {
  const asTabs = views.size > 1 && innerWidth < NARROWEST_PX * views.size;
  byId("wires").dataset.shown = asTabs ? "tabs" : "together";
  const tabs = byId("tabs");
  show(tabs, asTabs);
  for (const [bench, view] of views) {
    view.root.toggleAttribute("data-current", bench === shownWire);
    view.root.id = `wire-${bench}`;
    show(view.parts["stop-one"], views.size > 1);
  }
  if (!asTabs) return;
  tabs.replaceChildren(...[...views.keys()].map((bench) => el("button", {
    type: "button", role: "tab", class: "quiet", "aria-selected": String(bench === shownWire), "aria-controls": `wire-${bench}`, tabindex: bench === shownWire ? "0" : "-1",
    onclick: () => choose(bench), onkeydown: (event) => tabKey(event, bench),
  }, bench)));
}

function choose(bench) {
  shownWire = bench;
  arrange();
  byId("tabs").querySelector('[aria-selected="true"]')?.focus();
}

function tabKey(event, bench) {
  const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
  if (!step) return;
  const all = [...views.keys()];
  choose(all[(all.indexOf(bench) + step + all.length) % all.length]);
}

function setConnection(state) {
  const pill = byId("connection");
  pill.dataset.state = state;
  setText(pill, { connecting: "Connecting", open: `Connected as ${you}`, lost: "Connection lost" }[state]);
  setText(byId("lost"), state === "lost"
    ? "CONNECTION LOST. What you see is old. A bench that you controlled ends its run and takes the heat off by itself within a second. Trying again."
    : "");
  for (const view of wires()) view.root.classList.toggle("old", state === "lost");
  if (state === "lost") stopButton.unknown();
}

connection.addEventListener("hello", ({ detail }) => {
  you = detail.you;
  setText(byId("version"), detail.version);
  for (const view of wires()) view.setControl({ holder: null, you_hold: false, asked_by: null });
  detail.benches.forEach(viewOf);
  setConnection("open");
});
connection.addEventListener("state", ({ detail }) => {
  viewOf(detail.state.bench).setState(detail.state);
  stopButton.follow();
});
connection.addEventListener("rows", ({ detail }) => {
  figures.rows += detail.rows.length;
  viewOf(detail.bench).addRows(detail);
});
connection.addEventListener("control", ({ detail }) => {
  const view = viewOf(detail.bench);
  const had = view.control.you_hold;
  view.setControl(detail);
  if (detail.you_hold && detail.asked_by) announce(`${detail.asked_by} asks for control.`);
  else if (had !== detail.you_hold) announce(detail.you_hold ? "You have control." : "You no longer have control.");
});
connection.addEventListener("problem", ({ detail }) => announce(detail.message));
connection.addEventListener("lost", () => {
  for (const view of wires()) {
    view.stopPressed();
    view.setControl({ holder: null, you_hold: false, asked_by: null });
  }
  setConnection("lost");
});

// A line that is cut says nothing: silence is what shows it. Only what is seen depends on this timer.
setInterval(() => {
  if (!connection.isOpen) return;
  const isSilent = performance.now() - connection.heard_ms > SILENCE_S * 1000;
  const shown = byId("connection").dataset.state;
  if (isSilent && shown === "open") setConnection("lost");
  if (!isSilent && shown === "lost") setConnection("open");
}, 200);

let drawn_ms = 0;
function frame(now_ms) {
  requestAnimationFrame(frame);
  if (now_ms - drawn_ms < (calm.matches ? CALM_FRAME_MS : FRAME_MS) - 4) return;
  const before = performance.now();
  let hasDrawn = false;
  for (const [bench, view] of views) {
    if (byId("wires").dataset.shown === "tabs" && bench !== shownWire) continue;
    hasDrawn = view.draw(now_ms) || hasDrawn;
  }
  if (!hasDrawn) return;
  drawn_ms = now_ms;
  figures.frames += 1;
  figures.longest_draw_ms = Math.max(figures.longest_draw_ms, performance.now() - before);
}

followTheme(byId("theme"), () => {
  forgetColours();
  for (const view of wires()) view.recolour();
});
addEventListener("resize", arrange);
// For tests and for who wants to know: how many pictures were drawn, how many rows came, the longest time of a picture.
globalThis.musclewirePage = figures;
connection.open();
requestAnimationFrame(frame);
