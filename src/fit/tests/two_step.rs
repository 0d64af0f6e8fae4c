//! The fit as a whole, on slices that are evaluated from known parameters.

use brdfit_brdf::{ChannelModel, Configuration, MaterialParameters, ModelName, SgdParameters};
use brdfit_fit::document::Flag;
use brdfit_fit::{
    Anchor, Constraint, DistributionSharing, FitError, FitOptions, Loss, MaterialFit, Step2Solver, step_costs,
};
use brdfit_measured::{SamplePosition, Slices};

/// The slices of a noise-free measurement: at the edge i = o = h holds exactly, at the centre to the width of half a bin.
fn slices_at(parameters: &MaterialParameters, position: SamplePosition) -> Slices {
    let dimensions = brdfit_measured::Dimensions::HALF_TURN;
    let theta_h: Vec<f64> = (0..90).map(|i| dimensions.theta_h_sample(i, position)).collect();
    let theta_d: Vec<f64> = (0..90).map(|j| dimensions.theta_d_sample(j, position)).collect();
    let models: [Box<dyn ChannelModel>; 3] = [0, 1, 2].map(|c| parameters.channel_model(c));
    let at = |c: usize, tan_square_h: f64, cos_theta_d: f64, cos: f64| {
        models[c].value(&Configuration { tan_square_h, cos_theta_d, cos_theta_i: cos, cos_theta_o: cos })
    };
    let retro = |c: usize, theta: f64| at(c, libm::tan(theta).powi(2), 1.0, libm::cos(theta));
    let mirror = |c: usize, theta: f64| at(c, libm::tan(theta_h[0]).powi(2), libm::cos(theta), libm::cos(theta));
    Slices {
        position,
        measured_h: [0, 1, 2].map(|c| theta_h.iter().map(|&theta| Some(retro(c, theta))).collect()),
        measured_d: [0, 1, 2].map(|c| theta_d.iter().map(|&theta| Some(mirror(c, theta))).collect()),
        cells_h: vec![180; 90],
        cells_d: vec![180; 90],
        theta_h,
        theta_d,
    }
}

fn slices(parameters: &[SgdParameters; 3]) -> Slices {
    slices_at(&(*parameters).try_into().unwrap(), SamplePosition::Edge)
}

fn fit_slices(slices: &Slices, options: &FitOptions) -> Result<MaterialFit, FitError> {
    brdfit_fit::fit_slices(slices, ModelName::Sgd, options)
}

/// A parameter of R, G and B.
fn found(fit: &MaterialFit, name: &str) -> [f64; 3] {
    [0, 1, 2].map(|c| fit.parameters.get(c, name).unwrap())
}

/// Smooth multiplicative disturbance, so that the fits have something left to minimise.
fn disturbed(mut slices: Slices) -> Slices {
    for measured in slices.measured_h.iter_mut().chain(&mut slices.measured_d) {
        for (row, value) in measured.iter_mut().enumerate() {
            *value = value.map(|value| value * (1.0 + 0.1 * libm::sin(0.7 * row as f64)));
        }
    }
    slices
}

const MATERIALS: [SgdParameters; 6] = [
    SgdParameters { rho_d: 0.05, rho_s: 0.3, alpha: 4e-6, p: 0.4, f0: 0.04, f1: 0.0 },
    SgdParameters { rho_d: 0.01, rho_s: 0.2, alpha: 1e-5, p: 0.4, f0: 0.6, f1: 0.1 },
    SgdParameters { rho_d: 0.2, rho_s: 0.1, alpha: 7e-4, p: 1.3, f0: 0.05, f1: -0.02 },
    SgdParameters { rho_d: 0.1, rho_s: 0.5, alpha: 0.02, p: 0.6, f0: 0.3, f1: 0.1 },
    SgdParameters { rho_d: 0.4, rho_s: 0.3, alpha: 0.2, p: 0.1, f0: 0.2, f1: 0.1 },
    SgdParameters { rho_d: 0.3, rho_s: 0.4, alpha: 0.8, p: 1.5, f0: 0.5, f1: 0.2 },
];

fn curves_deviate(fit: &MaterialFit) -> f64 {
    let mut worst: f64 = 0.0;
    for c in 0..3 {
        let pairs = [
            (&fit.slices.measured.theta_h[c], &fit.slices.fitted.theta_h[c], &fit.slices.theta_h),
            (&fit.slices.measured.theta_d[c], &fit.slices.fitted.theta_d[c], &fit.slices.theta_d),
        ];
        for (measured, fitted, angles) in pairs {
            for ((m, f), angle) in measured.iter().zip(fitted).zip(angles) {
                if angle.to_degrees() <= 75.0 {
                    worst = worst.max((f / m.unwrap() - 1.0).abs());
                }
            }
        }
    }
    worst
}

