//! The interface of passes.

/// A pass of a frame, ready to run: a function from buffers, the fields of the type, to the buffer that it fills.
///
/// Nothing else influences the output, neither what the buffer held before nor the number of threads; so a pass can be run alone on
/// inputs that were recorded, and another implementation be compared with it.
pub(crate) trait Pass {
    /// The buffer that is filled.
    type Output;

    /// Fills `output`, which keeps its memory from one frame to the next.
    fn run(&self, output: &mut Self::Output);
}
