//! The validated plan of `brdfit render`.

use std::path::{Path, PathBuf};

use brdfit_renderer::{Exposure, LayerGroup, RenderOptions};

use crate::args::render::RenderArgs;
use crate::args::value_enums::{BackgroundArg, LayerArg};
use crate::jobs::render::options::options;
use crate::results::folder::keep_inputs;
use crate::results::output;
use crate::terminal::exit_code::Problem;

/// A checked rendering.
#[derive(Clone, Debug)]
pub(crate) struct RenderPlan {
    pub(crate) scene: PathBuf,
    /// Folder that is searched first for files of materials.
    pub(crate) materials: Option<PathBuf>,
    pub(crate) options: RenderOptions,
    /// Layers of the image, in the order of the frame.
    pub(crate) layers: Vec<LayerGroup>,
    pub(crate) background: BackgroundArg,
    pub(crate) exposure: Option<Exposure>,
    /// Frames that are averaged.
    pub(crate) frames: u32,
    /// Times that each frame is rendered.
    pub(crate) repeat: usize,
    pub(crate) reference: Option<PathBuf>,
    pub(crate) files: RenderTargets,
}

/// Files that are written.
#[derive(Clone, Debug)]
pub(crate) struct RenderTargets {
    pub(crate) image: PathBuf,
    pub(crate) png: Option<PathBuf>,
    pub(crate) map: Option<PathBuf>,
    pub(crate) stats: Option<PathBuf>,
    pub(crate) light_map: Option<PathBuf>,
}

impl RenderPlan {
    /// # Errors
    /// Options outside of their range or against each other, an input that would be overwritten.
    pub(crate) fn new(args: &RenderArgs) -> Result<Self, Problem> {
        let files = RenderTargets {
            image: args.output.clone(),
            png: args.png.clone(),
            map: args.map.clone(),
            stats: args.stats.clone(),
            light_map: args.light_map.clone(),
        };
        check_places(args, &files)?;
        let exposure = args.exposure.map(|factor| {
            Exposure::new(factor).ok_or_else(|| Problem::usage(format!("--exposure {factor}: must be above 0")))
        });
        Ok(Self {
            scene: args.scene.clone(),
            materials: args.materials.clone(),
            options: options(args)?,
            layers: groups(&args.layers),
            background: args.background,
            exposure: exposure.transpose()?,
            frames: args.frames,
            repeat: args.repeat.into(),
            reference: args.reference.clone(),
            files,
        })
    }
}

/// Each group once, in the order of the frame.
fn groups(layers: &[LayerArg]) -> Vec<LayerGroup> {
    let wanted = |group: &LayerGroup| {
        let layer = match group {
            LayerGroup::GBuffer => LayerArg::Gbuffer,
            LayerGroup::Light => LayerArg::Light,
            LayerGroup::Pilot => LayerArg::Pilot,
            LayerGroup::Bandwidth => LayerArg::Bandwidth,
            LayerGroup::Decision => LayerArg::Decision,
            LayerGroup::List => LayerArg::List,
            LayerGroup::Upsampled => LayerArg::Upsampled,
        };
        layers.contains(&LayerArg::All) || layers.contains(&layer)
    };
    LayerGroup::ALL.into_iter().filter(wanted).collect()
}

/// Refuses a file that is written twice, read and written, or cannot appear where it should. Only statistics may go to standard
/// output.
fn check_places(args: &RenderArgs, files: &RenderTargets) -> Result<(), Problem> {
    let printed = Path::new("-");
    let stats = files.stats.as_ref().filter(|path| *path != printed);
    let optional = [files.png.as_ref(), files.map.as_ref(), stats, files.light_map.as_ref()];
    let written: Vec<&PathBuf> = std::iter::once(&files.image).chain(optional.into_iter().flatten()).collect();
    for (n, path) in written.iter().enumerate() {
        if *path == printed {
            return Err(Problem::usage("-: images cannot be written to standard output; name a file"));
        }
        if written[..n].contains(path) {
            return Err(Problem::usage(format!("{}: is named for two outputs; choose another name", path.display())));
        }
        let inputs = std::iter::once(&args.scene).chain(&args.reference).map(PathBuf::as_path);
        keep_inputs(inputs, std::slice::from_ref(*path), "; choose another name")?;
        output::expect_place(path)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdfit_renderer::{Budget, Prefilter};

    use crate::args::cli::{Cli, Command};
    use clap::Parser;

    fn plan(line: &str) -> Result<RenderPlan, Problem> {
        let cli = Cli::try_parse_from(line.split(' ')).unwrap_or_else(|error| panic!("{error}"));
        let Command::Render(args) = cli.command else { panic!("{line}") };
        RenderPlan::new(&args)
    }

    #[test]
    fn the_default_is_that_of_the_library() {
        let options = plan("brdfit render s.json -o x.exr").unwrap().options;
        assert_eq!(options, RenderOptions { budget: Budget::SamplesPerPixel(16.0), ..RenderOptions::default() });
    }

    #[test]
    fn options_arrive() {
        let plan = plan(
            "brdfit render s.json -o x.exr --mode adaptive-pixels --target-error 0.05 --seed 7 --prefilter 0.2 \
             --pilot-samples 64 --allocation eq9 --geometry operators-literal --sampling-rate 3.1416 --upsample paper \
             --layers list,gbuffer,list --repeat 5",
        )
        .unwrap();
        assert_eq!(plan.options.budget, Budget::TargetError(0.05));
        assert_eq!(plan.options.prefilter, Prefilter::Above(0.2));
        assert_eq!((plan.options.seed, plan.options.pilot_samples, plan.repeat), (7, 64, 5));
        assert_eq!(plan.layers, [LayerGroup::GBuffer, LayerGroup::List]);
        assert_eq!(groups(&[LayerArg::All]), LayerGroup::ALL);
    }

    #[test]
    fn invalid_options_are_refused() {
        for (options, part) in [
            ("--spp 0", "--spp 0: must lie above 0"),
            ("--spp nan", "--spp NaN"),
            ("--mode reference --spp 0.3", "at least one sample"),
            ("--mode reference --target-error 0.1", "cannot be used with --mode reference"),
            ("--mode reference --prefilter 0.1", "accepts only never or always"),
            ("--target-error -1", "--target-error -1"),
            ("--prefilter some", "--prefilter some: must be never"),
            ("--prefilter -1", "--prefilter -1"),
            ("--sampling-rate 0", "--sampling-rate 0"),
            ("--exposure 0", "--exposure 0"),
            ("--png x.exr", "x.exr: is named for two outputs"),
            ("--png - --stats -", "images cannot be written to standard output"),
            ("--png no/such/folder.png", "its folder does not exist"),
        ] {
            let message = plan(&format!("brdfit render s.json -o x.exr {options}")).unwrap_err().to_string();
            assert!(message.contains(part), "{options}: {message}");
        }
    }
}
