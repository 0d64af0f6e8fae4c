//! Pictures for people: images and false-colour maps side by side, with titles and legends. Values are lost in them.

use brdfit_bandwidth::preview::canvas::{
    Align, BACKGROUND, BAR, FAINT, INK, LABEL, TITLE, colour_bar, fill, text, text_width,
};
use brdfit_bandwidth::preview::scale::{Scale, ZERO, colour};
use image::{Rgb, RgbImage, imageops};

use crate::images::exposure::Exposure;
use crate::images::film::shown;

/// Levels of the hierarchy of cells, 0 (single pixels) to 5 (32 x 32 pixels).
const LEVELS: usize = 6;
/// Pixels from the outer edge to whatever is drawn.
const MARGIN: u32 = 24;
/// Pixels between a picture and its legend.
const GAP: u32 = 16;
/// Pixels for the title of a panel and the line below it.
const HEADING: u32 = 46;

/// One picture of [`side_by_side`].
#[derive(Clone, Debug)]
pub struct Panel {
    title: String,
    note: String,
    picture: RgbImage,
    legend: Legend,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Legend {
    None,
    Levels,
    Bar(Scale),
}

impl Legend {
    fn width(self) -> u32 {
        match self {
            Self::None => 0,
            Self::Levels => GAP + BAR + 9 + text_width("32 x 32", LABEL),
            Self::Bar(_) => GAP + BAR + 9 + text_width("0.015625+", LABEL),
        }
    }

    fn height(self) -> u32 {
        match self {
            Self::None => 0,
            Self::Levels => LEVELS as u32 * 2 * LABEL.val() as u32,
            Self::Bar(_) => 6 * LABEL.val() as u32,
        }
    }

    fn draw(self, picture: &mut RgbImage, [x, y]: [u32; 2], height: u32) {
        match self {
            Self::None => {}
            Self::Levels => {
                let line = LABEL.val() as u32;
                for level in 0..LEVELS {
                    let at = y + level as u32 * 2 * line;
                    fill(picture, x, at, BAR, 2 * line, level_colour(level));
                    let side = 1 << level;
                    text(picture, [x + BAR + 9, at + line / 2], &format!("{side} x {side}"), LABEL, Align::Left, INK);
                }
            }
            Self::Bar(scale) => colour_bar(picture, [x, y], height, scale),
        }
    }
}

impl Panel {
    /// Radiance as a display shows it.
    ///
    /// # Panics
    /// If the number of pixels is not a multiple of the width.
    #[must_use]
    pub fn image(title: &str, pixels: &[[f32; 3]], width: usize, exposure: Exposure) -> Self {
        let picture = shown(pixels, width, exposure);
        Self { title: title.to_owned(), note: String::new(), picture, legend: Legend::None }
    }

    /// The size of the cell that each pixel belongs to, as its level 0 (bright, single pixels) to 5 (dark, 32 x 32
    /// pixels); any larger number, such as for the background, is grey.
    ///
    /// # Panics
    /// If the number of pixels is not a multiple of the width.
    #[must_use]
    pub fn levels(title: &str, levels: &[u8], width: usize) -> Self {
        let colour = |&level: &u8| if usize::from(level) < LEVELS { level_colour(usize::from(level)) } else { ZERO };
        let picture = coloured(levels.iter().map(colour), width);
        Self { title: title.to_owned(), note: "pixels per cell".to_owned(), picture, legend: Legend::Levels }
    }

    /// A quantity on a logarithmic scale between two powers of two; 0, negative values and what is no number are grey,
    /// the largest 0.5 % of the finite values and infinity may share the brightest colour, marked by a plus at the
    /// colour bar.
    ///
    /// # Panics
    /// If the number of pixels is not a multiple of the width.
    #[must_use]
    pub fn quantity(title: &str, unit: &str, values: &[f32], width: usize) -> Self {
        let mut scale = Scale::of(values.iter().copied().filter(|value| value.is_finite()));
        scale.beyond |= values.contains(&f32::INFINITY);
        let picture = coloured(values.iter().map(|&value| scale.colour(value)), width);
        Self { title: title.to_owned(), note: unit.to_owned(), picture, legend: Legend::Bar(scale) }
    }

    /// Says something else in the line below the title than the unit of a map.
    #[must_use]
    pub fn note(mut self, note: &str) -> Self {
        note.clone_into(&mut self.note);
        self
    }

    /// The map alone, pixel by pixel.
    #[must_use]
    pub fn picture(&self) -> &RgbImage {
        &self.picture
    }

    fn size(&self) -> [u32; 2] {
        let words = text_width(&self.title, LABEL).max(text_width(&self.note, LABEL));
        let (width, height) = self.picture.dimensions();
        [(width + self.legend.width()).max(words), HEADING + height.max(self.legend.height())]
    }

