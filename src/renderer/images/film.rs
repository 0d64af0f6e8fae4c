//! Image files: radiance with further layers as OpenEXR, read back as a reference; display images.
//!
//! A written OpenEXR file has one part: scan lines, ZIP, single precision, the data window equal to the display window.
//! Radiance is in the channels R, G, B; every further layer in channels called `layer.channel`, as viewers expect it.
//! Infinities are kept.

use std::io::Cursor;

use ::exr::meta::MetaData;
use ::exr::meta::header::Header;
use ::exr::prelude::*;
use brdfit_figures::image::RgbImage;

use crate::images::exposure::Exposure;

/// No more pixels are read than a square image of this many rows has.
const MOST_ROWS: usize = 1 << 14;

/// Errors of writing and reading images; the message is one line, to which the caller prepends the file name.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FilmError {
    /// The encoder or the decoder failed.
    #[error("unreadable OpenEXR image ({0}); write it again")]
    Format(String),
    /// A sound OpenEXR file of another kind.
    #[error("cannot be used as a reference: {0}; use an image that this program wrote, or channels R, G and B")]
    Unsupported(String),
    /// An image of another size.
    #[error(
        "{} x {} pixels where {} x {} are expected; render both images at the same size",
        found[0], found[1], expected[0], expected[1]
    )]
    Size {
        /// Columns and rows of the file.
        found: [usize; 2],
        /// Requested columns and rows.
        expected: [usize; 2],
    },
    /// A value that is no number.
    #[error("channel {channel} is {value} at column {column}, row {row}; only finite radiance can be compared")]
    Value {
        /// Name of the channel.
        channel: String,
        /// Column from the left.
        column: usize,
        /// Row from the top.
        row: usize,
        /// The value.
        value: f32,
    },
}

impl From<::exr::error::Error> for FilmError {
    fn from(error: ::exr::error::Error) -> Self {
        Self::Format(error.to_string())
    }
}

/// Planes of one image under the names of their channels.
#[derive(Clone, Debug)]
pub struct Film {
    width: usize,
    height: usize,
    comment: String,
    channels: Vec<(String, Vec<f32>)>,
}

impl Film {
    /// An image without channels.
    ///
    /// # Panics
    /// If it has no pixels.
    #[must_use]
    pub fn new(width: usize, height: usize) -> Self {
        assert!(width > 0 && height > 0, "an image of {width} x {height} pixels");
        Self { width, height, comment: String::new(), channels: Vec::new() }
    }

    /// Says in the file's attribute `comments` where the image comes from.
    #[must_use]
    pub fn comment(mut self, text: impl Into<String>) -> Self {
        self.comment = text.into();
        self
    }

    /// Adds radiance, W/(m^2 sr) or the unit of the light, row by row from the top left corner: channels R, G, B.
    ///
    /// # Panics
    /// If there is not one value per pixel.
    #[must_use]
    pub fn radiance(self, pixels: &[[f32; 3]]) -> Self {
        let plane = |c: usize| pixels.iter().map(move |pixel| pixel[c]);
        self.plane("R", plane(0)).plane("G", plane(1)).plane("B", plane(2))
    }

    /// Adds a layer: channels `name.component`.
    ///
    /// # Panics
    /// If there is not one value per pixel, or the layer exists.
    #[must_use]
    pub fn layer(self, layer: &crate::images::layer::Layer) -> Self {
        let add = |film: Self, (component, values): &(&str, Vec<f32>)| {
            film.plane(&format!("{}.{component}", layer.name()), values.iter().copied())
        };
        layer.planes().iter().fold(self, add)
    }

    /// Adds a layer of one component per pixel: the channel `name.Y`, which viewers show in grey.
    ///
    /// # Panics
    /// As [`Film::layer`].
    #[must_use]
    pub fn scalar(self, name: &str, pixels: impl Iterator<Item = f32>) -> Self {
        self.plane(&format!("{name}.Y"), pixels)
    }

    fn plane(mut self, name: &str, pixels: impl Iterator<Item = f32>) -> Self {
        let values: Vec<f32> = pixels.collect();
        assert_eq!(values.len(), self.width * self.height, "{name}: one value per pixel");
        assert!(self.channels.iter().all(|(other, _)| other != name), "{name} exists");
        self.channels.push((name.to_owned(), values));
        self
    }

    /// The OpenEXR file as bytes, the same for every number of threads.
    ///
    /// # Errors
    /// [`FilmError::Value`] for a value that is not a number, [`FilmError::Format`] for what the encoder refuses: an
    /// image without channels.
    pub fn to_exr(self) -> std::result::Result<Vec<u8>, FilmError> {
        let Self { width, height, comment, channels } = self;
        for (name, values) in &channels {
            check(name, values.iter().copied(), width, |value| !value.is_nan())?;
        }
        let channels =
            channels.into_iter().map(|(name, values)| AnyChannel::new(name.as_str(), FlatSamples::F32(values)));
        let encoding =
            Encoding { compression: Compression::ZIP16, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };
        let attributes = LayerAttributes {
            software_name: Some("brdfit".into()),
            comments: (!comment.is_empty()).then(|| Text::from_slice_unchecked(comment.as_bytes())),
            ..LayerAttributes::default()
        };
        let layer = Layer::new((width, height), attributes, encoding, AnyChannels::sort(channels.collect()));
        let mut bytes = Cursor::new(Vec::new());
        Image::from_layer(layer).write().to_buffered(&mut bytes)?;
        Ok(bytes.into_inner())
    }
}

