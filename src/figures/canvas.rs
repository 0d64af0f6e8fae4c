//! Drawing on an image: rectangles, text, discs of texels and colour bars.

use image::{Rgb, RgbImage};
use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

use crate::scale::{Scale, ZERO, colour};

/// Colour of the page.
pub const BACKGROUND: Rgb<u8> = Rgb([255, 255, 255]);
/// Colour of titles and values.
pub const INK: Rgb<u8> = Rgb([40, 40, 46]);
/// Colour of captions and units.
pub const FAINT: Rgb<u8> = Rgb([120, 120, 128]);
/// Width of a colour bar without its labels, in pixels.
pub const BAR: u32 = 22;

/// Size of a text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TextSize {
    /// Titles of figures.
    Title,
    /// All other text.
    Label,
}

impl TextSize {
    /// Height of a line of text in pixels.
    #[must_use]
    pub const fn height(self) -> u32 {
        match self {
            Self::Title => 20,
            Self::Label => 16,
        }
    }

    fn raster(self) -> RasterHeight {
        match self {
            Self::Title => RasterHeight::Size20,
            Self::Label => RasterHeight::Size16,
        }
    }
}

/// Alignment of a text relative to its point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Align {
    /// To the right of it.
    Left,
    /// Centred about it.
    Centre,
    /// To the left of it.
    Right,
}

/// A filled rectangle with its upper left corner at (x, y).
///
/// # Panics
/// If it does not lie inside the image.
pub fn fill(image: &mut RgbImage, x: u32, y: u32, width: u32, height: u32, colour: Rgb<u8>) {
    for row in y..y + height {
        for column in x..x + width {
            image.put_pixel(column, row, colour);
        }
    }
}

/// Width of a text in pixels.
#[must_use]
pub fn text_width(text: &str, size: TextSize) -> u32 {
    (text.chars().count() * get_raster_width(FontWeight::Regular, size.raster())) as u32
}

/// One line of text whose upper edge is `y`; what the font lacks becomes a question mark, what does not fit is cut off.
pub fn text(image: &mut RgbImage, [x, y]: [u32; 2], text: &str, size: TextSize, align: Align, ink: Rgb<u8>) {
    let width = text_width(text, size);
    let mut left = match align {
        Align::Left => x,
        Align::Centre => x.saturating_sub(width / 2),
        Align::Right => x.saturating_sub(width),
    };
    for c in text.chars() {
        let Some(glyph) = get_raster(c, FontWeight::Regular, size.raster())
            .or_else(|| get_raster('?', FontWeight::Regular, size.raster()))
        else {
            continue;
        };
        for (row, pixels) in (y..).zip(glyph.rows()) {
            for (column, &cover) in (left..).zip(pixels) {
                if let Some(pixel) = image.get_pixel_mut_checked(column, row) {
                    *pixel = mix(*pixel, ink, f32::from(cover) / 255.0);
                }
            }
        }
        left += glyph.width() as u32;
    }
}

/// The disc of an angular map of `n` x `n` values at (x, y), each texel `zoom` x `zoom` pixels, with a smooth edge.
pub fn disc(
    image: &mut RgbImage,
    [x, y]: [u32; 2],
    n: usize,
    zoom: u32,
    scale: Scale,
    value: impl Fn(usize, usize) -> f32,
) {
    let size = n as u32 * zoom;
    let radius = size as f32 / 2.0;
    for row in 0..size {
        for column in 0..size {
            let (u, v) = (column as f32 + 0.5 - radius, row as f32 + 0.5 - radius);
            let cover = (radius + 0.5 - (u * u + v * v).sqrt()).clamp(0.0, 1.0);
            if cover > 0.0 {
                let texel = scale.colour(value((row / zoom) as usize, (column / zoom) as usize));
                let pixel = image.get_pixel_mut(x + column, y + row);
                *pixel = mix(*pixel, texel, cover);
            }
        }
    }
}

/// A vertical colour bar with a tick at every power of two, or at every second or third where they are too many, a plus at
/// the uppermost where larger values share its colour, and below it the colour of 0. Occupies `height` pixels from y.
pub fn colour_bar(image: &mut RgbImage, [x, y]: [u32; 2], height: u32, scale: Scale) {
    let line = TextSize::Label.height();
    let bar = height - 2 * line;
    for row in 0..bar {
        let t = 1.0 - (row as f32 + 0.5) / bar as f32;
        fill(image, x, y + row, BAR, 1, colour(t));
    }
    let label = |image: &mut RgbImage, at: u32, value: &str| {
        fill(image, x + BAR, at, 5, 1, INK);
        text(image, [x + BAR + 9, at.saturating_sub(line / 2)], value, TextSize::Label, Align::Left, INK);
    };
    let step = (1..).find(|step| bar * step / scale.octaves().unsigned_abs() >= 2 * line).unwrap_or(1);
    for power in (scale.low..=scale.high).rev().step_by(step as usize) {
        let from_top = (scale.high - power) as u32 * (bar - 1) / scale.octaves().unsigned_abs();
        let more = if scale.beyond && power == scale.high { "+" } else { "" };
        label(image, y + from_top, &format!("{}{more}", power_of_two(power)));
    }
    let zero = y + height - line;
    fill(image, x, zero, BAR, line, ZERO);
    label(image, zero + line / 2, "0");
}

/// 2^power as short as it goes: 0.25, 8, 4096.
fn power_of_two(power: i32) -> String {
    let value = libm::exp2(f64::from(power));
    if !(-6..=23).contains(&power) { format!("{value:.0e}") } else { format!("{value}") }
}

fn mix(Rgb(a): Rgb<u8>, Rgb(b): Rgb<u8>, t: f32) -> Rgb<u8> {
    Rgb(std::array::from_fn(|c| (f32::from(a[c]) + (f32::from(b[c]) - f32::from(a[c])) * t).round() as u8))
}
