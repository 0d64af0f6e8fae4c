//! One octahedral image with a border, so that a bilinear look-up needs no wrapping.

use crate::geometry::octahedral::wrap;
use wide::f32x4;

/// `n x n` texels of four numbers, row-major, in a border of one texel that holds what [`wrap`] says.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LightLevel {
    n: usize,
    texels: Vec<[f32; 4]>,
}

impl LightLevel {
    /// The image of `n x n` texels, row-major.
    pub(crate) fn new(n: usize, inside: &[[f32; 4]]) -> Self {
        let padded = 0..(n + 2) * (n + 2);
        let texel = |k: usize| {
            let [column, row] = wrap(n, (k % (n + 2)) as isize - 1, (k / (n + 2)) as isize - 1);
            inside[row * n + column]
        };
        Self { n, texels: padded.map(texel).collect() }
    }

    /// Texels along a side, without the border.
    pub(crate) fn size(&self) -> usize {
        self.n
    }

    /// A texel inside.
    pub(crate) fn texel(&self, column: usize, row: usize) -> [f32; 4] {
        self.texels[(row + 1) * (self.n + 2) + column + 1]
    }

    /// Means of 2 x 2 texels; `n` must be even.
    pub(crate) fn half(&self) -> Self {
        let half = self.n / 2;
        let mean = |k: usize| {
            let (column, row) = (2 * (k % half), 2 * (k / half));
            let [a, b, c, d] =
                [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(x, y)| f32x4::from(self.texel(column + x, row + y)));
            (((a + b) + (c + d)) * 0.25).to_array()
        };
        Self::new(half, &(0..half * half).map(mean).collect::<Vec<_>>())
    }

    /// Where a place of the square `[-1, 1]^2` lies among the padded texels, along one side: the centre of padded texel k at k.
    #[inline(always)]
    pub(crate) fn position(&self, p: f32) -> f32 {
        let half = self.n as f32 * 0.5;
        (p * half + (half + 0.5)).clamp(0.0, self.n as f32 + 0.5)
    }

    /// Bilinear interpolation at a pair of [`Self::position`]s.
    #[inline(always)]
    pub(crate) fn bilinear(&self, [x, y]: [f32; 2]) -> f32x4 {
        let (column, row) = (x as usize, y as usize);
        self.between(row * (self.n + 2) + column, [x - column as f32, y - row as f32])
    }

    /// Bilinear interpolation between the padded texel of an index and those right of it and below, at offsets in [0, 1).
    #[inline(always)]
    pub(crate) fn between(&self, index: usize, [x, y]: [f32; 2]) -> f32x4 {
        let stride = self.n + 2;
        let texels = &self.texels[index..][..stride + 2];
        let [a, b, c, d] = [texels[0], texels[1], texels[stride], texels[stride + 1]].map(f32x4::from);
        let upper = a + (b - a) * x;
        let lower = c + (d - c) * x;
        upper + (lower - upper) * y
    }

    /// The fourth number of the padded texel of an index.
    #[inline(always)]
    pub(crate) fn fourth(&self, index: usize) -> f32 {
        self.texels[index][3]
    }
}
