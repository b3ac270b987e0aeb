// What a session has to show, as the program lists it: panels, layers, signals and plots. The page has no list of its own.

export interface PanelInfo {
  key: string;
  title: string;
  /** The key that brings it to the front. */
  digit: number;
  /** The row of tabs, from above. */
  row: number;
}

export interface LayerInfo {
  key: string;
  label: string;
  /** As style sheets write it. */
  colour: string;
  /** Shown until somebody switches it off. */
  on: boolean;
}

export interface Offer {
  panels: PanelInfo[];
  layers: LayerInfo[];
}

/** A number over time; SI units, the unit ends its name. */
export interface SignalInfo {
  id: string;
  title: string;
  /** The plot, and the name of the curve in it. */
  curve: [plot: string, name: string] | null;
  is_figure: boolean;
  /** Of a robot elsewhere nobody can know it. */
  is_seen_from_outside: boolean;
}

export interface PlotInfo {
  id: string;
  title: string;
  unit: string;
  /** The axis counts so many of a signal's value. */
  per_si_ratio: number;
  /** Range shown at least, in the unit of the axis. */
  least: [number, number];
  /** What is said when no value has come yet. */
  empty: string;
}
