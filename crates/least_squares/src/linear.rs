//! Sparse symmetric equations of N × N blocks: pattern, scatter, Cholesky factor, solution.
//!
//! The elimination order is found once for the blocks (approximate minimum degree), so the three
//! columns of a pose stay together and the factor has wide supernodes. Everything that depends
//! only on which vertices are joined is kept; a new set of values costs one numeric factorisation
//! and no allocation.

use std::ops::Range;

use faer::{
    Conj, MatMut, Par, Side, Spec,
    dyn_stack::{MemBuffer, MemStack},
    sparse::{
        FaerError, SparseColMatRef, SymbolicSparseColMat, SymbolicSparseColMatRef,
        linalg::{
            SupernodalThreshold, amd,
            cholesky::{
                CholeskySymbolicParams, LltRef, SymbolicCholesky, SymbolicCholeskyRaw,
                SymmetricOrdering, factorize_symbolic_cholesky,
                supernodal::{SupernodalLltRef, SymbolicSupernodalCholesky},
            },
        },
    },
};
use nalgebra::SMatrix;

/// The pattern or the factor has more entries than indices, or than memory.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TooLarge;

impl From<FaerError> for TooLarge {
    fn from(_: FaerError) -> Self {
        Self
    }
}

/// Stands for a vertex that is not moved.
const HELD: u32 = u32::MAX;

/// Which blocks of the matrix are filled, in elimination order, lower triangle by columns.
#[derive(Debug, Default)]
pub(crate) struct Pattern {
    /// Place of each vertex in elimination order, or `HELD`.
    variables: Vec<u32>,
    n_variables: usize,
    /// Where each block column begins in `rows`; its first block is the diagonal.
    begins: Vec<u32>,
    rows: Vec<u32>,
    /// For every edge where its block lies.
    slots: Vec<Slot>,
}

/// The off-diagonal block of an edge.
#[derive(Clone, Copy, Debug, Default)]
struct Slot {
    /// Where the block column begins, in blocks.
    begin: u32,
    /// How many blocks the column has.
    n_blocks: u32,
    /// Which of them it is; 0, the diagonal, when an end of the edge is held.
    position: u32,
    /// Whether the stored block belongs to (to, from), not (from, to).
    is_transposed: bool,
}

/// Values and factor of a matrix with a [`Pattern`].
pub(crate) struct BlockCholesky<const N: usize> {
    lower: SymbolicSparseColMat<u32>,
    symbolic: SymbolicCholesky<u32>,
    values: Vec<f64>,
    factor: Vec<f64>,
    memory: MemBuffer,
}

impl Pattern {
    /// Finds the elimination order for `edges` (pairs of vertices) where `is_held` says which
    /// vertices are no variables. Cost: about n log n for the graphs that robots make.
    pub(crate) fn new(
        is_held: &[bool],
        edges: impl Iterator<Item = (usize, usize)> + Clone,
    ) -> Result<Self, TooLarge> {
        let mut variables = vec![HELD; is_held.len()];
        let mut n_variables = 0;
        for (variable, _) in variables.iter_mut().zip(is_held).filter(|(_, held)| !**held) {
            *variable = n_variables;
            n_variables += 1;
        }
        let ends = |variables: &[u32], (from, to): (usize, usize)| {
            let (a, b) = (variables[from], variables[to]);
            (a != HELD && b != HELD).then_some((a.min(b), a.max(b)))
        };
        let mut pairs: Vec<u64> = Vec::new();
        pairs.extend(edges.clone().filter_map(|e| ends(&variables, e)).map(|(a, b)| key(b, a)));
        let new_of_old = elimination_order(n_variables as usize, &mut pairs)?;
        for variable in variables.iter_mut().filter(|v| **v != HELD) {
            *variable = new_of_old[*variable as usize];
        }
        pairs.clear();
        pairs.extend((0..n_variables).map(|v| key(v, v)));
        pairs.extend(edges.clone().filter_map(|e| ends(&variables, e)).map(|(a, b)| key(a, b)));
        let (begins, rows) = compressed(n_variables as usize, &mut pairs)?;
        let mut pattern =
            Self { variables, n_variables: n_variables as usize, begins, rows, slots: Vec::new() };
        let slots = edges.map(|edge| pattern.slot(edge)).collect();
        pattern.slots = slots;
        Ok(pattern)
    }

    pub(crate) fn n_variables(&self) -> usize {
        self.n_variables
    }

    /// Place of a vertex among the blocks; none when it is held.
    #[inline]
    pub(crate) fn variable(&self, vertex: usize) -> Option<usize> {
        let variable = self.variables[vertex];
        (variable != HELD).then_some(variable as usize)
    }

