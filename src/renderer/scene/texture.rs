//! Textures: images, chequerboards, constants.

use std::io::Cursor;

use brdfit_figures::srgb;
use image::{DynamicImage, ImageFormat, ImageReader, Limits};

use crate::scene::error::FileError;

/// Largest width and height of a picture, pixels.
const LARGEST: u32 = 16384;

/// A picture, linear, row 0 at the top.
#[derive(Clone, Debug)]
pub(crate) struct Texture {
    width: usize,
    height: usize,
    texels: Vec<[f32; 3]>,
}

impl Texture {
    /// Reads a PNG of 8 or 16 bits, grey or colour, with the sRGB curve; opacity is left out.
    ///
    /// # Errors
    /// Anything that is not a PNG of at most 16384 x 16384 pixels.
    pub(crate) fn from_png(bytes: &[u8]) -> Result<Self, FileError> {
        let mut reader = ImageReader::with_format(Cursor::new(bytes), ImageFormat::Png);
        let mut limits = Limits::default();
        (limits.max_image_width, limits.max_image_height) = (Some(LARGEST), Some(LARGEST));
        reader.limits(limits);
        let image = reader.decode().map_err(|error| FileError::content(format!("not a usable PNG file: {error}")))?;
        let image = DynamicImage::into_rgb16(image);
        let curve: Vec<f32> = (0..=u16::MAX).map(|code| srgb::decode_f64(f64::from(code) / 65535.0) as f32).collect();
        let (width, height) = (image.width() as usize, image.height() as usize);
        let texels = image.pixels().map(|pixel| pixel.0.map(|code| curve[usize::from(code)])).collect();
        Ok(Self { width, height, texels })
    }

    /// The colour at `uv`, (0, 0) the lower left corner, repeated in both directions, bilinear between the centres of texels.
    fn at(&self, uv: [f32; 2]) -> [f32; 3] {
        let (columns, s) = between(uv[0], self.width);
        let (rows, t) = between(1.0 - (uv[1] - uv[1].floor()), self.height);
        let texel = |column: usize, row: usize| self.texels[row * self.width + column];
        let corners = [
            texel(columns[0], rows[0]),
            texel(columns[1], rows[0]),
            texel(columns[0], rows[1]),
            texel(columns[1], rows[1]),
        ];
        std::array::from_fn(|channel| {
            let [a, b, c, d] = corners.map(|corner| corner[channel]);
            (a + (b - a) * s) * (1.0 - t) + (c + (d - c) * s) * t
        })
    }
}

/// The two texels of a row of `count` around the repeated coordinate `x`, and how far between their centres it lies.
fn between(x: f32, count: usize) -> ([usize; 2], f32) {
    let place = (x - x.floor()) * count as f32 - 0.5;
    let low = place.floor();
    let first = if low < 0.0 { count - 1 } else { (low as usize).min(count - 1) };
    ([first, (first + 1) % count], place - low)
}

/// Factor of a BRDF over a surface.
#[derive(Clone, Debug)]
pub(crate) enum Albedo {
    Constant([f32; 3]),
    Checker { colors: [[f32; 3]; 2], scale: f32 },
    Texture { texture: Texture, scale: f32 },
}

impl Albedo {
    /// The colour at texture coordinates.
    pub(crate) fn at(&self, uv: [f32; 2]) -> [f32; 3] {
        match self {
            Self::Constant(color) => *color,
            Self::Checker { colors, scale } => {
                let odd = |x: f32| ((x * scale).floor() * 0.5).fract() != 0.0;
                colors[usize::from(odd(uv[0]) != odd(uv[1]))]
            }
            Self::Texture { texture, scale } => texture.at(uv.map(|x| x * scale)),
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use image::{ImageBuffer, Rgb};

    use super::*;

    /// A PNG of `width` columns with these codes.
    pub(crate) fn png(width: u32, pixels: &[[u8; 3]]) -> Vec<u8> {
        let image = ImageBuffer::<Rgb<u8>, _>::from_raw(width, pixels.len() as u32 / width, pixels.concat()).unwrap();
        let mut bytes = Cursor::new(Vec::new());
        image.write_to(&mut bytes, ImageFormat::Png).unwrap();
        bytes.into_inner()
    }

    #[test]
    fn texels_bilinear_repeated_lower_row_first() {
        // code 188 is linear 0.5029 by the standard's formula, computed apart from this program
        let texture = Texture::from_png(&png(2, &[[255, 0, 0], [0, 188, 0], [0, 0, 0], [0, 0, 255]])).unwrap();
        let near = |uv, color: [f32; 3]| {
            let got = texture.at(uv);
            assert!((0..3).all(|k| (got[k] - color[k]).abs() < 2e-5), "{uv:?} {got:?}");
        };
        near([0.25, 0.75], [1.0, 0.0, 0.0]);
        near([0.75, 0.75], [0.0, 0.502_886, 0.0]);
        near([0.75, 0.25], [0.0, 0.0, 1.0]);
        near([-3.25, 7.25], [0.0, 0.0, 1.0]);
        near([0.5, 0.75], [0.5, 0.251_443, 0.0]);
        // across the border: half of either column, half of either row
        near([0.0, 0.0], [0.25, 0.125_722, 0.25]);
        near([1.0, 1.0], [0.25, 0.125_722, 0.25]);
    }

    #[test]
    fn the_chequerboard_alternates_also_below_zero() {
        let checker = Albedo::Checker { colors: [[0.0; 3], [1.0; 3]], scale: 4.0 };
        for k in -8..8 {
            let x = (k as f32 + 0.5) / 4.0;
            assert_eq!(checker.at([x, 0.1])[0], (k & 1) as f32);
            assert_eq!(checker.at([0.3, x])[0], 1.0 - (k & 1) as f32);
        }
    }

    #[test]
    fn damaged_pictures_are_refused() {
        let mut bytes = png(1, &[[1, 2, 3]]);
        bytes.truncate(40);
        for bytes in [&bytes[..], b"", b"GIF89a"] {
            match Texture::from_png(bytes) {
                Err(FileError::Content(why)) => assert!(why.starts_with("not a usable PNG file: "), "{why}"),
                other => panic!("{other:?}"),
            }
        }
    }
}
