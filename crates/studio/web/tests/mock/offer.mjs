// What the program offers, as its own test writes it down: the stand-in has no list of its own.

import { readFileSync } from "node:fs";

export const OFFER = JSON.parse(readFileSync(new URL("./offer.json", import.meta.url), "utf8"));

/** The lists for a flat with or without program, trail and lasers. */
export function offerOf(isBare, hasLasers) {
  const without = isBare ? ["program", "signals", "pheromones", "plan", "zones"] : [];
  const has = ({ key }) => !without.includes(key) && key !== "tags" && (key !== "laser" || hasLasers);
  return { ...OFFER, panels: OFFER.panels.filter(has), layers: OFFER.layers.filter(has), plots: OFFER.plots.filter(({ id }) => !isBare || id !== "smell") };
}

/** Values in the order of the signals; what the stand-in does not know is null. */
export function valuesOf(signals, values) {
  return signals.map(({ id }) => values[id] ?? null);
}
