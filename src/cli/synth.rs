//! `brdfit synth`: a MERL file from the parameters of a fit or of an embedded material.

use std::path::Path;

use brdfit_brdf::SgdParameters;
use brdfit_fit::document::CHANNELS;
use brdfit_fit::synthesise;
use brdfit_merl::{Dimensions, SamplePosition, write_merl};
use serde::Deserialize;

use crate::args::SynthArgs;
use crate::console::Console;
use crate::documents;
use crate::embedded;
use crate::noise::Noise;
use crate::outcome::{Outcome, Problem};
use crate::output;

/// What stands below the options in the help.
pub(crate) fn examples() -> String {
    let names: Vec<String> = embedded::names().map(|name| format!("  {name}\n")).collect();
    format!("{EXAMPLES}\n\nEmbedded materials:\n{}", names.concat().trim_end_matches('\n'))
}

const EXAMPLES: &str = "\
Examples:
  brdfit synth fits/gold.json -o gold.binary
  brdfit synth gold-metallic-paint -o gold.binary --noise 0.05 --seed 7";

pub(crate) fn run(args: &SynthArgs, console: &Console) -> anyhow::Result<Outcome> {
    if !(0.0..=10.0).contains(&args.noise) {
        return Err(Problem::usage(format!("--noise {}: must lie between 0 and 10", args.noise)).into());
    }
    let source = Source::find(&args.source)?;
    let shape = match args.phi_bins {
        Some(bins) => [Dimensions::THETA_H, Dimensions::THETA_D, bins.into()],
        None => source.dimensions.unwrap_or(Dimensions::HALF_TURN.shape()),
    };
    let dimensions = Dimensions::from_shape(shape)
        .ok_or_else(|| Problem::usage(format!("--phi-bins {}: must be 180 or 360", shape[2])))?;
    let position = args.sample_position.map(Into::into).or(source.sample_position).unwrap_or_default();

    let label = args.source.display();
    let planes = synthesise(&source.parameters, dimensions, position)
        .map_err(|error| Problem::invalid(format!("{label}: {error}; correct the parameter")))?;
    if let Some(channel) = planes.iter().position(|plane| plane.iter().any(|f| !f.is_finite())) {
        let name = CHANNELS[channel];
        let message = format!("{label}: the model of channel {name} overflows; correct its parameters");
        return Err(Problem::computation(message).into());
    }
    let noise = Noise::new(args.seed);
    output::write_with(&args.output, |mut out| {
        write_merl(&mut out, dimensions, |channel, theta_h, theta_d, phi_d| {
            let cell = dimensions.index(theta_h, theta_d, phi_d);
            let f = planes[channel][cell];
            if args.noise == 0.0 {
                return f;
            }
            let place = ((channel as u64) << 32) | cell as u64;
            f * libm::exp(args.noise * noise.standard_normal(place))
        })
    })?;
    console.note(&format!("{}: {dimensions} from {label}, samples at the {position}", args.output.display()));
    Ok(Outcome::Done)
}

/// What a file is made from.
#[derive(Clone, Copy, Debug)]
struct Source {
    parameters: [SgdParameters; 3],
    dimensions: Option<[usize; 3]>,
    sample_position: Option<SamplePosition>,
}

/// The part of a result that is needed; other members are skipped.
#[derive(Deserialize)]
struct Parametrised {
    channels: [Channel; 3],
    input: Option<Grid>,
}

#[derive(Deserialize)]
struct Channel {
    parameters: SgdParameters,
}

#[derive(Deserialize)]
struct Grid {
    dimensions: Option<[usize; 3]>,
    sample_position: Option<SamplePosition>,
}

impl Source {
    /// An existing file, or else what looks like the name of one, is a result; anything else is the name of a material.
    fn find(source: &Path) -> Result<Self, Problem> {
        let name = source.to_string_lossy();
        if let (false, Some(material)) = (source.exists(), embedded::material(&name)) {
            return Ok(Self { parameters: material.parameters, dimensions: None, sample_position: None });
        }
        if source.exists() || source.extension().is_some() || source.components().count() > 1 {
            return Self::read(source);
        }
        let names: Vec<&str> = embedded::names().collect();
        let nearest = names.iter().copied().min_by_key(|candidate| distance(&name, candidate));
        let guess = match nearest {
            Some(candidate) if distance(&name, candidate) <= candidate.chars().count() / 2 => {
                format!("did you mean {candidate}? ")
            }
            _ => String::new(),
        };
        Err(Problem::usage(format!(
            "{name}: neither a file nor an embedded material; {guess}embedded are {}",
            names.join(", ")
        )))
    }

    fn read(path: &Path) -> Result<Self, Problem> {
        let result: Parametrised = documents::read(path, "a fit result")?;
        let (dimensions, sample_position) =
            result.input.map_or((None, None), |input| (input.dimensions, input.sample_position));
        if let Some([h, d, p]) = dimensions
            && Dimensions::from_shape([h, d, p]).is_none()
        {
            return Err(Problem::invalid(format!(
                "{}: its dimensions {h} x {d} x {p} are not those of a MERL file; choose --phi-bins 180 or 360",
                path.display()
            )));
        }
        let parameters = result.channels.map(|channel| channel.parameters);
        Ok(Self { parameters, dimensions, sample_position })
    }
}

/// Levenshtein's distance: insertions, deletions and replacements of one character between two words.
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
    fn the_distance_counts_changes() {
        for (a, b, expected) in
            [("", "", 0), ("", "abc", 3), ("kitten", "sitting", 3), ("flaw", "lawn", 2), ("ab", "ba", 2)]
        {
            assert_eq!((distance(a, b), distance(b, a)), (expected, expected), "{a} {b}");
        }
    }
}
