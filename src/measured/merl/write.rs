//! Writes the MERL container.

use std::io::{self, Write};

use crate::grid::dimensions::{CHANNEL_SCALE, Dimensions};

/// Value stored in cells without a measurement.
const NO_MEASUREMENT: f64 = -1.0;

/// Writes a MERL file, one plane after the other.
///
/// `value(channel, theta_h bin, theta_d bin, phi_d bin)` is the BRDF in 1/sr, negative where there is no measurement
/// (stored as -1). A value comes back from [`crate::MerlFile::value`] to within one unit in the last place. Writes go out in rows of
/// one theta_d, 1.4 kB each; give a buffered writer where calls are expensive.
///
/// # Errors
/// Errors of `out`, or [`io::ErrorKind::InvalidData`] at the first value that is not finite; the file is then
/// incomplete.
pub fn write_merl(
    out: &mut impl Write,
    dimensions: Dimensions,
    mut value: impl FnMut(usize, usize, usize, usize) -> f64,
) -> io::Result<()> {
    out.write_all(&dimensions.header())?;
    let mut row = Vec::with_capacity(8 * dimensions.phi_d());
    for (channel, scale) in CHANNEL_SCALE.iter().enumerate() {
        for theta_h in 0..Dimensions::THETA_H {
            for theta_d in 0..Dimensions::THETA_D {
                row.clear();
                for phi_d in 0..dimensions.phi_d() {
                    let f = value(channel, theta_h, theta_d, phi_d);
                    let stored = if f < 0.0 && f.is_finite() { NO_MEASUREMENT } else { f / scale };
                    if !stored.is_finite() {
                        let at = format!("channel {channel}, theta_h {theta_h}, theta_d {theta_d}, phi_d {phi_d}");
                        return Err(io::Error::new(io::ErrorKind::InvalidData, format!("BRDF value {f} at {at}")));
                    }
                    row.extend_from_slice(&stored.to_le_bytes());
                }
                out.write_all(&row)?;
            }
        }
    }
    out.flush()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::merl::file::MerlFile;

    #[test]
    fn what_is_written_reads_back() {
        for dimensions in [Dimensions::HALF_TURN, Dimensions::FULL_TURN] {
            let f = |c: usize, h: usize, t: usize, p: usize| {
                if h + t > 120 { -3.0 } else { (1 + c + 7 * h + 11 * t + 13 * p) as f64 * 1e-3 }
            };
            let mut bytes = Vec::new();
            write_merl(&mut bytes, dimensions, f).unwrap();
            assert_eq!(bytes.len() as u64, dimensions.file_bytes());
            let file = MerlFile::from_bytes("x", bytes).unwrap();
            for cell in (0..dimensions.cells()).step_by(97) {
                let (h, t, p) = dimensions.bins(cell);
                for c in 0..3 {
                    let (written, read) = (f(c, h, t, p), file.value(c, cell));
                    if written < 0.0 {
                        assert_eq!(file.raw(c, cell), -1.0);
                    } else {
                        assert!((read - written).abs() <= f64::EPSILON * written);
                    }
                }
            }
        }
    }

    #[test]
    fn values_that_are_not_finite_are_refused() {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX] {
            let error = write_merl(&mut io::sink(), Dimensions::HALF_TURN, |_, h, _, _| if h == 3 { bad } else { 1.0 })
                .unwrap_err();
            assert_eq!(error.kind(), io::ErrorKind::InvalidData);
            assert!(error.to_string().contains("theta_h 3"), "{error}");
        }
    }
}
