/** Dark or light: as the system has it until the switch is used; remembered in this browser. */

const KEY = "musclewire-theme";

/** Begin to follow system and switch; `changed` is called whenever the colours are others. */
export function followTheme(button, changed) {
  const system = matchMedia("(prefers-color-scheme: light)");
  const apply = () => {
    const chosen = localStorage.getItem(KEY) ?? (system.matches ? "light" : "dark");
    document.documentElement.dataset.theme = chosen;
    button.textContent = chosen === "light" ? "Dark colours" : "Light colours";
    changed();
  };
  button.removeAttribute("aria-pressed");
  button.addEventListener("click", () => {
    localStorage.setItem(KEY, document.documentElement.dataset.theme === "light" ? "dark" : "light");
    apply();
  });
  system.addEventListener("change", apply);
  apply();
}

const cache = new Map();

/** Return a colour of the style sheet by its name, as "heating". */
export function colour(name) {
  if (!cache.has(name)) cache.set(name, getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim());
  return cache.get(name);
}

/** Forget the colours read so far: the theme has changed. */
export function forgetColours() {
  cache.clear();
}
