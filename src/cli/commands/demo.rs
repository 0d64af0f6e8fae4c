//! `brdfit demo`: an embedded material becomes a MERL file, the file becomes a fit, both are shown side by side, the
//! material becomes a bandwidth atlas, and fit and atlas become a picture.

use std::path::{Path, PathBuf};
use std::time::Instant;

use brdfit_bandwidth::sidecar::FileContent;
use brdfit_fit::document::FitDocument;
use brdfit_fit::{FitOptions, synthesise};
use brdfit_measured::{CHANNEL_NAMES, Dimensions, SamplePosition, write_merl};

use crate::args::demo::DemoArgs;
use crate::args::embedded_materials::{self, Embedded};
use crate::commands::fit;
use crate::jobs::atlas_job::{AtlasJob, AtlasMaker, Sidecar};
use crate::jobs::demo_picture::PictureFiles;
use crate::jobs::fit_job::Job;
use crate::jobs::fit_plan::{FitPlan, Target};
use crate::jobs::inputs::{InputFile, Wanted};
use crate::jobs::material_source::Origin;
use crate::results::documents;
use crate::results::folder::{ResultFile, ResultFolder};
use crate::results::output;
use crate::terminal::console::{Console, Tone};
use crate::terminal::exit_code::{Outcome, Problem};
use crate::terminal::table::{Align, Table};

pub(crate) fn run(args: &DemoArgs, console: &Console) -> anyhow::Result<Outcome> {
    let material = embedded_materials::material(&args.material)
        .ok_or_else(|| Problem::usage(format!("{}: no such material; see brdfit demo --help", args.material)))?;
    let (model, sample_position) = (material.parameters().model(), SamplePosition::default());
    let folder = ResultFolder::at(&args.output);
    folder.create()?;
    let files = Files::new(&folder, material.name);

    let start = Instant::now();
    make(material, sample_position, &files.binary)?;
    let made = start.elapsed();
    let plan = FitPlan {
        inputs: vec![InputFile::new(files.binary.clone(), Wanted::Measured)?],
        target: Target::Folder(folder.clone()),
        job: Job {
            model,
            sample_position: Some(sample_position),
            options: FitOptions::new(model),
            scan: true,
            panel: true,
            accept_non_finite: false,
        },
        resume: false,
        picture: true,
        atlas: false,
        shard: None,
    };
    let outcome = fit::fill(&folder, &plan, console)?;
    let fitted = start.elapsed();
    if outcome != Outcome::Done {
        return Ok(outcome);
    }
    let atlas = make_atlas(material, &folder)?;
    let mapped = start.elapsed();
    files.rendering.make(material.name)?;
    let total = start.elapsed();
    let document: FitDocument = documents::read(&files.json, "a fit result")?;
    output::print(&report(material, &document, &atlas, &files, console))?;
    console.note(&format!(
        "Times including output: MERL file {:.2} s, fit {:.2} s, atlas {:.2} s, rendering {:.2} s",
        made.as_secs_f64(),
        (fitted - made).as_secs_f64(),
        (mapped - fitted).as_secs_f64(),
        (total - mapped).as_secs_f64()
    ));
    Ok(outcome)
}

/// Writes the MERL file of a material.
fn make(material: &Embedded, position: SamplePosition, path: &Path) -> Result<(), Problem> {
    let dimensions = Dimensions::HALF_TURN;
    let planes = synthesise(&material.parameters(), dimensions, position);
    output::write_with(path, |mut out| {
        write_merl(&mut out, dimensions, |channel, theta_h, theta_d, phi_d| {
            planes[channel][dimensions.index(theta_h, theta_d, phi_d)]
        })
    })
}

/// Makes the atlas of a material and its preview.
fn make_atlas(material: &Embedded, folder: &ResultFolder) -> Result<Sidecar, Problem> {
    let mut job = AtlasJob::default();
    job.files.push(FileContent::PngPreview);
    let origin = Origin::fit(material.name, None);
    AtlasMaker::new(job).make(material.parameters().brdf().as_ref(), origin, material.name)?.write(folder)
}

/// Files of the demo.
struct Files {
    binary: PathBuf,
    json: PathBuf,
    picture: PathBuf,
    atlas: PathBuf,
    preview: PathBuf,
    rendering: PictureFiles,
    summaries: [PathBuf; 2],
}

