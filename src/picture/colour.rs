//! Colours: linear light inside, sRGB in palettes and files.

use std::ops::{Add, Mul};

/// Red, green and blue in linear light, 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Colour(pub [f32; 3]);

impl Colour {
    /// From an sRGB triple such as `0xE0533D`.
    pub fn srgb(hex: u32) -> Self {
        Self(
            [16, 8, 0]
                .map(|shift| linear_from_srgb(f64::from((hex >> shift) & 0xFF) / 255.0) as f32),
        )
    }

    /// A fraction `t` of the way from `self` to `other`.
    pub fn mix(self, other: Self, t: f32) -> Self {
        self * (1.0 - t) + other * t
    }
}

impl Mul<f32> for Colour {
    type Output = Self;
    fn mul(self, factor: f32) -> Self {
        Self(self.0.map(|channel| channel * factor))
    }
}

impl Add for Colour {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] + other.0[i]))
    }
}

fn linear_from_srgb(value: f64) -> f64 {
    if value <= 0.04045 { value / 12.92 } else { libm::pow((value + 0.055) / 1.055, 2.4) }
}

fn srgb_from_linear(value: f64) -> f64 {
    if value <= 0.003_130_8 { value * 12.92 } else { 1.055 * libm::pow(value, 1.0 / 2.4) - 0.055 }
}

/// A table from linear light to sRGB bytes.
pub struct Encoder(Vec<u8>);

impl Encoder {
    const LEVELS: usize = 4096;

    /// Fills the table.
    pub fn new() -> Self {
        let byte =
            |level: usize| srgb_from_linear(level as f64 / (Self::LEVELS - 1) as f64) * 255.0 + 0.5;
        Self((0..Self::LEVELS).map(|level| byte(level) as u8).collect())
    }

    /// The sRGB bytes of a colour; components out of range are clamped.
    pub fn bytes(&self, colour: Colour) -> [u8; 3] {
        colour.0.map(|channel| {
            self.0[(channel.clamp(0.0, 1.0) * (Self::LEVELS - 1) as f32 + 0.5) as usize]
        })
    }
}

/// The robot at the start of its walk, and the start's mark.
pub fn start_colour() -> Colour {
    Colour::srgb(0x2F6FD6)
}

/// The robot at the goal, and the goal's mark.
pub fn goal_colour() -> Colour {
    Colour::srgb(0xE2483A)
}

/// The place where a search failed most often.
pub fn bottleneck_colour() -> Colour {
    Colour::srgb(0xE08A00)
}

/// The lines of a search: what it explored, and its guide route.
pub fn search_colours() -> [Colour; 2] {
    [Colour::srgb(0x2A5A9A), Colour::srgb(0xE0A400)]
}

/// The robot a fraction `t` of the way through its walk: blue, violet, red.
pub fn robot_colour(t: f32) -> Colour {
    let middle = Colour::srgb(0x9A63C9);
    if t < 0.5 {
        start_colour().mix(middle, 2.0 * t)
    } else {
        middle.mix(goal_colour(), 2.0 * t - 1.0)
    }
}

/// The footholds and the foot of a limb: left teal, right magenta, further limbs ochre.
pub fn limb_colour(limb: usize) -> Colour {
    Colour::srgb([0x12A594, 0xD6338A].get(limb).copied().unwrap_or(0xC98A1B))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn srgb_bytes_survive_the_round_trip() {
        let encoder = Encoder::new();
        for hex in [0x0000_0000, 0x00FF_FFFF, 0x0080_4020, 0x00C8_DCF0] {
            let bytes = encoder.bytes(Colour::srgb(hex));
            let wanted = [hex >> 16, (hex >> 8) & 0xFF, hex & 0xFF];
            assert!(
                bytes.iter().zip(wanted).all(|(&b, w)| i64::from(b).abs_diff(i64::from(w)) <= 1),
                "{hex:06x} came back as {bytes:?}"
            );
        }
    }
}
