// Where each operand of the program stands in its source, and the live decorations that light it.

import { type Range, RangeSet, StateEffect, StateField, type Text } from "@codemirror/state";
import { Decoration, type DecorationSet, EditorView } from "@codemirror/view";
import { describe, isBoolean, isConstant, signalState } from "../history";
import type { ProgramInfo } from "../protocol";

/** An operand that names a resource, by document offsets. */
export interface Place {
  from: number;
  to: number;
  resource: string;
}

/** Finds the operands; where a column does not fit the text, the text is looked up in its line. */
export function placesOf(doc: Text, program: ProgramInfo): Place[] {
  const places: Place[] = [];
  for (const { line: number, operands } of program.functions) {
    if (number < 1 || number > doc.lines) continue;
    const line = doc.line(number);
    let after = 0;
    for (const { text, resource, column, length } of operands) {
      const start = columnOf(line.text, text, column, after);
      if (start < 0) continue;
      after = start + length;
      if (resource !== null) places.push({ from: line.from + start, to: Math.min(line.to, line.from + start + length), resource });
    }
  }
  return places.sort((a, b) => a.from - b.from);
}

function columnOf(line: string, text: string, column: number, after: number): number {
  const fits = (start: number): boolean => line.slice(start, start + text.length).toUpperCase() === text.toUpperCase();
  if (fits(column - 1)) return column - 1;
  return line.toUpperCase().indexOf(text.toUpperCase(), after);
}

export interface Lights {
  places: readonly Place[];
  resources: Readonly<Record<string, number>>;
  /** Lines whose MOVE was just sent. */
  flashed: readonly number[];
}

export const setLights = StateEffect.define<Lights>();

export const lightsField = StateField.define<DecorationSet>({
  create: () => Decoration.none,
  update(decorations, transaction) {
    for (const effect of transaction.effects) {
      if (effect.is(setLights)) return decorate(transaction.newDoc, effect.value);
    }
    return decorations.map(transaction.changes);
  },
  provide: (field) => EditorView.decorations.from(field),
});

function decorate(doc: Text, { places, resources, flashed }: Lights): DecorationSet {
  const ranges: Range<Decoration>[] = flashed
    .filter((line) => line >= 1 && line <= doc.lines)
    .map((line) => Decoration.line({ class: "line-flash" }).range(doc.line(line).from));
  for (const { from, to, resource } of places) {
    const byte = resources[resource];
    const known = byte !== undefined;
    const kind = !known ? "unknown" : isConstant(resource) ? "constant" : isBoolean(resource) ? signalState(byte) : "value";
    const attributes = {
      "data-resource": resource,
      tabindex: "0",
      role: "img",
      "aria-label": known ? describe(resource, byte) : resource,
    };
    ranges.push(Decoration.mark({ class: `operand operand-${kind}`, attributes }).range(from, to));
  }
  return RangeSet.of(ranges, true);
}