impl Files {
    fn new(folder: &ResultFolder, name: &str) -> Self {
        let file = |file: ResultFile| folder.file(file, name);
        Self {
            binary: file(ResultFile::Measurement),
            json: file(ResultFile::Fit),
            picture: file(ResultFile::Slices),
            atlas: file(ResultFile::AtlasKtx2),
            preview: file(ResultFile::AtlasPreview),
            rendering: PictureFiles::new(folder, name),
            summaries: [folder.summary(None), folder.summary_table()],
        }
    }
}

/// The printed report: true and fitted parameters, errors, files, next steps.
fn report(material: &Embedded, document: &FitDocument, atlas: &Sidecar, files: &Files, console: &Console) -> String {
    let strong = |text: &str| console.paint(Tone::Strong, text);
    let list = |entries: &[(&Path, &str)]| {
        let width = entries.iter().map(|(path, _)| path.display().to_string().chars().count()).max().unwrap_or(0);
        entries
            .iter()
            .map(|(path, what)| {
                format!("  {:width$}  {}\n", path.display().to_string(), console.paint(Tone::Dim, what))
            })
            .collect::<String>()
    };
    let [summary, csv] = &files.summaries;
    let PictureFiles { scene, picture } = &files.rendering;
    let left = list(&[
        (picture, "rendering of the fit on a sphere, with its shading density"),
        (&files.picture, "both slices, measured and fitted"),
        (&files.preview, "false-colour preview of the bandwidth atlas"),
        (&files.atlas, "bandwidth atlas as a texture, beside .exr and .json"),
        (scene, "scene of the sphere, for brdfit render"),
        (&files.json, "fit: parameters, errors, curves, convergence"),
        (summary, "summary of the batch"),
        (csv, "summary as a table"),
        (&files.binary, "MERL file that was fitted"),
    ]);
    format!(
        "{}: {}\n\n{}\nThe largest relative difference of a parameter is {:.0e}. E, L, C: cosine-weighted, logarithmic and\ncube root error \
         over the whole grid (docs/theory.md, section 6). The local bandwidth of\nthe lobes reaches {:.1} cycles per radian.\n\n{}\n{left}\n{}\n  brdfit fit YOUR_FOLDER -o fits\n  brdfit atlas fits -o atlases\n  brdfit render {} -o sphere.exr --png sphere.png\n  brdfit info YOUR_FILE.binary\n  brdfit fit --help\n",
        strong(material.name),
        material.description,
        parameters(material, document, console),
        largest_difference(material, document),
        atlas.atlas.range[1],
        strong("Files"),
        strong("Next"),
        scene.display(),
    )
}

/// The true parameters above the fitted ones.
fn parameters(material: &Embedded, document: &FitDocument, console: &Console) -> Table {
    let made_from = material.parameters();
    let known = made_from.model().model().parameters();
    let titles = known.iter().map(|parameter| match parameter.symbol {
        ("F", index) => format!("F{index}"),
        _ => parameter.name.to_owned(),
    });
    let numbers = titles.chain(["E", "L", "C"].map(str::to_owned)).map(|title| (title, Align::Right));
    let mut table =
        Table::new([String::new(), String::new()].map(|title| (title, Align::Left)).into_iter().chain(numbers));
    for (n, found) in document.channels.iter().enumerate() {
        let heading = [console.paint(Tone::Strong, CHANNEL_NAMES[n]), "true".to_owned()];
        table.row(heading.into_iter().chain(made_from.channel(n).iter().map(|value| format!("{value}"))));
        let errors = document.errors.as_ref().map(|panel| [panel.e[n], panel.l[n], panel.c[n]]);
        let errors = errors.into_iter().flatten().map(|value| format!("{value:.1e}"));
        let found = found.parameters.iter().map(|(_, value)| format!("{value:.6}"));
        table.row([String::new(), "fitted".to_owned()].into_iter().chain(found).chain(errors));
    }
    table
}

/// Largest relative difference between a parameter and the one that was found.
fn largest_difference(material: &Embedded, document: &FitDocument) -> f64 {
    let made_from = material.parameters();
    let channels = document.channels.iter().enumerate();
    channels
        .flat_map(|(n, found)| {
            made_from.named(n).iter().map(|(name, value)| (value, found.parameters.get(name))).collect::<Vec<_>>()
        })
        .map(|(made_from, found)| found.map_or(f64::INFINITY, |found| ((found - made_from) / made_from).abs()))
        .fold(0.0, f64::max)
}
