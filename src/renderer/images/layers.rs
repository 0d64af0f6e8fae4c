//! The visible surface as layers of a file.

use crate::geometry::gbuffer::{BACKGROUND, GBuffer};
use crate::images::film::Film;

impl GBuffer {
    /// Adds what it holds to an image: layers `position` (X, Y, Z), `normal` (X, Y, Z), `view` (X, Y, Z), `albedo` (R,
    /// G, B), `uv` (U, V), `depth` (Z) and `material` (Y). In the background all are 0, the depth too, and the material
    /// is -1.
    ///
    /// # Panics
    /// If the image is of another size.
    #[must_use]
    pub fn add_to(&self, film: Film) -> Film {
        let depth =
            self.depth.iter().zip(&self.material).map(|(&z, &material)| [if material == BACKGROUND { 0.0 } else { z }]);
        let material = self.material.iter().map(|&index| if index == BACKGROUND { -1.0 } else { f32::from(index) });
        film.layer("position", ["X", "Y", "Z"], self.position.iter().map(|&p| p.into()))
            .layer("normal", ["X", "Y", "Z"], self.normal.iter().map(|&n| n.into()))
            .layer("view", ["X", "Y", "Z"], self.view.iter().map(|&v| v.into()))
            .layer("albedo", ["R", "G", "B"], self.albedo.iter().copied())
            .layer("uv", ["U", "V"], self.uv.iter().copied())
            .layer("depth", ["Z"], depth)
            .scalar("material", material)
    }

    /// The pixels that show a surface.
    #[must_use]
    pub fn foreground(&self) -> Vec<bool> {
        self.material.iter().map(|&material| material != BACKGROUND).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Vec3;
    use ::exr::prelude::*;

    #[test]
    fn the_background_is_zero_and_its_material_minus_one() {
        let buffer = GBuffer {
            width: 2,
            height: 1,
            pixel_angle: 0.01,
            eye: Vec3::zeros(),
            axes: [Vec3::x(), Vec3::y()],
            position: vec![Vec3::new(1.0, 2.0, 3.0), Vec3::zeros()],
            normal: vec![Vec3::z(), Vec3::zeros()],
            view: vec![Vec3::x(), Vec3::zeros()],
            depth: vec![7.0, f32::INFINITY],
            material: vec![2, BACKGROUND],
            uv: vec![[0.25, 0.5], [0.0; 2]],
            albedo: vec![[0.1, 0.2, 0.3], [0.0; 3]],
        };
        assert_eq!(buffer.foreground(), [true, false]);
        let bytes = buffer.add_to(Film::new(2, 1)).to_exr().unwrap();
        let image = read()
            .no_deep_data()
            .largest_resolution_level()
            .all_channels()
            .first_valid_layer()
            .all_attributes()
            .from_buffered(std::io::Cursor::new(bytes))
            .unwrap();
        let channels = &image.layer_data.channel_data.list;
        let values = |name: &str| -> Vec<f32> {
            channels.iter().find(|channel| channel.name.eq(name)).unwrap().sample_data.values_as_f32().collect()
        };
        assert_eq!(channels.len(), 16);
        assert_eq!(values("depth.Z"), [7.0, 0.0]);
        assert_eq!(values("material.Y"), [2.0, -1.0]);
        assert_eq!(["X", "Y", "Z"].map(|c| values(&format!("position.{c}"))[0]), [1.0, 2.0, 3.0]);
        assert_eq!((values("uv.V"), values("albedo.B")), (vec![0.5, 0.0], vec![0.3, 0.0]));
    }
}
