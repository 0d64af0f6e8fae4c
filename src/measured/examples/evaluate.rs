//! Values of a measured file for pairs of directions, for checks by other programs:
//!
//!     cargo run --release -p brdfit-measured --example evaluate -- FILE < pairs > values
//!
//! Each line of the input holds i (x, y, z) and o (x, y, z), unit vectors with the normal +z; each line of the output f in 1/sr
//! for R, G and B. Samples of MERL files are taken at the edge of their cells.

use std::error::Error;
use std::io::{BufRead, stdin};
use std::path::Path;

use brdfit_brdf::Direction;

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("the file is missing")?;
    let brdf = brdfit_measured::open(Path::new(&path), None)?.brdf()?;
    for line in stdin().lock().lines() {
        let numbers: Vec<f64> = line?.split_whitespace().map(str::parse).collect::<Result<_, _>>()?;
        let [ix, iy, iz, ox, oy, oz] = numbers[..] else { return Err("a line does not hold six numbers".into()) };
        let [r, g, b] = brdf.value(&Direction::new(ix, iy, iz), &Direction::new(ox, oy, oz));
        println!("{r:e} {g:e} {b:e}");
    }
    Ok(())
}
