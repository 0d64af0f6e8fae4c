//! The least-squares problems of Moré, Garbow and Hillstrom, "Testing unconstrained optimization software", ACM TOMS 7
//! (1981) 17-41; numbers in brackets are theirs.

use super::Problem;
use super::dual::Dual;

/// (1) A parabolic valley.
pub fn rosenbrock() -> Problem {
    Problem::new("Rosenbrock", 2, &[-1.2, 1.0], |x, r| {
        r[0] = 10.0 * (x[1] - x[0].square());
        r[1] = 1.0 - x[0];
    })
}

/// (2) A second minimum at 48.98.
pub fn freudenstein_roth() -> Problem {
    Problem::new("Freudenstein-Roth", 2, &[0.5, -2.0], |x, r| {
        r[0] = -13.0 + x[0] + ((5.0 - x[1]) * x[1] - 2.0) * x[1];
        r[1] = -29.0 + x[0] + ((x[1] + 1.0) * x[1] - 14.0) * x[1];
    })
}

/// (3) Badly scaled: the solution is about (1e-5, 9.1).
pub fn powell_badly_scaled() -> Problem {
    Problem::new("Powell badly scaled", 2, &[0.0, 1.0], |x, r| {
        r[0] = 1e4 * x[0] * x[1] - 1.0;
        r[1] = (-x[0]).exp() + (-x[1]).exp() - 1.0001;
    })
}

/// (4) Badly scaled: the solution is (1e6, 2e-6).
pub fn brown_badly_scaled() -> Problem {
    Problem::new("Brown badly scaled", 3, &[1.0, 1.0], |x, r| {
        r[0] = x[0] - 1e6;
        r[1] = x[1] - 2e-6;
        r[2] = x[0] * x[1] - 2.0;
    })
}

/// (5) The solution is (3, 1/2).
pub fn beale() -> Problem {
    Problem::new("Beale", 3, &[1.0, 1.0], |x, r| {
        let mut power = Dual::from(1.0);
        for (r, y) in r.iter_mut().zip([1.5, 2.25, 2.625]) {
            power = power * x[1];
            *r = y - x[0] * (1.0 - power);
        }
    })
}

/// (6) A large residual.
pub fn jennrich_sampson() -> Problem {
    Problem::new("Jennrich-Sampson", 10, &[0.3, 0.4], |x, r| {
        for (i, r) in (1..).zip(r) {
            let t = f64::from(i);
            *r = 2.0 + 2.0 * t - ((t * x[0]).exp() + (t * x[1]).exp());
        }
    })
}

/// (7) The solution is (1, 0, 0).
pub fn helical_valley() -> Problem {
    Problem::new("helical valley", 3, &[-1.0, 0.0, 0.0], |x, r| {
        let turn = (x[1] / x[0]).atan() / (2.0 * std::f64::consts::PI);
        let theta = if x[0].value > 0.0 { turn } else { turn + 0.5 };
        r[0] = 10.0 * (x[2] - 10.0 * theta);
        r[1] = 10.0 * ((x[0].square() + x[1].square()).sqrt() - 1.0);
        r[2] = x[2];
    })
}

/// (8) A second infimum, 17.4286, at infinity.
pub fn bard() -> Problem {
    const Y: [f64; 15] = [0.14, 0.18, 0.22, 0.25, 0.29, 0.32, 0.35, 0.39, 0.37, 0.58, 0.73, 0.96, 1.34, 2.10, 4.39];
    Problem::new("Bard", 15, &[1.0, 1.0, 1.0], |x, r| {
        for (i, r) in r.iter_mut().enumerate() {
            let u = (i + 1) as f64;
            let v = 16.0 - u;
            *r = Y[i] - (x[0] + u / (v * x[1] + u.min(v) * x[2]));
        }
    })
}

/// (11) The solution is (50, 25, 3/2).
pub fn gulf() -> Problem {
    Problem::new("Gulf", 20, &[5.0, 2.5, 0.15], |x, r| {
        for (i, r) in (1..).zip(r) {
            let t = f64::from(i) / 100.0;
            let y = 25.0 + (-50.0 * t.ln()).powf(2.0 / 3.0);
            let distance = y - x[1];
            let distance = if distance.value < 0.0 { -distance } else { distance };
            // |y - x2|^x3 = exp(x3 ln |y - x2|), with its derivative in both.
            let (value, power) = (distance.value, x[2].value);
            let raised = value.powf(power);
            let slope = raised * (power / value * distance.slope + value.ln() * x[2].slope);
            let raised = Dual { value: raised, slope };
            *r = (-(raised / x[0])).exp() - t;
        }
    })
}

