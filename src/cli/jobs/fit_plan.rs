//! What `brdfit fit` is going to do, checked before anything is done.

use std::fmt;
use std::path::{Path, PathBuf};

use brdfit_fit::{DistributionSharing, FitOptions};

use crate::args::fit::FitArgs;
use crate::args::value_enums::ConstraintArg;
use crate::jobs::fit_job::Job;
use crate::jobs::inputs::{self, InputFile, Wanted};
use crate::terminal::exit_code::Problem;

/// A checked batch.
#[derive(Clone, Debug)]
pub(crate) struct FitPlan {
    /// The measured files of this shard, in the order of their names.
    pub(crate) inputs: Vec<InputFile>,
    /// Where the results go.
    pub(crate) target: Target,
    /// What is done with each file.
    pub(crate) job: Job,
    /// Whether results that are there already are kept.
    pub(crate) resume: bool,
    /// Whether pictures are drawn.
    pub(crate) picture: bool,
    /// Whether atlases are made.
    pub(crate) atlas: bool,
    /// The part of a larger batch.
    pub(crate) shard: Option<Shard>,
}

/// The value of an option, if it lies within its range, which `range` describes: "above 0", "from 0 to 1".
pub(crate) fn must_lie(option: &str, value: f64, within: bool, range: &str) -> Result<f64, Problem> {
    if within { Ok(value) } else { Err(Problem::usage(format!("{option} {value}: must lie {range}"))) }
}

/// Where results go.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Target {
    /// The one document goes to standard output.
    StandardOutput,
    /// Documents and summaries go to a folder.
    Folder(PathBuf),
}

/// The `index`-th of `count` parts, counted from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Shard {
    pub(crate) index: usize,
    pub(crate) count: usize,
}

impl FitPlan {
    /// # Errors
    /// What [`inputs::collect`] refuses, options that contradict each other or lie outside of their range.
    pub(crate) fn new(args: &FitArgs) -> Result<Self, Problem> {
        let options = options(args)?;
        let shard = args.shard.as_deref().map(Shard::parse).transpose()?;
        let target = match &args.output {
            None => Target::StandardOutput,
            Some(folder) if folder == Path::new("-") => {
                return Err(Problem::usage("-o wants a folder; leave it out to print the document of a single input"));
            }
            Some(folder) => Target::Folder(folder.clone()),
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
            "{}: its result {}.json would be that of an atlas too; rename the file",
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

impl Shard {
    /// Largest number of parts.
    const MAX: usize = 100_000;

    pub(crate) fn parse(text: &str) -> Result<Self, Problem> {
        Self::split(text, "/")
            .ok_or_else(|| Problem::usage(format!("--shard {text}: wants I/N with I from 1 to N, for instance 2/8")))
    }

    /// The shard to which a file `summary.I-of-N.json` belongs.
    pub(crate) fn of_summary(file_name: &str) -> Option<Self> {
        Self::split(file_name.strip_prefix("summary.")?.strip_suffix(".json")?, "-of-")
    }

    fn split(text: &str, separator: &str) -> Option<Self> {
        let number = |text: &str| text.parse().ok().filter(|n| (1..=Self::MAX).contains(n));
        let (index, count) = text.split_once(separator)?;
        let shard = Self { index: number(index)?, count: number(count)? };
        (shard.index <= shard.count).then_some(shard)
    }

    /// Every `count`-th, starting with the `index`-th.
    pub(crate) fn part<T>(self, all: Vec<T>) -> Vec<T> {
        all.into_iter().skip(self.index - 1).step_by(self.count).collect()
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}-of-{}", self.index, self.count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::{Cli, Command};
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
    fn what_makes_no_sense_is_refused() {
        for (line, part) in [
            ("brdfit fit x y", "add -o DIR"),
            ("brdfit fit x -o -", "wants a folder"),
            ("brdfit fit x -o d --shard 0/3", "--shard 0/3"),
            ("brdfit fit x -o d --shard 4/3", "--shard 4/3"),
            ("brdfit fit x -o d --shard 1", "--shard 1"),
            ("brdfit fit x.binary x.atlas.binary -o d --atlas", "x.atlas.binary: its result x.atlas.json"),
            ("brdfit fit x --cutoff-theta-h 95", "cutoff_theta_h"),
            ("brdfit fit x --cutoff-theta-d nan", "cutoff_theta_d"),
            ("brdfit fit x --start 2,0.4", "alpha 2"),
            ("brdfit fit x --start 0.1,-1", "p -1"),
            ("brdfit fit x --start 0.1", "alpha,p, not 1 number"),
            ("brdfit fit x --model ggx --start 0.1,0.4", "a start of the model ggx is alpha, not 2 numbers"),
            ("brdfit fit x --model ggx --start 3", "alpha 3 lies outside of alpha in [1e-4, 2]"),
            ("brdfit fit x --max-iterations 0", "max_iterations"),
        ] {
            let message = plan(line).unwrap_err().to_string();
            assert!(message.contains(part), "{line}: {message}");
        }
    }

    #[test]
    fn the_parts_of_a_batch_make_up_the_whole() {
        let whole: Vec<usize> = (0..10).collect();
        let mut joined: Vec<usize> = (1..=4).flat_map(|index| Shard { index, count: 4 }.part(whole.clone())).collect();
        assert_eq!(Shard::parse("2/4").unwrap().part(whole.clone()), [1, 5, 9]);
        joined.sort_unstable();
        assert_eq!(joined, whole);
    }
}