#[test]
fn parameters_come_back_from_chrome_to_felt() {
    for [r, g, b] in [[0, 1, 2], [3, 4, 5]].map(|trio| trio.map(|n: usize| MATERIALS[n])) {
        let truth = [r, g, b];
        let fit = fit_slices(&slices(&truth), &FitOptions::default()).unwrap();
        assert!(curves_deviate(&fit) < 1e-6, "{:.1e}", curves_deviate(&fit));
        for (c, truth) in truth.iter().enumerate() {
            let [rho_d, rho_s, alpha, p] = ["rho_d", "rho_s", "alpha", "p"].map(|name| found(&fit, name)[c]);
            assert!((alpha / truth.alpha - 1.0).abs() < 1e-4, "{alpha} {truth:?}");
            assert!((p - truth.p).abs() < 1e-4 && (rho_d / truth.rho_d - 1.0).abs() < 1e-5);
            assert!((rho_s / truth.rho_s - 1.0).abs() < 1e-3, "{rho_s} {truth:?}");
        }
    }
}

#[test]
fn both_solvers_of_step_2_agree_in_every_constraint() {
    let slices = disturbed(slices(&[MATERIALS[1], MATERIALS[2], MATERIALS[3]]));
    for constraint in [Constraint::Physical, Constraint::NonNegative, Constraint::Free] {
        let with = |step2_solver| {
            fit_slices(&slices, &FitOptions { constraint, step2_solver, ..FitOptions::default() }).unwrap()
        };
        let (exact, lm) = (with(Step2Solver::Convex), with(Step2Solver::LevenbergMarquardt));
        for (a, b) in exact.channels.iter().zip(&lm.channels) {
            assert_eq!(a.steps[0], b.steps[0]);
            assert!((a.steps[1].cost / b.steps[1].cost - 1.0).abs() < 1e-8, "{constraint:?}");
            if constraint == Constraint::Physical {
                let [low, high] = a.derived.fresnel_range;
                // held at every third degree: between them F may pass by a hair
                assert!(low > -2e-3 && high < 1.0 + 2e-3);
            }
        }
    }
}

#[test]
fn looser_constraints_cost_less() {
    let slices = disturbed(slices(&[MATERIALS[1], MATERIALS[2], MATERIALS[4]]));
    let costs = [Constraint::Physical, Constraint::NonNegative, Constraint::Free].map(|constraint| {
        let fit = fit_slices(&slices, &FitOptions { constraint, ..FitOptions::default() }).unwrap();
        fit.channels.map(|channel| channel.steps[1].cost)
    });
    for c in 0..3 {
        assert!(costs[0][c] >= costs[1][c] * (1.0 - 1e-9) && costs[1][c] >= costs[2][c] * (1.0 - 1e-9));
    }
}

#[test]
fn a_joint_distribution_comes_back_and_is_shared() {
    let shared = SgdParameters { alpha: 0.013, p: 0.7, ..MATERIALS[3] };
    let truth = [shared, SgdParameters { rho_d: 0.03, ..shared }, SgdParameters { rho_s: 0.1, f0: 0.8, ..shared }];
    let options = FitOptions { distribution: DistributionSharing::Joint, ..FitOptions::default() };
    let fit = fit_slices(&slices(&truth), &options).unwrap();
    assert!(curves_deviate(&fit) < 1e-6);
    let (alpha, p) = (found(&fit, "alpha"), found(&fit, "p"));
    assert!(alpha[0] == alpha[1] && alpha[1] == alpha[2] && p[0] == p[2]);
    assert!((alpha[0] / 0.013 - 1.0).abs() < 1e-6);
    // on different distributions one shared pair costs more than three
    let mixed = slices(&[MATERIALS[2], MATERIALS[3], MATERIALS[4]]);
    let joint = fit_slices(&mixed, &options).unwrap();
    let own: f64 = fit_slices(&mixed, &FitOptions::default()).unwrap().channels.iter().map(|c| c.steps[0].cost).sum();
    assert!(joint.channels[0].steps[0].cost > own && joint.channels[0].steps[0].cost > 1e-3);
}

