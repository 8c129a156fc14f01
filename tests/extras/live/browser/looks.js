/** What the tests ask of the page they have opened: put into it before its own scripts, as globalThis.looks. */

const isShown = (one) => one.checkVisibility({ visibilityProperty: true, opacityProperty: true });
const inWords = (one) => `${one.tagName.toLowerCase()} ${one.className?.baseVal ?? one.className} ${one.dataset?.part ?? ""}: ${one.textContent.trim().slice(0, 60)}`;
const CLIPS = new Set(["auto", "scroll", "hidden", "clip"]);
const ACTIONS = "a[href], button, input, select, textarea, summary, [role=button], [role=tab], [tabindex]";

const looks = {
  clicks: 0,

  /** What is wider than the screen although it does not scroll in a box of its own. */
  stickingOut() {
    return [...document.querySelectorAll("body *")].filter((one) => {
      const box = one.getBoundingClientRect();
      if (!box.width || !box.height || !isShown(one)) return false;
      if (box.right <= innerWidth + 1 && box.left >= -1) return false;
      for (let up = one.parentElement; up && up !== document.body; up = up.parentElement) {
        if (CLIPS.has(getComputedStyle(up).overflowX)) return false;
      }
      return getComputedStyle(one).position !== "absolute" || box.width > 2; // what is for screen readers alone
    }).map(inWords);
  },

  /** Text that is cut off in its box, unless the box says so by an ellipsis. */
  cutOff() {
    return [...document.querySelectorAll("button, h1, h2, h3, th, .value, .phase")]
      .filter((one) => isShown(one) && one.clientWidth > 2 && one.scrollWidth > one.clientWidth + 1)
      .filter((one) => getComputedStyle(one).textOverflow !== "ellipsis").map(inWords);
  },

  /** Where the stop button is, and whether something lies over it. */
  stop() {
    const stop = document.querySelector("#stop");
    const { top, left, bottom, right, width, height } = stop.getBoundingClientRect();
    const inside = top >= 0 && left >= 0 && bottom <= innerHeight && right <= innerWidth;
    return { inside, on_top: stop.contains(document.elementFromPoint(left + width / 2, top + height / 2)), width, height };
  },

  /** Number everything that can be worked now; a group of radio buttons is one stop of Tab. */
  actions() {
    document.querySelectorAll("[data-action]").forEach((one) => delete one.dataset.action);
    const groups = new Set();
    const found = [...document.querySelectorAll(ACTIONS)].filter((one) => {
      if (one.disabled || one.closest("[inert]") || !one.checkVisibility({ visibilityProperty: true })) return false;
      if (one.getAttribute("role") === "tab") return one.tabIndex >= 0; // arrows go on from there
      if (one.type !== "radio") return true;
      if (!one.checked || groups.has(one.name)) return false;
      groups.add(one.name);
      return true;
    });
    found.forEach((one, place) => { one.dataset.action = place; });
    return found.map((one) => [one.dataset.action, `${inWords(one)} ${one.getAttribute("aria-label") ?? ""} ${one.name ?? ""}`]);
  },

  fromTheTop() {
    document.body.tabIndex = -1;
    document.body.focus();
    document.body.removeAttribute("tabindex");
  },

  /** What has the keyboard now, and whether its looks say so: compared with those once it no longer has it. */
  focused() {
    const one = document.activeElement;
    const shown = one.type === "radio" ? one.closest("label") ?? one : one;
    const marks = ["outlineStyle", "outlineWidth", "outlineColor", "boxShadow", "borderColor", "backgroundColor"];
    const styleOf = (part) => { const style = getComputedStyle(part); return marks.map((mark) => style[mark]).join(); };
    const appearance = () => [shown, ...shown.querySelectorAll("*")].map(styleOf).join(";");
    const { top, left, bottom, right } = shown.getBoundingClientRect();
    const withFocus = appearance();
    one.blur();
    const without = appearance();
    one.focus({ preventScroll: true, focusVisible: true });
    const inside = bottom > 0 && top < innerHeight && right > 0 && left < innerWidth;
    return { action: one.dataset.action ?? null, name: inWords(one), differs: withFocus !== without, inside };
  },

  /** What a reader finds on the page: headings, buttons, fields, and names of pictures that are in sight. */
  landmarks() {
    const inSight = (one) => {
      const { top, bottom, width } = one.getBoundingClientRect();
      return isShown(one) && width > 2 && bottom > 0 && top < innerHeight;
    };
    const texts = [...document.querySelectorAll("h1, h2, h3, button, summary, label, legend, .key, .plot-title, [role=img]")].filter(inSight)
      .map((one) => one.getAttribute("aria-label") ?? one.innerText ?? "")
      // Numbers, and the dash for a value that has not come yet, are left out.
      .map((text) => text.replace(/[-\u2212]?\d+([.,]\d+)?|\u2013/g, "").replace(/\s+/g, " ").trim());
    return [...new Set(texts.filter(Boolean))];
  },

  /** Send a command over a socket of its own; return the promise of the answer. */
  command(what) {
    return new Promise((resolve) => {
      const socket = new WebSocket(`ws://${location.host}/api/v1/live`);
      const message = { type: "command", id: 1, bench: "simulated", command: what };
      socket.onmessage = ({ data }) => {
        const { type, ...rest } = JSON.parse(data);
        if (type === "hello") socket.send(JSON.stringify(message));
        if (type === "answer") resolve(rest);
      };
    });
  },
};
// A click of a pointer, and one that a key makes, each counted once, before any part of the page hears of it.
addEventListener("pointerdown", () => { looks.clicks += 1; }, { capture: true });
addEventListener("click", (event) => { looks.clicks += Number(event.isTrusted && event.detail === 0); }, { capture: true });
globalThis.looks = looks;
