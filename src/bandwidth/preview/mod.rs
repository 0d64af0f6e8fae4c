//! Pictures for people: an atlas with its tiles, and single lobes side by side. Values are lost in them.

pub mod canvas;
pub mod scale;
pub mod srgb;

use std::io::Cursor;

use image::{ImageFormat, RgbImage};

use crate::atlas::error::AtlasError;
use crate::atlas::texture::{Atlas, Layout, TILE, TILES, UNITS};
use crate::lobe::mapping::AngularMap;
use canvas::{Align, BACKGROUND, FAINT, INK, LABEL, TITLE, colour_bar, disc, text, text_width};
use scale::Scale;

/// Pixels from the outer edge to whatever is drawn.
const MARGIN: u32 = 24;
/// Pixels between tiles.
const GAP: u32 = 4;
/// Pixels from one tile to the next.
const PITCH: u32 = TILE as u32 + GAP;
/// Pixels for a colour bar with its labels.
const BAR_SPACE: u32 = 88;

/// Level 0 of an atlas as a picture for people: its 16 x 16 tiles as discs, texel by texel, with the incident directions
/// along the edges and a colour bar. The colours are logarithmic between two powers of two; 0 is grey, and
/// the largest 0.5 % of the values may share the brightest colour, marked by a plus at the colour bar. Of four channels the
/// maximum is shown. The corners of the tiles, which repeat the rim, are left out.
#[must_use]
pub fn preview(atlas: &Atlas, title: &str) -> RgbImage {
    let last = atlas.channels().count() - 1;
    let level = atlas.level(0);
    let scale = Scale::of(level.texels().iter().skip(last).step_by(last + 1).copied());

    let labels = text_width("00.0\u{b0} ", LABEL);
    let (left, top) = (MARGIN + labels, MARGIN + 74);
    let side = TILES as u32 * PITCH - GAP;
    let mut picture = RgbImage::from_pixel(left + side + 26 + BAR_SPACE + MARGIN, top + side + MARGIN, BACKGROUND);

    text(&mut picture, [MARGIN, MARGIN - 4], title, TITLE, Align::Left, INK);
    let caption = match atlas.layout() {
        Layout::Isotropic => "theta_i of a tile = row + column, light on the right, mirror direction on the left",
        Layout::Hemisphere => "tiles: (u, v) of the incident direction on the angular map, v downwards",
    };
    text(&mut picture, [MARGIN, MARGIN + 22], caption, LABEL, Align::Left, FAINT);
    let right = picture.width() - MARGIN;
    text(&mut picture, [right, MARGIN + 22], UNITS, LABEL, Align::Right, FAINT);
    for k in 0..TILES {
        let start = k as u32 * PITCH;
        let (row_label, column_label) = edge_labels(atlas.layout(), k);
        text(&mut picture, [left - 9, top + start + (PITCH - GAP) / 2 - 8], &row_label, LABEL, Align::Right, INK);
        text(&mut picture, [left + start + (PITCH - GAP) / 2, top - 22], &column_label, LABEL, Align::Centre, INK);
    }
    for row in 0..TILES {
        for column in 0..TILES {
            let corner = [left + column as u32 * PITCH, top + row as u32 * PITCH];
            let value = |y: usize, x: usize| atlas.texel(0, row * TILE + y, column * TILE + x)[last];
            disc(&mut picture, corner, TILE, 1, scale, value);
        }
    }
    colour_bar(&mut picture, [left + side + 26, top], side, scale);
    picture
}

/// The labels at the left of row k and above column k of tiles.
fn edge_labels(layout: Layout, k: usize) -> (String, String) {
    match layout {
        Layout::Isotropic => {
            let degrees = |tiles: f64| tiles / (TILES * TILES) as f64 * 90.0;
            let (row, column) = (degrees((k * TILES) as f64 + 0.5), degrees(k as f64));
            (format!("{row:.1}\u{b0}"), format!("+{column:.1}\u{b0}"))
        }
        Layout::Hemisphere => {
            let [u, _] = AngularMap::new(TILES).position(0, k);
            (format!("{u:.2}"), format!("{u:.2}"))
        }
    }
}

/// One disc of [`discs`].
#[derive(Clone, Copy, Debug)]
pub struct Disc<'a> {
    /// What it shows, in a few words of ASCII or Latin-1.
    pub caption: &'a str,
    /// Unit of the values.
    pub units: &'a str,
    /// Texels along one side of the angular map.
    pub size: usize,
    /// The texels row by row, `size * size` of them.
    pub values: &'a [f32],
}

