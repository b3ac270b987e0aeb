// The studio protocol, version 2: every message that passes between the program and this page.
//
// One JSON object per WebSocket text frame, "type" first. Coordinates are in the map frame: metres,
// x to the right, y up; yaw in radians, counter-clockwise. Units are part of the names.

import type { Offer, PlotInfo, SignalInfo } from "./offer";

/** The version this page speaks; a server with another one gets a warning, not a crash. */
export const PROTOCOL_VERSION = 2;

/** [x_m, y_m] */
export type Point = [number, number];
/** [x_m, y_m, yaw_rad] */
export type Pose = [number, number, number];

// ---- server → client ----------------------------------------------------------------------------

/** Everything that does not change from state to state. Sent at connection, restart, scene change. */
export interface Hello extends Offer {
  type: "hello";
  protocol: number;
  /** Version of the program, for the about line. */
  cairn: string;
  /** Names this run: when it changes, what the page knew belongs to another run. */
  run?: string;
  mission: MissionInfo;
  /** What the mission chooser offers. */
  missions: MissionChoice[];
  world: WorldScene;
  robots: RobotInfo[];
  /** Robots beyond those, when there are too many to tell everything of each. */
  crowd?: CrowdInfo | null;
  pheromones: PheromoneField | null;
  tags?: TagsInfo | null;
  planned_path_m: Point[];
  program: ProgramInfo | null;
  links: LinkInfo[];
  plots: PlotInfo[];
  /** In the order of `RobotState.signals`. */
  robot_signals: SignalInfo[];
  /** In the order of `State.signals`. */
  run_signals: SignalInfo[];
}

export interface TagsInfo {
  pitch_m: number;
  /** x, y and what is stored. */
  tags: [x_m: number, y_m: number, strength: number][];
}

export interface MissionInfo {
  name: string;
  title: string;
  about: string;
  seed: number;
  duration_max_s: number;
  /** A replay shows a recording: it can be played, but nobody can intervene. */
  kind: "live" | "replay";
  /** The file in which this run is recorded. */
  recording?: string | null;
  /** How long the recording is that is shown. */
  length_s?: number | null;
  /** When something was done in it, whether a person did it, and what. */
  marks?: [t_s: number, byPerson: boolean, what: string][];
}

export interface MissionChoice {
  name: string;
  title: string;
  /** It is not among those that come with the program. */
  own?: boolean;
}

export interface WorldScene {
  /** [x0, y0, x1, y1] */
  bounds_m: [number, number, number, number];
  /** [x0, y0, x1, y1, material] */
  walls: [number, number, number, number, string][];
  points: Point[];
  things: Thing[];
  rooms: { name: string; at_m: Point }[];
  devices: Device[];
}

export interface Thing {
  id: number;
  name: string;
  kind: "furniture" | "box" | "door";
  material: string;
  corners_m: Point[];
  removable: boolean;
}

export interface Device {
  name: string;
  label: string;
  kind: "button" | "motion" | "latch" | "lamp";
  at_m: Point;
  /** The zone a detector watches. */
  area_m: Point[] | null;
  /** Number n of the input I<n> it drives. */
  input: number | null;
  /** Number n of the output O<n> that drives it. */
  output: number | null;
}

export interface RobotInfo {
  id: number;
  name: string;
  model: string;
  /** In the robot's own frame: x forward, y left. */
  footprint_m: Point[];
  sonars: SonarInfo[];
  scanners?: ScannerInfo[];
  tag_readers_m?: Point[];
  tag_range_m?: number;
  start: Pose;
  /** No body of this simulation: what cannot be measured from outside is not known of it. */
  is_elsewhere?: boolean;
  hand_speed_max_mps?: number;
  hand_turn_rate_max_radps?: number;
}

export interface CrowdInfo {
  /** Number of the crowd's first robot. */
  first_id: number;
  n_robots: number;
  footprint_m: Point[];
}

/** [x_m, y_m, yaw_rad, mark]: 1 in the mark is "touches something", 2 "has arrived". */
export type CrowdRobot = [number, number, number, number];

export interface SonarInfo {
  /** Where the sonar sits on the robot. */
  at: Pose;
  half_angle_rad: number;
  range_max_m: number;
}

export interface ScannerInfo {
  name: string;
  /** Where it sits on the robot. */
  at: Pose;
  first_angle_rad: number;
  /** From a beam to the next, counter-clockwise. */
  step_rad: number;
  n_beams: number;
  range_max_m: number;
}

/** Which scanner, from where, and its beams: 16 bits each, in base 64 (map/lasers.ts). */
export type Scan = [scanner: number, at: Pose, beams: string];

export interface PheromoneField {
  cell_m: number;
  width: number;
  height: number;
  /** Lower-left corner of cell (0, 0). */
  origin_m: Point;
  /** [column, row, value] of the cells that are not empty. */
  values: [number, number, number][];
  sigma_m: number;
  antenna_spacing_m: number;
}

export interface ProgramInfo {
  source: string;
  mode: string;
  functions: ProgramFunction[];
}

export interface ProgramFunction {
  /** First line is 1. */
  line: number;
  mnemonic: string;
  operands: Operand[];
}

export interface Operand {
  text: string;
  /** Name of the resource in `DecisionState.resources`; null for an immediate. */
  resource: string | null;
  /** First column is 1. */
  column: number;
  length: number;
}

export interface LinkInfo {
  id: number;
  name: string;
  ends: [string, string];
  baud: number | null;
  /** The robot whose line it is, and which: what `cut` takes. */
  robot?: number;
  line?: string;
}