/// (12) A curve of solutions.
pub fn box_three() -> Problem {
    Problem::new("Box 3D", 10, &[0.0, 10.0, 20.0], |x, r| {
        for (i, r) in (1..).zip(r) {
            let t = 0.1 * f64::from(i);
            let known = (-t).exp() - (-10.0 * t).exp();
            *r = (-t * x[0]).exp() - (-t * x[1]).exp() - x[2] * known;
        }
    })
}

/// (13) The Jacobian is singular at the solution, 0.
pub fn powell_singular() -> Problem {
    Problem::new("Powell singular", 4, &[3.0, -1.0, 0.0, 1.0], |x, r| {
        r[0] = x[0] + 10.0 * x[1];
        r[1] = 5f64.sqrt() * (x[2] - x[3]);
        r[2] = (x[1] - 2.0 * x[2]).square();
        r[3] = 10f64.sqrt() * (x[0] - x[3]).square();
    })
}

/// (14) The solution is (1, 1, 1, 1).
pub fn wood() -> Problem {
    Problem::new("Wood", 6, &[-3.0, -1.0, -3.0, -1.0], |x, r| {
        r[0] = 10.0 * (x[1] - x[0].square());
        r[1] = 1.0 - x[0];
        r[2] = 90f64.sqrt() * (x[3] - x[2].square());
        r[3] = 1.0 - x[2];
        r[4] = 10f64.sqrt() * (x[1] + x[3] - 2.0);
        r[5] = (x[1] - x[3]) / 10f64.sqrt();
    })
}

/// (16) A large residual.
pub fn brown_dennis() -> Problem {
    Problem::new("Brown-Dennis", 20, &[25.0, 5.0, -5.0, -1.0], |x, r| {
        for (i, r) in (1..).zip(r) {
            let t = f64::from(i) / 5.0;
            *r = (x[0] + t * x[1] - t.exp()).square() + (x[2] + x[3] * t.sin() - t.cos()).square();
        }
    })
}

/// (18) Six parameters of exponentials; 13 rows.
pub fn biggs() -> Problem {
    Problem::new("Biggs EXP6", 13, &[1.0, 2.0, 1.0, 1.0, 1.0, 1.0], |x, r| {
        for (i, r) in (1..).zip(r) {
            let t = 0.1 * f64::from(i);
            let y = (-t).exp() - 5.0 * (-10.0 * t).exp() + 3.0 * (-4.0 * t).exp();
            *r = x[2] * (-t * x[0]).exp() - x[3] * (-t * x[1]).exp() + x[5] * (-t * x[4]).exp() - y;
        }
    })
}

/// (19) Eleven parameters.
pub fn osborne_two() -> Problem {
    const Y: [f64; 65] = [
        1.366, 1.191, 1.112, 1.013, 0.991, 0.885, 0.831, 0.847, 0.786, 0.725, 0.746, 0.679, 0.608, 0.655, 0.616, 0.606,
        0.602, 0.626, 0.651, 0.724, 0.649, 0.649, 0.694, 0.644, 0.624, 0.661, 0.612, 0.558, 0.533, 0.495, 0.500, 0.423,
        0.395, 0.375, 0.372, 0.391, 0.396, 0.405, 0.428, 0.429, 0.523, 0.562, 0.607, 0.653, 0.672, 0.708, 0.633, 0.668,
        0.645, 0.632, 0.591, 0.559, 0.597, 0.625, 0.739, 0.710, 0.729, 0.720, 0.636, 0.581, 0.428, 0.292, 0.162, 0.098,
        0.054,
    ];
    let start = [1.3, 0.65, 0.65, 0.7, 0.6, 3.0, 5.0, 7.0, 2.0, 4.5, 5.5];
    Problem::new("Osborne 2", 65, &start, |x, r| {
        for (i, r) in r.iter_mut().enumerate() {
            let t = i as f64 / 10.0;
            *r = Y[i] - x[0] * (-t * x[4]).exp();
            for k in 0..3 {
                *r = *r - x[1 + k] * (-((t - x[8 + k]).square()) * x[5 + k]).exp();
            }
        }
    })
}

