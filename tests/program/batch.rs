//! Batches: bad files in the middle, folders and lists, shards, threads, interruption.

use std::fs;

use crate::program::{Workplace, measured};

/// A folder `in` with good files and, between them, bad ones.
fn mixed() -> Workplace {
    let place = Workplace::new();
    place.link("in/a.binary", &measured().glossy);
    place.put("in/b-empty.binary", "");
    place.link("in/c.binary", &measured().rough);
    place.put("in/d-text.binary", "this is no measurement");
    place.link("in/e.binary", &measured().glossy);
    place.put("in/readme.txt", "not a measured file");
    place
}

#[test]
fn a_batch_goes_on_past_bad_files() {
    let place = mixed();
    let ran = place.run("fit in gone.binary -o out");
    assert_eq!(ran.code, Some(3), "{}", ran.stderr);
    let mut lines: Vec<&str> = ran.stderr.lines().collect();
    assert_eq!(lines.pop(), Some("3 fitted, 3 failed: out/summary.json"));
    lines.sort_unstable();
    assert_eq!(lines.len(), 3, "{}", ran.stderr);
    assert!(lines[0].starts_with("error: gone.binary: no such file"), "{}", ran.stderr);
    assert!(lines[1].starts_with("error: in/b-empty.binary: the file is empty"), "{}", ran.stderr);
    assert!(lines[2].starts_with("error: in/d-text.binary: implausible dimensions"), "{}", ran.stderr);

    let files = place.files("out");
    assert_eq!(place.names("out"), ["a.json", "c.json", "e.json", "summary.csv", "summary.json"]);
    let summary = place.json("out/summary.json");
    let names = |list: &str, member: &str| -> Vec<String> {
        summary[list].as_array().unwrap().iter().map(|row| row[member].as_str().unwrap().to_owned()).collect()
    };
    assert_eq!(names("materials", "name"), ["a", "c", "e"]);
    assert_eq!(names("failures", "input"), ["in/b-empty.binary", "in/d-text.binary", "gone.binary"]);
    assert_eq!(summary["failures"][2]["exit_code"], 2);
    let csv = String::from_utf8(files["summary.csv"].clone()).unwrap();
    assert_eq!(csv.lines().count(), 1 + 3 * 3);
}

#[test]
fn quiet_leaves_the_errors_and_nothing_else() {
    let place = mixed();
    let ran = place.run("fit in/b-empty.binary in/a.binary -o out --quiet --no-panel");
    assert_eq!(ran.code, Some(3));
    assert_eq!((ran.stderr.lines().count(), ran.stdout.as_str()), (1, ""), "{}", ran.stderr);
}

#[test]
fn every_number_of_threads_writes_the_same_bytes() {
    let place = mixed();
    for threads in [1, 2, 3, 8] {
        let ran = place.run(&format!("fit in -o out{threads} --threads {threads} --picture"));
        assert_eq!(ran.code, Some(3), "{}", ran.stderr);
        assert_eq!(place.files("out1"), place.files(&format!("out{threads}")), "{threads} threads");
    }
    assert_eq!(place.files("out1").len(), 3 * 2 + 2);
}

#[test]
fn shards_merge_into_the_summary_of_the_whole() {
    let place = mixed();
    place.run("fit in -o whole --no-panel");
    for shard in [3, 1, 2] {
        place.run(&format!("fit in -o parts --no-panel --shard {shard}/3"));
    }
    assert!(!place.path("parts/summary.json").exists());
    let merged = place.succeed("merge parts");
    assert_eq!(merged.stderr, "3 materials, 2 failures: parts/summary.json\n");
    let parts = place.files("parts");
    for (name, bytes) in place.files("whole") {
        assert!(parts[&name] == bytes, "{name} differs");
    }
    assert_eq!(parts.len(), 5 + 3);

    place.run("fit in -o parts --no-panel --shard 2/3 --loss l2");
    let refused = place.run("merge parts");
    assert_eq!(refused.code, Some(3));
    assert!(refused.stderr.contains("summary.2-of-3.json: program version or options differ"), "{}", refused.stderr);
    fs::copy(place.path("parts/summary.1-of-3.json"), place.path("parts/summary.2-of-3.json")).unwrap();
    assert!(place.run("merge parts").stderr.contains("the material a is in two shards"));
    fs::remove_file(place.path("parts/summary.2-of-3.json")).unwrap();
    assert!(place.run("merge parts").stderr.contains("summary.2-of-3.json is missing; run shard 2/3"));
    place.put("parts/summary.2-of-3.json", "{}");
    assert!(place.run("merge parts").stderr.contains("is not a batch summary"));
}

#[test]
fn inputs_may_be_named_in_any_way() {
    let place = mixed();
    place.put("lists/three", "# relative to this list\n../in/e.binary\n\n../in/a.binary\n../in/c.binary\n");
    place.succeed("fit @lists/three -o a --no-panel");
    place.succeed("fit in/c.binary in/a.binary in/e.binary in/a.binary -o b --no-panel");
    place.link("deep/x/c.binary", &place.path("in/c.binary"));
    place.link("deep/a.binary", &place.path("in/a.binary"));
    place.link("deep/x/y/e.binary", &place.path("in/e.binary"));
    place.succeed("fit deep --recursive -o c --no-panel");
    assert_eq!(place.files("a"), place.files("b"));
    assert_eq!(place.files("a"), place.files("c"));
}

#[test]
fn a_single_document_goes_to_standard_output() {
    let place = mixed();
    let printed = place.succeed("fit in/c.binary");
    assert_eq!(printed.stderr, "");
    place.succeed("fit in/c.binary -o out");
    assert!(place.files("out")["c.json"] == printed.stdout.as_bytes());
}

#[test]
fn an_output_that_cannot_be_written_ends_the_batch_with_one_line() {
    let place = mixed();
    place.put("out/a.json/in-the-way", "");
    let ran = place.run("fit in/a.binary in/c.binary in/e.binary -o out --no-panel --threads 1");
    assert_eq!(ran.code, Some(2), "{}", ran.stderr);
    assert_eq!(ran.stderr, "error: out/a.json: is a folder; name a file with -o\n");
    assert!(!place.path("out/summary.json").exists() && !place.path("out/c.json").exists());
}
