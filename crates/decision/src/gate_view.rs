//! A program as a drawing of gates: pure text to SVG, no screen involved.
//!
//! Every function is a symbol; a wire leads from the function that writes a resource to those
//! below it that read it in the same scan. What comes from the field, from a constant, from the
//! scan before, or from far away, is a name at the pin. Unused inputs, tied to the constant that
//! changes nothing, are left out.
//!
//! Symbols, wires and names carry `data-line` and `data-resource`, so that a screen can light
//! them up while the program runs; colours are the CSS variables `--gate-ink`, `--gate-fill`,
//! `--gate-wire` and `--gate-name`.
//!
//! Method: layers by longest path, long wires as rows of their own, one vertical track per net
//! between two layers. Source: Sugiyama, Tagawa, Toda (1981), "Methods for Visual Understanding
//! of Hierarchical System Structures", IEEE Trans. SMC 11(2). Differences: no search for fewer
//! crossings; every symbol stands where its first wire is straight, if there is room. Symbols
//! follow the thesis, Table 4.6 and Fig. 4.5.

mod layout;
mod svg;
mod symbols;

use crate::Program;

/// Functions that are drawn; the drawing says how many are not.
const N_DRAWN_MAX: usize = 500;

/// Draws a program as an SVG document. O(n²) time at worst for n functions, of which at most 500
/// are drawn.
pub fn gate_view(program: &Program) -> String {
    let drawn = program.functions().iter().take(N_DRAWN_MAX);
    let nodes = drawn.map(|function| symbols::node(function, program.source())).collect();
    let n_left_out = program.functions().len().saturating_sub(N_DRAWN_MAX);
    svg::document(&layout::lay_out(nodes), n_left_out)
}
