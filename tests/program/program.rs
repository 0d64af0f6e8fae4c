//! The program under test, a folder to run it in, and measured files to feed it.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

use tempfile::TempDir;

/// A folder of its own in which the program runs.
pub(crate) struct Workplace {
    folder: TempDir,
}

impl Workplace {
    pub(crate) fn new() -> Self {
        // Beside the build, because the files are large and /tmp may be small.
        Self { folder: TempDir::new_in(env!("CARGO_TARGET_TMPDIR")).unwrap() }
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Writes a small file, with the folders that it lies in.
    pub(crate) fn put(&self, name: &str, content: impl AsRef<[u8]>) {
        let path = self.path(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, content).unwrap();
    }

    /// A measured file under another name, without copying it.
    pub(crate) fn link(&self, name: &str, file: &Path) {
        let path = self.path(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        if fs::hard_link(file, &path).is_err() {
            fs::copy(file, &path).unwrap();
        }
    }

    /// The program with arguments that are separated by spaces, in this folder.
    pub(crate) fn command(&self, line: &str) -> Command {
        let mut command = Command::new(assert_cmd::cargo::cargo_bin!("brdfit"));
        command.args(line.split_whitespace()).current_dir(self.folder.path());
        command
    }

    pub(crate) fn run(&self, line: &str) -> Ran {
        Ran::new(self.command(line).output().unwrap())
    }

    /// Runs the program and insists that it ends well.
    pub(crate) fn succeed(&self, line: &str) -> Ran {
        let ran = self.run(line);
        assert_eq!(ran.code, Some(0), "brdfit {line}: {}", ran.stderr);
        ran
    }

    /// Names of everything in a folder, hidden things too.
    pub(crate) fn names(&self, name: &str) -> Vec<String> {
        let mut names: Vec<String> =
            fs::read_dir(self.path(name)).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// Names and contents of the files in a folder, hidden ones too.
    pub(crate) fn files(&self, name: &str) -> BTreeMap<String, Vec<u8>> {
        self.names(name)
            .into_iter()
            .filter(|file| self.path(name).join(file).is_file())
            .map(|file| (file.clone(), fs::read(self.path(name).join(file)).unwrap()))
            .collect()
    }

    pub(crate) fn json(&self, name: &str) -> serde_json::Value {
        serde_json::from_slice(&fs::read(self.path(name)).unwrap()).unwrap()
    }
}

/// How a run ended.
pub(crate) struct Ran {
    pub(crate) code: Option<i32>,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

impl Ran {
    pub(crate) fn new(output: Output) -> Self {
        Self {
            code: output.status.code(),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
        }
    }
}

/// Parameters of three channels that differ in everything, as the program reads them.
pub(crate) const GLOSSY: [[f64; 6]; 3] = [
    [0.05, 0.30, 0.010, 0.40, 0.60, 0.20],
    [0.10, 0.25, 0.020, 0.50, 0.50, 0.30],
    [0.20, 0.20, 0.030, 0.30, 0.40, 0.20],
];
/// A broad lobe.
pub(crate) const ROUGH: [[f64; 6]; 3] =
    [[0.30, 0.10, 0.30, 0.10, 0.50, 0.10], [0.20, 0.10, 0.25, 0.20, 0.45, 0.10], [0.10, 0.10, 0.20, 0.15, 0.40, 0.10]];

/// A result with these parameters (rho_d, rho_s, alpha, p, f0, f1) and nothing else.
pub(crate) fn result(channels: &[[f64; 6]; 3]) -> String {
    let channels = channels.map(|[rho_d, rho_s, alpha, p, f0, f1]| {
        serde_json::json!({"parameters": {
            "rho_d": rho_d, "rho_s": rho_s, "alpha": alpha, "p": p, "f0": f0, "f1": f1
        }})
    });
    serde_json::json!({ "channels": channels }).to_string()
}

/// Two measured files that all tests share: made once by the program itself.
pub(crate) struct Measured {
    pub(crate) glossy: PathBuf,
    pub(crate) rough: PathBuf,
}

pub(crate) fn measured() -> &'static Measured {
    static MADE: OnceLock<(Workplace, Measured)> = OnceLock::new();
    &MADE
        .get_or_init(|| {
            let place = Workplace::new();
            for (name, parameters) in [("glossy", GLOSSY), ("rough", ROUGH)] {
                place.put(&format!("{name}.json"), result(&parameters));
                place.succeed(&format!("synth {name}.json -o {name}.binary"));
            }
            let measured = Measured { glossy: place.path("glossy.binary"), rough: place.path("rough.binary") };
            (place, measured)
        })
        .1
}

/// SplitMix64, for tests that want many different but repeatable numbers.
pub(crate) struct Numbers(pub(crate) u64);

impl Numbers {
    /// The next number in [0, 1).
    pub(crate) fn draw(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let x = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((x ^ (x >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
}
