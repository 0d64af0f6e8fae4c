//! Command-line arguments of `brdfit demo`.

use std::path::PathBuf;

use clap::Args;
use clap::builder::PossibleValuesParser;

use crate::args::embedded_materials;

/// Options of `brdfit demo`.
#[derive(Debug, Args)]
pub(crate) struct DemoArgs {
    /// Folder for the MERL file, the fit, the summary, the atlas, the scene
    /// and the pictures
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: PathBuf,

    /// Embedded material
    #[arg(long, value_name = "NAME", value_parser = PossibleValuesParser::new(embedded_materials::names()),
          default_value = embedded_materials::default_material().name)]
    pub(crate) material: String,
}

pub(super) const EXAMPLES: &str = "\
Examples:
  brdfit demo -o out
  brdfit demo -o out --material polished-metal
See out/<name>.svg, .atlas.png and .render.png. The parameters of the embedded
materials are invented.";
