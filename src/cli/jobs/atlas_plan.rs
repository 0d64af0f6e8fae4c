//! The validated plan of `brdfit atlas`.

use std::path::{Path, PathBuf};

use brdfit_bandwidth::sidecar::FileContent;
use brdfit_bandwidth::{Estimator, LobeOptions, Rule};

use crate::args::atlas::AtlasArgs;
use crate::args::ranges::must_lie;
use crate::args::value_enums::Format;
use crate::args::value_enums::{ContainerArg, SamplesArg};
use crate::jobs::atlas_job::AtlasJob;
use crate::jobs::inputs::{self, Wanted};
use crate::jobs::material_source::{MaterialInput, Reading};
use crate::results::folder::{ResultFile, ResultFolder, keep_inputs};
use crate::results::shard::Shard;
use crate::terminal::exit_code::Problem;

/// A checked batch.
#[derive(Clone, Debug)]
pub(crate) struct AtlasPlan {
    /// The materials of this shard, in the order of their names.
    pub(crate) inputs: Vec<MaterialInput>,
    /// Options of reading measured files.
    pub(crate) reading: Reading,
    /// The job of each material.
    pub(crate) job: AtlasJob,
    /// Destination of the results.
    pub(crate) folder: ResultFolder,
    /// Whether existing results are kept.
    pub(crate) resume: bool,
    /// Format of the final report.
    pub(crate) report: Option<Format>,
}

impl AtlasPlan {
    /// # Errors
    /// Errors of [`inputs::collect`]; options that are inconsistent or out of range.
    pub(crate) fn new(args: &AtlasArgs) -> Result<Self, Problem> {
        let job = AtlasJob {
            layout: args.layout.into(),
            channels: args.channels.into(),
            options: options(args)?,
            files: files(args)?,
        };
        let shard = args.shard.as_deref().map(Shard::parse).transpose()?;
        if args.output == Path::new("-") {
            return Err(Problem::usage("-o must be a folder; an atlas is several files"));
        }
        let folder = ResultFolder::at(&args.output);
        let inputs = inputs::collect(&args.inputs, args.recursive, Wanted::Materials)?;
        let inputs: Vec<MaterialInput> = inputs.into_iter().map(MaterialInput::new).collect::<Result<_, _>>()?;
        let documents: Vec<PathBuf> = inputs.iter().map(|input| folder.file(ResultFile::Atlas, input.name())).collect();
        let by = " by the atlas of another input; choose another folder with -o";
        keep_inputs(inputs.iter().filter_map(MaterialInput::path), &documents, by)?;
        Ok(Self {
            inputs: shard.map_or(inputs.clone(), |shard| shard.part(inputs)),
            reading: Reading {
                sample_position: args.sample_position.map(Into::into),
                accept_non_finite: args.accept_non_finite,
            },
            job,
            folder,
            resume: args.resume,
            report: args.format,
        })
    }
}

/// The files of each atlas, in a fixed order.
fn files(args: &AtlasArgs) -> Result<Vec<FileContent>, Problem> {
    let exr = args.formats.contains(&ContainerArg::Exr);
    if !exr && args.exr_samples == Some(SamplesArg::Float) {
        return Err(Problem::usage("--exr-samples float: requires exr in --formats"));
    }
    let exr_content = match args.exr_samples {
        Some(SamplesArg::Float) => FileContent::ExrFloat,
        Some(SamplesArg::Half) | None => FileContent::ExrHalf,
    };
    let wanted = [
        (args.formats.contains(&ContainerArg::Ktx2), FileContent::Ktx2Half),
        (exr, exr_content),
        (args.preview, FileContent::PngPreview),
    ];
    Ok(wanted.into_iter().filter_map(|(wanted, content)| wanted.then_some(content)).collect())
}

/// Options of the estimation of lobes.
fn options(args: &AtlasArgs) -> Result<LobeOptions, Problem> {
    let rule = match args.epsilon {
        Some(e) => Rule::Epsilon(must_lie("--epsilon", e, e > 0.0 && e <= 1.0, "above 0, up to 1")?),
        None => {
            let p = args.percentile;
            Rule::Percentile(must_lie("--percentile", p, p > 0.0 && p < 100.0, "between 0 and 100")?)
        }
    };
    let (delta, share) = (args.delta, args.finest_share);
    let default = LobeOptions::default();
    Ok(LobeOptions {
        estimator: Estimator {
            rule,
            delta: must_lie("--delta", delta, (0.0..1.0).contains(&delta), "from 0 to below 1")?,
            reflections: !args.no_reflections,
            border: default.estimator.border,
        },
        finest_share: must_lie("--finest-share", share, (0.0..=1.0).contains(&share), "from 0 to 1")?,
        max_resolution: args.max_resolution,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::cli::{Cli, Command};
    use clap::Parser;

    fn plan(line: &str) -> Result<AtlasPlan, Problem> {
        let cli = Cli::try_parse_from(line.split(' ')).unwrap_or_else(|error| panic!("{error}"));
        let Command::Atlas(args) = cli.command else { panic!("{line}") };
        AtlasPlan::new(&args)
    }

    #[test]
    fn the_default_is_that_of_the_library() {
        let plan = plan("brdfit atlas x.binary -o d").unwrap();
        assert_eq!(plan.job, AtlasJob::default());
        assert_eq!(plan.job.options, LobeOptions::default());
        assert_eq!(plan.reading, Reading::default());
    }

    #[test]
    fn options_arrive() {
        let plan = plan(
            "brdfit atlas red-satin -o d --formats exr,ktx2,exr --exr-samples float --preview --epsilon 0.01 --delta 0 \
             --no-reflections --finest-share 1 --max-resolution 512",
        )
        .unwrap();
        assert_eq!(plan.job.files, [FileContent::Ktx2Half, FileContent::ExrFloat, FileContent::PngPreview]);
        let options = plan.job.options;
        assert_eq!((options.estimator.rule, options.estimator.delta), (Rule::Epsilon(0.01), 0.0));
        assert_eq!((options.finest_share, options.max_resolution), (1.0, 512));
        assert!(!options.estimator.reflections);
        assert!(matches!(plan.inputs[..], [MaterialInput::Embedded(_)]));
    }

    #[test]
    fn an_input_is_not_overwritten() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["x.json", "x.atlas.json"] {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        let at = folder.path().display();
        let refused = plan(&format!("brdfit atlas {at}/x.json {at}/x.atlas.json -o {at}/.")).unwrap_err().to_string();
        assert!(refused.contains("x.atlas.json: would be overwritten"), "{refused}");
        assert!(plan(&format!("brdfit atlas {at}/x.json {at}/x.atlas.json -o {at}/other")).is_ok());
        assert!(plan(&format!("brdfit atlas {at}/x.json -o {at}")).is_ok());
    }

    #[test]
    fn invalid_usage_is_refused() {
        for (options, part) in [
            ("--percentile 0", "--percentile 0: must lie between"),
            ("--percentile nan", "--percentile NaN"),
            ("--epsilon 0", "--epsilon 0"),
            ("--epsilon 1.5", "--epsilon 1.5"),
            ("--delta -0.1", "--delta -0.1"),
            ("--delta 1", "--delta 1"),
            ("--finest-share 2", "--finest-share 2"),
            ("--formats ktx2 --exr-samples float", "requires exr in --formats"),
            ("--shard 4/3", "--shard 4/3"),
            ("no-such-material", "no such file or embedded material"),
        ] {
            let message = plan(&format!("brdfit atlas x.binary -o d {options}")).unwrap_err().to_string();
            assert!(message.contains(part), "{options}: {message}");
        }
    }
}
