//! MAT files: the author's workspace, other byte orders, damage.

use super::*;
use proptest::prelude::*;

const LIMIT: usize = 1 << 26;

/// Compared with what scipy reads.
#[test]
fn the_saved_workspace_is_read() {
    let Some(path) = testkit::data_folder("artemic/matlab.mat") else { return };
    let bytes = std::fs::read(path).unwrap();
    let file = MatFile::parse(&bytes, LIMIT).unwrap();
    assert_eq!(file.unread, []);
    assert_eq!(file.matrices.len(), 32);
    let world = file.matrix("world").unwrap();
    assert_eq!((world.n_rows(), world.n_columns(), world.class), (800, 800, Class::Double));
    let score = file.matrix("score").unwrap();
    // The eight bytes of the unpacked file.
    assert_eq!(score.values, [f64::from_bits(0x40a7_c9b3_c86e_b9ab)]);
    assert!((score.values[0] - 3_044.851_138_553_776).abs() < 1e-9);
    assert_eq!(file.matrix("rstm").unwrap().dimensions, [160, 160, 63]);
    assert!(file.matrix("model").unwrap().at(0, 0).is_nan());
    let readings = file.matrix("saved_readings").unwrap();
    assert_eq!(readings.row(0).take(2).collect::<Vec<_>>(), [1077.0, 1502.0]);
    assert_eq!(file.matrix("poses").unwrap().row(1).collect::<Vec<_>>(), [-1.0, -1.0]);
    assert_eq!(file.matrix("no such matrix"), None);
    let error = MatFile::parse(&bytes, 1 << 20).unwrap_err();
    assert_eq!(error, MatError::TooLarge { bytes_max: 1 << 20 });
}

/// Elements by hand, in either byte order.
struct ByHand {
    big: bool,
    bytes: Vec<u8>,
}

impl ByHand {
    fn new(big: bool) -> Self {
        let mut bytes = vec![b' '; 124];
        bytes.extend(if big { *b"\x01\x00MI" } else { *b"\x00\x01IM" });
        Self { big, bytes }
    }

    fn u32(&self, value: u32) -> [u8; 4] {
        if self.big { value.to_be_bytes() } else { value.to_le_bytes() }
    }

    fn element(&self, kind: u32, data: &[u8]) -> Vec<u8> {
        let length = u32::try_from(data.len()).unwrap();
        let mut out = [self.u32(kind), self.u32(length)].concat();
        out.extend(data);
        out.resize(out.len().next_multiple_of(8), 0);
        out
    }

    fn small(&self, kind: u32, data: &[u8]) -> Vec<u8> {
        let length = u32::try_from(data.len()).unwrap();
        let mut out = self.u32(length << 16 | kind).to_vec();
        out.extend(data);
        out.resize(8, 0);
        out
    }

    /// Class and flags, storage type, and the bytes of the values.
    fn matrix(
        &self,
        class: u32,
        name: &[u8],
        size: [u32; 2],
        storage: u32,
        values: &[u8],
    ) -> Vec<u8> {
        let mut body = self.element(6, &[self.u32(class), self.u32(0)].concat());
        body.extend(self.element(5, &[self.u32(size[0]), self.u32(size[1])].concat()));
        body.extend(if name.len() <= 4 { self.small(1, name) } else { self.element(1, name) });
        body.extend(if values.len() <= 4 {
            self.small(storage, values)
        } else {
            self.element(storage, values)
        });
        self.element(14, &body)
    }
}

