//! One state of a run as shown by a page, and its bytes for a page that is updated during the run.

/// A state.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Frame {
    /// Time \[s\]
    pub t: f64,
    /// Displacement \[points × 3\] \[m\]
    pub motion: Vec<f32>,
    /// Values \[fields\]\[nodes × components\]
    pub fields: Vec<Vec<f32>>,
    /// Points of the shape with contact forces, and these forces \[N\]
    pub contact: Vec<(u32, [f32; 3])>,
}

impl Frame {
    /// Returns the number of values in the histories of the state.
    pub fn size(&self) -> usize {
        self.motion.len() + self.fields.iter().map(Vec::len).sum::<usize>()
    }

    /// Returns the state as little-endian bytes: the time (8 bytes), the number of blocks, their lengths in words of 4 bytes, and the blocks
    /// themselves: the motion, every field, the points of the contact forces, and these forces. `viewer/src/live.js` reads it.
    pub fn bytes(&self) -> Vec<u8> {
        let points: Vec<u8> = self.contact.iter().flat_map(|(p, _)| p.to_le_bytes()).collect();
        let forces: Vec<f32> = self.contact.iter().flat_map(|(_, f)| *f).collect();
        let lengths = std::iter::once(self.motion.len()).chain(self.fields.iter().map(Vec::len));
        let lengths: Vec<u32> = lengths.chain([self.contact.len(), forces.len()]).map(|n| n as u32).collect();
        let mut out = Vec::with_capacity(4 * self.size() + points.len() + 4 * (forces.len() + lengths.len()) + 12);
        out.extend(self.t.to_le_bytes());
        out.extend((lengths.len() as u32).to_le_bytes());
        out.extend(lengths.iter().flat_map(|n| n.to_le_bytes()));
        for values in std::iter::once(&self.motion).chain(&self.fields) {
            out.extend(values.iter().flat_map(|v| v.to_le_bytes()));
        }
        out.extend(points);
        out.extend(forces.iter().flat_map(|v| v.to_le_bytes()));
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bytes_of_a_state_hold_its_numbers_in_order() {
        let frame = Frame {
            t: 0.1,
            motion: vec![1.0, -2.0, 3.5],
            fields: vec![vec![0.25], vec![7.0, f32::NAN]],
            contact: vec![(9, [1.0, 2.0, 3.0])],
        };
        let bytes = frame.bytes();
        let word = |k: usize| <[u8; 4]>::try_from(&bytes[8 + 4 * k..12 + 4 * k]).expect("4 bytes");
        assert_eq!(bytes[..8], 0.1f64.to_le_bytes());
        assert_eq!((0..6).map(|k| u32::from_le_bytes(word(k))).collect::<Vec<_>>(), [5, 3, 1, 2, 1, 3]);
        let floats: Vec<f32> = (6..11).map(|k| f32::from_le_bytes(word(k))).collect();
        assert_eq!(floats, [1.0, -2.0, 3.5, 0.25, 7.0]);
        assert!(f32::from_le_bytes(word(11)).is_nan() && u32::from_le_bytes(word(12)) == 9);
        assert_eq!(bytes.len(), 8 + 4 * 16);
    }
}