    fn slot(&self, (from, to): (usize, usize)) -> Slot {
        let (Some(a), Some(b)) = (self.variable(from), self.variable(to)) else {
            return Slot::default();
        };
        let (column, row) = (a.min(b), a.max(b));
        let blocks = self.column(column);
        let position = self.rows[blocks.clone()].partition_point(|r| (*r as usize) < row);
        Slot {
            begin: self.begins[column],
            n_blocks: blocks.len() as u32,
            position: position as u32,
            is_transposed: row == b,
        }
    }

    fn column(&self, variable: usize) -> Range<usize> {
        self.begins[variable] as usize..self.begins[variable + 1] as usize
    }

    /// The lower triangle by scalars; diagonal blocks whole, so that all columns of a block column
    /// are equally long and blocks are found by multiplication.
    fn lower_scalars<const N: usize>(&self) -> Result<SymbolicSparseColMat<u32>, TooLarge> {
        let size = self.n_variables * N;
        let mut begins = Vec::with_capacity(size + 1);
        let mut rows = Vec::with_capacity(self.rows.len() * N * N);
        begins.push(0);
        for column in 0..self.n_variables {
            for _ in 0..N {
                for &row in &self.rows[self.column(column)] {
                    rows.extend((0..N as u32).map(|r| row * N as u32 + r));
                }
                begins.push(u32::try_from(rows.len()).ok().ok_or(TooLarge)?);
            }
        }
        Ok(SymbolicSparseColMat::new_checked(size, size, begins, None, rows))
    }

    /// The upper triangle by scalars: what the symbolic factorisation looks at.
    fn upper_scalars<const N: usize>(&self) -> SymbolicSparseColMat<u32> {
        let size = self.n_variables * N;
        let mut above = vec![0_u32; self.n_variables + 1];
        for &row in &self.rows {
            above[row as usize + 1] += 1;
        }
        for variable in 0..self.n_variables {
            above[variable + 1] += above[variable];
        }
        let mut free = above.clone();
        let mut transposed = vec![0_u32; self.rows.len()];
        for column in 0..self.n_variables {
            for &row in &self.rows[self.column(column)] {
                transposed[free[row as usize] as usize] = column as u32;
                free[row as usize] += 1;
            }
        }
        let mut begins = Vec::with_capacity(size + 1);
        let mut rows = Vec::with_capacity(self.rows.len() * N * N);
        begins.push(0);
        for column in 0..self.n_variables {
            let blocks = &transposed[above[column] as usize..above[column + 1] as usize];
            for c in 0..N {
                let entries =
                    blocks.iter().flat_map(|b| (0..N as u32).map(move |r| b * N as u32 + r));
                rows.extend(entries.filter(|row| *row as usize <= column * N + c));
                begins.push(rows.len() as u32);
            }
        }
        SymbolicSparseColMat::new_checked(size, size, begins, None, rows)
    }
}

impl<const N: usize> BlockCholesky<N> {
    /// Finds the pattern of the factor and reserves all memory that is needed later.
    pub(crate) fn new(pattern: &Pattern) -> Result<Self, TooLarge> {
        let n_values = pattern.rows.len().checked_mul(N * N).ok_or(TooLarge)?;
        if n_values > i32::MAX as usize {
            return Err(TooLarge);
        }
        let lower = pattern.lower_scalars::<N>()?;
        let upper = pattern.upper_scalars::<N>();
        let params = CholeskySymbolicParams {
            // Measured on graphs of 1045 to 10000 poses: supernodes are up to four times as quick
            // as single columns, and never slower.
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
            ..CholeskySymbolicParams::default()
        };
        let order = SymmetricOrdering::Identity;
        let symbolic = factorize_symbolic_cholesky(upper.as_ref(), Side::Upper, order, params)?;
        let scratch = symbolic
            .factorize_numeric_llt_scratch::<f64>(Par::Seq, Spec::default())
            .or(symbolic.solve_in_place_scratch::<f64>(1, Par::Seq));
        Ok(Self {
            values: vec![0.0; n_values],
            factor: vec![0.0; symbolic.len_val()],
            memory: MemBuffer::try_new(scratch).ok().ok_or(TooLarge)?,
            lower,
            symbolic,
        })
    }

    /// Sets all values to zero.
    pub(crate) fn clear(&mut self) {
        self.values.fill(0.0);
    }

