//! Images and false-colour maps side by side, with titles and legends. Values cannot be recovered from them.

use image::{Rgb, RgbImage, imageops};

use crate::canvas::{Align, BACKGROUND, BAR, FAINT, INK, TextSize, colour_bar, fill, text, text_width};
use crate::scale::Scale;

/// Margin in pixels.
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

#[derive(Clone, Debug, PartialEq)]
enum Legend {
    None,
    Classes(Vec<Class>),
    Bar(Scale),
}

/// A colour of a map and its meaning.
#[derive(Clone, Debug, PartialEq)]
pub struct Class {
    /// As it is drawn.
    pub colour: Rgb<u8>,
    /// Its label in the legend, in ASCII or Latin-1.
    pub label: String,
}

impl Legend {
    fn width(&self) -> u32 {
        match self {
            Self::None => 0,
            Self::Classes(classes) => {
                let labels = classes.iter().map(|class| text_width(&class.label, TextSize::Label));
                GAP + BAR + 9 + labels.max().unwrap_or(0)
            }
            Self::Bar(_) => GAP + BAR + 9 + text_width("0.015625+", TextSize::Label),
        }
    }

    fn height(&self) -> u32 {
        match self {
            Self::None => 0,
            Self::Classes(classes) => classes.len() as u32 * 2 * TextSize::Label.height(),
            Self::Bar(_) => 6 * TextSize::Label.height(),
        }
    }

    fn draw(&self, picture: &mut RgbImage, [x, y]: [u32; 2], height: u32) {
        match self {
            Self::None => {}
            Self::Classes(classes) => {
                let line = TextSize::Label.height();
                for (k, Class { colour, label }) in (0..).zip(classes) {
                    let at = y + k * 2 * line;
                    fill(picture, x, at, BAR, 2 * line, *colour);
                    text(picture, [x + BAR + 9, at + line / 2], label, TextSize::Label, Align::Left, INK);
                }
            }
            Self::Bar(scale) => colour_bar(picture, [x, y], height, *scale),
        }
    }
}

impl Panel {
    /// A picture as it is.
    #[must_use]
    pub fn image(title: &str, picture: RgbImage) -> Self {
        Self { title: title.to_owned(), note: String::new(), picture, legend: Legend::None }
    }

    /// A map of a few classes. A pixel gives the index of its class; one that is not in the list is drawn in `others`.
    ///
    /// # Panics
    /// If the number of pixels is not a multiple of the width.
    #[must_use]
    pub fn classes(title: &str, classes: Vec<Class>, others: Rgb<u8>, pixels: &[u8], width: usize) -> Self {
        let colour = |&pixel: &u8| classes.get(usize::from(pixel)).map_or(others, |class| class.colour);
        let picture = coloured(pixels.iter().map(colour), width);
        Self { title: title.to_owned(), note: String::new(), picture, legend: Legend::Classes(classes) }
    }

    /// A quantity on a logarithmic scale between two powers of two; 0, negative values and NaN are grey,
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

    /// The line below the title, for a quantity instead of its unit.
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
        let words = text_width(&self.title, TextSize::Label).max(text_width(&self.note, TextSize::Label));
        let (width, height) = self.picture.dimensions();
        [(width + self.legend.width()).max(words), HEADING + height.max(self.legend.height())]
    }

    fn draw(&self, page: &mut RgbImage, [x, y]: [u32; 2]) {
        text(page, [x, y + 2], &self.title, TextSize::Label, Align::Left, INK);
        text(page, [x, y + 20], &self.note, TextSize::Label, Align::Left, FAINT);
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
    let width = x[columns].max(2 * MARGIN + text_width(title, TextSize::Title));
    let mut page = RgbImage::from_pixel(width, y[heights.len()], BACKGROUND);
    text(&mut page, [MARGIN, MARGIN - 4], title, TextSize::Title, Align::Left, INK);
    for (k, panel) in panels.iter().enumerate() {
        panel.draw(&mut page, [x[k % columns], y[k / columns]]);
    }
    page
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
    use crate::scale::{ZERO, colour};

    fn classes() -> Vec<Class> {
        let class = |(t, label): (f32, &str)| Class { colour: colour(t), label: label.to_owned() };
        [(0.0, "dark"), (0.5, "between"), (1.0, "bright")].map(class).into()
    }

    #[test]
    fn classes_have_their_colours_and_what_is_none_another() {
        let panel = Panel::classes("classes", classes(), ZERO, &[0, 1, 2, 3, 255, 1], 3);
        let colours: Vec<_> = panel.picture().pixels().copied().collect();
        assert_eq!(panel.picture().dimensions(), (3, 2));
        assert_eq!(colours, [colour(0.0), colour(0.5), colour(1.0), ZERO, ZERO, colour(0.5)]);
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
        let picture = RgbImage::from_fn(40, 30, |x, y| Rgb([x as u8 * 6, y as u8 * 8, 9]));
        let pixels: Vec<u8> = (0..40 * 30).map(|k| (k % 7) as u8).collect();
        let values: Vec<f32> = (0..40 * 30).map(|k| (k as f32).exp2() * 1e-3).collect();
        let panels = [
            Panel::image("an image", picture).note("exposure 1"),
            Panel::classes("classes", classes(), ZERO, &pixels, 40),
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
