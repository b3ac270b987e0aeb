// The messages of the mapping page, version 2: JSON below; binary ones are read in decode.ts.

import type { Offer } from "../offer";
import type { Pose } from "../protocol";

export const MAPPING_PROTOCOL = 2;

/** 0 is run A, 1 is run B. */
export type Slot = 0 | 1;
export const SLOT_NAMES = ["A", "B"] as const;

export interface Sample {
  name: string;
  title: string;
  about: string;
}

export interface Hello {
  type: "hello";
  protocol: number;
  cairn: string;
  /** Names the program; everything is forgotten when it changes. */
  server: number;
  has_mission: boolean;
  upload_max_bytes: number;
  samples: Sample[];
  formats: FormatInfo[];
}

/** A format of logs that can be opened. */
export interface FormatInfo {
  name: string;
  /** What comes in a second file. */
  second: string | null;
}

export interface RecordingInfo {
  format: string;
  rig: "laser" | "sonar";
  n_readings: number;
  n_scans: number;
  duration_s: number;
  path_length_m: number;
  has_truth: boolean;
  n_complaints: number;
  complaint_counts: string[];
  /** The first ones in full. */
  complaints: string[];
}

export interface Parameter {
  /** Table and name, such as `map.resolution_m`; the unit ends it. */
  key: string;
  table: string;
  name: string;
  about: string;
  kind: "number" | "count" | "flag" | "choice";
  /** What its values must be, as prose. */
  allowed: string;
  default: string;
  /** The default in the modes in which it is another one. */
  by_mode: Record<string, string>;
  choices: string[];
}

/** What is being mapped; sent when it changes. */
export interface Source extends Offer {
  type: "source";
  phase: "empty" | "reading" | "ready";
  name: string;
  problem: string | null;
  recording: RecordingInfo | null;
  parameters: Parameter[];
}

export interface RunState {
  /** The number of the run; another one begins from nothing. */
  run: number;
  phase: "under way" | "finishing" | "finished" | "failed";
  problem: string | null;
  scan: number;
  n_scans: number;
  t_s: number;
  pose: Pose | null;
  odometry: Pose | null;
  tracking: string;
  counters: { name: string; label: string; value: number }[];
  stages: { name: string; n_times: number; total_s: number; longest_s: number }[];
  /** At the end: names with units, values. */
  figures: [string, number | null][];
  /** Parameters that are not at the default of their mode; the mode too. */
  values: Record<string, string>;
  is_cut: boolean;
}

/** Sent thirty times a second while a recording plays, else at every change. */
export interface State {
  type: "state";
  playing: boolean;
  hurrying: boolean;
  speed_ratio: number;
  achieved_ratio: number;
  runs: RunState[];
  /** Parameters in which the runs differ: key, A's value, B's. */
  differences: [string, string, string][];
}

/** x (m), y (m), yaw (rad) from where odometry says, and the score. */
export type Candidate = [number, number, number, number | null];

/** How the last short-term map was compared with the map. */
export interface Registration {
  type: "registration";
  slot: Slot;
  run: number;
  /** Which one, from 1; 0 before the first. */
  number: number;
  scan: number;
  applied: boolean;
  verdict: string;
  /** What the scores are. */
  score: string;
  best: number | null;
  candidates: Candidate[];
}

export interface Refusal {
  type: "error";
  text: string;
}

export type ServerMessage = Hello | Source | State | Registration | Refusal;

export type Request =
  | { type: "play" }
  | { type: "pause" }
  | { type: "step" }
  | { type: "rewind" }
  | { type: "speed"; ratio: number }
  | { type: "seek"; scan: number }
  | { type: "run"; values: Record<string, string>; keep: Slot }
  | { type: "keep"; slot: Slot }
  | { type: "sample"; name: string };

const TYPES: readonly string[] = ["hello", "source", "state", "registration", "error"] satisfies ServerMessage["type"][];

/** A message of a kind that this page knows, or null. */
export function parseMessage(text: string): ServerMessage | null {
  try {
    const value: unknown = JSON.parse(text);
    const type = typeof value === "object" && value !== null && "type" in value ? value.type : null;
    return TYPES.includes(String(type)) ? (value as ServerMessage) : null;
  } catch {
    return null;
  }
}
