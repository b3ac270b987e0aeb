//! Columns of the inverse of a factor: what covariances are made of.

use nalgebra::Matrix3;

use crate::linear::{BlockCholesky, Pattern};

/// Memory of the substitutions.
#[derive(Debug)]
pub(crate) struct Scratch {
    /// The supernode of every column.
    pub(crate) supernodes: Vec<u32>,
    /// Y of the vertex asked about and of its partner, kept until another is asked about.
    pub(crate) first: Column,
    pub(crate) second: Column,
}

/// Three columns of L⁻¹, and the rows (begin, end) where they are not zero, ascending.
#[derive(Debug, Default)]
pub(crate) struct Column {
    /// Whose columns they are; none: all is zero.
    vertex: Option<usize>,
    rows: Vec<[f64; 3]>,
    path: Vec<(usize, usize)>,
}

impl Scratch {
    pub(crate) fn new(equations: &BlockCholesky<3>, pattern: &Pattern) -> Self {
        let size = 3 * pattern.n_variables();
        let mut supernodes = Vec::with_capacity(size);
        let mut n_supernodes = 0;
        if let Some(symbolic) = equations.symbolic_supernodes() {
            n_supernodes = symbolic.n_supernodes();
            let ends = symbolic.supernode_begin().iter().zip(symbolic.supernode_end());
            for (index, (begin, end)) in ends.enumerate() {
                supernodes.extend((*begin..*end).map(|_| index as u32));
            }
        }
        let column = || Column {
            vertex: None,
            rows: vec![[0.0; 3]; size],
            path: Vec::with_capacity(n_supernodes),
        };
        Self { supernodes, first: column(), second: column() }
    }
}

impl Column {
    pub(crate) fn become_that_of(
        &mut self,
        vertex: usize,
        pattern: &Pattern,
        equations: &BlockCholesky<3>,
        supernodes: &[u32],
    ) -> Option<()> {
        if self.vertex == Some(vertex) {
            return Some(());
        }
        self.clear();
        if let Some(variable) = pattern.variable(vertex) {
            self.substitute(equations, supernodes, variable)?;
        }
        self.vertex = Some(vertex);
        Some(())
    }

    /// Solves L Y = E for the three columns of a variable, along its path.
    fn substitute(
        &mut self,
        equations: &BlockCholesky<3>,
        supernodes: &[u32],
        variable: usize,
    ) -> Option<()> {
        let factor = equations.supernodes()?;
        for axis in 0..3 {
            self.rows[3 * variable + axis][axis] = 1.0;
        }
        let mut supernode = supernodes[3 * variable] as usize;
        loop {
            let part = factor.supernode(supernode);
            let (start, pattern) = (part.start(), part.pattern());
            let n_columns = part.val().ncols();
            self.path.push((start, start + n_columns));
            for column in 0..n_columns {
                // The columns of a supernode are contiguous: its own rows first, then the pattern.
                let entries = part.val().col(column).try_as_col_major()?.as_slice();
                let y = self.rows[start + column].map(|v| v / entries[column]);
                self.rows[start + column] = y;
                if y.iter().all(|v| *v == 0.0) {
                    continue;
                }
                let own = self.rows[start..start + n_columns].iter_mut().skip(column + 1);
                for (row, l) in own.zip(&entries[column + 1..n_columns]) {
                    subtract(row, *l, y);
                }
                for (row, l) in pattern.iter().zip(&entries[n_columns..]) {
                    subtract(&mut self.rows[*row as usize], *l, y);
                }
            }
            let Some(next) = pattern.first() else { return Some(()) };
            supernode = supernodes[*next as usize] as usize;
        }
    }

    /// Sets everything to zero again.
    pub(crate) fn clear(&mut self) {
        self.vertex = None;
        for (begin, end) in self.path.drain(..) {
            self.rows[begin..end].fill([0.0; 3]);
        }
    }
}

/// Y_aᵀ Y_b.
pub(crate) fn product(a: &Column, b: &Column) -> Matrix3<f64> {
    let mut sum = Matrix3::zeros();
    for &(begin, end) in &a.path {
        for (x, y) in a.rows[begin..end].iter().zip(&b.rows[begin..end]) {
            for column in 0..3 {
                for row in 0..3 {
                    sum[(row, column)] += x[row] * y[column];
                }
            }
        }
    }
    sum
}

#[inline]
fn subtract(row: &mut [f64; 3], l: f64, y: [f64; 3]) {
    for axis in 0..3 {
        row[axis] -= l * y[axis];
    }
}
