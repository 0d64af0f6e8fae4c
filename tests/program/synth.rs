//! Synthesised files: their container, their values, their noise.

use std::fs;

use crate::program::{GLOSSY, Workplace, result};

/// The stored numbers of a file with 180 bins of phi_d, read by nothing but the layout of the format.
fn numbers(bytes: &[u8]) -> Vec<f64> {
    assert_eq!(bytes[..12], [90, 0, 0, 0, 90, 0, 0, 0, 180, 0, 0, 0]);
    bytes[12..].as_chunks().0.iter().map(|&bytes| f64::from_le_bytes(bytes)).collect()
}

/// A material without a specular part.
const DIFFUSE: [[f64; 6]; 3] =
    [[0.1, 0.0, 0.1, 0.3, 0.0, 0.0], [0.2, 0.0, 0.1, 0.3, 0.0, 0.0], [0.3, 0.0, 0.1, 0.3, 0.0, 0.0]];

#[test]
fn a_diffuse_material_is_its_albedo_over_pi() {
    let place = Workplace::new();
    place.put("x.json", result(&DIFFUSE));
    place.succeed("synth x.json -o x.binary");
    let stored = numbers(&fs::read(place.path("x.binary")).unwrap());
    let scales = [1.0 / 1500.0, 1.15 / 1500.0, 1.66 / 1500.0];
    for (channel, plane) in stored.chunks(stored.len() / 3).enumerate() {
        let measured: Vec<f64> = plane.iter().copied().filter(|&x| x >= 0.0).collect();
        assert!(measured.len() > plane.len() / 2);
        assert!(plane.iter().all(|&x| x >= 0.0 || x == -1.0));
        let expected = DIFFUSE[channel][0] / std::f64::consts::PI / scales[channel];
        assert!(measured.iter().all(|x| (x / expected - 1.0).abs() < 1e-14), "channel {channel}");
    }
}

#[test]
fn noise_is_log_normal_and_repeatable() {
    let place = Workplace::new();
    place.put("x.json", result(&DIFFUSE));
    place.succeed("synth x.json -o clean.binary");
    place.succeed("synth x.json -o a.binary --noise 0.2 --seed 5");
    place.succeed("synth x.json -o b.binary --noise 0.2 --seed 5 --threads 1");
    place.succeed("synth x.json -o c.binary --noise 0.2 --seed 6");
    let read = |name: &str| fs::read(place.path(name)).unwrap();
    let (clean, a) = (read("clean.binary"), read("a.binary"));
    assert!(a == read("b.binary"));
    assert!(a != read("c.binary"));
    let logs: Vec<f64> = numbers(&a)
        .iter()
        .zip(numbers(&clean))
        .filter(|(_, clean)| *clean > 0.0)
        .map(|(noisy, clean)| (noisy / clean).ln())
        .collect();
    let count = logs.len() as f64;
    let mean = logs.iter().sum::<f64>() / count;
    let deviation = (logs.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / count).sqrt();
    assert!(mean.abs() < 5.0 * 0.2 / count.sqrt(), "{mean}");
    assert!((deviation / 0.2 - 1.0).abs() < 5.0 / (2.0 * count).sqrt(), "{deviation}");
}

#[test]
fn the_grid_follows_the_result_and_the_options() {
    let place = Workplace::new();
    let text = result(&GLOSSY);
    place.put(
        "full.json",
        text.replacen('{', r#"{"input": {"dimensions": [90, 90, 360], "sample_position": "centre"}, "#, 1),
    );
    let ran = place.succeed("synth full.json -o full.binary");
    assert!(ran.stderr.contains("90 x 90 x 360") && ran.stderr.contains("samples at the centre"), "{}", ran.stderr);
    assert_eq!(fs::metadata(place.path("full.binary")).unwrap().len(), 69_984_012);
    let ran = place.succeed("synth full.json -o half.binary --phi-bins 180 --sample-position edge");
    assert!(ran.stderr.contains("90 x 90 x 180") && ran.stderr.contains("samples at the edge"), "{}", ran.stderr);
    assert_eq!(fs::metadata(place.path("half.binary")).unwrap().len(), 34_992_012);
}

#[test]
fn an_embedded_material_needs_no_file() {
    let place = Workplace::new();
    place.succeed("synth gold-metallic-paint -o gold.binary --quiet");
    let text = place.succeed("info gold.binary").stdout;
    assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
}
