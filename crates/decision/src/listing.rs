//! The `.lst` text: every line of the source with its address and bytes, and what is wrong.

use std::fmt::Write as _;

use crate::{
    Compilation, Estimate, Function, Program, compile,
    image::hex,
    source_text::{end_of_text, lines},
};

impl Program {
    /// The listing of the program, as [`Compilation::listing`] gives it.
    pub fn listing(&self) -> String {
        compile(&self.source).listing()
    }
}

impl Compilation {
    /// The listing: line number, address, bytes and text of every line, problems below the line
    /// they are about, symbols, and the totals in the words of the thesis's compiler.
    ///
    /// Columns: the number of the line (5 wide), two blanks, the address of the instruction in the
    /// image (4 hexadecimal digits) and its bytes (32 wide together; empty where the line has no
    /// function), two blanks, the line. Cost: linear in the text.
    pub fn listing(&self) -> String {
        let mut text = String::with_capacity(self.source.len().saturating_mul(3));
        text.push_str("Cairn RDPL compiler list file.\n\n");
        let image = self.program.as_ref().map_or(&[][..], |program| program.image());
        let functions = self.program.as_ref().map_or(&[][..], |program| program.functions());
        let mut functions = functions.iter().peekable();
        let mut diagnostics = self.diagnostics.iter().peekable();
        let (end, _) = end_of_text(&self.source);
        let source = self.source.get(..end).unwrap_or(&self.source);
        for (number, (_, line)) in (1..).zip(lines(source)) {
            let function = functions.next_if(|function| function.line == number);
            let code = function.map(|function| code_of(function, image)).unwrap_or_default();
            // Writing to a string cannot fail.
            let _fine = write!(text, "{number:5}  {code:32}  {line}");
            text.truncate(text.trim_end().len());
            text.push('\n');
            while let Some(diagnostic) = diagnostics.next_if(|d| d.line <= number) {
                let _fine = writeln!(text, "*****  {diagnostic}");
            }
        }
        for diagnostic in diagnostics {
            let _fine = writeln!(text, "*****  {diagnostic}");
        }
        self.list_totals(&mut text);
        text
    }

    fn list_totals(&self, text: &mut String) {
        if !self.symbols.is_empty() {
            text.push_str("\nSymbols\n");
        }
        for (name, line, symbol) in &self.symbols {
            let _fine = writeln!(text, "       {name} = {symbol} (line {line})");
        }
        if let Some(program) = &self.program {
            let Estimate { n_functions, bytes, scan_ms, .. } = program.estimate();
            let _fine = writeln!(
                text,
                "\n{n_functions} functions, {bytes} bytes, {scan_ms:.1} ms per scan"
            );
        }
        let (n_lines, n_errors) = (self.n_lines, self.n_errors);
        let _fine = writeln!(text, "\nLines compiled: {n_lines}. Total errors {n_errors}");
    }
}

/// `0001 06 41 01 02 03 D1`.
fn code_of(function: &Function, image: &[u8]) -> String {
    let start = function.address;
    let bytes = image.get(start..start.saturating_add(function.mnemonic.size_bytes()));
    format!("{start:04X} {}", hex(bytes.unwrap_or_default()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use expect_test::expect;

    #[test]
    fn addresses_and_bytes_stand_beside_the_text() {
        let source = "; lamp\nDARK equ 40\n\n  STIC M0,DARK,1L,3\nACOMP O1,M0,A0 ; on";
        let program = compile(source).program.expect("correct");
        expect![[r"
            Cairn RDPL compiler list file.

                1                                    ; lamp
                2                                    DARK equ 40
                3
                4  0001 11 38 28 D2 03                 STIC M0,DARK,1L,3
                5  0006 0D 21 38 30                  ACOMP O1,M0,A0 ; on

            Symbols
                   DARK = 40 (line 2)

            2 functions, 11 bytes, 0.8 ms per scan

            Lines compiled: 5. Total errors 0
        "]]
        .assert_eq(&program.listing());
    }

    #[test]
    fn problems_stand_below_their_line() {
        expect![[r"
            Cairn RDPL compiler list file.

                1                                    ADN O1,I0
            *****  1:1 R1001 error: there is no function `ADN` (did you mean `AND`?)
                2                                    AND O1,I0,I1,1L,1L

            Lines compiled: 2. Total errors 1
        "]]
        .assert_eq(&compile("ADN O1,I0\nAND O1,I0,I1,1L,1L\n").listing());
    }
}
