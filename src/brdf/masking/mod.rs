//! Smith's masking: by quadrature, as a curve, as a table, in closed form.

pub(crate) mod closed_form;
pub(crate) mod curve;
pub(crate) mod smith;
pub(crate) mod table;