    /// Adds to the diagonal block of a variable; `block` must be symmetric.
    #[inline]
    pub(crate) fn add_diagonal(
        &mut self,
        pattern: &Pattern,
        variable: usize,
        block: &SMatrix<f64, N, N>,
    ) {
        let blocks = pattern.column(variable);
        self.add_block(blocks.start, blocks.len(), 0, block);
    }

    /// Adds `block` at (from, to) of an edge of which no end is held, and its transpose at (to,
    /// from).
    #[inline]
    pub(crate) fn add_edge(&mut self, pattern: &Pattern, edge: usize, block: &SMatrix<f64, N, N>) {
        let Slot { begin, n_blocks, position, is_transposed } = pattern.slots[edge];
        let (begin, n_blocks, position) = (begin as usize, n_blocks as usize, position as usize);
        if is_transposed {
            self.add_block(begin, n_blocks, position, &block.transpose());
        } else {
            self.add_block(begin, n_blocks, position, block);
        }
    }

    #[inline]
    fn add_block(
        &mut self,
        begin: usize,
        n_blocks: usize,
        position: usize,
        block: &SMatrix<f64, N, N>,
    ) {
        for column in 0..N {
            let first = N * N * begin + N * n_blocks * column + N * position;
            let sums = &mut self.values[first..first + N];
            for (sum, value) in sums.iter_mut().zip(block.column(column).iter()) {
                *sum += value;
            }
        }
    }

    /// Copies the diagonal out.
    pub(crate) fn diagonal(&self, pattern: &Pattern, diagonal: &mut [f64]) {
        for (index, entry) in diagonal.iter_mut().enumerate() {
            *entry = self.values[Self::place_of_diagonal(pattern, index)];
        }
    }

    /// Overwrites the diagonal.
    pub(crate) fn set_diagonal(&mut self, pattern: &Pattern, diagonal: impl Iterator<Item = f64>) {
        for (index, entry) in diagonal.enumerate() {
            self.values[Self::place_of_diagonal(pattern, index)] = entry;
        }
    }

    fn place_of_diagonal(pattern: &Pattern, index: usize) -> usize {
        let blocks = pattern.column(index / N);
        let within = index % N;
        N * N * blocks.start + N * blocks.len() * within + within
    }

    /// Factorises the present values; false when they are not positive definite.
    pub(crate) fn factorise(&mut self) -> bool {
        let matrix = SparseColMatRef::new(self.lower.as_ref(), self.values.as_slice());
        let result = self.symbolic.factorize_numeric_llt(
            &mut self.factor,
            matrix,
            Side::Lower,
            faer::linalg::cholesky::llt::factor::LltRegularization::default(),
            Par::Seq,
            MemStack::new(&mut self.memory),
            Spec::default(),
        );
        result.is_ok()
    }

    /// Replaces the right side (in elimination order) by the solution, with the last factor.
    pub(crate) fn solve(&mut self, right_side: &mut [f64]) {
        let size = right_side.len();
        let factor = LltRef::new(&self.symbolic, &self.factor);
        let column = MatMut::from_column_major_slice_mut(right_side, size, 1);
        factor.solve_in_place_with_conj(
            Conj::No,
            column,
            Par::Seq,
            MemStack::new(&mut self.memory),
        );
    }

    /// The factor by supernodes.
    pub(crate) fn supernodes(&self) -> Option<SupernodalLltRef<'_, u32, f64>> {
        let symbolic = self.symbolic_supernodes()?;
        Some(SupernodalLltRef::new(symbolic, &self.factor))
    }

    /// The pattern of the factor by supernodes.
    pub(crate) fn symbolic_supernodes(&self) -> Option<&SymbolicSupernodalCholesky<u32>> {
        match self.symbolic.raw() {
            SymbolicCholeskyRaw::Supernodal(symbolic) => Some(symbolic),
            SymbolicCholeskyRaw::Simplicial(_) => None,
        }
    }
}

impl<const N: usize> std::fmt::Debug for BlockCholesky<N> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (n_values, n_factor) = (self.values.len(), self.factor.len());
        write!(f, "BlockCholesky<{N}> {{ {n_values} values, {n_factor} in the factor }}")
    }
}

/// Sorts by column, then row.
fn key(column: u32, row: u32) -> u64 {
    (u64::from(column) << 32) | u64::from(row)
}

/// Column begins and rows of the different keys.
fn compressed(n_columns: usize, keys: &mut Vec<u64>) -> Result<(Vec<u32>, Vec<u32>), TooLarge> {
    keys.sort_unstable();
    keys.dedup();
    if keys.len() > i32::MAX as usize {
        return Err(TooLarge);
    }
    let mut begins = vec![0_u32; n_columns + 1];
    for key in keys.iter() {
        begins[(key >> 32) as usize + 1] += 1;
    }
    for column in 0..n_columns {
        begins[column + 1] += begins[column];
    }
    Ok((begins, keys.iter().map(|key| *key as u32).collect()))
}

