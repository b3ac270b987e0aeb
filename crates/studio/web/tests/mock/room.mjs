// A log made by arithmetic: a robot drives twice around in a room of 8 m × 6 m; its odometry turns away by 2° per metre.

const WALLS = [
  ...polyline([[0, 0], [8, 0], [8, 6], [0, 6], [0, 0]]),
  ...polyline([[0, 2], [0.9, 2], [0.9, 3.2], [0, 3.2]]),
  ...polyline([[3.6, 2.7], [4.5, 2.7], [4.5, 3.3], [3.6, 3.3], [3.6, 2.7]]),
];
const N_BEAMS = 181;
const RANGE_MAX_M = 81.83;

/** The text of a CARMEN log; the last lines are bad on request. */
export function roomLog(n_scans, { bad = false } = {}) {
  const lines = ["# made by arithmetic"];
  let odometry = [0, 0, 0];
  let before = null;
  for (let i = 0; i < n_scans; i += 1) {
    const pose = poseAt((4 * Math.PI * i) / n_scans);
    if (before) odometry = drift(odometry, before, pose);
    before = pose;
    const ranges = Array.from({ length: N_BEAMS }, (_, beam) => range(pose, -Math.PI / 2 + (beam * Math.PI) / 180).toFixed(3));
    const place = odometry.map((value) => value.toFixed(6)).join(" ");
    const time = (1000 + i * 0.2).toFixed(3);
    lines.push(`FLASER ${N_BEAMS} ${ranges.join(" ")} ${place} ${place} ${time} room ${time}`);
  }
  if (bad) lines.push("FLASER 181 1.0 2.0", "FLASER 181 nonsense");
  return `${lines.join("\n")}\n`;
}

function poseAt(angle) {
  const heading = Math.atan2(1.6 * Math.cos(angle), -2.4 * Math.sin(angle));
  return [4 + 2.4 * Math.cos(angle), 3 + 1.6 * Math.sin(angle), heading];
}

function drift([x, y, yaw], before, after) {
  const [dx, dy] = [after[0] - before[0], after[1] - before[1]];
  const forward = Math.cos(before[2]) * dx + Math.sin(before[2]) * dy;
  const left = -Math.sin(before[2]) * dx + Math.cos(before[2]) * dy;
  const turn = Math.atan2(Math.sin(after[2] - before[2]), Math.cos(after[2] - before[2]));
  const way = Math.hypot(dx, dy);
  return [x + Math.cos(yaw) * forward - Math.sin(yaw) * left, y + Math.sin(yaw) * forward + Math.cos(yaw) * left, yaw + turn + (2 * Math.PI * way) / 180];
}

function range([x, y, yaw], bearing) {
  const [ux, uy] = [Math.cos(yaw + bearing), Math.sin(yaw + bearing)];
  let nearest = RANGE_MAX_M;
  for (const [ax, ay, bx, by] of WALLS) {
    const [ex, ey] = [bx - ax, by - ay];
    const cross = ux * ey - uy * ex;
    if (Math.abs(cross) < 1e-12) continue;
    const along = ((ax - x) * ey - (ay - y) * ex) / cross;
    const share = ((ax - x) * uy - (ay - y) * ux) / cross;
    if (along > 0 && share >= 0 && share <= 1) nearest = Math.min(nearest, along);
  }
  return nearest;
}

function polyline(corners) {
  return corners.slice(1).map((corner, i) => [...corners[i], ...corner]);
}
