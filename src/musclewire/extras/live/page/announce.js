/** What a screen reader says: few sentences, the newest only, never the running numbers. */

import { setText } from "./dom.js";

let timer = null;

/** Say a sentence politely, a moment later: of several at once only the last is said. */
export function announce(text) {
  clearTimeout(timer);
  timer = setTimeout(() => setText(document.getElementById("announcement"), text), 250);
}
