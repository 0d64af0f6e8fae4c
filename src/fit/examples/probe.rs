//! scratch
use brdfit_fit::*;
use brdfit_merl::*;
use rayon::prelude::*;
use std::time::Instant;
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let pos = if args[1] == "edge" { SamplePosition::Edge } else { SamplePosition::Centre };
    let mut opt = FitOptions { sample_position: pos, ..Default::default() };
    if let Ok(c) = std::env::var("FREE") {
        if c == "1" {
            opt.constraint = Constraint::Free;
        }
    }
    let files: Vec<_> = args[2..].iter().map(|f| MerlFile::open(std::path::Path::new(f)).unwrap()).collect();
    let t = Instant::now();
    let slices: Vec<_> = files.iter().map(|f| f.slices(pos)).collect();
    println!("slices {:?}", t.elapsed());
    let t = Instant::now();
    let fits: Vec<_> = slices.par_iter().map(|s| fit_slices(s, &opt).unwrap()).collect();
    println!("fits {:?}", t.elapsed());
    let t = Instant::now();
    let scans: Vec<_> = files.par_iter().map(|f| f.scan()).collect();
    println!("scans {:?}", t.elapsed());
    let t = Instant::now();
    let geo = PanelGeometry::new(files[0].dimensions(), pos);
    println!("geometry {:?}", t.elapsed());
    let t = Instant::now();
    let panels: Vec<_> = files
        .par_iter()
        .zip(&scans)
        .zip(&fits)
        .map(|((f, s), fit)| error_panel(f, s.valid(), &geo, &fit.parameters()).unwrap())
        .collect();
    println!("panels {:?}", t.elapsed());
    let mut e = vec![];
    let mut l = vec![];
    let mut c = vec![];
    let (mut gm, mut gr): (f64, f64) = (0., 0.);
    for ((f, fit), p) in args[2..].iter().zip(&fits).zip(&panels) {
        for ch in 0..3 {
            let x = &fit.channels[ch];
            e.push(p.e[ch]);
            l.push(p.l[ch]);
            c.push(p.c[ch]);
            gm = gm.max(x.derived.g1.max_error);
            gr = gr.max(x.derived.g1.rms_error);
            println!(
                "{} {} cost {:.10e} {:.10e} it {} {} {:?} start {} cond {:?} {:?} E {:.5} L {:.6} C {:.5} a {:.3e} p {:.3} rs {:.3e} f0 {:.3} f1 {:.3} {:?} {:?}",
                f.rsplit('/').next().unwrap(),
                x.name,
                x.steps[0].cost,
                x.steps[1].cost,
                x.steps[0].iterations,
                x.steps[1].iterations,
                x.steps[0].termination,
                x.steps[0].start,
                x.steps[0].condition_number.map(|x| x as u64),
                x.steps[1].condition_number.map(|x| x as u64),
                p.e[ch],
                p.l[ch],
                p.c[ch],
                x.parameters.alpha,
                x.parameters.p,
                x.parameters.rho_s,
                x.parameters.f0,
                x.parameters.f1,
                x.flags,
                x.steps[1].active_bounds
            );
        }
    }
    let med = |v: &mut Vec<f64>| {
        v.sort_by(f64::total_cmp);
        v[v.len() / 2]
    };
    println!(
        "samples {} {} median E {:.4} L {:.5} C {:.5}  g1 rms {gr:.2e} max {gm:.2e}",
        panels[0].samples,
        panels[0].all_cells.samples,
        med(&mut e),
        med(&mut l),
        med(&mut c)
    );
}
