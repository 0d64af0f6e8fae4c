//! LDR-FLIP, the perceived difference of two images that alternate on a display.
//!
//! P. Andersson, J. Nilsson, T. Akenine-Möller, M. Oskarsson, K. Åström, M. D. Fairchild: "FLIP: A difference evaluator
//! for alternating images", Proc. ACM Comput. Graph. Interact. Tech. 3 (2), 2020; the sections below are this paper's.
//! Against the authors' program, version 1.7, in single precision, the map agrees within 1e-5 and its mean within 1e-6.

use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;

use crate::images::exposure::Exposure;

mod kernel;
use kernel::{Kernel, Plane};

/// Pixels per degree of the paper: 0.7 m from a display that is 0.7 m and 3840 pixels wide.
pub const PIXELS_PER_DEGREE: f64 = 67.0;

/// Exponent of colour differences, section 4.1.3.
const COLOUR_EXPONENT: f64 = 0.7;
/// Colour differences below this part of the largest ...
const KNEE: f64 = 0.4;
/// ... take up this part of the range, section 4.1.3.
const BELOW_KNEE: f64 = 0.95;
/// Exponent of feature differences, section 4.2.
const FEATURE_EXPONENT: f64 = 0.5;
/// Width of an edge that is easily seen, degrees, section 4.2.
const EDGE: f64 = 0.082;

/// Weights and widths of the Gaussians of the contrast sensitivity (table 1): a sum of a sqrt(pi/b) exp(-pi^2 r^2/b), r
/// in degrees; luminance, red-green, blue-yellow.
const SENSITIVITY: [&[[f64; 2]]; 3] = [&[[1.0, 0.0047]], &[[1.0, 0.0053]], &[[34.1, 0.04], [13.5, 0.025]]];

/// FLIP per pixel, 0 to 1, between two images of radiance as a display shows them: exposed and limited to [0, 1].
///
/// # Panics
/// If the images differ in length, their length is not a multiple of `width`, or `pixels_per_degree` is not positive.
#[must_use]
pub fn flip(
    image: &[[f32; 3]],
    reference: &[[f32; 3]],
    width: usize,
    exposure: Exposure,
    pixels_per_degree: f64,
) -> Vec<f32> {
    assert!(image.len() == reference.len() && image.len().is_multiple_of(width.max(1)), "images of the same size");
    assert!(pixels_per_degree > 0.0, "pixels per degree");
    if image.is_empty() {
        return Vec::new();
    }
    let colours = Colours::new();
    let (x, y) = (colours.opponent(image, width, exposure), colours.opponent(reference, width, exposure));
    let seen = |opponent: &[Plane; 3]| colours.perceived(&filtered(opponent, pixels_per_degree));
    let (seen_x, seen_y) = (seen(&x), seen(&y));
    let (features_x, features_y) = (features(&x[0], pixels_per_degree), features(&y[0], pixels_per_degree));
    let colour = seen_x.par_iter().zip(&seen_y).map(|(&a, &b)| colours.difference(a, b));
    let feature = features_x.par_iter().zip(&features_y).map(|(a, b)| {
        let [edge, point] = [0, 1].map(|kind: usize| (a[kind] - b[kind]).abs());
        libm::pow(edge.max(point) / std::f64::consts::SQRT_2, FEATURE_EXPONENT)
    });
    // section 4.3
    colour.zip(feature).map(|(colour, feature)| libm::pow(colour, 1.0 - feature) as f32).collect()
}

/// Mean of a map over the foreground, the pixels whose `foreground` is true; 0 without any.
///
/// # Panics
/// If map and mask differ in length.
#[must_use]
pub fn mean(map: &[f32], foreground: &[bool]) -> f64 {
    assert_eq!(map.len(), foreground.len(), "one mask value per pixel");
    let shown = || map.iter().zip(foreground).filter(|&(_, &shown)| shown);
    shown().map(|(&value, _)| f64::from(value)).sum::<f64>() / shown().count().max(1) as f64
}