/// Radiance per pixel, row by row from the top left corner.
#[derive(Clone, Debug, PartialEq)]
pub struct Radiance {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// R, G, B of each pixel, finite.
    pub pixels: Vec<[f32; 3]>,
}

impl Radiance {
    /// Reads R, G and B of the first part of an OpenEXR file that has them, of any sample type and compression except
    /// DWA.
    ///
    /// # Errors
    /// [`FilmError::Format`] if the bytes are no whole OpenEXR file, [`FilmError::Unsupported`] if it has no R, G and
    /// B, is larger than 16384 x 16384, or covers only a part of its display window, [`FilmError::Value`] for the first
    /// value that is not finite.
    pub fn from_exr(bytes: &[u8]) -> std::result::Result<Self, FilmError> {
        let meta = MetaData::read_from_buffered(Cursor::new(bytes), false)?;
        let is_colour = |header: &&Header| {
            ["R", "G", "B"].iter().all(|&name| header.channels.list.iter().any(|channel| channel.name.eq(name)))
        };
        let Some(header) = meta.headers.iter().find(is_colour) else {
            return Err(FilmError::Unsupported("no part of the file has the channels R, G and B".to_owned()));
        };
        let Vec2(width, height) = header.layer_size;
        let window = header.shared_attributes.display_window;
        if header.own_attributes.layer_position != window.position || header.layer_size != window.size {
            let Vec2(columns, rows) = window.size;
            let why =
                format!("its data window of {width} x {height} pixels is not its display window of {columns} x {rows}");
            return Err(FilmError::Unsupported(why));
        }
        if meta.headers.iter().any(|header| header.layer_size.area() > MOST_ROWS * MOST_ROWS) {
            return Err(FilmError::Unsupported(format!("it has more than {MOST_ROWS} x {MOST_ROWS} pixels")));
        }
        let (_, pixels) = read_colours(bytes, 0.0)?;
        for (c, name) in ["R", "G", "B"].into_iter().enumerate() {
            check(name, pixels.iter().map(|pixel| pixel[c]), width, f32::is_finite)?;
        }
        Ok(Self { width, height, pixels })
    }

    /// The image itself if it has this size.
    ///
    /// # Errors
    /// [`FilmError::Size`].
    pub fn sized(self, width: usize, height: usize) -> std::result::Result<Self, FilmError> {
        let (found, expected) = ([self.width, self.height], [width, height]);
        if found == expected { Ok(self) } else { Err(FilmError::Size { found, expected }) }
    }
}

/// Width and pixels of the channels R, G and B of the first part of an OpenEXR file that has them; what no block of the file
/// fills stays `unfilled`.
pub(crate) fn read_colours(bytes: &[u8], unfilled: f32) -> ::exr::error::Result<(usize, Vec<[f32; 3]>)> {
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .specific_channels()
        .required("R")
        .required("G")
        .required("B")
        .collect_pixels(
            move |size, _| (size.width(), vec![[unfilled; 3]; size.area()]),
            |(width, pixels): &mut (usize, Vec<[f32; 3]>), at, (r, g, b): (f32, f32, f32)| {
                pixels[at.y() * *width + at.x()] = [r, g, b];
            },
        )
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))?;
    Ok(image.layer_data.channel_data.pixels)
}

/// Finds the first value that is not allowed.
fn check(
    channel: &str,
    mut values: impl Iterator<Item = f32>,
    width: usize,
    allowed: fn(f32) -> bool,
) -> std::result::Result<(), FilmError> {
    let mut found = 0.0;
    let wrong = values.position(|value| {
        found = value;
        !allowed(value)
    });
    match wrong {
        Some(k) => {
            Err(FilmError::Value { channel: channel.to_owned(), column: k % width, row: k / width, value: found })
        }
        None => Ok(()),
    }
}

