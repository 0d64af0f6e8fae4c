//! Run-time dispatch of loops to the widest vector instructions of the processor.

/// Runs a closure, which the caller marks `#[inline(always)]`, compiled for the processor's vector instructions. The compiler
/// neither reorders sums nor contracts products and sums, so the results are the same bytes on every processor.
#[inline(always)]
pub(crate) fn dispatch_simd(work: impl FnMut()) {
    pulp::Arch::new().dispatch(Work(work));
}

struct Work<F>(F);

impl<F: FnMut()> pulp::WithSimd for Work<F> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(mut self, _: S) {
        (self.0)();
    }
}
