//! The false-colour preview of an atlas: its tiles as discs. Values cannot be recovered from it.

use brdfit_bandwidth::{AngularMap, Atlas, Layout, TILE, TILES, UNITS};
use brdfit_figures::canvas::{Align, BACKGROUND, FAINT, INK, TextSize, colour_bar, disc, text, text_width};
use brdfit_figures::image::RgbImage;
use brdfit_figures::scale::Scale;

/// Margin in pixels.
const MARGIN: u32 = 24;
/// Pixels between tiles.
const GAP: u32 = 4;
/// Pixels from one tile to the next.
const PITCH: u32 = TILE as u32 + GAP;
/// Pixels for a colour bar with its labels.
const BAR_SPACE: u32 = 88;

/// Level 0 of an atlas as a preview: its 16 x 16 tiles as discs, texel by texel, with the incident directions
/// along the edges and a colour bar. The colours are logarithmic between two powers of two; 0 is grey, and
/// the largest 0.5 % of the values may share the brightest colour, marked by a plus at the colour bar. Of four channels the
/// maximum is shown. The corners of the tiles, which repeat the rim, are left out.
pub(crate) fn preview(atlas: &Atlas, title: &str) -> RgbImage {
    let last = atlas.channels().count() - 1;
    let level = atlas.level(0);
    let scale = Scale::of(level.texels().iter().skip(last).step_by(last + 1).copied());

    let labels = text_width("00.0\u{b0} ", TextSize::Label);
    let (left, top) = (MARGIN + labels, MARGIN + 74);
    let side = TILES as u32 * PITCH - GAP;
    let mut picture = RgbImage::from_pixel(left + side + 26 + BAR_SPACE + MARGIN, top + side + MARGIN, BACKGROUND);

    text(&mut picture, [MARGIN, MARGIN - 4], title, TextSize::Title, Align::Left, INK);
    let caption = match atlas.layout() {
        Layout::Isotropic => "theta_i of a tile = row + column, light on the right, mirror direction on the left",
        Layout::Hemisphere => "tiles: (u, v) of the incident direction on the angular map, v downwards",
    };
    text(&mut picture, [MARGIN, MARGIN + 22], caption, TextSize::Label, Align::Left, FAINT);
    let right = picture.width() - MARGIN;
    text(&mut picture, [right, MARGIN + 22], UNITS, TextSize::Label, Align::Right, FAINT);
    for k in 0..TILES {
        let start = k as u32 * PITCH;
        let (row_label, column_label) = edge_labels(atlas.layout(), k);
        text(
            &mut picture,
            [left - 9, top + start + (PITCH - GAP) / 2 - 8],
            &row_label,
            TextSize::Label,
            Align::Right,
            INK,
        );
        text(
            &mut picture,
            [left + start + (PITCH - GAP) / 2, top - 22],
            &column_label,
            TextSize::Label,
            Align::Centre,
            INK,
        );
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

#[cfg(test)]
mod tests {
    use super::*;
    use brdfit_bandwidth::{AtlasChannels, SIZE};
    use brdfit_figures::image::Rgb;

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
        let (left, top) = (MARGIN + text_width("00.0\u{b0} ", TextSize::Label), MARGIN + 74);
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
        for layout in [Layout::Hemisphere, Layout::Isotropic] {
            let picture = preview(&atlas(layout), "an atlas");
            let (width, height) = picture.dimensions();
            let inside = |x: u32, y: u32| (8..width - 8).contains(&x) && (8..height - 8).contains(&y);
            let drawn = |x: u32, y: u32, pixel: &Rgb<u8>| *pixel != BACKGROUND && !inside(x, y);
            assert!(!picture.enumerate_pixels().any(|(x, y, pixel)| drawn(x, y, pixel)));
        }
    }
}
