//! A rectangle as seen from points in front of it: its solid angle, and directions uniform over it. Eight points at a time.
//!
//! Source: Urena, Fajardo and King, "An area-preserving parametrization for spherical rectangles", EGSR 2013. The angles between the
//! planes through the edges are written so that single precision keeps what differences of angles near pi would lose.

use wide::f32x8;

/// The rectangle `[x0, x1] x [y0, y1]` of the plane z = -height, seen from the origin.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SeenRectangle {
    /// Above zero.
    height: f32x8,
    x: [f32x8; 2],
    y: [f32x8; 2],
    /// Distances of the corners, `[of x][of y]`.
    corners: [[f32x8; 2]; 2],
}

impl SeenRectangle {
    #[inline(always)]
    pub(crate) fn new(height: f32x8, x: [f32x8; 2], y: [f32x8; 2]) -> Self {
        let corners = x.map(|x| y.map(|y| (x * x + y * y + height * height).sqrt()));
        Self { height, x, y, corners }
    }

    /// The solid angle, steradians: two triangles, each `2 atan2(a.(b x c), abc + (a.b) c + (b.c) a + (c.a) b)` (Van Oosterom and
    /// Strackee 1983). The triple product is that of the edges, so that nothing cancels: within 2e-6 relative at every size, 2e-5 above 5 sr
    /// (test below).
    #[inline(always)]
    pub(crate) fn solid_angle(&self) -> f32x8 {
        let ([x0, x1], [y0, y1], [[r00, r01], [r10, r11]]) = (self.x, self.y, self.corners);
        let volume = self.height * (x1 - x0) * (y1 - y0);
        let square = self.height * self.height;
        let across = x0 * x1 + y0 * y1 + square;
        let triangle = |beside_x: f32x8, beside_y: f32x8, beside: f32x8| {
            let (first, second) = (x0 * beside_x + y0 * beside_y + square, x1 * beside_x + y1 * beside_y + square);
            volume.atan2(r00 * r11 * beside + first * r11 + second * r00 + across * beside)
        };
        (triangle(x1, y0, r10) + triangle(x0, y1, r01)) * 2.0
    }

