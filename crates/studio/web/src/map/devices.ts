// The house's devices on the map: bell, motion zones, latch, lamp; lit while they are on.

import { PATHS } from "../icons";
import type { Device, Point, State } from "../protocol";
import type { Camera } from "./camera";
import { label, type Pen, tracePolygon } from "./pen";

export const DEVICE_ICONS = { button: "bell", motion: "motion", latch: "latch", lamp: "lamp" } as const;
const RADIUS_PX = 12;

export function isOn(state: State | null, name: string): boolean {
  return state?.devices.some((device) => device.name === name && device.on) ?? false;
}

/** Watched areas lie under everything that moves. */
export function drawZones(pen: Pen, devices: readonly Device[], state: State | null): void {
  const { context, palette } = pen;
  for (const device of devices) {
    if (!device.area_m) continue;
    const on = isOn(state, device.name);
    const colour = on ? palette.colour["zone-on"] : palette.colour.zone;
    tracePolygon(pen, device.area_m);
    context.fillStyle = colour;
    context.globalAlpha = on ? 0.2 : 0.05;
    context.fill();
    context.globalAlpha = on ? 0.9 : 0.45;
    context.strokeStyle = colour;
    context.lineWidth = on ? 1.5 : 1;
    context.setLineDash([4, 4]);
    context.stroke();
    context.setLineDash([]);
    context.globalAlpha = 1;
  }
}

export function drawDevices(pen: Pen, devices: readonly Device[], state: State | null, hovered: string | null): void {
  for (const device of devices) drawDevice(pen, device, isOn(state, device.name), hovered === device.name);
}

/** The device under a pixel, if any. */
export function deviceAt(camera: Camera, devices: readonly Device[], at_px: Point): Device | null {
  for (const device of devices) {
    const [x, y] = camera.toScreen(device.at_m[0], device.at_m[1]);
    if (Math.hypot(x - at_px[0], y - at_px[1]) <= RADIUS_PX + 4) return device;
  }
  return null;
}

function drawDevice(pen: Pen, device: Device, on: boolean, hovered: boolean): void {
  const { context, camera, palette } = pen;
  const [x, y] = camera.toScreen(device.at_m[0], device.at_m[1]);
  const radius = camera.scale_pxpm < 28 ? RADIUS_PX * 0.7 : RADIUS_PX;
  if (on) {
    context.beginPath();
    context.arc(x, y, radius + 6, 0, 2 * Math.PI);
    context.fillStyle = palette.colour["device-on"];
    context.globalAlpha = 0.3;
    context.fill();
    context.globalAlpha = 1;
  }
  context.beginPath();
  context.arc(x, y, radius, 0, 2 * Math.PI);
  context.fillStyle = on ? palette.colour["device-on"] : palette.surface;
  context.fill();
  context.lineWidth = hovered ? 2.5 : 1.4;
  context.strokeStyle = hovered ? palette.accent : on ? palette.colour["device-on"] : palette.colour.device;
  context.stroke();
  drawIcon(pen, PATHS[DEVICE_ICONS[device.kind]], [x, y], radius * 1.35, on ? palette.surface : palette.colour.device);
  if (hovered) label(pen, device.label, [x, y + radius + 11], { colour: palette.ink, size_px: 12, weight: 600 });
}

function drawIcon({ context }: Pen, path: string, [x, y]: Point, size_px: number, colour: string): void {
  context.save();
  context.translate(x - size_px / 2, y - size_px / 2);
  context.scale(size_px / 20, size_px / 20);
  context.strokeStyle = colour;
  context.lineWidth = 1.8;
  context.lineCap = "round";
  context.lineJoin = "round";
  context.stroke(new Path2D(path));
  context.restore();
}