/// Contrast sensitivity of the eye for each component of opponent colours, section 4.1.1.
fn filtered(opponent: &[Plane; 3], pixels_per_degree: f64) -> [Plane; 3] {
    let pi = std::f64::consts::PI;
    let widest = SENSITIVITY.iter().flat_map(|gaussians| gaussians.iter()).map(|&[_, b]| b).fold(0.0, f64::max);
    let radius = (3.0 * (widest / (2.0 * pi * pi)).sqrt() * pixels_per_degree).ceil() as usize;
    std::array::from_fn(|c| {
        // in two dimensions each Gaussian weighs the square of its sum in one, and all weights together are 1
        let parts: Vec<(Kernel, f64)> = SENSITIVITY[c]
            .iter()
            .map(|&[a, b]| {
                let (kernel, sum) = Kernel::gaussian((b / 2.0).sqrt() / pi * pixels_per_degree, radius);
                (kernel, a * (pi / b).sqrt() * sum * sum)
            })
            .collect();
        let total: f64 = parts.iter().map(|(_, weight)| weight).sum();
        let mut planes = parts.iter().map(|(kernel, weight)| {
            let mut plane = opponent[c].along_rows(kernel).along_columns(kernel);
            plane.values.iter_mut().for_each(|value| *value *= weight / total);
            plane
        });
        let first = planes.next().expect("at least one Gaussian");
        planes.fold(first, |mut sum, plane| {
            sum.values.iter_mut().zip(&plane.values).for_each(|(sum, value)| *sum += value);
            sum
        })
    })
}

/// Strength of edges and of points in the achromatic component, section 4.2.
fn features(achromatic: &Plane, pixels_per_degree: f64) -> Vec<[f64; 2]> {
    let deviation = 0.5 * EDGE * pixels_per_degree;
    let radius = (3.0 * deviation).ceil() as usize;
    let (smooth, _) = Kernel::gaussian(deviation, radius);
    // from 0 to 1
    let mut lightness = achromatic.clone();
    lightness.values.iter_mut().for_each(|value| *value = (*value + 16.0) / 116.0);
    let across = lightness.along_columns(&smooth);
    let along = lightness.along_rows(&smooth);
    let [edges, points] = [Kernel::slope(deviation, radius), Kernel::curvature(deviation, radius)]
        .map(|kernel| (across.along_rows(&kernel), along.along_columns(&kernel)));
    let length = |(x, y): &(Plane, Plane), k: usize| (x.values[k] * x.values[k] + y.values[k] * y.values[k]).sqrt();
    (0..lightness.values.len()).into_par_iter().map(|k| [length(&edges, k), length(&points, k)]).collect()
}

/// Conversions between linear sRGB, the opponent colours YCxCz and a colour space in which distances are perceived.
struct Colours {
    /// Linear sRGB to X, Y, Z, each divided by its value for white.
    to_xyz: Matrix3<f64>,
    from_xyz: Matrix3<f64>,
    /// The difference between green and blue, the largest there is.
    largest: f64,
}

