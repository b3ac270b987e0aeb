// Names that end in their unit, as people read them: "map.resolution_m" is a resolution in metres.

const UNITS: readonly [suffix: string, unit: string][] = [
  ["_per_metre_std_rad", "rad/m"], ["_mps", "m/s"], ["_m2", "m²"], ["_rad", "rad"], ["_deg", "°"], ["_bits", "bit"], ["_cells", "cells"], ["_logodds", "log-odds"],
  ["_prob", ""], ["_ratio", ""], ["_scans", "scans"], ["_readings", "readings"], ["_ms", "ms"], ["_m", "m"], ["_s", "s"],
];

/** "resolution_m" → { stem: "Resolution", unit: "m" } */
export function unitOf(name: string): { stem: string; unit: string } {
  const found = UNITS.find(([suffix]) => name.endsWith(suffix));
  const stem = (found ? name.slice(0, -found[0].length) : name).replaceAll("_", " ").replace(/[.]/g, ": ");
  return { stem: stem.charAt(0).toUpperCase() + stem.slice(1), unit: found?.[1] ?? "" };
}

/** "0.30000000000000004" → "0.3"; words stay. */
export function tidyNumber(text: string): string {
  const value = Number(text);
  return text.length > 14 && Number.isFinite(value) ? String(Number(value.toPrecision(12))) : text;
}

/** A figure for the table: "0.0123", "m" → "12.3 mm". */
export function figureText(value: number | null, unit: string): string {
  if (value === null || !Number.isFinite(value)) return "–";
  if (unit === "m" && Math.abs(value) < 0.1 && value !== 0) return `${(value * 1000).toFixed(1)} mm`;
  const text = Number.isInteger(value) && Math.abs(value) < 1e9 ? String(value) : value.toFixed(Math.abs(value) < 10 ? 3 : Math.abs(value) < 1000 ? 2 : 0);
  return unit === "" || unit === "cells" || unit === "scans" ? text : unit === "°" ? `${text}°` : `${text} ${unit}`;
}
