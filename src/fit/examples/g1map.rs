//! scratch
use brdfit_fit::*; use brdfit_brdf::*;
fn main(){ for p in [0.0,0.4,0.8,1.2,2.0] { for la in [-6.,-5.,-4.,-3.,-2.5,-2.,-1.5,-1.,-0.5,0.0f64] {
  let c=G1Curve::new(&ShiftedGamma::new(10f64.powf(la),p).unwrap()); let f=fit_g1(&c).unwrap();
  println!("p {p} la {la} lnlam {:.3} theta0 {:.4} lnk {:.3} rms {:.2e} max {:.2e}",f.lambda.ln(),f.theta0,f.k.ln(),f.rms_error,f.max_error);
}}}
