// The part of the picture that stands still: floor, grid, pheromones, rooms, furniture, walls, plan.

import type { Hello, Thing } from "../protocol";
import type { FieldImage } from "./field";
import type { Layers } from "./layers";
import { drawTags } from "./marks";
import { centroid, label, type Pen, tracePolygon } from "./pen";

/** Side of the square that stands for one scanned point. */
const POINT_M = 0.05;

export function drawScene(pen: Pen, hello: Hello, layers: Layers, field: FieldImage | null): void {
  drawFloor(pen, hello, layers.has("grid"));
  if (layers.has("pheromones") && hello.pheromones && field) drawField(pen, hello.pheromones, field);
  if (layers.has("tags") && hello.tags) drawTags(pen, hello.tags);
  for (const thing of hello.world.things) drawThing(pen, thing, layers.has("names"));
  drawWalls(pen, hello);
  if (layers.has("names")) drawRooms(pen, hello);
  if (layers.has("plan")) drawPlan(pen, hello);
}

function drawFloor({ context, camera, palette }: Pen, hello: Hello, withGrid: boolean): void {
  const [x0_m, y0_m, x1_m, y1_m] = hello.world.bounds_m;
  const [left, bottom] = camera.toScreen(x0_m, y0_m);
  const [right, top] = camera.toScreen(x1_m, y1_m);
  context.fillStyle = palette.colour.void;
  context.fillRect(0, 0, camera.width_px, camera.height_px);
  context.fillStyle = palette.colour.floor;
  context.fillRect(left, top, right - left, bottom - top);
  if (!withGrid || camera.scale_pxpm < 9) return;
  context.strokeStyle = palette.colour.grid;
  context.lineWidth = 1;
  context.beginPath();
  for (let x_m = Math.ceil(x0_m); x_m <= x1_m; x_m += 1) {
    const x = Math.round(camera.toScreen(x_m, 0)[0]) + 0.5;
    context.moveTo(x, top);
    context.lineTo(x, bottom);
  }
  for (let y_m = Math.ceil(y0_m); y_m <= y1_m; y_m += 1) {
    const y = Math.round(camera.toScreen(0, y_m)[1]) + 0.5;
    context.moveTo(left, y);
    context.lineTo(right, y);
  }
  context.stroke();
}

function drawField({ context, camera }: Pen, field: NonNullable<Hello["pheromones"]>, image: FieldImage): void {
  const [x_m, y_m] = field.origin_m;
  const [left, top] = camera.toScreen(x_m, y_m + field.height * field.cell_m);
  context.imageSmoothingEnabled = true;
  context.imageSmoothingQuality = "high";
  const width_px = field.width * field.cell_m * camera.scale_pxpm;
  const height_px = field.height * field.cell_m * camera.scale_pxpm;
  context.drawImage(image.canvas, left, top, width_px, height_px);
}

function drawRooms(pen: Pen, hello: Hello): void {
  const size_px = Math.max(11, Math.min(17, pen.camera.scale_pxpm * 0.26));
  for (const { name, at_m } of hello.world.rooms) {
    label(pen, name, pen.camera.toScreen(at_m[0], at_m[1]), { colour: pen.palette.colour.room, size_px, weight: 600 });
  }
}

/** Furniture, or a box that came later. */
export function drawThing(pen: Pen, thing: Thing, withName: boolean): void {
  const { context, camera, palette } = pen;
  const isBox = thing.kind === "box";
  tracePolygon(pen, thing.corners_m);
  context.fillStyle = isBox ? palette.colour.box : palette.colour.thing;
  context.fill();
  context.strokeStyle = isBox ? palette.colour["box-line"] : palette.colour["thing-line"];
  context.lineWidth = 1.25;
  context.lineJoin = "round";
  context.stroke();
  if (isBox) {
    // Two strokes of tape make a box a box.
    tracePolygon(pen, thing.corners_m.filter((_, index) => index % 2 === 0), false);
    context.globalAlpha = 0.5;
    context.stroke();
    context.globalAlpha = 1;
    return;
  }
  if (!withName) return;
  const xs = thing.corners_m.map(([x]) => x);
  const width_px = (Math.max(...xs) - Math.min(...xs)) * camera.scale_pxpm;
  context.font = `500 11px ${palette.font}`;
  if (context.measureText(thing.name).width > width_px - 4) return;
  const [x_m, y_m] = centroid(thing.corners_m);
  const [x_px, y_px] = camera.toScreen(x_m, y_m);
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.fillStyle = palette.colour["thing-text"];
  context.fillText(thing.name, x_px, y_px);
}

function drawWalls(pen: Pen, hello: Hello): void {
  const { context, camera, palette } = pen;
  context.lineCap = "round";
  for (const [x0, y0, x1, y1, material] of hello.world.walls) {
    const isGlass = material === "glass";
    const [x0_px, y0_px] = camera.toScreen(x0, y0);
    const [x1_px, y1_px] = camera.toScreen(x1, y1);
    context.strokeStyle = isGlass ? palette.colour.estimate : palette.colour.wall;
    context.lineWidth = Math.max(2, Math.min(7, camera.scale_pxpm * (isGlass ? 0.045 : 0.07)));
    context.beginPath();
    context.moveTo(x0_px, y0_px);
    context.lineTo(x1_px, y1_px);
    context.stroke();
  }
  const side_px = Math.max(1, POINT_M * camera.scale_pxpm);
  context.fillStyle = palette.colour.wall;
  for (const [x, y] of hello.world.points) {
    const [x_px, y_px] = camera.toScreen(x, y);
    context.fillRect(x_px - side_px / 2, y_px - side_px / 2, side_px, side_px);
  }
}

function drawPlan(pen: Pen, hello: Hello): void {
  if (hello.planned_path_m.length < 2) return;
  const { context, palette } = pen;
  tracePolygon(pen, hello.planned_path_m, false);
  context.strokeStyle = palette.colour.plan;
  context.lineWidth = 2;
  context.lineJoin = "round";
  context.setLineDash([2, 6]);
  context.stroke();
  context.setLineDash([]);
}
