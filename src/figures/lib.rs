//! Building blocks of figures, for PNG (pixels) and SVG (text).
//!
//! [`canvas`] paints rectangles, text, discs and colour bars on an image, [`scale`] turns values into colours, [`panel`] places
//! images side by side with titles and legends, and [`png`] encodes them. [`axis`] maps values to positions with ticks, and
//! [`svg`] writes the text of vector figures. [`srgb`] is the transfer curve of displays. The figures themselves live in the
//! crates that draw them.
//!
//! The same values give the same bytes on every machine: there is no system font, and transcendental functions are those of
//! `libm`.
//!
//! ```
//! use brdfit_figures::panel::{Panel, side_by_side};
//! use brdfit_figures::png;
//!
//! let bandwidth: Vec<f32> = (0..64 * 48).map(|n| 1.0 + (n % 64) as f32).collect();
//! let map = Panel::quantity("bandwidth", "cycles per radian", &bandwidth, 64);
//! let page = side_by_side("a material", &[map], 1);
//! assert!(png::encode(&page)?.starts_with(b"\x89PNG"));
//! # Ok::<(), png::PngError>(())
//! ```
#![forbid(unsafe_code)]

pub mod axis;
pub mod canvas;
pub mod panel;
pub mod png;
pub mod scale;
pub mod srgb;
pub mod svg;

pub use image;
