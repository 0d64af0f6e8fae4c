//! FLIP against the program of its authors: `data-fixtures/flip.json`, whose description has the conventions.

use std::path::Path;

use brdfit_figures::srgb;
use brdfit_renderer::{Exposure, flip};
use serde::Deserialize;

#[derive(Deserialize)]
struct Fixture {
    width: usize,
    cases: Vec<Case>,
}

/// Name, pixels per degree, reference, test, mean of the map, map.
type Case = (String, f64, Vec<u8>, Vec<u8>, f64, Vec<f32>);

#[test]
fn maps_and_means_agree() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data-fixtures/flip.json");
    let fixture: Fixture = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    // any exposure: the radiance is such that the image is shown
    let exposure = Exposure::new(4.0).unwrap();
    let radiance = |bytes: &[u8]| -> Vec<[f32; 3]> {
        let linear = |byte: u8| srgb::decode(f32::from(byte) / 255.0) / exposure.factor();
        bytes.chunks_exact(3).map(|pixel| [pixel[0], pixel[1], pixel[2]].map(linear)).collect()
    };
    assert_eq!(fixture.cases.len(), 6);
    for (name, density, reference, test, mean, map) in &fixture.cases {
        let found = flip::flip(&radiance(test), &radiance(reference), fixture.width, exposure, *density);
        assert_eq!(found.len(), map.len());
        let worst = found.iter().zip(map).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        let off = (flip::mean(&found, &vec![true; map.len()]) - mean).abs();
        println!("{name}: map within {worst:.1e}, mean {mean:.6} within {off:.1e}");
        assert!(worst < 2e-5, "{name}: map off by {worst}");
        assert!(off < 1e-6, "{name}: mean off by {off}");
    }
}