impl Colours {
    fn new() -> Self {
        // IEC 61966-2-1, from the chromaticities of its primaries and of D65 in exact fractions
        let matrix = Matrix3::new(
            10_135_552.0 / 24_577_794.0,
            8_788_810.0 / 24_577_794.0,
            4_435_075.0 / 24_577_794.0,
            2_613_072.0 / 12_288_897.0,
            8_788_810.0 / 12_288_897.0,
            887_015.0 / 12_288_897.0,
            1_425_312.0 / 73_733_382.0,
            8_788_810.0 / 73_733_382.0,
            70_074_185.0 / 73_733_382.0,
        );
        let white = matrix * Vector3::repeat(1.0);
        let to_xyz = Matrix3::from_diagonal(&white.map(f64::recip)) * matrix;
        let from_xyz = to_xyz.try_inverse().expect("the primaries of sRGB are independent");
        let mut colours = Self { to_xyz, from_xyz, largest: 0.0 };
        let [green, blue] = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|colour| colours.hunt_lab(Vector3::from(colour)));
        colours.largest = Self::distance(green, blue);
        colours
    }

    /// YCxCz of what is shown, one plane each.
    fn opponent(&self, image: &[[f32; 3]], width: usize, exposure: Exposure) -> [Plane; 3] {
        let colours: Vec<[f64; 3]> = image
            .par_iter()
            .map(|&radiance| {
                let shown = exposure.expose(radiance).map(|value| f64::from(value.clamp(0.0, 1.0)));
                let xyz = self.to_xyz * Vector3::from(shown);
                [116.0 * xyz.y - 16.0, 500.0 * (xyz.x - xyz.y), 200.0 * (xyz.y - xyz.z)]
            })
            .collect();
        std::array::from_fn(|c| Plane { width, values: colours.iter().map(|colour| colour[c]).collect() })
    }

    /// Filtered YCxCz, limited to what a display shows, in CIELAB with the Hunt effect, section 4.1.2.
    fn perceived(&self, opponent: &[Plane; 3]) -> Vec<[f64; 3]> {
        let [lightness, red_green, blue_yellow] = opponent;
        (0..lightness.values.len())
            .into_par_iter()
            .map(|k| {
                let y = (lightness.values[k] + 16.0) / 116.0;
                let xyz = Vector3::new(y + red_green.values[k] / 500.0, y, y - blue_yellow.values[k] / 200.0);
                self.hunt_lab((self.from_xyz * xyz).map(|value| value.clamp(0.0, 1.0)))
            })
            .collect()
    }

    /// CIELAB of linear sRGB, a* and b* in proportion to the lightness (Hunt 1952).
    fn hunt_lab(&self, linear: Vector3<f64>) -> [f64; 3] {
        const DELTA: f64 = 6.0 / 29.0;
        let curve = |t: f64| {
            if t > DELTA * DELTA * DELTA { libm::cbrt(t) } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 }
        };
        let [x, y, z] = (self.to_xyz * linear).map(curve).into();
        let lightness = 116.0 * y - 16.0;
        [lightness, 0.01 * lightness * 500.0 * (x - y), 0.01 * lightness * 200.0 * (y - z)]
    }

    /// HyAB distance (Abasi et al. 2020) to the exponent, section 4.1.3.
    fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
        let [lightness, red_green, blue_yellow] = [0, 1, 2].map(|c: usize| a[c] - b[c]);
        let distance = lightness.abs() + (red_green * red_green + blue_yellow * blue_yellow).sqrt();
        libm::pow(distance, COLOUR_EXPONENT)
    }

    /// Difference of two perceived colours from 0 to 1, section 4.1.3.
    fn difference(&self, a: [f64; 3], b: [f64; 3]) -> f64 {
        let distance = Self::distance(a, b) / self.largest;
        if distance < KNEE {
            distance * BELOW_KNEE / KNEE
        } else {
            BELOW_KNEE + (distance - KNEE) / (1.0 - KNEE) * (1.0 - BELOW_KNEE)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDTH: usize = 48;

    fn image(value: impl Fn(usize, usize) -> [f32; 3]) -> Vec<[f32; 3]> {
        (0..WIDTH * WIDTH).map(|k| value(k % WIDTH, k / WIDTH)).collect()
    }

    fn map(x: &[[f32; 3]], y: &[[f32; 3]]) -> Vec<f32> {
        flip(x, y, WIDTH, Exposure::ONE, PIXELS_PER_DEGREE)
    }

    #[test]
    fn the_ends_of_the_range() {
        // no difference is 0; green and blue differ most of all colours
        let [green, blue] = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|colour| image(|_, _| colour));
        assert!(map(&green, &green).iter().all(|&value| value == 0.0));
        assert!(map(&green, &blue).iter().all(|&value| (value - 1.0).abs() < 1e-6));
        assert!(flip(&[], &[], WIDTH, Exposure::ONE, PIXELS_PER_DEGREE).is_empty());
    }

    #[test]
    fn the_images_may_change_places_and_turn() {
        let x = image(|x, y| [x as f32 / 48.0, ((x * y) % 7) as f32 / 7.0, 0.3]);
        let y = image(|x, y| [y as f32 / 48.0, ((x + y) % 5) as f32 / 5.0, 0.4]);
        let expected = map(&x, &y);
        assert_eq!(map(&y, &x), expected);
        let turned =
            |image: &[[f32; 3]]| (0..image.len()).map(|k| image[k % WIDTH * WIDTH + k / WIDTH]).collect::<Vec<_>>();
        let swapped = map(&turned(&x), &turned(&y));
        for k in 0..expected.len() {
            assert!((swapped[k % WIDTH * WIDTH + k / WIDTH] - expected[k]).abs() < 1e-6, "{k}");
        }
    }

    #[test]
    fn seen_from_far_away_fine_noise_disappears() {
        let flat = image(|_, _| [0.5; 3]);
        let noisy = image(|x, y| if (x + y) % 2 == 0 { [0.45; 3] } else { [0.55; 3] });
        let at = |pixels_per_degree: f64| {
            mean(&flip(&noisy, &flat, WIDTH, Exposure::ONE, pixels_per_degree), &[true; WIDTH * WIDTH])
        };
        assert!(at(8.0) > 0.05 && at(67.0) < 0.2 * at(8.0), "{} {}", at(8.0), at(67.0));
    }

    #[test]
    fn the_mean_is_of_the_foreground() {
        assert_eq!(mean(&[0.25, 1.0, 0.75], &[true, false, true]), 0.5);
        assert_eq!(mean(&[0.25], &[false]), 0.0);
    }
}
