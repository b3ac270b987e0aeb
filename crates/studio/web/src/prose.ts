// What a mission says about itself has a few marks of plain text: *emphasis*, `code`, and settings of the command line.

import { h } from "./dom";

export interface Piece {
  kind: "text" | "emphasis" | "code";
  text: string;
}

const MARKED = /\*(\S(?:[^*\n]*\S)?)\*|`([^`\n]+)`|(--set(?: [\w.[\]]+=[^\s,;)]*[^\s,;).:])?)/g;

/** The pieces of a text, without their marks. */
export function pieces(text: string): Piece[] {
  const found: Piece[] = [];
  let from = 0;
  for (const match of text.matchAll(MARKED)) {
    if (match.index > from) found.push({ kind: "text", text: text.slice(from, match.index) });
    found.push(match[1] !== undefined ? { kind: "emphasis", text: match[1] } : { kind: "code", text: match[2] ?? match[3] ?? "" });
    from = match.index + match[0].length;
  }
  if (from < text.length) found.push({ kind: "text", text: text.slice(from) });
  return found;
}

/** The same for the page. */
export function prose(text: string): (Node | string)[] {
  return pieces(text).map(({ kind, text: said }) => (kind === "text" ? said : h(kind === "code" ? "code" : "em", {}, said)));
}

/** The same without any marks. */
export function plain(text: string): string {
  return pieces(text).map(({ text: said }) => said).join("");
}