#[test]
fn every_loss_and_the_published_procedure_recover_clean_data() {
    let truth = [MATERIALS[2], MATERIALS[3], MATERIALS[4]];
    let slices = slices(&truth);
    for options in [
        FitOptions { loss: Loss::SqrtCos, ..FitOptions::default() },
        FitOptions { loss: Loss::L2, anchor: Anchor::Distribution, ..FitOptions::default() },
        FitOptions::published(ModelName::Sgd),
    ] {
        let fit = fit_slices(&slices, &options).unwrap();
        assert!(curves_deviate(&fit) < 1e-4, "{options:?}: {:.1e}", curves_deviate(&fit));
    }
}

#[test]
fn given_parameters_cost_what_their_own_fit_costs() {
    let truth = [MATERIALS[2], MATERIALS[3], MATERIALS[4]];
    let slices = disturbed(slices(&truth));
    let options = FitOptions { anchor: Anchor::Distribution, ..FitOptions::default() };
    let fit = fit_slices(&slices, &options).unwrap();
    // the parameters of the fit itself: step 1's Fr is not rho_s F(0), so only step 2 is the same problem
    let own = step_costs(&slices, &options, &fit.parameters).unwrap();
    for (costs, channel) in own.iter().zip(&fit.channels) {
        assert!((costs[1] / channel.steps[1].cost - 1.0).abs() < 1e-9, "{} {}", costs[1], channel.steps[1].cost);
    }
    // the true parameters by hand: half the sum of the squared residuals of docs/theory.md, sections 4.1 and 4.3
    let truth_costs = step_costs(&slices, &options, &truth.try_into().unwrap()).unwrap();
    let edges = |bin: usize| (bin as f64 / 90.0).powi(2) * std::f64::consts::FRAC_PI_2;
    let disturbance = |row: usize| 1.0 + 0.1 * libm::sin(0.7 * row as f64);
    for (c, costs) in truth_costs.iter().enumerate() {
        let (mut by_hand, mut step2) = (0.0, 0.0);
        for row in 0..90 {
            let [measured_h, measured_d] =
                [&slices.measured_h, &slices.measured_d].map(|measured| measured[c][row].unwrap());
            let (cos_h, cos_d) = (libm::cos(slices.theta_h[row]), libm::cos(slices.theta_d[row]));
            if slices.theta_h[row] <= 75_f64.to_radians() * (1.0 + 1e-12) {
                let weight = (libm::cos(edges(row)) - libm::cos(edges(row + 1))).powf(0.375);
                let logarithm = |f: f64| (f * cos_h).ln_1p();
                by_hand += (weight * (logarithm(measured_h) - logarithm(measured_h / disturbance(row)))).powi(2);
            }
            if slices.theta_d[row] <= 75_f64.to_radians() * (1.0 + 1e-12) {
                let weight = cos_d / (measured_d * cos_d).max(1e-6).powf(2.0 / 3.0);
                step2 += (weight * (measured_d - measured_d / disturbance(row))).powi(2);
            }
        }
        assert!((costs[0] / (0.5 * by_hand) - 1.0).abs() < 1e-9, "{} {}", costs[0], 0.5 * by_hand);
        assert!((costs[1] / (0.5 * step2) - 1.0).abs() < 1e-9, "{} {}", costs[1], 0.5 * step2);
        assert!(costs[0] > fit.channels[c].steps[0].cost * (1.0 + 1e-6), "the fit is a minimum");
    }
}

#[test]
fn slices_are_fitted_where_their_samples_lie() {
    // the start is so far that the search on the table of another position would end elsewhere
    for position in [SamplePosition::Edge, SamplePosition::Centre] {
        let truth = MaterialParameters::try_from([MATERIALS[2], MATERIALS[3], MATERIALS[4]]).unwrap();
        let slices = slices_at(&truth, position);
        let fit = fit_slices(&slices, &FitOptions::default()).unwrap();
        for channel in &fit.channels {
            let iterations = channel.steps[0].iterations;
            assert!(channel.steps[0].cost < 1e-18, "{position}: {:.1e} after {iterations}", channel.steps[0].cost);
        }
        for c in 0..3 {
            let [ours, theirs] = [&fit.parameters, &truth].map(|parameters| parameters.get(c, "alpha").unwrap());
            assert!((ours / theirs - 1.0).abs() < 1e-5, "{position}: {ours} {theirs}");
        }
    }
}

