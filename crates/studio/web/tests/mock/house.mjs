// The mock's flat: 12 m × 9 m, origin at the centre; walls, furniture, devices, trail; ray casting.

export const BOUNDS = [-6, -4.5, 6, 4.5];

const wall = (x0, y0, x1, y1, material = "plaster") => [x0, y0, x1, y1, material];

export const WALLS = [
  // Outer walls; the corner by the entrance is chamfered, the living room has a glass front.
  wall(-6, -4.5, -1.2, -4.5), wall(-1.2, -4.5, 1.8, -4.5, "glass"), wall(1.8, -4.5, 6, -4.5), wall(6, -4.5, 6, 2.9),
  wall(6, 2.9, 5.999, 3.9), wall(5.4, 4.5, -6, 4.5), wall(6, 3.9, 5.4, 4.5), wall(-6, 4.5, -6, -4.5),
  // Bedroom (upper left), kitchen (lower right), hall along the top right.
  wall(-6, 0.6, -3.6, 0.6), wall(-2.6, 0.6, -1.9, 0.6), wall(-1.9, 0.6, -1.6, 0.9), wall(-1.6, 0.9, -1.6, 4.5),
  wall(2.4, -4.5, 2.4, -2.4), wall(2.4, -1.3, 2.4, 1.0), wall(2.4, 1.0, 2.7, 1.3), wall(2.7, 1.3, 6, 1.3),
  wall(-1.6, 2.2, 0.2, 2.2), wall(1.4, 2.2, 2.7, 2.2), wall(2.7, 2.2, 2.7, 1.3),
];

const box = (x0, y0, x1, y1) => [[x0, y0], [x1, y0], [x1, y1], [x0, y1]];
const thing = (id, name, material, corners_m) => ({ id, name, kind: "furniture", material, corners_m, removable: false });

export const THINGS = [
  thing(1, "sofa", "fabric", box(-1.4, -4.2, 0.8, -3.35)),
  thing(2, "table", "wood", [[-1.0, -2.5], [-0.6, -2.7], [0.2, -2.7], [0.5, -2.5], [0.5, -1.9], [0.2, -1.7], [-0.6, -1.7], [-1.0, -1.9]]),
  thing(3, "bed", "fabric", box(-5.8, 2.5, -3.8, 4.2)),
  thing(4, "wardrobe", "wood", box(-2.2, 2.6, -1.7, 4.3)),
  thing(5, "bookcase", "wood", box(-5.9, -1.7, -5.5, 0.4)),
  thing(6, "kitchen unit", "wood", box(5.3, -4.4, 5.9, 0.4)),
  thing(7, "dining", "wood", box(3.3, -2.6, 4.4, -1.5)),
  thing(8, "shoes", "wood", box(3.0, 4.05, 4.3, 4.4)),
];

export const ROOMS = [
  { name: "Living room", at_m: [-3.4, -2.9] }, { name: "Bedroom", at_m: [-3.0, 1.7] },
  { name: "Kitchen", at_m: [4.3, -0.4] }, { name: "Hall", at_m: [0.4, 3.7] },
];

const device = (name, label, kind, at_m, area_m, input, output) => ({ name, label, kind, at_m, area_m, input, output });
export const DEVICES = [
  device("bell", "Doorbell", "button", [5.55, 4.0], null, 0, null),
  device("motion_living", "Motion, living room", "motion", [-5.75, -4.25], box(-5.9, -4.4, -1.5, -1.8), 1, null),
  device("motion_kitchen", "Motion, kitchen", "motion", [2.65, 1.05], box(2.6, -4.3, 5.2, 1.1), 2, null),
  device("motion_bedroom", "Motion, bedroom", "motion", [-5.75, 0.85], box(-5.8, 0.8, -1.8, 4.3), 3, null),
  device("latch", "Door latch", "latch", [5.95, 3.35], null, null, 0),
  device("lamp", "Hall lamp", "lamp", [2.2, 4.2], null, null, 1),
];

