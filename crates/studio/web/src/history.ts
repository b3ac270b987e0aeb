// Reads RDPL history bytes: eight samples of a signal, the least significant bit being now.

export type SignalState = "high" | "low" | "rising" | "falling";

/** Names whose byte is a history of a boolean; M, A and STATUS hold numbers. */
const BOOLEAN_NAME = /^(N?I|O|Y|YTMR|S)\d+$/i;
const CONSTANT_NAME = /^[01]L$/i;

export function isBoolean(resource: string): boolean {
  return BOOLEAN_NAME.test(resource) || CONSTANT_NAME.test(resource);
}

export function isConstant(resource: string): boolean {
  return CONSTANT_NAME.test(resource);
}

/** The two youngest samples: 00 low, 11 high, 01 rising, 10 falling (previous, now). */
export function signalState(byte: number): SignalState {
  switch (byte & 3) {
    case 0: return "low";
    case 1: return "rising";
    case 2: return "falling";
    default: return "high";
  }
}

export function isHigh(byte: number): boolean {
  return (byte & 1) === 1;
}

/** Oldest first: what a reader expects of a waveform. */
export function samples(byte: number): boolean[] {
  return Array.from({ length: 8 }, (_, index) => ((byte >> (7 - index)) & 1) === 1);
}

/** The waveform as an SVG path in a box of the given size, oldest sample at the left. */
export function waveformPath(byte: number, width: number, height: number): string {
  const step = width / 8;
  const parts: string[] = [];
  samples(byte).forEach((high, index) => {
    const y = high ? 1 : height - 1;
    parts.push(index === 0 ? `M0 ${y}` : `V${y}`, `H${(index + 1) * step}`);
  });
  return parts.join("");
}

const STATE_WORDS: Record<SignalState, string> = {
  high: "on", low: "off", rising: "just went on", falling: "just went off",
};

export function describe(resource: string, byte: number): string {
  if (isConstant(resource)) return `${resource} is the constant ${isHigh(byte) ? "on" : "off"}`;
  if (!isBoolean(resource)) return `${resource} = ${byte}`;
  return `${resource} is ${STATE_WORDS[signalState(byte)]}`;
}
