// Where an axis is marked: round values, at least three of them, however low the plot is.

const STEPS = [5, 2.5, 2, 1] as const;
const N_TICKS_MIN = 3;

/** The round values between `min` and `max` with the largest step that gives three or more; at most six of them. */
export function ticks(min: number, max: number): number[] {
  const range = max - min;
  if (!(range > 0) || !Number.isFinite(range)) return [min];
  for (let decade = Math.ceil(Math.log10(range)); ; decade -= 1) {
    for (const mantissa of STEPS) {
      const step = mantissa * 10 ** decade;
      const first = Math.ceil(min / step - 1e-9);
      const last = Math.floor(max / step + 1e-9);
      if (last - first + 1 < N_TICKS_MIN) continue;
      // Adding zero turns -0 into 0; twelve digits hide what binary makes of a tenth.
      return Array.from({ length: last - first + 1 }, (_, index) => Number(((first + index) * step).toPrecision(12)) + 0);
    }
  }
}
