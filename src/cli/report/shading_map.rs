//! The false-colour map of the shading density of a frame.

use brdfit_figures::panel::{Class, Panel};
use brdfit_figures::scale::{ZERO, colour};
use brdfit_renderer::COARSEST_LEVEL;

/// The panel of the level at which each pixel was shaded, row by row: 0 (bright, single pixels) to the coarsest (dark); any
/// larger number, such as for the background, is grey.
pub(crate) fn panel(levels: &[u8], width: usize) -> Panel {
    let class = |level: usize| {
        let side = 1 << level;
        Class { colour: colour(1.0 - level as f32 / COARSEST_LEVEL as f32), label: format!("{side} x {side}") }
    };
    let classes = (0..=COARSEST_LEVEL).map(class).collect();
    Panel::classes("shaded once per", classes, ZERO, levels, width).note("pixels per cell")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_can_be_told_apart() {
        let panel = panel(&[0, 1, 2, 3, 4, 5, 6, 255], 4);
        let colours: Vec<_> = panel.picture().pixels().copied().collect();
        assert_eq!(panel.picture().dimensions(), (4, 2));
        for k in 0..6 {
            for other in 0..k {
                let apart = (0..3).map(|c| colours[k].0[c].abs_diff(colours[other].0[c])).max().unwrap();
                assert!(apart > 30, "{k} and {other}: {:?} and {:?}", colours[k], colours[other]);
            }
        }
        assert_eq!(colours[6..], [ZERO; 2]);
    }
}
