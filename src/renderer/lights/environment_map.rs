//! Environment maps in latitude and longitude, from OpenEXR and Radiance HDR files.
//!
//! Row 0 is at the zenith, world +z, the last row at the nadir. The column in the middle is world +x; a quarter to the left lies +y,
//! a quarter to the right -y, as somebody sees it who stands inside and looks along +x. At the centre of column c of w the azimuth
//! from +x towards +y is `phi = pi - 2 pi (c + 1/2) / w`, at the centre of row r of h the angle from +z is `theta = pi (r + 1/2) / h`.

use crate::geometry::vec3::Vec3;
use crate::images::film::read_colours;
use crate::lights::error::LightError;
use crate::lights::octahedral::light::{Light, is_radiance, texel_means};
use exr::error::Error as ExrError;
use image::ImageDecoder;
use rayon::prelude::*;
use std::f32::consts::{PI, TAU};
use std::io::Cursor;
use std::path::Path;

/// Maps with more pixels are refused.
const MOST_PIXELS: usize = 1 << 28;
/// A map is read at up to this many places along a side of each texel of the light.
const MOST_PLACES: usize = 16;

/// An environment map: radiance over latitude and longitude, linear RGB.
#[derive(Clone, Debug, PartialEq)]
pub struct LatLong {
    width: usize,
    height: usize,
    /// Row-major from the zenith.
    pixels: Vec<[f32; 3]>,
}

impl LatLong {
    /// A map with these pixels, row-major.
    ///
    /// # Errors
    /// [`LightError::Radiance`] if there are no pixels, not `width x height`, or a value is negative, not finite or above
    /// [`crate::LARGEST_RADIANCE`].
    pub fn new(width: usize, height: usize, pixels: Vec<[f32; 3]>) -> Result<Self, LightError> {
        if pixels.is_empty() || pixels.len() != width * height {
            let why = format!("{} pixels for {width} x {height}", pixels.len());
            return Err(LightError::Radiance { why });
        }
        match pixels.iter().position(|pixel| !pixel.iter().all(|&value| is_radiance(value))) {
            Some(k) => {
                let why = format!("{:?} at column {}, row {}", pixels[k], k % width, k / width);
                Err(LightError::Radiance { why })
            }
            None => Ok(Self { width, height, pixels }),
        }
    }

    /// Reads an OpenEXR file (the first layer with channels R, G and B) or a Radiance HDR file, told apart by their first bytes. It must
    /// be twice as wide as high.
    ///
    /// # Errors
    /// Any of [`LightError`], with the name of the file.
    pub fn read(path: &Path) -> Result<Self, LightError> {
        let file = path.display().to_string();
        let bytes = std::fs::read(path).map_err(|source| LightError::Io { file: file.clone(), source })?;
        Self::from_bytes(&bytes, &file)
    }

    /// The map in the bytes of a file, whose name is for messages; see [`Self::read`].
    ///
    /// # Errors
    /// As [`Self::read`], but never [`LightError::Io`].
    pub fn from_bytes(bytes: &[u8], file: &str) -> Result<Self, LightError> {
        let (width, height, pixels) = if bytes.starts_with(&exr::meta::magic_number::BYTES) {
            read_exr(bytes, file)?
        } else if bytes.starts_with(b"#?") {
            read_hdr(bytes, file)?
        } else {
            let why = if bytes.is_empty() { "it is empty" } else { "its first bytes are other ones" };
            return Err(LightError::WrongFormat { file: file.to_owned(), why: why.to_owned() });
        };
        let unsupported = |why: String| LightError::Unsupported { file: file.to_owned(), why };
        if width != 2 * height {
            return Err(unsupported(format!(
                "{width} x {height} pixels; latitude and longitude need twice as many columns as rows"
            )));
        }
        Self::new(width, height, pixels).map_err(|error| unsupported(error.to_string()))
    }

    /// Columns and rows.
    pub fn size(&self) -> [usize; 2] {
        [self.width, self.height]
    }

    /// All pixels, row-major from the zenith.
    pub fn pixels(&self) -> &[[f32; 3]] {
        &self.pixels
    }

    /// The radiance from a unit direction, bilinear; columns wrap, and over a pole the map goes on at the other side.
    pub fn radiance(&self, d: Vec3) -> [f32; 3] {
        let theta = libm::atan2f((d.x * d.x + d.y * d.y).sqrt(), d.z);
        self.bilinear(libm::atan2f(d.y, d.x), theta)
    }

