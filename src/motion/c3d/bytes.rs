//! Numbers of a C3D file in the byte order of the processor on which it was written.

/// Number of bytes of a block, the unit of offsets in the file
pub const BLOCK: usize = 512;

/// Processor whose number formats a file uses.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Order {
    Intel,
    /// Integers as Intel, floats as VAX F_floating
    Dec,
    Mips,
}

impl Order {
    /// Returns the order for its code in the parameters.
    pub fn of(code: u8) -> Option<Self> {
        match code {
            84 => Some(Self::Intel),
            85 => Some(Self::Dec),
            86 => Some(Self::Mips),
            _ => None,
        }
    }

    pub fn name(self) -> &'static str {
        match self {
            Self::Intel => "Intel",
            Self::Dec => "DEC",
            Self::Mips => "MIPS",
        }
    }

    /// Reads a signed 16-bit word; zero beyond the end.
    pub fn i16(self, bytes: &[u8], at: usize) -> i16 {
        let pair = [bytes.get(at).copied().unwrap_or(0), bytes.get(at + 1).copied().unwrap_or(0)];
        if self == Self::Mips { i16::from_be_bytes(pair) } else { i16::from_le_bytes(pair) }
    }

    /// Reads an unsigned 16-bit word; zero beyond the end.
    pub fn u16(self, bytes: &[u8], at: usize) -> u16 {
        self.i16(bytes, at).cast_unsigned()
    }

    /// Reads a 32-bit float; zero beyond the end. VAX F_floating has its words exchanged and an exponent that is larger by two.
    pub fn f32(self, bytes: &[u8], at: usize) -> f32 {
        let byte = |k: usize| bytes.get(at + k).copied().unwrap_or(0);
        match self {
            Self::Intel => f32::from_le_bytes([byte(0), byte(1), byte(2), byte(3)]),
            Self::Mips => f32::from_be_bytes([byte(0), byte(1), byte(2), byte(3)]),
            Self::Dec => 0.25 * f32::from_le_bytes([byte(2), byte(3), byte(0), byte(1)]),
        }
    }
}