/** From the robot's corner through the living room and the hall to the entrance. */
export const TRAIL = [
  [-4.6, -3.6], [-4.6, -1.2], [-4.2, -0.55], [-3.4, -0.3], [-0.6, -0.3], [0.3, -0.05], [0.8, 0.6], [0.8, 2.6], [1.1, 3.1], [1.8, 3.3], [4.4, 3.3], [5.0, 3.5],
];

export const ROBOT = {
  id: 0, name: "assistant", model: "Pioneer 3-DX",
  footprint_m: [[0.21, -0.12], [0.21, 0.12], [0.13, 0.2], [-0.18, 0.2], [-0.25, 0.12], [-0.25, -0.12], [-0.18, -0.2], [0.13, -0.2]],
  sonars: [[0.075, 0.13, 90], [0.115, 0.115, 50], [0.15, 0.08, 30], [0.17, 0.025, 10], [0.17, -0.025, -10], [0.15, -0.08, -30], [0.115, -0.115, -50], [0.075, -0.13, -90]]
    .map(([x, y, deg]) => ({ at: [x, y, (deg * Math.PI) / 180], half_angle_rad: 0.17, range_max_m: 5 })),
  start: [-4.6, -3.6, Math.PI / 4],
};

/** Cells of 0.2 m along the trail, unit sources of strength 100. */
export function pheromones() {
  const cell_m = 0.2;
  const [width, height] = [61, 46];
  const origin_m = [-6.1, -4.6];
  const cells = new Map();
  for (let i = 1; i < TRAIL.length; i += 1) {
    const [a, b] = [TRAIL[i - 1], TRAIL[i]];
    const n = Math.ceil(Math.hypot(b[0] - a[0], b[1] - a[1]) / 0.05);
    for (let k = 0; k <= n; k += 1) {
      const x = a[0] + ((b[0] - a[0]) * k) / n;
      const y = a[1] + ((b[1] - a[1]) * k) / n;
      const [column, row] = [Math.floor((x - origin_m[0]) / cell_m), Math.floor((y - origin_m[1]) / cell_m)];
      cells.set(`${column},${row}`, [column, row, 100]);
    }
  }
  return { cell_m, width, height, origin_m, values: [...cells.values()], sigma_m: 0.6, antenna_spacing_m: 0.38 };
}

export function segmentsOf(things, people) {
  const segments = WALLS.map(([x0, y0, x1, y1]) => [x0, y0, x1, y1]);
  for (const { corners_m } of things) {
    corners_m.forEach((corner, i) => segments.push([...corner, ...corners_m[(i + 1) % corners_m.length]]));
  }
  for (const { at: [x, y], radius_m: r } of people) {
    for (let k = 0; k < 8; k += 1) {
      const [a, b] = [(k * Math.PI) / 4, ((k + 1) * Math.PI) / 4];
      segments.push([x + r * Math.cos(a), y + r * Math.sin(a), x + r * Math.cos(b), y + r * Math.sin(b)]);
    }
  }
  return segments;
}

export function cast(segments, x, y, yaw, range_max_m) {
  const [dx, dy] = [Math.cos(yaw), Math.sin(yaw)];
  let best = range_max_m;
  for (const [x0, y0, x1, y1] of segments) {
    const [ex, ey] = [x1 - x0, y1 - y0];
    const cross = dx * ey - dy * ex;
    if (Math.abs(cross) < 1e-12) continue;
    const t = ((x0 - x) * ey - (y0 - y) * ex) / cross;
    const s = ((x0 - x) * dy - (y0 - y) * dx) / cross;
    if (t >= 0 && t < best && s >= 0 && s <= 1) best = t;
  }
  return best;
}

export function distance(segments, x, y) {
  let best = 5;
  for (const [x0, y0, x1, y1] of segments) {
    const [ex, ey] = [x1 - x0, y1 - y0];
    const t = Math.max(0, Math.min(1, ((x - x0) * ex + (y - y0) * ey) / (ex * ex + ey * ey || 1)));
    best = Math.min(best, Math.hypot(x - x0 - t * ex, y - y0 - t * ey));
  }
  return best;
}
