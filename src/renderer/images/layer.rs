//! A named group of channels of an image.

/// A layer of an image: one or more components per pixel under one name.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    name: &'static str,
    planes: Vec<(&'static str, Vec<f32>)>,
}

impl Layer {
    /// A layer of N components per pixel.
    #[must_use]
    pub fn new<const N: usize>(
        name: &'static str,
        components: [&'static str; N],
        pixels: impl Iterator<Item = [f32; N]>,
    ) -> Self {
        let mut planes = components.map(|component| (component, Vec::with_capacity(pixels.size_hint().0)));
        for pixel in pixels {
            planes.iter_mut().zip(pixel).for_each(|((_, plane), value)| plane.push(value));
        }
        Self { name, planes: planes.into() }
    }

    /// A layer of the one component Y, which viewers show in grey.
    #[must_use]
    pub fn scalar(name: &'static str, pixels: impl Iterator<Item = f32>) -> Self {
        Self::new(name, ["Y"], pixels.map(|value| [value]))
    }

    /// The name that its channels share.
    #[must_use]
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// The components in their order, row-major.
    #[must_use]
    pub fn planes(&self) -> &[(&'static str, Vec<f32>)] {
        &self.planes
    }
}
