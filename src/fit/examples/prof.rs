//! scratch
use brdfit_brdf::*;
use brdfit_fit::*;
use brdfit_merl::*;
use std::time::Instant;
fn cpu() -> f64 {
    let s = std::fs::read_to_string("/proc/self/schedstat").unwrap();
    s.split(' ').next().unwrap().parse::<f64>().unwrap() / 1e6
}
fn main() {
    rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global().unwrap();
    let args: Vec<String> = std::env::args().collect();
    let pos = SamplePosition::Edge;
    let opt = FitOptions::default();
    let files: Vec<_> = args[1..].iter().map(|f| MerlFile::open(std::path::Path::new(f)).unwrap()).collect();
    let slices: Vec<_> = files.iter().map(|f| f.slices(pos)).collect();
    let n = (files.len() * 3) as f64;
    let _ = fit_slices(&slices[0], &opt);
    let t = cpu();
    let fits: Vec<_> = slices.iter().map(|s| fit_slices(s, &opt).unwrap()).collect();
    println!("fit/channel {:.3} ms", (cpu() - t) / n);
    let o1 = FitOptions { starts: vec![[3e-3, 0.4]], ..Default::default() };
    let t = cpu();
    for s in &slices {
        std::hint::black_box(fit_slices(s, &o1).unwrap());
    }
    println!("one start {:.3} ms", (cpu() - t) / n);
    let ps: Vec<_> = fits.iter().flat_map(|f| f.parameters()).collect();
    let t = cpu();
    let curves: Vec<_> = ps.iter().map(|p| G1Curve::new(Sgd::new(*p).unwrap().distribution())).collect();
    println!("curve {:.3} ms", (cpu() - t) / n);
    let t = cpu();
    let mut w = 0f64;
    for c in &curves {
        let f = fit_g1(c).unwrap();
        w = w.max(f.rms_error);
    }
    println!("g1fit {:.3} ms {w:.3e}", (cpu() - t) / n);
    let t = cpu();
    for (c, p) in curves.iter().zip(&ps) {
        for a in [0., 30., 60., 80.0f64] {
            std::hint::black_box(directional_albedo(&Sgd::new(*p).unwrap(), c, a.to_radians()));
        }
    }
    println!("albedo {:.3} ms", (cpu() - t) / n);
    let t = cpu();
    for p in &ps {
        let s = *Sgd::new(*p).unwrap().smith();
        for i in 0..180 {
            std::hint::black_box(s.g1(i as f64 * 0.0087));
        }
    }
    println!("180 g1 {:.3} ms", (cpu() - t) / n);
    let t = cpu();
    let scans: Vec<_> = files.iter().map(|f| f.scan()).collect();
    println!("scan/file {:.3} ms", (cpu() - t) / n * 3.);
    let t = cpu();
    let scans2: Vec<_> = files.iter().map(|f| f.scan()).collect();
    println!("scan/file again {:.3} ms", (cpu() - t) / n * 3.);
    let t = cpu();
    let geo = PanelGeometry::new(files[0].dimensions(), pos);
    println!("geo {:.3} ms", (cpu() - t));
    let t = cpu();
    for ((f, s), fit) in files.iter().zip(&scans).zip(&fits) {
        std::hint::black_box(error_panel(f, s.valid(), &geo, &fit.parameters()).unwrap());
    }
    println!("panel/file {:.3} ms", (cpu() - t) / n * 3.);
    let _ = Instant::now();
    drop(scans2);
}