    /// The place (x, y) on the rectangle of a direction that is uniform in solid angle, from two numbers in [0, 1).
    ///
    /// Below 0.01 sr what is left of the differences is too coarse for single precision.
    #[inline(always)]
    pub(crate) fn place(&self, solid_angle: f32x8, [u, v]: [f32x8; 2]) -> [f32x8; 2] {
        let ([x0, x1], [y0, y1], [[r00, r01], _]) = (self.x, self.y, self.corners);
        let square = self.height * self.height;
        // z of the unit normals of the planes through the edges y = y0 and y = y1
        let [b0, b1] = [-y0, y1].map(|y| y / (y * y + square).sqrt());
        // the solid angle to the left of x is turn - start
        let start = (self.height * x0 * (r00 * y1 - r01 * y0)).atan2(x0 * x0 * y0 * y1 + square * r00 * r01);
        let turn = u * solid_angle + start;
        let (sin, cos) = turn.sin_cos();
        let f = (cos * b0 + b1) / sin;
        let c = (f * f + b0 * b0).sqrt().fast_max(f32x8::ONE);
        // x / height = c_u / sqrt(1 - c_u^2), c_u = sign(f) / sqrt(f^2 + b0^2)
        let magnitude = self.height / (c * c - 1.0).fast_max(f32x8::splat(1e-30)).sqrt();
        let x = (magnitude | (f & f32x8::splat(-0.0))).fast_max(x0).fast_min(x1);
        let distance = (x * x + square).sqrt();
        let [h0, h1] = [y0, y1].map(|y| y / (y * y + distance * distance).sqrt());
        let h = h0 + v * (h1 - h0);
        let y = h * distance / (1.0 - h * h).fast_max(f32x8::splat(1e-30)).sqrt();
        [x, y.fast_max(y0).fast_min(y1)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::sobol;

    /// A rectangle `[x0, x1] x [y0, y1]` below the origin, in double precision.
    #[derive(Clone, Copy, Debug)]
    struct Case {
        height: f64,
        x: [f64; 2],
        y: [f64; 2],
    }

    /// Large and small, above, beside and far away, at a grazing angle, thin.
    const CASES: [Case; 10] = [
        Case { height: 1e-3, x: [-1.0, 1.0], y: [-1.0, 1.0] },
        Case { height: 0.3, x: [-1.0, 1.0], y: [-0.5, 1.5] },
        Case { height: 1.0, x: [-0.5, 0.5], y: [-0.5, 0.5] },
        Case { height: 0.7, x: [0.4, 2.4], y: [0.3, 1.3] },
        Case { height: 0.05, x: [0.2, 3.2], y: [-1.0, 1.0] },
        Case { height: 0.02, x: [0.1, 2.1], y: [-3.0, -0.2] },
        Case { height: 0.4, x: [-4.0, 4.0], y: [0.1, 0.13] },
        Case { height: 5.0, x: [-0.5, 0.5], y: [-0.5, 0.5] },
        Case { height: 6.0, x: [2.0, 3.0], y: [-4.0, -3.0] },
        Case { height: 2.0, x: [-0.1, 0.1], y: [-0.1, 0.1] },
    ];

    impl Case {
        /// The solid angle of the part `[x0, x] x [y0, y]`.
        fn below(&self, [x, y]: [f64; 2]) -> f64 {
            let h = self.height;
            let corner = |x: f64, y: f64| libm::atan2(x * y, h * (x * x + y * y + h * h).sqrt());
            let ([x0, _], [y0, _]) = (self.x, self.y);
            corner(x, y) - corner(x, y0) - corner(x0, y) + corner(x0, y0)
        }

        fn all(&self) -> f64 {
            self.below([self.x[1], self.y[1]])
        }

        fn seen(&self) -> SeenRectangle {
            let single = |x: f64| f32x8::splat(x as f32);
            SeenRectangle::new(single(self.height), self.x.map(single), self.y.map(single))
        }
    }

    #[test]
    fn solid_angles_agree_with_double_precision_at_every_size() {
        let mut worst = 0.0_f64;
        for case in CASES {
            for scale in [1.0, 1e-2, 1e-4, 1e-6] {
                let small = |[a, b]: [f64; 2]| [a, a + (b - a) * scale];
                let case = Case { x: small(case.x), y: small(case.y), ..case };
                // as the single precision numbers are
                let [x, y] = [case.x, case.y].map(|ends| ends.map(|x| f64::from(x as f32)));
                let exact = Case { height: f64::from(case.height as f32), x, y };
                // of small ones the difference of four angles loses digits even in double precision
                let tolerance = if exact.all() > 5.0 { 2e-5 } else { 2e-6 + 1e-15 / exact.all() };
                let error = (f64::from(exact.seen().solid_angle().to_array()[0]) / exact.all() - 1.0).abs();
                assert!(error < tolerance, "{exact:?}: {error}");
                worst = worst.max(if exact.all() > 1e-8 { error } else { 0.0 });
            }
        }
        println!("largest relative error of a solid angle: {worst:.1e}");
    }

    /// What a place divides the solid angle into are the numbers that it was made from.
    #[test]
    fn places_divide_the_solid_angle_as_asked_for() {
        for case in CASES.into_iter().filter(|case| case.all() >= 0.01) {
            let seen = case.seen();
            let mut worst = 0.0_f64;
            for n in 0..4000 {
                let (mut a, mut b) = ([0.0; 8], [0.0; 8]);
                sobol::fill(7, 8 * n, [&mut a, &mut b]);
                let [x, y] = seen.place(seen.solid_angle(), [f32x8::from(a), f32x8::from(b)]);
                for lane in 0..8 {
                    let (x, y) = (f64::from(x.to_array()[lane]), f64::from(y.to_array()[lane]));
                    let left = case.below([x, case.y[1]]) / case.all();
                    worst = worst.max((left - f64::from(a[lane])).abs());
                    // along a line of constant x the solid angle grows as sin(latitude) does
                    let sine = |y: f64| y / (y * y + x * x + case.height * case.height).sqrt();
                    let share = (sine(y) - sine(case.y[0])) / (sine(case.y[1]) - sine(case.y[0]));
                    worst = worst.max((share - f64::from(b[lane])).abs());
                }
            }
            println!("{:.4} sr: largest error of a share {worst:.1e}", case.all());
            assert!(worst < 2e-3, "{case:?}: {worst}");
        }
    }
}