#[test]
fn every_model_recovers_its_own_parameters() {
    for &model in ModelName::ALL {
        let shapes = FitOptions::new(model).starts;
        let channel = |c: usize| {
            let mut values = vec![[0.05, 0.2, 0.01][c], 0.4];
            // between the starts
            values.extend(shapes[c].iter().map(|value| 0.7 * value));
            values.extend([0.3, 0.05]);
            values
        };
        let truth = MaterialParameters::new(model, [0, 1, 2].map(channel)).unwrap();
        for distribution in [DistributionSharing::PerChannel, DistributionSharing::Joint] {
            let truth = match distribution {
                DistributionSharing::PerChannel => truth.clone(),
                DistributionSharing::Joint => {
                    let values = truth.channel(1).to_vec();
                    MaterialParameters::new(model, [values.clone(), values.clone(), values]).unwrap()
                }
            };
            let options = FitOptions { distribution, ..FitOptions::new(model) };
            let fit = brdfit_fit::fit_slices(&slices_at(&truth, SamplePosition::Edge), model, &options).unwrap();
            assert!(curves_deviate(&fit) < 1e-6, "{model}");
            for c in 0..3 {
                for (parameter, (ours, theirs)) in
                    model.model().parameters().iter().zip(fit.parameters.channel(c).iter().zip(truth.channel(c)))
                {
                    assert!((ours - theirs).abs() < 1e-3 * theirs.abs(), "{model} {}: {ours} {theirs}", parameter.name);
                }
            }
        }
    }
}

#[test]
fn a_flat_slice_is_flagged_and_not_explained() {
    let diffuse = SgdParameters { rho_d: 0.3, rho_s: 0.0, ..MATERIALS[3] };
    let fit = fit_slices(&slices(&[diffuse; 3]), &FitOptions::default()).unwrap();
    for channel in &fit.channels {
        assert!(
            channel.flags.contains(&Flag::NoPeak) && channel.flags.contains(&Flag::NoSpecular),
            "{:?}",
            channel.flags
        );
        let [rho_d, rho_s, f0] = ["rho_d", "rho_s", "f0"].map(|name| channel.parameters.get(name).unwrap());
        assert_eq!((rho_s, f0, channel.derived.fr), (0.0, 0.0, 0.0));
        assert!((rho_d - 0.3).abs() < 1e-6);
    }
    assert!(curves_deviate(&fit) < 1e-6);
}

#[test]
fn a_dip_is_followed_only_without_constraint() {
    // F(0) = -0.05: the slice falls towards theta_h = 0
    let dip = SgdParameters { rho_d: 0.2, rho_s: 0.1, alpha: 0.1, p: 0.0, f0: 0.2, f1: 0.25 };
    let slices = slices(&[dip; 3]);
    let free = fit_slices(&slices, &FitOptions { constraint: Constraint::Free, ..FitOptions::default() }).unwrap();
    assert!(curves_deviate(&free) < 1e-6 && free.channels[0].derived.fr < 0.0);
    assert!(free.channels[0].flags.contains(&Flag::FresnelOutsideUnit));
    let physical = fit_slices(&slices, &FitOptions::default()).unwrap();
    assert!(physical.channels[0].steps[0].cost > free.channels[0].steps[0].cost);
}

#[test]
fn slices_without_enough_rows_are_refused() {
    let mut slices = slices(&[MATERIALS[3]; 3]);
    for channel in &mut slices.measured_h {
        channel.iter_mut().skip(5).for_each(|value| *value = None);
    }
    let error = fit_slices(&slices, &FitOptions::default()).unwrap_err();
    assert!(matches!(error, FitError::FewRows { slice: "theta_h", found: 5, .. }), "{error}");
}

#[test]
fn standard_errors_match_the_scatter_of_noisy_fits() {
    // 1 % independent noise on the rows: the scatter of 60 fits against the mean of the reported errors
    let truth = MATERIALS[3];
    let clean = slices(&[truth; 3]);
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut uniform = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut alphas = Vec::new();
    let mut reported = Vec::new();
    for _ in 0..20 {
        let mut noisy = clean.clone();
        for value in noisy.measured_h.iter_mut().flatten() {
            let normal: f64 = (0..12).map(|_| uniform()).sum::<f64>() - 6.0;
            *value = value.map(|value| value * (1.0 + 0.01 * normal));
        }
        let fit = fit_slices(&noisy, &FitOptions::default()).unwrap();
        for channel in fit.channels {
            alphas.push(channel.parameters.get("alpha").unwrap());
            reported.push(channel.standard_errors.get("alpha").unwrap().unwrap());
        }
    }
    let n = alphas.len() as f64;
    let mean = alphas.iter().sum::<f64>() / n;
    let scatter = (alphas.iter().map(|alpha| (alpha - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
    let error = reported.iter().sum::<f64>() / n;
    println!("alpha {mean:.5}, scatter {scatter:.2e}, reported {error:.2e}");
    // the residual's variance is not the same in all rows, so the formula holds within a factor
    assert!(scatter / error > 0.4 && scatter / error < 2.5);
}
