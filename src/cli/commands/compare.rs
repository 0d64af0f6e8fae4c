//! `brdfit compare`: compares fits with reference fits.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use brdfit_fit::compare::{
    ChannelComparison, ComparableFit, Comparison, CurveComparison, ErrorsComparison, Tolerance, Tolerances, Verdict,
    compare,
};
use brdfit_fit::document::Failure;
use serde::Serialize;

use crate::args::compare::CompareArgs;
use crate::args::value_enums::Format;
use crate::results::documents;
use crate::results::folder::PROGRAM;
use crate::results::json;
use crate::results::output;
use crate::terminal::console::{Console, Tone};
use crate::terminal::exit_code::{Outcome, Problem};
use crate::terminal::table::{Align, Table};

pub(crate) fn run(args: &CompareArgs, console: &Console) -> anyhow::Result<Outcome> {
    let tolerances = tolerances(args)?;
    let pairs = pairs(&args.ours, &args.reference)?;
    let mut report = Report { program: PROGRAM, tolerances, materials: Vec::new(), failures: Vec::new() };
    let mut outcome = Outcome::Done;
    for pair in &pairs {
        match pair.compare(&tolerances) {
            Ok(comparison) => report.materials.push(comparison),
            Err(problem) => {
                let (input, message) = (pair.ours.display().to_string(), problem.to_string());
                let error = problem.into();
                console.error(&error);
                let asked = Outcome::of(&error);
                outcome = outcome.max(asked);
                report.failures.push(Failure { input, message, exit_code: asked.code() });
            }
        }
    }
    if report.materials.iter().any(|material| material.verdict == Verdict::Fail) {
        outcome = outcome.max(Outcome::Difference);
    }
    let bytes = match args.format {
        Format::Text => text(&report, console).into_bytes(),
        Format::Json => json::to_vec(&report),
    };
    output::deliver(args.output.as_deref(), &bytes)?;
    Ok(outcome)
}

fn tolerances(args: &CompareArgs) -> Result<Tolerances, Problem> {
    let limits = |name: &str, warn: f64, fail: f64| {
        if warn <= fail {
            Ok(Tolerance { warn, fail })
        } else {
            Err(Problem::usage(format!("--{name}-warn {warn} exceeds --{name}-fail {fail}; lower it")))
        }
    };
    Ok(Tolerances {
        cost: limits("cost", args.cost_warn, args.cost_fail)?,
        errors: limits("errors", args.errors_warn, args.errors_fail)?,
        curve: limits("curve", args.curve_warn, args.curve_fail)?,
        two_sided: args.two_sided,
        ..Tolerances::default()
    })
}

/// Two documents that belong together.
struct Pair {
    ours: PathBuf,
    reference: PathBuf,
}

impl Pair {
    fn compare(&self, tolerances: &Tolerances) -> Result<Comparison, Problem> {
        let [ours, reference] = [read(&self.ours)?, read(&self.reference)?];
        compare(&ours, &reference, tolerances)
            .map_err(|error| Problem::invalid(format!("{}: {error}", self.ours.display())))
    }
}

fn read(path: &Path) -> Result<ComparableFit, Problem> {
    let fit: ComparableFit = documents::read(path, "a fit result")?;
    fit.check().map_err(|error| Problem::invalid(format!("{}: {error}", path.display())))?;
    Ok(fit)
}

/// Two files, or the files of two folders by name. A file without a counterpart makes a pair, too, and fails when it is read.
fn pairs(ours: &Path, reference: &Path) -> Result<Vec<Pair>, Problem> {
    for path in [ours, reference] {
        fs::metadata(path).map_err(|error| Problem::reading(path, &error))?;
    }
    match [ours, reference].map(Path::is_dir) {
        [true, true] => {
            let mut names = documents_in(ours)?;
            names.extend(documents_in(reference)?);
            if names.is_empty() {
                let (a, b) = (ours.display(), reference.display());
                let missing = format!("{a}: neither this folder nor {b} contains a fit result");
                return Err(Problem::invalid(format!("{missing}; run brdfit fit -o {a}")));
            }
            let pair = |name: &String| Pair { ours: ours.join(name), reference: reference.join(name) };
            Ok(names.iter().map(pair).collect())
        }
        [false, false] => Ok(vec![Pair { ours: ours.to_owned(), reference: reference.to_owned() }]),
        [is_folder, _] => {
            let (folder, file) = if is_folder { (ours, reference) } else { (reference, ours) };
            let (folder, file) = (folder.display(), file.display());
            Err(Problem::usage(format!("{folder} is a folder and {file} is not; name two files or two folders")))
        }
    }
}

