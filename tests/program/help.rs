//! The help as users see it, stored in `tests/snapshots`; `BRDFIT_UPDATE=1 cargo test` refreshes it.

use std::fs;
use std::path::PathBuf;

use crate::program::Workplace;

const COMMANDS: [&str; 12] =
    ["fit", "atlas", "render", "export", "info", "synth", "compare", "merge", "schema", "demo", "completions", "man"];

#[test]
fn the_help_is_as_stored_and_fits_80_columns() {
    let place = Workplace::new();
    let mut lines = vec![("brdfit".to_owned(), "--help".to_owned())];
    lines.extend(COMMANDS.map(|command| (format!("brdfit-{command}"), format!("{command} --help"))));
    for (name, line) in lines {
        let help = place.succeed(&line).stdout;
        for line in help.lines() {
            assert!(line.chars().count() <= 80, "{name}: {line}");
        }
        let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(format!("tests/snapshots/{name}.txt"));
        if std::env::var_os("BRDFIT_UPDATE").is_some() {
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(&path, &help).unwrap();
        }
        let stored = fs::read_to_string(&path).unwrap_or_default();
        assert!(stored == help, "{}: out of date; run the tests with BRDFIT_UPDATE=1. Now:\n{help}", path.display());
    }
}

#[test]
fn the_version_is_that_of_the_package() {
    let place = Workplace::new();
    assert_eq!(place.succeed("--version").stdout, format!("brdfit {}\n", env!("CARGO_PKG_VERSION")));
}

#[test]
fn the_exit_codes_are_documented() {
    let help = Workplace::new().succeed("--help").stdout;
    for code in ["0 ", "1 ", "2 ", "3 ", "4 ", "7 ", "130 "] {
        assert!(help.lines().any(|line| line.trim_start().starts_with(code)), "{code}: {help}");
    }
}

#[test]
fn every_command_has_a_manual_page_and_a_completion() {
    let place = Workplace::new();
    assert!(place.succeed("man").stdout.contains(".TH brdfit 1"));
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let script = place.succeed(&format!("completions {shell}")).stdout;
        assert!(COMMANDS.iter().all(|command| script.contains(command)), "{shell}");
    }
    for command in COMMANDS {
        let page = place.succeed(&format!("man {command}")).stdout;
        assert!(page.contains(&format!("brdfit\\-{command}")), "{page}");
    }
}

#[test]
fn colour_is_used_where_it_is_wanted() {
    let place = Workplace::new();
    let coloured = |line: &str| place.run(line).stderr.contains('\u{1b}');
    assert!(!coloured("fit gone.binary"));
    assert!(coloured("fit gone.binary --color always"));
    assert!(coloured("fit --wrong --color always"));
    assert!(!coloured("fit --wrong --color never"));
    assert!(place.succeed("--color always --help").stdout.contains('\u{1b}'));
}
