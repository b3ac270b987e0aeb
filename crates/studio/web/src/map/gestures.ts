// Turns pointers, wheel and pinch on the canvas into pan, zoom, hover, click and drag of a tool.

import type { Point } from "../protocol";
import type { Camera } from "./camera";

export interface GestureEvents {
  /** True when a press begins something of the tool's own and must not pan. */
  press(at_px: Point): boolean;
  drag(at_px: Point): void;
  release(at_px: Point): void;
  cancel(): void;
  click(at_px: Point): void;
  /** null when the pointer leaves. */
  hover(at_px: Point | null): void;
  /** The user moved the camera by hand. */
  moved(): void;
}

const CLICK_SLOP_PX = 5;
const WHEEL_RATE = 0.0016;

export function attachGestures(canvas: HTMLCanvasElement, camera: Camera, events: GestureEvents): void {
  const pointers = new Map<number, Point>();
  let mode: "none" | "pan" | "tool" | "pinch" = "none";
  let start_px: Point = [0, 0];
  let wandered = false;

  const at = (event: PointerEvent | WheelEvent): Point => {
    const box = canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };

  canvas.addEventListener("pointerdown", (event) => {
    if (event.button > 1) return;
    canvas.setPointerCapture(event.pointerId);
    const here = at(event);
    pointers.set(event.pointerId, here);
    if (pointers.size === 2) {
      if (mode === "tool") events.cancel();
      mode = "pinch";
      return;
    }
    start_px = here;
    wandered = false;
    mode = event.button === 0 && events.press(here) ? "tool" : "pan";
  });

  canvas.addEventListener("pointermove", (event) => {
    const here = at(event);
    const before = pointers.get(event.pointerId);
    if (!before) return events.hover(here);
    if (Math.hypot(here[0] - start_px[0], here[1] - start_px[1]) > CLICK_SLOP_PX) wandered = true;
    if (mode === "pinch") pinch(event.pointerId, before, here);
    pointers.set(event.pointerId, here);
    if (mode === "tool") {
      events.hover(here);
      events.drag(here);
    } else if (mode === "pan" && wandered) {
      canvas.classList.add("is-panning");
      camera.panBy(here[0] - before[0], here[1] - before[1]);
      events.moved();
    }
  });

  const end = (event: PointerEvent, cancelled: boolean): void => {
    if (!pointers.delete(event.pointerId)) return;
    canvas.classList.remove("is-panning");
    const here = at(event);
    if (mode === "tool") {
      if (cancelled) events.cancel();
      else events.release(here);
    } else if (mode === "pan" && !wandered && !cancelled) {
      events.click(here);
    }
    // After a pinch the remaining finger does nothing until it is lifted.
    if (pointers.size === 0) mode = "none";
    if (event.pointerType === "touch") events.hover(null);
  };
  canvas.addEventListener("pointerup", (event) => end(event, false));
  canvas.addEventListener("pointercancel", (event) => end(event, true));
  canvas.addEventListener("pointerleave", () => events.hover(null));

  canvas.addEventListener(
    "wheel",
    (event) => {
      event.preventDefault();
      const pixels = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? event.deltaY * 24 : event.deltaY;
      // A pinch on a touchpad arrives as a wheel with Ctrl and small steps.
      const rate = event.ctrlKey ? WHEEL_RATE * 6 : WHEEL_RATE;
      camera.zoomAt(...at(event), Math.exp(-pixels * rate));
      events.moved();
    },
    { passive: false },
  );

  function pinch(id: number, before: Point, here: Point): void {
    for (const [other_id, other] of pointers) {
      if (other_id === id) continue;
      const length_before = Math.hypot(before[0] - other[0], before[1] - other[1]);
      const length = Math.hypot(here[0] - other[0], here[1] - other[1]);
      camera.panBy((here[0] - before[0]) / 2, (here[1] - before[1]) / 2);
      if (length_before > 1) camera.zoomAt((here[0] + other[0]) / 2, (here[1] + other[1]) / 2, length / length_before);
      events.moved();
    }
  }
}