/** What has just happened in the world, 30 a second while playing and once after each change. */
export interface State {
  type: "state";
  t_s: number;
  step: number;
  playing: boolean;
  /** Asked for by the user. */
  speed_ratio: number;
  /** What the computer managed. */
  achieved_ratio: number;
  verdict: Verdict | null;
  robots: RobotState[];
  /** The robots of `hello.crowd`, in order; left out when there are none. */
  crowd?: CrowdRobot[];
  people: Person[];
  /** Only things that are not in the hello; the full list each time. */
  things: Thing[];
  devices: { name: string; on: boolean }[];
  decision: DecisionState | null;
  /** In the order of `Hello.run_signals`. */
  signals: (number | null)[];
}

export interface Verdict {
  passed: boolean;
  text: string;
  checks: { name: string; passed: boolean; text: string }[];
}

export interface RobotState {
  id: number;
  truth: Pose;
  estimate: Pose;
  /** [semi_major_m, semi_minor_m, yaw_rad] */
  ellipse: [number, number, number];
  /** [left, right] */
  wheels_mps: [number, number];
  sonar_m: number[];
  /** Limit per sonar below which the avoider takes over; empty when there is none. */
  bubble_m: number[];
  phase: string;
  /** What it does about its goal, or why it gave it up, in a sentence; empty without a goal. */
  task?: string;
  avoider: { state: number; name: string };
  goal: Pose | null;
  /** Allowed distance from the goal, when the server says it. */
  goal_tolerance_m?: number;
  /** Detour target of the avoider. */
  target: Point | null;
  /** What the scout has seen of the trail ahead. */
  preview_m: Point[];
  /** [left, right] antenna */
  intensities: [number, number] | null;
  scans?: Scan[];
  stalled: boolean;
  touching: boolean;
  /** In the order of `Hello.robot_signals`. */
  signals: (number | null)[];
  /** Why it gave up, if it did. */
  failure?: string | null;
}

export interface Person {
  name: string;
  at: Pose;
  radius_m: number;
}

export interface DecisionState {
  scans: number;
  /** History byte per resource the program names; least significant bit is now. */
  resources: Record<string, number>;
  timers: { index: number; remaining_s: number; total_s: number; on: boolean }[];
  run: boolean;
  /** False while the outputs have their fail-safe values. */
  drives_outputs?: boolean;
  /** Code of the error that the program stands on. */
  fault?: string | null;
  /** What the node's clock shows: "2026-03-01 07:30:00.00". */
  clock?: string;
  n_watchdog_resets?: number;
  /** Entries that EVENT wrote into the log. */
  n_events?: number;
  /** Number of the last MOVE, 0 before the first, and what became of it. */
  last_move?: [number: number, state: "idle" | "busy" | "done" | "failed"];
  /**
   * Optional: [t_s, resource, high], the latest changes of boolean resources, oldest first; a change is
   * told in several states, in case one is missed. Without it pulses shorter than the time between two
   * states are seen by luck only.
   */
  edges?: [number, string, boolean][];
}

export interface Trace {
  type: "trace";
  items: TraceItem[];
}

export interface TraceItem {
  t_s: number;
  link: number;
  /** The end that receives it. */
  to: string;
  hex: string;
  text: string;
}

export type LogLevel = "info" | "warn" | "good" | "bad";

export interface Log {
  type: "log";
  items: LogItem[];
}

export interface LogItem {
  t_s: number;
  level: LogLevel;
  text: string;
}

/** What has been, for a page that comes late; a few thousand samples however long the run is. */
export interface History {
  type: "history";
  t_s: number[];
  /** x and y in turn, one pair for each time. */
  robots: { id: number; truth: number[]; estimate: number[] }[];
  /** Signals of the first robot by name. */
  columns: Record<string, (number | null)[]>;
  edges: [number, string, boolean][];
}

/** What was shown at a time, for the page that asked; the run goes on. */
export interface Past {
  type: "past";
  asked_s: number;
  state: State;
  kept: Kept;
}

/** How much of the past there is. */
export interface Kept {
  n_states: number;
  n_bytes: number;
  bytes_max: number;
  /** Between two states at first. */
  period_s: number;
  /** The longest time between two of them by now. */
  gap_max_s: number;
}

/** The answer to a request that cannot be done; the connection stays. */
export interface ServerError {
  type: "error";
  text: string;
}

export type ServerMessage = Hello | State | Past | History | Trace | Log | ServerError;

// ---- client → server ----------------------------------------------------------------------------

export type ClientMessage =
  | { type: "play" }
  | { type: "pause" }
  | { type: "step" }
  | { type: "speed"; ratio: number }
  | { type: "restart"; seed: number | null; mission: string | null }
  | { type: "place"; at_m: Point; size_m: number }
  | { type: "remove"; id: number }
  | { type: "goal"; robot: number; pose: Pose }
  | { type: "seek"; t_s: number }
  | { type: "past"; t_s: number }
  | { type: "cut"; robot: number; line: string; cut: boolean }
  | { type: "drive"; robot: number; speed_mps: number; turn_rate_radps: number }
  | { type: "press"; device: string }
  | { type: "stop"; robot: number };

const SERVER_TYPES = ["hello", "state", "past", "history", "trace", "log", "error"];

/** Reads one frame; null when it is not a message this page knows (a newer server may send such). */
export function parseServerMessage(frame: string): ServerMessage | null {
  let value: unknown;
  try {
    value = JSON.parse(frame);
  } catch {
    return null;
  }
  if (typeof value !== "object" || value === null || !("type" in value)) return null;
  return SERVER_TYPES.includes(String(value.type)) ? (value as ServerMessage) : null;
}
