// RDPL for the editor: a small highlighter (labels, mnemonics, resources, numbers, comments).

import { HighlightStyle, StreamLanguage, syntaxHighlighting } from "@codemirror/language";
import type { Extension } from "@codemirror/state";
import { tags } from "@lezer/highlight";

const CONSTANTS = new Set(["RISE", "FALL", "UP", "DOWN", "MONO", "OSC"]);
const RESOURCE = /^(NI\d+|I\d+|O\d+|A\d+|M\d+|YTMR\d+|Y\d+|STATUS|S\d+|[01]L|QRUN|HOUR|MINUTE|SECOND|DAY|MONTH|WEEKDAY)$/;

/** A program is shown with the functions that it has: the table of all of them is the compiler's. */
const rdpl = (functions: ReadonlySet<string>) => StreamLanguage.define({
  name: "rdpl",
  token(stream) {
    if (stream.eatSpace()) return null;
    if (stream.match(/^;.*/)) return "comment";
    if (stream.match(/^(["']).*?\1/)) return "string";
    if (stream.match(/^(\$[0-9a-f]+|%[01]+|-?\d+(?![0-9A-Za-z]))/i)) return "number";
    const word = stream.match(/^\w+/);
    if (!word || word === true) {
      stream.next();
      return "punctuation";
    }
    const text = word[0].toUpperCase();
    if (text === "EQU" || functions.has(text)) return "keyword";
    if (CONSTANTS.has(text)) return "atom";
    return RESOURCE.test(text) ? "variableName" : "labelName";
  },
});

const colours = HighlightStyle.define([
  { tag: tags.keyword, color: "var(--accent)", fontWeight: "600" },
  { tag: tags.atom, color: "var(--series-3)" },
  { tag: tags.number, color: "var(--series-4)" },
  { tag: tags.string, color: "var(--good)" },
  { tag: tags.comment, color: "var(--muted)", fontStyle: "italic" },
  { tag: tags.labelName, color: "var(--warn)" },
]);

export function rdplLanguage(functions: Iterable<string>): Extension {
  return [rdpl(new Set(functions)), syntaxHighlighting(colours)];
}