    fn bilinear(&self, phi: f32, theta: f32) -> [f32; 3] {
        let x = (0.5 - phi / TAU) * self.width as f32 - 0.5;
        let y = theta / PI * self.height as f32 - 0.5;
        let (column, row) = (x.floor(), y.floor());
        let at = |right: i64, down: i64| self.pixel(column as i64 + right, row as i64 + down);
        let [a, b, c, d] = [at(0, 0), at(1, 0), at(0, 1), at(1, 1)];
        let (s, t) = (x - column, y - row);
        std::array::from_fn(|k| {
            let (upper, lower) = (a[k] + (b[k] - a[k]) * s, c[k] + (d[k] - c[k]) * s);
            upper + (lower - upper) * t
        })
    }

    fn pixel(&self, column: i64, row: i64) -> [f32; 3] {
        let (width, height) = (self.width as i64, self.height as i64);
        let (column, row) = match row {
            ..0 => (column + width / 2, -1 - row),
            _ if row >= height => (column + width / 2, 2 * height - 1 - row),
            _ => (column, row),
        };
        self.pixels[row.clamp(0, height - 1) as usize * self.width + column.rem_euclid(width) as usize]
    }

    /// The unit direction of a place in a map, columns and rows from its upper left corner.
    pub fn direction([column, row]: [f32; 2], [width, height]: [usize; 2]) -> Vec3 {
        let theta = PI * row / height as f32;
        let phi = PI - TAU * column / width as f32;
        let flat = libm::sinf(theta);
        Vec3::new(flat * libm::cosf(phi), flat * libm::sinf(phi), libm::cosf(theta))
    }

    /// The light of this map with `n x n` texels, turned about +z by `rotation` radians (from +x towards +y) and multiplied by `scale`.
    ///
    /// Each texel is the mean over places in it, weighted by solid angle, at a quarter of the distance of the map's pixels (16 x 16
    /// places at most). The integral over the sphere is kept within 2 % (test below: maps of noise and of a single bright pixel at
    /// three places); a map with more than about 2.7 n rows is sampled more coarsely than its pixels.
    ///
    /// # Errors
    /// As [`Light::from_octahedral`], if the scaled radiance or `n` is not allowed; [`LightError::Radiance`] for a rotation that is not
    /// finite.
    pub fn to_light(&self, n: usize, rotation: f32, scale: f32) -> Result<Light, LightError> {
        if !rotation.is_finite() {
            return Err(LightError::Radiance { why: format!("turned by {rotation}") });
        }
        if !n.is_power_of_two() || n > Light::LARGEST_SIZE {
            return Light::from_octahedral(n, Vec::new());
        }
        // the largest texels measure sqrt(4 3^(3/2)) / n radians
        let places = (4.0 * 4.56 / n as f32 * self.height as f32 / PI).ceil() as usize;
        let (sin, cos) = (libm::sinf(rotation), libm::cosf(rotation));
        let radiance = |d: Vec3| self.radiance(turned_back(d, [cos, sin])).map(|x| x * scale);
        Light::from_octahedral(n, texel_means(n, places.clamp(2, MOST_PLACES), radiance))
    }
}

impl Light {
    /// The light in latitude and longitude, means over 4 x 4 places per pixel weighted by solid angle.
    ///
    /// # Panics
    /// If there are no pixels.
    pub fn to_lat_long(&self, width: usize, height: usize) -> LatLong {
        assert!(width * height > 0, "{width} x {height} pixels");
        const PLACES: usize = 4;
        let mean = |k: usize| {
            let (mut sum, mut total) = ([0.0; 3], 0.0);
            for place in 0..PLACES * PLACES {
                let inside = |n: usize| (n as f32 + 0.5) / PLACES as f32;
                let column = (k % width) as f32 + inside(place % PLACES);
                let row = (k / width) as f32 + inside(place / PLACES);
                let d = LatLong::direction([column, row], [width, height]);
                let flat = (d.x * d.x + d.y * d.y).sqrt();
                let radiance = self.radiance(d);
                total += flat;
                for (sum, value) in sum.iter_mut().zip(radiance) {
                    *sum += flat * value;
                }
            }
            sum.map(|sum| sum / total)
        };
        let pixels = (0..width * height).into_par_iter().with_min_len(width).map(mean).collect();
        LatLong { width, height, pixels }
    }
}

/// Where a direction was before a turn about +z, from +x towards +y, by the angle of this cosine and sine.
pub(crate) fn turned_back(d: Vec3, [cos, sin]: [f32; 2]) -> Vec3 {
    Vec3::new(cos * d.x + sin * d.y, cos * d.y - sin * d.x, d.z)
}

type Pixels = (usize, usize, Vec<[f32; 3]>);

