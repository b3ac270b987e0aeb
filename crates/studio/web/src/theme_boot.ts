// Runs before the first paint and says dark or light, so that neither theme flashes the other.

let chosen: unknown = null;
try {
  chosen = JSON.parse(localStorage.getItem("cairn.theme") ?? "null");
} catch {
  // Without storage the system's preference holds.
}
const system = window.matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light";
document.documentElement.dataset["theme"] = chosen === "dark" || chosen === "light" ? chosen : system;
