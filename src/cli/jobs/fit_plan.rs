//! The validated plan of `brdfit fit`.

use std::path::Path;

use brdfit_fit::{DistributionSharing, FitOptions};

use crate::args::fit::FitArgs;
use crate::args::value_enums::ConstraintArg;
use crate::jobs::fit_job::Job;
use crate::jobs::inputs::{self, InputFile, Wanted};
use crate::results::folder::ResultFolder;
use crate::results::shard::Shard;
use crate::terminal::exit_code::Problem;

/// A checked batch.
#[derive(Clone, Debug)]
pub(crate) struct FitPlan {
    /// The measured files of this shard, in the order of their names.
    pub(crate) inputs: Vec<InputFile>,
    /// Destination of the results.
    pub(crate) target: Target,
    /// The job of each file.
    pub(crate) job: Job,
    /// Whether existing results are kept.
    pub(crate) resume: bool,
    /// Whether pictures are drawn.
    pub(crate) picture: bool,
    /// Whether atlases are made.
    pub(crate) atlas: bool,
    /// The part of a larger batch.
    pub(crate) shard: Option<Shard>,
}

/// Destination of the results.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Target {
    /// The one document goes to standard output.
    StandardOutput,
    /// Documents and summaries go to a folder.
    Folder(ResultFolder),
}

impl FitPlan {
    /// # Errors
    /// Errors of [`inputs::collect`]; options that are inconsistent or out of range.
    pub(crate) fn new(args: &FitArgs) -> Result<Self, Problem> {
        let options = options(args)?;
        let shard = args.shard.as_deref().map(Shard::parse).transpose()?;
        let target = match &args.output {
            None => Target::StandardOutput,
            Some(folder) if folder == Path::new("-") => {
                return Err(Problem::usage("-o must be a folder; omit it to print the result of a single input"));
            }
            Some(folder) => Target::Folder(ResultFolder::at(folder)),
        };
        let mut inputs = inputs::collect(&args.inputs, args.recursive, Wanted::Measured)?;
        if args.atlas {
            check_names(&inputs)?;
        }
        if target == Target::StandardOutput && inputs.len() > 1 {
            return Err(Problem::usage(format!("{} inputs; add -o DIR for their results", inputs.len())));
        }
        if let Some(shard) = shard {
            inputs = shard.part(inputs);
        }
        let job = Job {
            model: args.model,
            sample_position: args.sample_position.map(Into::into),
            options,
            scan: !args.no_hash,
            panel: !args.no_panel && !args.no_hash,
            accept_non_finite: args.accept_non_finite,
        };
        Ok(Self { inputs, target, job, resume: args.resume, picture: args.picture, atlas: args.atlas, shard })
    }
}

/// Refuses two inputs of which one has a fit where the other has the document of its atlas.
fn check_names(inputs: &[InputFile]) -> Result<(), Problem> {
    let is_there = |name: &str| inputs.iter().any(|input| input.name == name);
    match inputs.iter().find(|input| input.name.strip_suffix(".atlas").is_some_and(is_there)) {
        None => Ok(()),
        Some(input) => Err(Problem::usage(format!(
            "{}: its result {}.json would collide with that of an atlas; rename the file",
            input.path.display(),
            input.name
        ))),
    }
}

/// The options of the fit: a preset, and what was said about single ones.
fn options(args: &FitArgs) -> Result<FitOptions, Problem> {
    let preset = match args.constraint {
        Some(ConstraintArg::Paper) => FitOptions::published(args.model),
        _ => FitOptions::new(args.model),
    };
    let options = FitOptions {
        distribution: if args.joint { DistributionSharing::Joint } else { preset.distribution },
        loss: args.loss.map_or(preset.loss, Into::into),
        constraint: args.constraint.map_or(preset.constraint, ConstraintArg::constraint),
        anchor: args.anchor.map_or(preset.anchor, Into::into),
        step2_solver: args.step2_solver.map_or(preset.step2_solver, Into::into),
        cutoff_theta_h_degrees: args.cutoff_theta_h.unwrap_or(preset.cutoff_theta_h_degrees),
        cutoff_theta_d_degrees: args.cutoff_theta_d.unwrap_or(preset.cutoff_theta_d_degrees),
        starts: if args.start.is_empty() {
            preset.starts
        } else {
            args.start.iter().map(|start| start.0.clone()).collect()
        },
        max_iterations: args.max_iterations.unwrap_or(preset.max_iterations),
    };
    options.check(args.model).map_err(|error| Problem::usage(format!("{error}; see brdfit fit --help")))?;
    Ok(options)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::cli::{Cli, Command};
    use brdfit_brdf::ModelName;
    use brdfit_fit::{Constraint, Loss};
    use clap::Parser;

    fn plan(line: &str) -> Result<FitPlan, Problem> {
        let cli = Cli::try_parse_from(line.split(' ')).unwrap_or_else(|error| panic!("{error}"));
        let Command::Fit(args) = cli.command else { panic!("{line}") };
        FitPlan::new(&args)
    }

    #[test]
    fn the_default_is_the_default() {
        let plan = plan("brdfit fit x.binary").unwrap();
        assert_eq!((plan.target, plan.job.options), (Target::StandardOutput, FitOptions::default()));
        assert!(plan.job.scan && plan.job.panel && !plan.atlas);
    }

    #[test]
    fn the_preset_is_a_start_and_single_options_change_it() {
        let paper = plan("brdfit fit x.binary --constraint paper").unwrap().job.options;
        assert_eq!(paper, FitOptions::published(ModelName::default()));
        let mixed =
            plan("brdfit fit x --constraint paper --loss sqrt-cos --cutoff-theta-d 60 --start 0.1,0.2").unwrap();
        let expected = FitOptions {
            loss: Loss::SqrtCos,
            cutoff_theta_d_degrees: 60.0,
            starts: vec![vec![0.1, 0.2]],
            ..FitOptions::published(ModelName::default())
        };
        assert_eq!(mixed.job.options, expected);
        let free = plan("brdfit fit x --constraint free").unwrap().job.options;
        assert_eq!(free, FitOptions { constraint: Constraint::Free, ..FitOptions::default() });
    }

    #[test]
    fn invalid_usage_is_refused() {
        for (line, part) in [
            ("brdfit fit x y", "add -o DIR"),
            ("brdfit fit x -o -", "-o must be a folder"),
            ("brdfit fit x -o d --shard 0/3", "--shard 0/3"),
            ("brdfit fit x -o d --shard 4/3", "--shard 4/3"),
            ("brdfit fit x -o d --shard 1", "--shard 1"),
            ("brdfit fit x.binary x.atlas.binary -o d --atlas", "x.atlas.binary: its result x.atlas.json"),
            ("brdfit fit x --cutoff-theta-h 95", "cutoff_theta_h"),
            ("brdfit fit x --cutoff-theta-d nan", "cutoff_theta_d"),
            ("brdfit fit x --start 2,0.4", "alpha 2"),
            ("brdfit fit x --start 0.1,-1", "p -1"),
            ("brdfit fit x --start 0.1", "alpha,p, not 1 number"),
            ("brdfit fit x --model ggx --start 0.1,0.4", "a starting point of the model ggx is alpha, not 2 numbers"),
            ("brdfit fit x --model ggx --start 3", "alpha 3 lies outside of alpha in [1e-4, 2]"),
            ("brdfit fit x --max-iterations 0", "max_iterations"),
        ] {
            let message = plan(line).unwrap_err().to_string();
            assert!(message.contains(part), "{line}: {message}");
        }
    }
}