/// (20) A polynomial differential equation; ill-conditioned for large n.
pub fn watson(n: usize) -> Problem {
    Problem::new(format!("Watson {n}"), 31, &vec![0.0; n], |x, r| {
        for (i, r) in r.iter_mut().take(29).enumerate() {
            let t = (i + 1) as f64 / 29.0;
            let mut derivative = Dual::from(0.0);
            let mut value = Dual::from(0.0);
            for (j, &x) in x.iter().enumerate() {
                if j > 0 {
                    derivative = derivative + j as f64 * t.powi(j as i32 - 1) * x;
                }
                value = value + t.powi(j as i32) * x;
            }
            *r = derivative - value.square() - 1.0;
        }
        r[29] = x[0];
        r[30] = x[1] - x[0].square() - 1.0;
    })
}

/// (27) Both (a, .., a, a^(1-n)) and (0, .., 0, n + 1) are minima.
pub fn brown_almost_linear(n: usize) -> Problem {
    Problem::new(format!("Brown almost linear {n}"), n, &vec![0.5; n], move |x, r| {
        let sum = x.iter().fold(Dual::from(0.0), |a, &b| a + b);
        let product = x.iter().fold(Dual::from(1.0), |a, &b| a * b);
        for i in 0..n - 1 {
            r[i] = x[i] + sum - (n as f64 + 1.0);
        }
        r[n - 1] = product - 1.0;
    })
}

/// (32) Linear, of full rank.
pub fn linear_full_rank(rows: usize, n: usize) -> Problem {
    Problem::new(format!("linear {rows}x{n}"), rows, &vec![1.0; n], move |x, r| {
        let sum = x.iter().fold(Dual::from(0.0), |a, &b| a + b);
        for (i, r) in r.iter_mut().enumerate() {
            *r = -2.0 * sum / rows as f64 - 1.0;
            if i < n {
                *r = *r + x[i];
            }
        }
    })
}

/// (33) Linear, of rank one.
pub fn linear_rank_one(rows: usize, n: usize) -> Problem {
    Problem::new(format!("rank one {rows}x{n}"), rows, &vec![1.0; n], |x, r| {
        let mut sum = Dual::from(0.0);
        for (j, &x) in x.iter().enumerate() {
            sum = sum + (j + 1) as f64 * x;
        }
        for (i, r) in r.iter_mut().enumerate() {
            *r = (i + 1) as f64 * sum - 1.0;
        }
    })
}

/// (34) Linear, of rank one, with columns and rows of zeros.
pub fn linear_rank_one_zeros(rows: usize, n: usize) -> Problem {
    let name = format!("rank one with zeros {rows}x{n}");
    Problem::new(name, rows, &vec![1.0; n], move |x, r| {
        let mut sum = Dual::from(0.0);
        for (j, &x) in x.iter().enumerate().take(n - 1).skip(1) {
            sum = sum + (j + 1) as f64 * x;
        }
        for (i, r) in r.iter_mut().enumerate() {
            *r = Dual::from(-1.0);
            if i > 0 && i < rows - 1 {
                *r = *r + i as f64 * sum;
            }
        }
    })
}

/// (35) Shifted Chebyshev polynomials averaged over n points.
pub fn chebyquad(n: usize) -> Problem {
    let start: Vec<f64> = (1..=n).map(|j| j as f64 / (n + 1) as f64).collect();
    Problem::new(format!("Chebyquad {n}"), n, &start, move |x, r| {
        r.fill(Dual::from(0.0));
        for &x in x {
            let argument = 2.0 * x - 1.0;
            let (mut before, mut now) = (Dual::from(1.0), argument);
            for r in r.iter_mut() {
                *r = *r + now / n as f64;
                (before, now) = (now, 2.0 * argument * now - before);
            }
        }
        for (i, r) in (1..).zip(r) {
            if i % 2 == 0 {
                *r = *r + 1.0 / f64::from(i * i - 1);
            }
        }
    })
}
