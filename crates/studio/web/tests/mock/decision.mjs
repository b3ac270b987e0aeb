// The mock's decision module: the doorbell program of the thesis, hand-evaluated with history bytes.

export const SOURCE = `; The doorbell. If nobody moves for 15 s after it rang,
; the robot goes to the entrance.
OR   Y1,I1,I2,I3,0L        ; somebody moves
FF   Y2,I0,Y1,0            ; set by the bell, reset by motion
TIMER 16,MONO,I0,RISE,15   ; 15 s from the bell
TIMER 0,MONO,YTMR16,FALL,10 ; 100 ms when they are over
AND  Y3,YTMR0,Y2,1L,1L
MOVE Y3,5000,3500,45,RISE
`;

const WORDS = /[A-Z0-9]+/gi;
const RESOURCE = /^(I\d+|O\d+|Y\d+|YTMR\d+|[01]L)$/;

/** Lines, columns and resources as the compiler reports them. */
export function functions() {
  return SOURCE.split("\n").flatMap((text, index) => {
    const code = text.split(";")[0];
    const words = [...code.matchAll(WORDS)];
    if (words.length === 0) return [];
    const [mnemonic, ...operands] = words;
    return [{
      line: index + 1,
      mnemonic: mnemonic[0],
      operands: operands.map((word, at) => {
        const isTimer = mnemonic[0] === "TIMER" && at === 0;
        const resource = isTimer ? `YTMR${word[0]}` : RESOURCE.test(word[0]) ? word[0] : null;
        return { text: word[0], resource, column: word.index + 1, length: word[0].length };
      }),
    }];
  });
}

export class Decision {
  bytes = { I0: 0, I1: 0, I2: 0, I3: 0, Y1: 0, Y2: 0, Y3: 0, YTMR16: 0, YTMR0: 0, "0L": 0, "1L": 255 };
  left_s = { 16: 0, 0: 0 };
  scans = 0;
  edges = [];

  /** One scan every 10 ms; true when MOVE is sent. */
  scan(inputs) {
    const { bytes, left_s } = this;
    const shift = (name, bit) => {
      if ((bytes[name] & 1) !== (bit ? 1 : 0)) this.edges.push([this.scans / 100, name, Boolean(bit)]);
      bytes[name] = ((bytes[name] << 1) | (bit ? 1 : 0)) & 0xff;
    };
    const edge = (name) => bytes[name] & 3;
    this.scans += 1;
    inputs.forEach((on, i) => shift(`I${i}`, on));
    for (const timer of [16, 0]) left_s[timer] = Math.max(0, left_s[timer] - 0.01);
    shift("Y1", (bytes.I1 | bytes.I2 | bytes.I3) & 1);
    shift("Y2", bytes.Y1 & 1 ? 0 : bytes.I0 & 1 ? 1 : bytes.Y2 & 1);
    if (edge("I0") === 1) left_s[16] = 15;
    shift("YTMR16", left_s[16] > 1e-9);
    if (edge("YTMR16") === 2) left_s[0] = 0.1;
    shift("YTMR0", left_s[0] > 1e-9);
    shift("Y3", bytes.YTMR0 & bytes.Y2 & 1);
    return edge("Y3") === 1;
  }

  state() {
    const timers = [[16, 15], [0, 0.1]].map(([index, total_s]) => ({ index, remaining_s: round(this.left_s[index]), total_s, on: (this.bytes[`YTMR${index}`] & 1) === 1 }));
    return { scans: this.scans, resources: { ...this.bytes }, timers, run: true, edges: this.edges.splice(0) };
  }
}

function round(value) {
  return Math.round(value * 1000) / 1000;
}
