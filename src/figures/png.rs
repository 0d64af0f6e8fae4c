//! Pictures as PNG files.

use std::io::Cursor;

use image::{ImageFormat, RgbImage};

/// The encoder refused a picture: it has no pixels, or more than the format can count.
#[derive(Debug)]
pub struct PngError(image::ImageError);

impl std::fmt::Display for PngError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "no PNG can be made of this picture ({})", self.0)
    }
}

impl std::error::Error for PngError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        Some(&self.0)
    }
}

/// A picture as the bytes of a PNG file, 8 bits per channel.
///
/// # Errors
/// [`PngError`] for a picture without pixels.
pub fn encode(picture: &RgbImage) -> Result<Vec<u8>, PngError> {
    let mut bytes = Cursor::new(Vec::new());
    picture.write_to(&mut bytes, ImageFormat::Png).map_err(PngError)?;
    Ok(bytes.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_come_back_from_their_files() {
        let picture = RgbImage::from_fn(31, 17, |x, y| image::Rgb([x as u8 * 8, y as u8 * 15, 7]));
        let again = image::load_from_memory(&encode(&picture).unwrap()).unwrap().to_rgb8();
        assert_eq!(again, picture);
        assert!(encode(&RgbImage::new(0, 4)).is_err());
    }
}
