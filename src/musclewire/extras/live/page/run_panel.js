/** The panel that starts runs: kinds as a row of choices, one form for the chosen kind, one button. */

import { el, renew, setText, show, table } from "./dom.js";
import { fixed } from "./format.js";
import { PathEditor } from "./path_editor.js";
import { KINDS, obstacle, readField, targetScale } from "./run_kinds.js";

export class RunPanel {
  /** `run` is called with commands and whether the slider is to be focused; `refuse` with a sentence. */
  constructor(parts, bench, run, refuse) {
    this.form = parts["run-form"];
    this.run = run;
    this.refuse = refuse;
    this.kind = KINDS.find((kind) => kind.key === "loop");
    this.inputs = new Map();
    this.radios = KINDS.map((kind) => this.radio(kind, bench));
    parts.kinds.append(...this.radios.map(({ label }) => label));
    this.form.addEventListener("submit", (event) => {
      event.preventDefault();
      this.submit();
    });
  }

  radio(kind, bench) {
    const input = el("input", { type: "radio", name: `kind-${bench}`, value: kind.key, checked: kind === this.kind, onchange: () => this.choose(kind) });
    return { kind, input, label: el("label", {}, input, el("span", {}, kind.label)) };
  }

  choose(kind) {
    this.kind = kind;
    this.radios.forEach((each) => { each.input.checked = each.kind === kind; });
    this.refuse("");
    if (this.state) this.follow(this.state, this.isRunning);
  }

  follow(state, isRunning) {
    const hadModel = Boolean(this.state?.model);
    this.state = state;
    this.isRunning = isRunning;
    if (state.model && !hadModel && this.kind.key === "loop") this.choose(KINDS[0]);
    const { kind } = this;
    const scale = targetScale(state);
    renew(this.form, JSON.stringify([kind.key, state.model?.file, scale.lowest, scale.highest, state.rig?.name, state.controllers, state.pretensions]), () => this.make(kind, state));
    const why = obstacle(kind, state);
    setText(this.why, why);
    show(this.why, Boolean(why));
    this.button.disabled = Boolean(why) || isRunning || state.phase !== "ready";
    setText(this.button, state.phase === "busy" ? "Running\u2026" : kind.button);
  }

  make(kind, state) {
    this.inputs.clear();
    const fields = kind.fields(state).map((field) => this.field(field));
    this.editor = kind.drawsPath ? new PathEditor(targetScale(state), () => Number(this.inputs.get("duration_s").input.value) || 30) : null;
    if (this.editor) this.inputs.get("duration_s").input.addEventListener("change", () => this.editor.durationChanged());
    this.why = el("p", { class: "hint" });
    this.button = el("button", { type: "submit", class: "primary" }, kind.button);
    const shown = kind.shows === "pretensions" && state.pretensions ? [this.pretensions(state.pretensions)] : [];
    return [kind.hint ? el("p", { class: "hint" }, kind.hint) : null, ...fields, ...(this.editor ? [this.editor.root] : []), this.why, this.button, ...shown].filter(Boolean);
  }

  field(field) {
    const { name, label, unit, value, options } = field;
    const input = options
      ? el("select", { name }, ...options.map((option) => el("option", { value: option }, option || "default")))
      : el("input", {
        name, type: field.text ? "text" : "number", inputmode: "decimal", autocomplete: "off", step: field.text ? null : "any",
        min: field.min ?? null, max: field.max ?? null, placeholder: field.optional ? "safe default" : null,
      });
    if (value !== null && value !== undefined) input.value = value;
    this.inputs.set(name, { field, input });
    return el("label", { class: field.text ? "" : "row-field" }, el("span", {}, label), el("span", { class: "with-unit" }, input, unit ?? ""));
  }

  submit() {
    const values = {};
    try {
      for (const [name, { field, input }] of this.inputs) values[name] = readField(field, input.value);
      if (this.editor) values.points = this.editor.points();
    } catch (problem) {
      this.refuse(problem.message);
      return;
    }
    this.refuse("");
    this.run(this.kind.commands(values, targetScale(this.state), this.state), this.kind.focusSlider);
  }

  pretensions({ rows, best_n }) {
    const choose = (row) => el("button", { type: "button", class: row.pretension_n === best_n ? "primary small" : "small", onclick: () => this.run([{ do: "choose_pretension", pretension_n: row.pretension_n }]) },
      "Choose", el("span", { class: "unseen" }, ` ${row.pretension_n} N`));
    const heads = [{ text: "Pretension", number: true }, { text: "Gap", number: true }, { text: "Largest strain", number: true }, { text: "" }];
    return el("div", { class: "scroll" }, table("Pretensions that were tried", heads, rows.map((row) => [
      `${fixed(row.pretension_n, 2)}\u202fN`, `${fixed(row.gap_pct, 2)}\u202f%`, `${fixed(row.largest_strain_pct, 2)}\u202f%`, choose(row),
    ])));
  }
}