fn check_size(width: usize, height: usize, file: &str) -> Result<(), LightError> {
    let count = width.saturating_mul(height);
    if count == 0 || count > MOST_PIXELS {
        let why = format!("{width} x {height} pixels; there must be some, and at most 2^28");
        return Err(LightError::Unsupported { file: file.to_owned(), why });
    }
    Ok(())
}

fn read_exr(bytes: &[u8], file: &str) -> Result<Pixels, LightError> {
    let refuse = |error: ExrError| {
        let file = file.to_owned();
        match error {
            ExrError::NotSupported(why) => LightError::Unsupported { file, why: why.into_owned() },
            other => LightError::Damaged { file, why: other.to_string() },
        }
    };
    let meta = exr::meta::MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(refuse)?;
    for header in &meta.headers {
        check_size(header.layer_size.width(), header.layer_size.height(), file)?;
    }
    let has =
        |name: &str| meta.headers.iter().any(|header| header.channels.list.iter().any(|channel| channel.name.eq(name)));
    if !["R", "G", "B"].into_iter().all(has) {
        let why = "it has no channels R, G and B".to_owned();
        return Err(LightError::Unsupported { file: file.to_owned(), why });
    }
    // what no block fills stays no number and is refused
    let (width, pixels) = read_colours(bytes, f32::NAN).map_err(refuse)?;
    Ok((width, pixels.len() / width, pixels))
}