/// Where each variable comes in elimination, for pairs of joined variables.
fn elimination_order(n_variables: usize, pairs: &mut Vec<u64>) -> Result<Vec<u32>, TooLarge> {
    let (begins, rows) = compressed(n_variables, pairs)?;
    let upper =
        SymbolicSparseColMatRef::new_checked(n_variables, n_variables, &begins, None, &rows);
    let scratch = amd::order_maybe_unsorted_scratch::<u32>(n_variables, rows.len());
    let mut memory = MemBuffer::try_new(scratch).ok().ok_or(TooLarge)?;
    let mut old_of_new = vec![0_u32; n_variables];
    let mut new_of_old = vec![0_u32; n_variables];
    let stack = MemStack::new(&mut memory);
    amd::order_maybe_unsorted(
        &mut old_of_new,
        &mut new_of_old,
        upper,
        amd::Control::default(),
        stack,
    )?;
    Ok(new_of_old)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector, Matrix2};

    /// A ring with chords and a held vertex, as blocks and as a dense matrix.
    fn example() -> (Pattern, BlockCholesky<2>, DMatrix<f64>) {
        let n = 12;
        let mut is_held = vec![false; n];
        is_held[4] = true;
        let edges: Vec<(usize, usize)> =
            (0..n).map(|i| (i, (i + 1) % n)).chain([(0, 6), (9, 3), (3, 9), (7, 2)]).collect();
        let pattern = Pattern::new(&is_held, edges.iter().copied()).unwrap();
        let mut blocks = BlockCholesky::<2>::new(&pattern).unwrap();
        let size = 2 * pattern.n_variables();
        let mut dense = DMatrix::zeros(size, size);
        blocks.clear();
        for variable in 0..pattern.n_variables() {
            let diagonal = Matrix2::new(9.0 + variable as f64, 0.5, 0.5, 11.0);
            blocks.add_diagonal(&pattern, variable, &diagonal);
            let mut view = dense.view_mut((2 * variable, 2 * variable), (2, 2));
            view += diagonal;
        }
        for (index, &(from, to)) in edges.iter().enumerate() {
            let (Some(a), Some(b)) = (pattern.variable(from), pattern.variable(to)) else {
                continue;
            };
            let block = Matrix2::new(-1.0, 0.3, -0.2, 0.1 * index as f64);
            blocks.add_edge(&pattern, index, &block);
            let mut view = dense.view_mut((2 * a, 2 * b), (2, 2));
            view += block;
            let mut view = dense.view_mut((2 * b, 2 * a), (2, 2));
            view += block.transpose();
        }
        (pattern, blocks, dense)
    }

    #[test]
    fn solutions_agree_with_a_dense_solver() {
        let (pattern, mut blocks, dense) = example();
        let right = DVector::from_fn(dense.nrows(), |i, _| (i as f64).sin());
        assert!(blocks.factorise());
        let mut solution = right.clone();
        blocks.solve(solution.as_mut_slice());
        let expected = dense.clone().lu().solve(&right).unwrap();
        assert!((&solution - expected).amax() < 1e-13);
        let mut diagonal = vec![0.0; dense.nrows()];
        blocks.diagonal(&pattern, &mut diagonal);
        assert_eq!(DVector::from_vec(diagonal), dense.diagonal());
    }

    #[test]
    fn a_matrix_that_is_not_positive_definite_is_told() {
        let (pattern, mut blocks, dense) = example();
        let spoilt = dense
            .diagonal()
            .into_iter()
            .enumerate()
            .map(|(i, d)| if i == 5 { -d } else { *d })
            .collect::<Vec<_>>();
        blocks.set_diagonal(&pattern, spoilt.into_iter());
        assert!(!blocks.factorise());
        blocks.set_diagonal(&pattern, dense.diagonal().into_iter().copied());
        assert!(blocks.factorise());
        blocks.set_diagonal(&pattern, std::iter::repeat_n(f64::NAN, dense.nrows()));
        assert!(!blocks.factorise());
    }

    #[test]
    fn nothing_to_solve_is_no_trouble() {
        let pattern = Pattern::new(&[true, true], [(0, 1)].into_iter()).unwrap();
        let mut blocks = BlockCholesky::<3>::new(&pattern).unwrap();
        assert!(blocks.factorise());
        blocks.solve(&mut []);
    }
}
