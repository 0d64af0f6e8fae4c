//! Materials embedded in the program, to try it without a measurement.
//!
//! All parameters were invented for this purpose; they describe no measured sample. Each material stands for one
//! difficulty of fitting.

use std::path::Path;

use brdfit_brdf::{MaterialParameters, SgdParameters};

use crate::terminal::exit_code::Problem;

/// An embedded material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Embedded {
    /// Its name on the command line and the stem of its files.
    pub(crate) name: &'static str,
    /// One line about it.
    pub(crate) description: &'static str,
    /// Parameters of R, G and B.
    parameters: [SgdParameters; 3],
}

impl Embedded {
    /// The parameters of R, G and B.
    pub(crate) fn parameters(&self) -> MaterialParameters {
        self.parameters.try_into().expect("inside of the model's domain (tests below)")
    }
}

/// Six parameters in the order of docs/theory.md, section 2.
const fn channel(rho_d: f64, rho_s: f64, alpha: f64, p: f64, f0: f64, f1: f64) -> SgdParameters {
    SgdParameters { rho_d, rho_s, alpha, p, f0, f1 }
}

/// All of them; the first is the default of the demo.
const MATERIALS: [Embedded; 5] = [
    Embedded {
        name: "gold-metallic-paint",
        description: "a coloured lobe over a coloured base",
        parameters: [
            channel(0.120, 0.46, 0.014, 0.62, 0.55, 0.08),
            channel(0.068, 0.34, 0.014, 0.64, 0.48, 0.07),
            channel(0.016, 0.15, 0.015, 0.68, 0.34, 0.05),
        ],
    },
    Embedded {
        name: "blue-gloss-plastic",
        description: "a narrow white highlight, a strong Fresnel term, a diffuse blue",
        parameters: [
            channel(0.021, 0.90, 0.0018, 0.72, 0.046, 0.004),
            channel(0.058, 0.88, 0.0018, 0.72, 0.047, 0.004),
            channel(0.260, 0.86, 0.0018, 0.73, 0.048, 0.004),
        ],
    },
    Embedded {
        name: "polished-metal",
        description: "seven decades between peak and tail, hardly anything diffuse",
        parameters: [
            channel(0.0021, 0.71, 0.00035, 0.86, 0.64, 0.03),
            channel(0.0022, 0.70, 0.00035, 0.86, 0.65, 0.03),
            channel(0.0026, 0.69, 0.00036, 0.87, 0.67, 0.03),
        ],
    },
    Embedded {
        name: "terracotta",
        description: "matte: all but the grazing angles are diffuse",
        parameters: [
            channel(0.420, 0.32, 0.42, 0.30, 0.050, 0.010),
            channel(0.190, 0.31, 0.43, 0.30, 0.050, 0.010),
            channel(0.110, 0.30, 0.44, 0.30, 0.050, 0.010),
        ],
    },
    Embedded {
        name: "red-satin",
        description: "a broad sheen that fades slowly",
        parameters: [
            channel(0.390, 0.62, 0.055, 1.25, 0.120, 0.040),
            channel(0.026, 0.48, 0.060, 1.20, 0.085, 0.020),
            channel(0.038, 0.50, 0.058, 1.22, 0.090, 0.020),
        ],
    },
];

/// The material with this name.
pub(crate) fn material(name: &str) -> Option<&'static Embedded> {
    MATERIALS.iter().find(|material| material.name == name)
}

/// The embedded material that `typed` names, or `None` for a file: an existing one, or what looks like a file name.
///
/// # Errors
/// A name that is neither.
pub(crate) fn find(typed: &Path) -> Result<Option<&'static Embedded>, Problem> {
    if typed.exists() {
        return Ok(None);
    }
    let name = typed.to_string_lossy();
    let found = material(&name);
    if found.is_some() || typed.extension().is_some() || typed.components().count() > 1 {
        return Ok(found);
    }
    let guess = match names().min_by_key(|candidate| distance(&name, candidate)) {
        Some(candidate) if distance(&name, candidate) <= candidate.chars().count() / 2 => {
            format!("did you mean {candidate}? ")
        }
        _ => String::new(),
    };
    let all: Vec<&str> = names().collect();
    Err(Problem::usage(format!(
        "{name}: no such file or embedded material; {guess}embedded materials: {}",
        all.join(", ")
    )))
}

/// The names, one per line, for the help.
pub(crate) fn list() -> String {
    let names: Vec<String> = names().map(|name| format!("  {name}")).collect();
    format!("Embedded materials:\n{}", names.join("\n"))
}

/// The default material of `brdfit demo`.
pub(crate) fn default_material() -> &'static Embedded {
    &MATERIALS[0]
}

/// Their names.
pub(crate) fn names() -> impl Iterator<Item = &'static str> {
    MATERIALS.iter().map(|material| material.name)
}

/// Levenshtein distance: the least number of insertions, deletions and substitutions of one character.
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, from) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, to) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(from != *to);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_file_names_and_unique() {
        let mut seen: Vec<&str> = names().collect();
        assert!(seen.iter().all(|name| name.bytes().all(|byte| byte.is_ascii_lowercase() || byte == b'-')));
        assert_eq!(material(seen[2]).map(|material| material.name), Some(seen[2]));
        assert_eq!(material("nothing"), None);
        seen.sort_unstable();
        seen.dedup();
        assert_eq!(seen.len(), MATERIALS.len());
    }

    #[test]
    fn materials_reflect_no_more_than_they_receive() {
        for material in &MATERIALS {
            for channel in 0..3 {
                let model = material.parameters().channel_model(channel);
                for degrees in [0.0_f64, 30.0, 60.0, 80.0] {
                    let albedo = model.directional_albedo(degrees.to_radians());
                    assert!((0.0..1.0).contains(&albedo), "{} at {degrees}: {albedo}", material.name);
                }
            }
        }
    }

    #[test]
    fn fresnel_terms_are_physical() {
        for parameters in MATERIALS.iter().flat_map(|material| material.parameters) {
            for degrees in 0..=90 {
                let f = parameters.fresnel().value(libm::cos(f64::from(degrees).to_radians()));
                assert!((0.0..=1.0 + 1e-12).contains(&f), "{parameters:?} at {degrees}: {f}");
            }
        }
    }

    #[test]
    fn the_distance_counts_changes() {
        for (a, b, expected) in
            [("", "", 0), ("", "abc", 3), ("kitten", "sitting", 3), ("flaw", "lawn", 2), ("ab", "ba", 2)]
        {
            assert_eq!((distance(a, b), distance(b, a)), (expected, expected), "{a} {b}");
        }
    }
}