/// Images on the angular map, such as lobes and their bandwidth, side by side in rows of `columns`, 256 pixels wide or more,
/// each with its own logarithmic colour bar as in [`preview`].
///
/// # Panics
/// If there is none, `columns` is zero, or the number of values of a disc is not the square of its size.
#[must_use]
pub fn discs(title: &str, discs: &[Disc<'_>], columns: usize) -> RgbImage {
    assert!(!discs.is_empty() && columns > 0, "no discs");
    let zoom = |disc: &Disc| (256 / disc.size as u32).max(1);
    let side = discs.iter().map(|disc| disc.size as u32 * zoom(disc)).max().unwrap_or(0);
    let columns = columns.min(discs.len());
    let (width, height) = (side + 16 + BAR_SPACE, side + 66);
    let rows = discs.len().div_ceil(columns) as u32;
    let heading = MARGIN + 24;
    let mut picture =
        RgbImage::from_pixel(2 * MARGIN + columns as u32 * width, heading + MARGIN + rows * height, BACKGROUND);
    text(&mut picture, [MARGIN, MARGIN - 4], title, TITLE, Align::Left, INK);
    for (k, shown) in discs.iter().enumerate() {
        assert_eq!(shown.values.len(), shown.size * shown.size, "{}: wrong number of values", shown.caption);
        let (x, y) = (MARGIN + (k % columns) as u32 * width, heading + (k / columns) as u32 * height);
        let scale = Scale::of(shown.values.iter().copied());
        text(&mut picture, [x, y + 4], shown.caption, LABEL, Align::Left, INK);
        text(&mut picture, [x, y + 22], shown.units, LABEL, Align::Left, FAINT);
        let corner = [x, y + 48];
        disc(&mut picture, corner, shown.size, zoom(shown), scale, |row, column| {
            shown.values[row * shown.size + column]
        });
        colour_bar(&mut picture, [x + side + 16, y + 48], side, scale);
    }
    picture
}

/// A picture as the bytes of a PNG file.
///
/// # Errors
/// [`AtlasError::Io`] if the encoder refuses; none is known for the pictures of this module.
pub fn png_bytes(picture: &RgbImage) -> Result<Vec<u8>, AtlasError> {
    let mut bytes = Cursor::new(Vec::new());
    picture.write_to(&mut bytes, ImageFormat::Png).map_err(|error| AtlasError::Io(std::io::Error::other(error)))?;
    Ok(bytes.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::atlas::texture::{AtlasChannels, SIZE};
    use image::Rgb;

    fn atlas(layout: Layout) -> Atlas {
        let texels = (0..SIZE * SIZE).map(|k| if k % SIZE < SIZE / 2 { 0.0 } else { 3.0 + (k / SIZE) as f32 / 16.0 });
        Atlas::from_level0(layout, AtlasChannels::Max, texels.collect()).unwrap()
    }

    #[test]
    fn every_texel_inside_the_discs_is_one_pixel() {
        let atlas = atlas(Layout::Isotropic);
        let picture = preview(&atlas, "test");
        let scale = Scale::of(atlas.level(0).texels().iter().copied());
        assert_eq!(scale, Scale { low: 1, high: 7, beyond: false });
        let (left, top) = (MARGIN + text_width("00.0\u{b0} ", LABEL), MARGIN + 74);
        for (row, column) in [(32, 32), (5 * 64 + 30, 15 * 64 + 12), (1000, 990), (700, 100)] {
            let at = |start: u32, index: usize| start + index as u32 + (index / TILE) as u32 * GAP;
            let pixel = picture.get_pixel(at(left, column), at(top, row));
            assert_eq!(*pixel, scale.colour(atlas.texel(0, row, column)[0]));
        }
        // corners are left out
        assert_eq!(*picture.get_pixel(left, top), BACKGROUND);
    }

    #[test]
    fn nothing_is_drawn_at_the_edges() {
        let values = vec![0.5; 32 * 32];
        let shown = Disc { caption: "a disc", units: "1/sr", size: 32, values: &values };
        for picture in [
            preview(&atlas(Layout::Hemisphere), "hemisphere"),
            preview(&atlas(Layout::Isotropic), "isotropic"),
            discs("three discs in two rows", &[shown; 3], 2),
        ] {
            let (width, height) = picture.dimensions();
            let inside = |x: u32, y: u32| (8..width - 8).contains(&x) && (8..height - 8).contains(&y);
            let drawn = |x: u32, y: u32, pixel: &Rgb<u8>| *pixel != BACKGROUND && !inside(x, y);
            assert!(!picture.enumerate_pixels().any(|(x, y, pixel)| drawn(x, y, pixel)));
            assert!(png_bytes(&picture).unwrap().starts_with(b"\x89PNG"));
        }
    }
}
