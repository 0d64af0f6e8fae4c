//! `brdfit synth`: a MERL file from the parameters of a fit or of an embedded material.

use std::path::Path;

use brdfit_brdf::MaterialParameters;
use brdfit_fit::synthesise;
use brdfit_measured::{CHANNEL_NAMES, Dimensions, SamplePosition, write_merl};
use serde::Deserialize;

use crate::args::embedded_materials;
use crate::args::measured::SynthArgs;
use crate::jobs::synthetic_noise::Noise;
use crate::results::documents::Document;
use crate::results::output;
use crate::terminal::console::Console;
use crate::terminal::exit_code::{Outcome, Problem};

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
    let planes = synthesise(&source.parameters, dimensions, position);
    if let Some(channel) = planes.iter().position(|plane| plane.iter().any(|f| !f.is_finite())) {
        let name = CHANNEL_NAMES[channel];
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

/// Source of a file.
#[derive(Clone, Debug)]
struct Source {
    parameters: MaterialParameters,
    dimensions: Option<[usize; 3]>,
    sample_position: Option<SamplePosition>,
}

/// Members of a result about the measurement.
#[derive(Deserialize)]
struct Measured {
    input: Option<Grid>,
}

#[derive(Deserialize)]
struct Grid {
    dimensions: Option<[usize; 3]>,
    sample_position: Option<SamplePosition>,
}

impl Source {
    /// A result or an embedded material, as [`embedded_materials::find`] decides.
    fn find(source: &Path) -> Result<Self, Problem> {
        match embedded_materials::find(source)? {
            Some(material) => Ok(Self { parameters: material.parameters(), dimensions: None, sample_position: None }),
            None => Self::read(source),
        }
    }

    fn read(path: &Path) -> Result<Self, Problem> {
        let result = Document::open(path, "a fit result")?;
        let parameters = result.material()?;
        let Measured { input } = result.decode()?;
        let (dimensions, sample_position) =
            input.map_or((None, None), |input| (input.dimensions, input.sample_position));
        if let Some([h, d, p]) = dimensions
            && Dimensions::from_shape([h, d, p]).is_none()
        {
            return Err(Problem::invalid(format!(
                "{}: its dimensions {h} x {d} x {p} are not those of a MERL file; choose --phi-bins 180 or 360",
                path.display()
            )));
        }
        Ok(Self { parameters, dimensions, sample_position })
    }
}