#[test]
fn both_byte_orders_and_all_storage_types_are_read() {
    for big in [false, true] {
        let mut hand = ByHand::new(big);
        let turn = |bytes: &[u8]| -> Vec<u8> {
            if big { bytes.iter().rev().copied().collect() } else { bytes.to_vec() }
        };
        let cases: Vec<(u32, Vec<u8>, f64)> = vec![
            (1, vec![0xfe], -2.0),
            (2, vec![0xfe], 254.0),
            (3, turn(&(-300_i16).to_le_bytes()), -300.0),
            (4, turn(&60_000_u16.to_le_bytes()), 60_000.0),
            (5, turn(&(-70_000_i32).to_le_bytes()), -70_000.0),
            (6, turn(&4_000_000_000_u32.to_le_bytes()), 4e9),
            (7, turn(&1.5_f32.to_le_bytes()), 1.5),
            (9, turn(&(-0.1_f64).to_le_bytes()), -0.1),
            (12, turn(&(-5_000_000_000_i64).to_le_bytes()), -5e9),
            (13, turn(&5_000_000_000_u64.to_le_bytes()), 5e9),
        ];
        for (storage, bytes, _) in &cases {
            let two = [bytes.as_slice(), bytes].concat();
            let matrix = hand.matrix(6, b"numbers", [1, 2], *storage, &two);
            hand.bytes.extend(matrix);
        }
        let logical = hand.matrix(9 | 0x0200, b"l", [3, 1], 2, &[1, 0, 1]);
        hand.bytes.extend(logical);
        let text = hand.matrix(4, b"text", [1, 2], 4, &[0, 65, 0, 66]);
        hand.bytes.extend(text);
        let file = MatFile::parse(&hand.bytes, 0).unwrap();
        for (matrix, (storage, _, value)) in file.matrices.iter().zip(&cases) {
            assert_eq!(matrix.values, [*value; 2], "storage type {storage}");
            assert_eq!((matrix.n_rows(), matrix.n_columns()), (1, 2));
        }
        let logical = file.matrix("l").unwrap();
        assert_eq!(
            (logical.class, logical.values.as_slice()),
            (Class::Logical, &[1.0, 0.0, 1.0][..])
        );
        let [unread] = file.unread.as_slice() else { panic!("{:?}", file.unread) };
        assert_eq!(unread.what, "text (class char)");
    }
}

#[test]
fn what_is_wrong_is_said_and_the_rest_is_read() {
    let hand = ByHand::new(false);
    let eight = 1.0_f64.to_le_bytes();
    let good = hand.matrix(6, b"good", [1, 1], 9, &eight);
    let cases = [
        (hand.matrix(6, b"bad", [3, 1], 9, &eight), "1 values for a size of 3×1"),
        (hand.matrix(6, b"bad", [u32::MAX, 1], 9, &eight), "a size of -1"),
        (hand.matrix(6, b"bad", [1 << 30, 1 << 30], 9, &eight), "1 values for a size"),
        (hand.matrix(6, b"bad", [1, 1], 77, &eight), "storage type 77"),
        (hand.matrix(5, b"bad", [1, 1], 9, &eight), "class sparse"),
        (hand.element(9, &eight), "an element of type 9"),
        (hand.element(15, b"no zlib at all!!"), "the file ends in the tag"),
    ];
    for (bad, expected) in cases {
        let bytes = [hand.bytes.as_slice(), &bad, &good].concat();
        let file = MatFile::parse(&bytes, LIMIT).unwrap();
        assert_eq!(file.unread.len(), 1, "{expected}");
        assert_eq!(file.unread[0].byte, HEADER);
        assert!(file.unread[0].what.contains(expected), "{} / {expected}", file.unread[0].what);
        assert_eq!(file.matrix("good").unwrap().values, [1.0]);
    }
    // A length beyond the file.
    let bytes = [hand.bytes.as_slice(), &good[..good.len() - 8]].concat();
    let file = MatFile::parse(&bytes, LIMIT).unwrap();
    assert!(file.matrices.is_empty());
    assert!(file.unread[0].what.contains("are left"), "{:?}", file.unread);
}

#[test]
fn a_header_of_another_kind_is_refused() {
    let header = |mark: &[u8]| [&[b' '; 124][..], mark].concat();
    assert!(MatFile::parse(&header(b"\x00\x01IM"), 0).is_ok());
    for (bytes, expected) in [
        (header(b"\x00\x02IM"), "version"),
        (header(b"\x00\x01XX"), "endian"),
        (vec![0; 50], "50 bytes"),
    ] {
        let error = MatFile::parse(&bytes, 0).unwrap_err();
        assert!(error.to_string().contains(expected), "{error}");
    }
}

proptest! {
    #[test]
    fn what_is_written_is_read_again(
        columns in 0..5_usize,
        rows in prop::collection::vec(any::<f64>(), 0..40),
        name in "[a-z_]{1,12}",
    ) {
        let n_rows = rows.len().checked_div(columns).unwrap_or(0);
        let values: Vec<f64> = rows.into_iter().take(n_rows * columns).collect();
        let class = Class::Double;
        let matrix = Matrix { name, dimensions: vec![n_rows, columns], class, values };
        let bytes = write(&[matrix.clone(), matrix.clone()]);
        let file = MatFile::parse(&bytes, LIMIT).unwrap();
        prop_assert_eq!(file.matrices.len(), 2);
        prop_assert!(file.unread.is_empty());
        let found = &file.matrices[1];
        prop_assert_eq!((&found.name, &found.dimensions), (&matrix.name, &matrix.dimensions));
        let bits = |m: &Matrix| m.values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        prop_assert_eq!(bits(found), bits(&matrix));
    }
}
