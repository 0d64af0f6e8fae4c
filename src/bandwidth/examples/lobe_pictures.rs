//! Lobes of materials and their local bandwidth, to be drawn by scripts/figures/lobe_pictures.py.
//!
//!     cargo run --release --example lobe_pictures -- VALUES.f32 FIT.json|FILE.binary...      (scripts/figures/atlas_pictures.sh)
//!
//! Writes little-endian f32, per material and incident angle: the lobe on an angular map of 256 x 256 samples in 1/sr, and its
//! bandwidth, 64 x 64 texels in cycles per radian; of the green channel, row by row.

use std::error::Error;

use brdfit_bandwidth::{AngularMap, LobeEstimator, LobeGrid, LobeMemory, LobeOptions};
use brdfit_brdf::{Directions, direction};

mod support;

/// theta_i in degrees.
const ANGLES: [f64; 2] = [40.0, 75.0];
/// Samples along a side of a lobe.
const SIZE: usize = 256;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let output = arguments.next().ok_or("lobe_pictures VALUES.f32 FIT.json|FILE.binary...")?;
    let map = AngularMap::new(SIZE);
    let outgoing: Directions = (0..SIZE * SIZE).map(|n| map.direction(n / SIZE, n % SIZE)).collect();
    let grid = LobeGrid::default();
    let mut values = Vec::new();
    for path in arguments {
        let (_, brdf) = support::open(&path)?;
        let lobes = LobeEstimator::new(brdf.as_ref(), &grid, true, LobeOptions::default());
        let samples = brdf.lobes(&outgoing);
        for degrees in ANGLES {
            let i = direction(degrees.to_radians(), 0.0);
            let [mut r, mut g, mut b] = [(); 3].map(|()| vec![0.0; SIZE * SIZE]);
            samples.values(&i, 0, [&mut r, &mut g, &mut b]);
            values.extend(g);
            values.extend_from_slice(&lobes.estimate(&i, &mut LobeMemory::default()).texels[1]);
        }
    }
    let bytes: Vec<u8> = values.iter().flat_map(|value: &f32| value.to_le_bytes()).collect();
    Ok(std::fs::write(output, bytes)?)
}
