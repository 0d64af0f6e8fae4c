//! The interface of backends, which render frames.

use crate::frame::error::FrameError;
use crate::frame::input::FrameInput;
use crate::frame::layers::LayerGroup;
use crate::frame::options::RenderOptions;
use crate::frame::statistics::FrameStatistics;
use crate::images::layer::Layer;

/// A rendered frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Outgoing radiance of every pixel of a surface, row-major, in linear sRGB; zeros in the background.
    pub radiance: Vec<[f32; 3]>,
    /// Its statistics.
    pub statistics: FrameStatistics,
}

/// A backend runs the passes of a frame: a processor and its representation of buffers.
pub trait Backend {
    /// An input where the passes read it, and the buffers that they fill.
    type Prepared<'a>;

    /// Makes an input ready: its materials become tables and evaluators, its buffers move to where the passes run.
    fn prepare<'a>(&self, input: FrameInput<'a>) -> Self::Prepared<'a>;

    /// Renders a frame.
    ///
    /// # Errors
    /// [`FrameError::Options`] if options cannot be used.
    fn render(&self, prepared: &mut Self::Prepared<'_>, options: &RenderOptions) -> Result<Frame, FrameError>;

    /// The layers of a group, of the input and of the last frame; none where the mode of the frame left the pass out or no frame has
    /// been rendered.
    fn layers(&self, prepared: &Self::Prepared<'_>, group: LayerGroup) -> Vec<Layer>;
}
