// The mock's planar scanner: 361 beams over half a turn, some free, some lost.

import { cast } from "./house.mjs";

const N_BEAMS = 361;
const RANGE_MAX_M = 3.2;

export const SCANNER = { name: "laser", at: [0.1, 0, 0], first_angle_rad: -Math.PI / 2, step_rad: Math.PI / (N_BEAMS - 1), n_beams: N_BEAMS, range_max_m: RANGE_MAX_M };

/** Beams as the program packs them; one in sixteen says nothing, as on glass. */
export function scanAt(pose, segments, number) {
  const bytes = Buffer.alloc(2 * N_BEAMS);
  for (let i = 0; i < N_BEAMS; i += 1) {
    const range_m = cast(segments, pose[0], pose[1], pose[2] + SCANNER.first_angle_rad + i * SCANNER.step_rad, RANGE_MAX_M);
    const beam = (i + number) % 16 === 0 ? 0 : range_m >= RANGE_MAX_M ? 65535 : Math.round(range_m * 1000);
    bytes.writeUInt16LE(beam, 2 * i);
  }
  return [0, pose, bytes.toString("base64")];
}
