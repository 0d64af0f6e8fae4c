//! The transfer curve of sRGB (IEC 61966-2-1:1999) and its bytes.

/// A linear component from 0 to 1 as sRGB shows it, from 0 to 1; what is outside is clamped.
#[must_use]
pub fn encode(linear: f32) -> f32 {
    let linear = linear.clamp(0.0, 1.0);
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * libm::powf(linear, 1.0 / 2.4) - 0.055 }
}

/// The inverse of [`encode`].
#[must_use]
pub fn decode(encoded: f32) -> f32 {
    let encoded = encoded.clamp(0.0, 1.0);
    if encoded <= 0.040_45 { encoded / 12.92 } else { libm::powf((encoded + 0.055) / 1.055, 2.4) }
}

/// As [`decode`], in double precision: for tables of 16-bit codes.
#[must_use]
pub fn decode_f64(encoded: f64) -> f64 {
    let encoded = encoded.clamp(0.0, 1.0);
    if encoded <= 0.040_45 { encoded / 12.92 } else { libm::pow((encoded + 0.055) / 1.055, 2.4) }
}

/// A linear component as a byte of sRGB, rounded to the nearest.
#[must_use]
pub fn byte(linear: f32) -> u8 {
    (255.0 * encode(linear)).round() as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_byte_comes_back() {
        for k in 0..=255_u8 {
            assert_eq!(byte(decode(f32::from(k) / 255.0)), k);
        }
        assert_eq!((byte(-1.0), byte(7.0)), (0, 255));
    }

    #[test]
    fn known_values() {
        // 1.055 x 0.5^(1/2.4) - 0.055 and ((0.5 + 0.055)/1.055)^2.4, by mpmath
        assert!((encode(0.5) - 0.735_357).abs() < 2e-7);
        assert!((decode(0.5) - 0.214_041_14).abs() < 2e-7);
        assert!((decode_f64(0.5) - 0.214_041_140_482_232_55).abs() < 1e-15);
        // the two branches meet as closely as the rounded constants of the standard allow
        assert!((encode(0.003_130_8) - encode(0.003_130_9)).abs() < 2e-6);
    }
}