/// Exposed radiance as a display shows it.
///
/// # Panics
/// If the number of pixels is not a multiple of the width.
#[must_use]
pub fn shown(pixels: &[[f32; 3]], width: usize, exposure: Exposure) -> RgbImage {
    assert!(pixels.len().is_multiple_of(width.max(1)), "whole rows");
    let bytes = pixels.iter().flat_map(|&pixel| exposure.bytes(pixel)).collect();
    RgbImage::from_raw(width as u32, (pixels.len() / width.max(1)) as u32, bytes).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdfit_figures::srgb;

    fn pixels() -> Vec<[f32; 3]> {
        (0..35).map(|k| [k as f32 / 7.0, 1e-20 * k as f32, 3e9 - k as f32]).collect()
    }

    fn film() -> Film {
        let depths = (0..35).map(|k| if k % 5 == 0 { f32::INFINITY } else { k as f32 });
        let normals = pixels().into_iter().map(|[x, y, _]| [x, y, 1.0]);
        let normal = crate::images::layer::Layer::new("normal", ["X", "Y", "Z"], normals);
        Film::new(7, 5).comment("a test").scalar("depth", depths).radiance(&pixels()).layer(&normal)
    }

    #[test]
    fn radiance_comes_back() {
        let bytes = film().to_exr().unwrap();
        let radiance = Radiance::from_exr(&bytes).unwrap();
        assert_eq!(radiance, Radiance { width: 7, height: 5, pixels: pixels() });
        assert_eq!(radiance.clone().sized(7, 5).unwrap(), radiance);
        let message = radiance.sized(5, 7).unwrap_err().to_string();
        assert!(message.starts_with("7 x 5 pixels where 5 x 7 are expected"), "{message}");
    }

    #[test]
    fn every_layer_comes_back_under_its_name() {
        let bytes = film().to_exr().unwrap();
        let image = read()
            .no_deep_data()
            .largest_resolution_level()
            .all_channels()
            .first_valid_layer()
            .all_attributes()
            .from_buffered(Cursor::new(&bytes))
            .unwrap();
        let names: Vec<String> = image.layer_data.channel_data.list.iter().map(|c| c.name.to_string()).collect();
        assert_eq!(names, ["B", "G", "R", "depth.Y", "normal.X", "normal.Y", "normal.Z"]);
        for channel in &image.layer_data.channel_data.list {
            let film = film();
            let (_, expected) = film.channels.iter().find(|(name, _)| channel.name.eq(name.as_str())).unwrap();
            assert!(channel.sample_data.values_as_f32().eq(expected.iter().copied()), "{}", channel.name);
        }
        assert_eq!(image.layer_data.attributes.comments.as_ref().map(Text::to_string).as_deref(), Some("a test"));
    }

    #[test]
    fn the_bytes_do_not_depend_on_threads() {
        let bytes = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let pixels: Vec<_> =
                    (0..200 * 300).map(|k| [(k % 977) as f32, (k % 31 * (k % 89)) as f32, 1.0]).collect();
                Film::new(200, 300).radiance(&pixels).scalar("a", pixels.iter().map(|p| p[0])).to_exr().unwrap()
            })
        };
        let one = bytes(1);
        for threads in [2, 3, 2] {
            assert!(bytes(threads) == one, "{threads}");
        }
    }

    #[test]
    fn half_precision_is_read() {
        let channels = SpecificChannels::rgb(|at: Vec2<usize>| {
            [at.x() as f32, at.y() as f32 / 4.0, 0.5].map(f16::from_f32).into()
        });
        let mut bytes = Cursor::new(Vec::new());
        Image::from_channels((6, 4), channels).write().to_buffered(&mut bytes).unwrap();
        let radiance = Radiance::from_exr(bytes.get_ref()).unwrap();
        assert_eq!((radiance.width, radiance.height), (6, 4));
        assert_eq!(radiance.pixels[6 * 3 + 5], [5.0, 0.75, 0.5]);
    }

    #[test]
    fn what_is_no_reference_is_refused_in_one_line() {
        let no_number = |value: f32| {
            let mut pixels = pixels();
            pixels[9][1] = value;
            Film::new(7, 5).radiance(&pixels)
        };
        let message = no_number(f32::NAN).to_exr().unwrap_err().to_string();
        assert!(message.starts_with("channel G is NaN at column 2, row 1"), "{message}");

        let whole = film().to_exr().unwrap();
        let infinite = no_number(f32::INFINITY).to_exr().unwrap();
        let no_colour = Film::new(2, 2).scalar("depth", [1.0; 4].into_iter()).to_exr().unwrap();
        for (bytes, expected) in [
            (b"\x89PNG and so on".as_slice(), "unreadable OpenEXR image"),
            (&whole[..whole.len() / 2], "unreadable OpenEXR image"),
            (&whole[..40], "unreadable OpenEXR image"),
            (&infinite, "channel G is inf at column 2, row 1"),
            (&no_colour, "cannot be used as a reference: no part of the file has the channels R, G and B"),
        ] {
            let message = Radiance::from_exr(bytes).unwrap_err().to_string();
            assert!(message.starts_with(expected) && !message.contains('\n'), "{message}");
        }
        assert!(matches!(Film::new(2, 2).to_exr(), Err(FilmError::Format(_))));
    }

    #[test]
    fn pictures_are_exposed() {
        let picture = shown(&[[0.0, 0.25, 0.5], [0.5, 1.0, 9.0]], 1, Exposure::new(2.0).unwrap());
        assert_eq!(picture.dimensions(), (1, 2));
        assert_eq!(picture.into_raw(), [0, srgb::byte(0.5), 255, 255, 255, 255]);
        assert_eq!(shown(&pixels(), 7, Exposure::ONE).dimensions(), (7, 5));
    }
}