fn read_hdr(bytes: &[u8], file: &str) -> Result<Pixels, LightError> {
    let damaged = |error: image::ImageError| LightError::Damaged { file: file.to_owned(), why: error.to_string() };
    let decoder = image::codecs::hdr::HdrDecoder::new(Cursor::new(bytes)).map_err(damaged)?;
    let (width, height) = decoder.dimensions();
    check_size(width as usize, height as usize, file)?;
    let image = image::DynamicImage::from_decoder(decoder).map_err(damaged)?.into_rgb32f();
    let pixels = image.pixels().map(|pixel| pixel.0).collect();
    Ok((width as usize, height as usize, pixels))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::octahedral::square_to_direction;
    use crate::lights::procedural::Procedural;
    use exr::prelude::WritableImage;

    fn integral_of_map(map: &LatLong) -> f64 {
        let [width, height] = map.size();
        let edge = |row: usize| libm::cos(std::f64::consts::PI * row as f64 / height as f64);
        let row = |r: usize| {
            let sum: f64 = map.pixels()[r * width..][..width].iter().map(|pixel| f64::from(pixel[1])).sum();
            sum * (edge(r) - edge(r + 1)) * std::f64::consts::TAU / width as f64
        };
        (0..height).map(row).sum()
    }

    fn integral(light: &Light) -> f64 {
        let n = light.size();
        let term = |k: usize| {
            let d = square_to_direction([k % n, k / n].map(|x| (x as f32 + 0.5) / n as f32));
            f64::from(light.texel(0, k % n, k / n)[1]) * f64::from(light.solid_angle(d))
        };
        (0..n * n).map(term).sum()
    }

    #[test]
    fn energy_is_kept() {
        let (width, height) = (256, 128);
        let noise = |k: u32| (crate::geometry::sobol::mix(k) >> 8) as f32 / 16_777_216.0;
        let pixels = (0..width * height).map(|k| [noise(k as u32); 3]).collect();
        let mut maps = vec![LatLong::new(width, height, pixels).expect("a map")];
        for (column, row) in [(3, 20), (200, 64), (130, 100)] {
            let mut pixels = vec![[0.0; 3]; width * height];
            pixels[row * width + column] = [1e4; 3];
            maps.push(LatLong::new(width, height, pixels).expect("a map"));
        }
        for map in maps {
            for (n, rotation) in [(64, 0.0), (256, 1.0)] {
                let ratio = integral(&map.to_light(n, rotation, 2.0).expect("a light")) / (2.0 * integral_of_map(&map));
                assert!((ratio - 1.0).abs() < 2e-2, "n = {n}: {ratio}");
            }
        }
    }

    #[test]
    fn there_and_back() {
        let light = Procedural::Studio.light(128);
        let map = light.to_lat_long(512, 256);
        let back = map.to_light(128, 0.0, 1.0).expect("a light");
        let difference: f64 = (0..128 * 128)
            .map(|k| {
                f64::from((back.texel(1, k % 64, k / 128 % 64)[0] - light.texel(1, k % 64, k / 128 % 64)[0]).abs())
            })
            .sum();
        assert!(difference / (128.0 * 128.0) < 0.02, "{difference}");
        assert!((integral(&back) / integral(&light) - 1.0).abs() < 3e-3);
    }

    /// The convention, by four bright directions.
    #[test]
    fn columns_and_rows_lie_where_they_are_said_to() {
        let spot = |centre: Vec3| move |d: Vec3| [if d.dot(&centre) > 0.98 { 1.0 } else { 0.0 }; 3];
        for (centre, column, row) in
            [(Vec3::x(), 32, 16), (Vec3::y(), 16, 16), (-Vec3::y(), 48, 16), (Vec3::z(), 5, 0), (-Vec3::z(), 50, 31)]
        {
            let map = Light::from_fn(128, spot(centre)).expect("a light").to_lat_long(64, 32);
            assert!(map.pixels()[row * 64 + column][0] > 0.9, "{centre:?}");
            let back = map.to_light(128, 0.0, 1.0).expect("a light");
            assert!(back.radiance(centre)[0] > 0.9);
        }
        let map = Light::from_fn(128, spot(Vec3::x())).expect("a light").to_lat_long(64, 32);
        let turned = map.to_light(128, std::f32::consts::FRAC_PI_2, 3.0).expect("a light");
        assert!(turned.radiance(Vec3::y())[0] > 2.7 && turned.radiance(Vec3::x())[0] < 1e-3);
    }

    #[test]
    fn reads_both_formats() {
        let pixel = |x: usize, y: usize| (x as f32 + 1.0, y as f32 * 2.0, 0.25);
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("light.exr");
        exr::prelude::write_rgb_file(&path, 8, 4, pixel).expect("written");
        let from_exr = LatLong::read(&path).expect("a map");

        let pixels: Vec<image::Rgb<f32>> =
            (0..32).map(|k| pixel(k % 8, k / 8)).map(|(r, g, b)| image::Rgb([r, g, b])).collect();
        let path = folder.path().join("light.hdr");
        let writer = std::fs::File::create(&path).expect("a file");
        image::codecs::hdr::HdrEncoder::new(writer).encode(&pixels, 8, 4).expect("written");
        let from_hdr = LatLong::read(&path).expect("a map");

        assert_eq!(from_exr.size(), [8, 4]);
        assert_eq!(from_hdr.size(), [8, 4]);
        for k in 0..32 {
            let (r, g, b) = pixel(k % 8, k / 8);
            assert_eq!(from_exr.pixels()[k], [r, g, b]);
            // eight bits of the largest channel
            let error = from_hdr.pixels()[k].iter().zip([r, g, b]).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(error <= r.max(g) / 100.0);
        }
    }

    #[test]
    fn refuses_with_one_line_that_names_the_file() {
        let folder = tempfile::tempdir().expect("a folder");
        let written = |name: &str, width: usize, value: f32| {
            let path = folder.path().join(name);
            exr::prelude::write_rgb_file(&path, width, 4, |x, y| {
                (if x == 3 && y == 1 { value } else { 1.0 }, 1.0, 1.0)
            })
            .expect("written");
            path
        };
        let good = std::fs::read(written("good.exr", 8, 1.0)).expect("bytes");
        let file = |name: &str, bytes: &[u8]| {
            let path = folder.path().join(name);
            std::fs::write(&path, bytes).expect("written");
            path
        };
        let grey = folder.path().join("grey.exr");
        exr::prelude::Image::from_channels(
            (8, 4),
            exr::prelude::SpecificChannels::build().with_channel("Y").with_pixel_fn(|_| (1.0_f32,)),
        )
        .write()
        .to_file(&grey)
        .expect("written");
        for (path, part, invalid) in [
            (folder.path().join("missing.exr"), "check the path", false),
            (written("nan.exr", 8, f32::NAN), "column 3, row 1", true),
            (written("negative.exr", 8, -0.5), "column 3, row 1", true),
            (written("infinite.exr", 8, f32::INFINITY), "column 3, row 1", true),
            (written("square.exr", 4, 1.0), "4 x 4", true),
            (grey, "R, G and B", true),
            (file("empty.exr", b""), "empty", true),
            (file("text.hdr", b"hello"), "OpenEXR", true),
            (file("short.exr", &good[..good.len() / 2]), "damaged", true),
            (file("head.exr", &good[..60]), "damaged", true),
            (file("short.hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n"), "damaged", true),
            (file("zero.hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 0 +X 8\n"), "", true),
            (file("huge.hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 999999 +X 999999\n"), "", true),
        ] {
            let error = LatLong::read(&path).expect_err("no map");
            let message = error.to_string();
            assert!(message.starts_with(&path.display().to_string()), "{message}");
            assert!(message.contains(part) && !message.contains('\n'), "{message}");
            assert_eq!(error.is_invalid_input(), invalid, "{message}");
        }
    }
}