/// Names of the documents in a folder, without the summaries of a batch.
fn documents_in(folder: &Path) -> Result<BTreeSet<String>, Problem> {
    let unreadable = |error| Problem::reading(folder, &error);
    let mut names = BTreeSet::new();
    for entry in fs::read_dir(folder).map_err(unreadable)? {
        let name = entry.map_err(unreadable)?.file_name().to_string_lossy().into_owned();
        if name.ends_with(".json") && !name.starts_with("summary.") && !name.starts_with('.') {
            names.insert(name);
        }
    }
    Ok(names)
}

/// The comparison as JSON. An infinite tolerance is null.
#[derive(Serialize)]
struct Report {
    program: &'static str,
    tolerances: Tolerances,
    materials: Vec<Comparison>,
    failures: Vec<Failure>,
}

impl Report {
    fn channels(&self) -> impl Iterator<Item = &ChannelComparison> {
        self.materials.iter().flat_map(|material| &material.channels)
    }
}

fn text(report: &Report, console: &Console) -> String {
    if report.materials.is_empty() {
        return String::new();
    }
    let titles = ["step 1", "step 2", "theta_h rms", "largest", "theta_d rms", "largest", "E", "L", "C"];
    let [s1, s2, h, hm, d, dm, e, l, c] = titles.map(|title| (title, Align::Right));
    let left = |title| (title, Align::Left);
    let mut table =
        Table::new([left("material"), left(""), left("data"), s1, s2, h, hm, d, dm, e, l, c, left("verdict")]);
    for material in &report.materials {
        for (n, channel) in material.channels.iter().enumerate() {
            let name = if n == 0 { material.name.as_str() } else { "" };
            table.row([name, &channel.name].map(str::to_owned).into_iter().chain(cells(channel, console)));
        }
    }
    format!("{table}\n{}", closing(report, console))
}

/// The numbers of a row.
fn cells(channel: &ChannelComparison, console: &Console) -> Vec<String> {
    let data = match channel.measured.largest {
        Some(largest) if channel.measured.verdict == Verdict::Fail => format!("{largest:.1e}"),
        Some(_) => "same".to_owned(),
        None => "other rows".to_owned(),
    };
    let mut cells = vec![painted(&data, channel.measured.verdict, true, console)];
    cells.extend(channel.costs.iter().map(|cost| painted(&signed(cost.relative), cost.verdict, cost.judged, console)));
    for CurveComparison { rms, largest, judged, verdict, .. } in channel.curves {
        cells.push(painted(&format!("{rms:.1e}"), verdict, judged, console));
        cells.push(painted(&format!("{largest:.1e}"), Verdict::Agree, judged, console));
    }
    match channel.errors {
        Some(ErrorsComparison { e, l, c, judged, verdict }) => {
            cells.extend([e, l, c].map(|difference| painted(&signed(difference), verdict, judged, console)));
        }
        None => cells.extend(["-"; 3].map(str::to_owned)),
    }
    let word = match channel.verdict {
        Verdict::Agree => console.paint(Tone::Good, "agree"),
        Verdict::Warn => console.paint(Tone::Warn, "warn"),
        Verdict::Fail => console.paint(Tone::Bad, "FAIL"),
    };
    cells.push(word);
    cells
}

fn signed(difference: f64) -> String {
    if difference == 0.0 { "0".to_owned() } else { format!("{difference:+.1e}") }
}

/// A number in the colour of its verdict, or in brackets if it was not judged.
fn painted(text: &str, verdict: Verdict, judged: bool, console: &Console) -> String {
    match verdict {
        _ if !judged => console.paint(Tone::Dim, &format!("({text})")),
        Verdict::Agree => text.to_owned(),
        Verdict::Warn => console.paint(Tone::Warn, text),
        Verdict::Fail => console.paint(Tone::Bad, text),
    }
}

