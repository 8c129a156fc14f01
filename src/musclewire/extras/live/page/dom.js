/** Elements made and changed without HTML in text, so that nothing from outside can become a script. */

/** Return a new element with attributes (class, data-..., on... as functions) and children (elements or texts). */
export function el(name, attributes = {}, ...children) {
  const element = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) continue;
    if (typeof value === "function") element.addEventListener(key.slice(2), value);
    else if (key === "value") element.value = value;
    else element.setAttribute(key, value === true ? "" : value);
  }
  element.append(...children.flat().filter((child) => child !== null && child !== undefined));
  return element;
}

const SVG = "http://www.w3.org/2000/svg";

/** Return a new SVG element with attributes and children. */
export function svg(name, attributes = {}, ...children) {
  const element = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  element.append(...children);
  return element;
}

/** Set an element's text only if it differs: a browser lays out again what is set again. */
export function setText(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

/** Show or hide an element. */
export function show(element, shown) {
  if (element.hidden === shown) element.hidden = !shown;
}

/** Replace an element's children unless the key is that of the last time. */
export function renew(element, key, children) {
  if (element.dataset.key === key) return false;
  element.dataset.key = key;
  element.replaceChildren(...children());
  return true;
}

/** Return the parts of a view by their data-part names. */
export function partsOf(root) {
  return Object.fromEntries([...root.querySelectorAll("[data-part]")].map((part) => [part.dataset.part, part]));
}

/** Return a table; cells that are numbers (by the column's mark) stand right. */
export function table(caption, heads, rows) {
  const cell = (kind, text, place) => el(kind, { class: heads[place].number ? "number-cell" : null, scope: kind === "th" ? "col" : null }, text);
  return el(
    "table", {},
    el("caption", { class: "unseen" }, caption),
    el("thead", {}, el("tr", {}, ...heads.map((head, place) => cell("th", head.text, place)))),
    el("tbody", {}, ...rows.map((row) => el("tr", {}, ...row.map((text, place) => cell("td", text, place))))),
  );
}