    fn draw(&self, page: &mut RgbImage, [x, y]: [u32; 2]) {
        text(page, [x, y + 2], &self.title, LABEL, Align::Left, INK);
        text(page, [x, y + 20], &self.note, LABEL, Align::Left, FAINT);
        let (width, height) = self.picture.dimensions();
        imageops::replace(page, &self.picture, i64::from(x), i64::from(y + HEADING));
        self.legend.draw(page, [x + width + GAP, y + HEADING], height.max(self.legend.height()));
    }
}

/// Panels in rows of `columns` on one page, each column as wide and each row as high as its panels need.
///
/// # Panics
/// If there is no panel or no column.
#[must_use]
pub fn side_by_side(title: &str, panels: &[Panel], columns: usize) -> RgbImage {
    assert!(!panels.is_empty() && columns > 0, "no panels");
    let columns = columns.min(panels.len());
    let mut widths = vec![0; columns];
    let mut heights = vec![0; panels.len().div_ceil(columns)];
    for (k, panel) in panels.iter().enumerate() {
        let [width, height] = panel.size();
        widths[k % columns] = width.max(widths[k % columns]);
        heights[k / columns] = height.max(heights[k / columns]);
    }
    // places of the first pixels, and in the end what comes after the last and a margin
    let starts = |first: u32, lengths: &[u32]| {
        lengths.iter().fold(vec![first], |mut starts, length| {
            starts.push(starts[starts.len() - 1] + length + MARGIN);
            starts
        })
    };
    let (x, y) = (starts(MARGIN, &widths), starts(MARGIN + 28, &heights));
    let width = x[columns].max(2 * MARGIN + text_width(title, TITLE));
    let mut page = RgbImage::from_pixel(width, y[heights.len()], BACKGROUND);
    text(&mut page, [MARGIN, MARGIN - 4], title, TITLE, Align::Left, INK);
    for (k, panel) in panels.iter().enumerate() {
        panel.draw(&mut page, [x[k % columns], y[k / columns]]);
    }
    page
}

fn level_colour(level: usize) -> Rgb<u8> {
    colour(1.0 - level as f32 / (LEVELS - 1) as f32)
}

fn coloured(pixels: impl ExactSizeIterator<Item = Rgb<u8>>, width: usize) -> RgbImage {
    let count = pixels.len();
    assert!(count.is_multiple_of(width.max(1)), "whole rows");
    let bytes = pixels.flat_map(|Rgb(bytes)| bytes).collect();
    RgbImage::from_raw(width as u32, (count / width.max(1)) as u32, bytes).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_can_be_told_apart() {
        let panel = Panel::levels("levels", &[0, 1, 2, 3, 4, 5, 6, 255], 4);
        let colours: Vec<_> = panel.picture().pixels().copied().collect();
        assert_eq!(panel.picture().dimensions(), (4, 2));
        for k in 0..6 {
            for other in 0..k {
                let apart = (0..3).map(|c| colours[k].0[c].abs_diff(colours[other].0[c])).max().unwrap();
                assert!(apart > 30, "{k} and {other}: {:?} and {:?}", colours[k], colours[other]);
            }
        }
        assert_eq!(colours[6..], [ZERO; 2]);
    }

    #[test]
    fn quantities_keep_their_order_and_infinity_is_bright() {
        let mut values: Vec<f32> = (0..100).map(|k| k as f32).collect();
        values[99] = f32::INFINITY;
        values[98] = f32::NAN;
        let panel = Panel::quantity("bandwidth", "cycles per pixel", &values, 10);
        let Legend::Bar(scale) = panel.legend else { panic!("{:?}", panel.legend) };
        assert!(scale.beyond && scale.low == 0 && scale.high == 7);
        assert_eq!(*panel.picture().get_pixel(0, 0), ZERO);
        assert_eq!(*panel.picture().get_pixel(8, 9), ZERO);
        assert_eq!(*panel.picture().get_pixel(9, 9), colour(1.0));
        assert_eq!(*panel.picture().get_pixel(8, 0), colour(3.0 / 7.0));
    }

    #[test]
    fn panels_keep_their_pixels_and_the_margin_stays_free() {
        let pixels: Vec<[f32; 3]> = (0..40 * 30).map(|k| [k as f32 / 1200.0, 0.5, 0.1]).collect();
        let levels: Vec<u8> = (0..40 * 30).map(|k| (k % 7) as u8).collect();
        let values: Vec<f32> = (0..40 * 30).map(|k| (k as f32).exp2() * 1e-3).collect();
        let panels = [
            Panel::image("an image", &pixels, 40, Exposure::ONE).note("exposure 1"),
            Panel::levels("levels", &levels, 40),
            Panel::quantity("a quantity", "cycles per radian", &values, 40),
        ];
        for columns in 1..5 {
            let page = side_by_side("three panels", &panels, columns);
            let (width, height) = page.dimensions();
            let inside = |x: u32, y: u32| (8..width - 8).contains(&x) && (8..height - 8).contains(&y);
            assert!(!page.enumerate_pixels().any(|(x, y, &pixel)| pixel != BACKGROUND && !inside(x, y)), "{columns}");
            let first = imageops::crop_imm(&page, MARGIN, MARGIN + 28 + HEADING, 40, 30).to_image();
            assert_eq!(first, *panels[0].picture());
        }
        let titled = side_by_side("a title that is much wider than the only picture below it", &panels[..1], 1);
        assert!(titled.width() > 500);
    }
}