/// Legend of the columns, and totals.
fn closing(report: &Report, console: &Console) -> String {
    let Tolerances { cost, errors, curve, .. } = report.tolerances;
    let count = |verdict| report.channels().filter(|channel| channel.verdict == verdict).count();
    let costs: Vec<f64> = report
        .channels()
        .flat_map(|channel| channel.costs)
        .filter(|cost| cost.judged)
        .map(|cost| cost.relative)
        .collect();
    let largest = costs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let smallest = costs.iter().copied().fold(f64::INFINITY, f64::min);
    let above = costs.iter().filter(|&&relative| relative > cost.warn).count();
    let brackets = if report.channels().any(|channel| channel.curves.iter().any(|curve| !curve.judged)) {
        "In brackets: not compared, because an earlier step differs.\n"
    } else {
        ""
    };
    let legend = format!(
        "Differences (ours - reference) / reference; warn and fail: costs {:e} and {:e}{}, E, L, C {:e} and {:e},\n\
         root mean square of a curve {:e} and {:e}.\n{brackets}",
        cost.warn,
        cost.fail,
        if report.tolerances.two_sided { " on both sides" } else { " above the reference" },
        errors.warn,
        errors.fail,
        curve.warn,
        curve.fail,
    );
    format!(
        "{}{} materials, {} channels: {} agree, {} warn, {} fail.\n\
         Costs: {} to {} of the reference's, {above} of {} above it by more than {:e}.\n",
        console.paint(Tone::Dim, &legend),
        report.materials.len(),
        report.channels().count(),
        count(Verdict::Agree),
        count(Verdict::Warn),
        count(Verdict::Fail),
        signed(smallest),
        signed(largest),
        costs.len(),
        cost.warn,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::cli::{Cli, Command};
    use clap::Parser;

    fn names(pairs: &[Pair]) -> Vec<(String, String)> {
        let name = |path: &Path| path.file_name().unwrap().to_string_lossy().into_owned();
        pairs.iter().map(|pair| (name(&pair.ours), name(&pair.reference))).collect()
    }

    #[test]
    fn folders_are_paired_by_name_and_summaries_left_out() {
        let (ours, reference) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        for name in ["b.json", "a.json", "summary.json", "summary.1-of-2.json", "a.svg", ".x.json"] {
            fs::write(ours.path().join(name), "{}").unwrap();
        }
        for name in ["b.json", "c.json"] {
            fs::write(reference.path().join(name), "{}").unwrap();
        }
        let pairs = pairs(ours.path(), reference.path()).unwrap();
        let expected = ["a.json", "b.json", "c.json"].map(|name| (name.to_owned(), name.to_owned()));
        assert_eq!(names(&pairs), expected);
        let missing = pairs[2].compare(&Tolerances::default()).unwrap_err();
        assert_eq!(Outcome::of(&missing.into()), Outcome::InputOutput);
    }

    #[test]
    fn a_folder_and_a_file_are_no_pair() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("x.json");
        fs::write(&file, "{}").unwrap();
        assert!(pairs(folder.path(), &file).err().unwrap().to_string().contains("name two files or two folders"));
        assert!(pairs(&file, folder.path()).err().unwrap().to_string().contains("name two files or two folders"));
        let (a, b) = (folder.path().join("a"), folder.path().join("b"));
        fs::create_dir(&a).unwrap();
        fs::create_dir(&b).unwrap();
        assert!(pairs(&a, &b).err().unwrap().to_string().contains("contains a fit result"));
        let nowhere = pairs(&a, &folder.path().join("c")).err().unwrap();
        assert_eq!(Outcome::of(&nowhere.into()), Outcome::InputOutput);
    }

    #[test]
    fn the_defaults_are_those_of_the_library() {
        let cli = Cli::try_parse_from(["brdfit", "compare", "a", "b"]).unwrap();
        let Command::Compare(args) = cli.command else { panic!() };
        assert_eq!(tolerances(&args).unwrap(), Tolerances::default());
        let cli = Cli::try_parse_from(["brdfit", "compare", "a", "b", "--cost-warn", "1"]).unwrap();
        let Command::Compare(args) = cli.command else { panic!() };
        assert!(tolerances(&args).unwrap_err().to_string().contains("--cost-warn 1 exceeds --cost-fail 0.0001"));
    }
}
