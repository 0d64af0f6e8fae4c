//! What is left when a run is ended from outside, and what the next run makes of it.
#![cfg(unix)]

use std::fs;
use std::os::unix::process::ExitStatusExt;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::program::{Numbers, Workplace, measured};

/// A folder `in` with four materials.
fn four() -> Workplace {
    let place = Workplace::new();
    for name in ["a", "b", "c", "d"] {
        let file = if name < "c" { &measured().glossy } else { &measured().rough };
        place.link(&format!("in/{name}.binary"), file);
    }
    place
}

fn start(place: &Workplace, line: &str) -> Child {
    place.command(line).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
}

fn interrupt(child: &Child) {
    let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(sent.success());
}

fn wait_until(what: &str, mut done: impl FnMut() -> bool) {
    let limit = Instant::now() + Duration::from_secs(60);
    while !done() {
        assert!(Instant::now() < limit, "waited in vain for {what}");
        std::thread::sleep(Duration::from_millis(1));
    }
}

#[test]
fn a_batch_that_is_killed_and_resumed_gives_the_bytes_of_an_undisturbed_one() {
    let place = four();
    let before = Instant::now();
    place.succeed("fit in -o whole --picture");
    let duration = before.elapsed().as_secs_f64();
    let whole = place.files("whole");
    assert_eq!(whole.len(), 4 * 2 + 2);

    let mut numbers = Numbers(20_121);
    let (mut killed, mut span) = (0, duration);
    while killed < 10 {
        let mut child = start(&place, "fit in -o out --picture");
        std::thread::sleep(Duration::from_secs_f64(numbers.draw() * span));
        child.kill().unwrap();
        if child.wait().unwrap().signal().is_some() {
            killed += 1;
            if place.path("out").exists() {
                for (name, bytes) in place.files("out").iter().filter(|(name, _)| !name.ends_with(".tmp")) {
                    assert!(whole[name] == *bytes, "{name} is not whole after kill number {killed}");
                }
            }
            place.succeed("fit in -o out --picture --resume");
            assert!(place.files("out") == whole, "kill number {killed}");
        } else {
            span *= 0.8; // it was done before: the machine is faster now
        }
        let _ = fs::remove_dir_all(place.path("out"));
    }
}

#[test]
fn resume_skips_what_is_done_and_nothing_else() {
    let place = four();
    let kept = |line: &str| -> usize {
        let stderr = place.succeed(&format!("fit in -o out --no-panel --resume {line}")).stderr;
        stderr.split_once('(').map_or(0, |(_, rest)| rest.split(' ').next().unwrap().parse().unwrap())
    };
    let modified = |name: &str| fs::metadata(place.path(name)).unwrap().modified().unwrap();
    assert_eq!(kept(""), 0);
    let (bytes, time) = (place.files("out"), modified("out/a.json"));
    assert_eq!(kept(""), 4);
    assert_eq!(modified("out/a.json"), time, "what is kept is not written");
    assert_eq!(place.files("out"), bytes);

    // other options, and back
    assert_eq!(kept("--loss l2"), 0);
    assert_eq!(kept(""), 0);
    // another input under the same name
    fs::remove_file(place.path("in/a.binary")).unwrap();
    place.link("in/a.binary", &measured().rough);
    assert_eq!(kept(""), 3);
    fs::remove_file(place.path("in/a.binary")).unwrap();
    place.link("in/a.binary", &measured().glossy);
    assert_eq!(kept(""), 3);
    // a document that was cut, changed, emptied, made by another version, lost
    let text = String::from_utf8(bytes["b.json"].clone()).unwrap();
    place.put("out/a.json", &text[..text.len() / 2]);
    place.put("out/b.json", text.replacen("\"rho_d\": ", "\"rho_d\":  ", 1));
    place.put("out/c.json", "");
    place.put("out/d.json", text.replacen("\"program\": \"brdfit ", "\"program\": \"brdfit 0", 1));
    assert_eq!(kept(""), 0);
    fs::remove_file(place.path("out/d.json")).unwrap();
    assert_eq!(kept(""), 3);
    assert_eq!(place.files("out"), bytes);
    // the panel is wanted now
    let stderr = place.succeed("fit in -o out --resume").stderr;
    assert_eq!(stderr, "4 fitted: out/summary.json\n");
}

/// Whole documents in the program's own form, but for the number of channels or of steps.
#[test]
fn resume_does_again_what_has_other_than_three_channels_and_two_steps() {
    let place = four();
    place.succeed("fit in -o out --no-panel");
    let bytes = place.files("out");
    let change = |name: &str, change: fn(&str) -> String| {
        let text = String::from_utf8(bytes[name].clone()).unwrap();
        let (before, list) = text.split_once("\"channels\": [").unwrap();
        let (channels, after) = list.split_once("\n  ]").unwrap();
        let changed = change(channels);
        assert_ne!(changed, channels);
        place.put(&format!("out/{name}"), format!("{before}\"channels\": [{changed}{after}"));
    };
    change("a.json", |_| "]".to_owned());
    change("b.json", |channels| format!("{}\n    }}\n  ]", channels.split_once("\n    },").unwrap().0));
    change("c.json", |channels| {
        let (before, steps) = channels.split_once("\"steps\": [").unwrap();
        format!("{before}\"steps\": []{}\n  ]", steps.split_once("\n      ]").unwrap().1)
    });
    let ran = place.run("fit in -o out --no-panel --resume");
    assert_eq!((ran.code, ran.stderr.as_str()), (Some(0), "4 fitted (1 kept): out/summary.json\n"));
    assert_eq!(place.files("out"), bytes);
}

#[test]
fn an_interrupted_batch_exits_with_130_and_leaves_whole_files_only() {
    let place = four();
    place.succeed("fit in -o whole");
    let whole = place.files("whole");
    let mut child = start(&place, "fit in -o out --threads 1");
    wait_until("the first result", || place.path("out/a.json").exists());
    interrupt(&child);
    let status = child.wait().unwrap();
    let files = place.files("out");
    assert_eq!(status.code(), Some(130), "{files:?}");
    assert!(!files.contains_key("summary.json"));
    for (name, bytes) in &files {
        assert!(whole[name] == *bytes, "{name} is half-written");
    }
}

#[test]
fn an_interrupted_synthesis_leaves_nothing() {
    let place = Workplace::new();
    place.put("x.json", crate::program::result(&crate::program::GLOSSY));
    let mut child = start(&place, "synth x.json -o x.binary --noise 0.1");
    let started = || place.names(".").iter().any(|name| name.starts_with(".brdfit-"));
    wait_until("the temporary file", || started() || place.path("x.binary").exists());
    interrupt(&child);
    let status = child.wait().unwrap();
    assert_eq!(status.code(), Some(130));
    assert_eq!(place.names("."), ["x.json"]);
}

#[test]
fn the_next_run_removes_what_a_killed_one_left() {
    let place = four();
    for name in [".brdfit-aBc123.tmp", ".brdfit-xYz789.tmp", "notes.tmp"] {
        place.put(&format!("out/{name}"), "half a resu");
    }
    place.succeed("fit in/a.binary -o out --no-panel");
    assert_eq!(place.names("out"), ["a.json", "notes.tmp", "summary.csv", "summary.json"]);
}
