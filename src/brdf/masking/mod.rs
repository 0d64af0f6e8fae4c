//! Smith's masking: by quadrature, as a curve, as a table, in closed form.

pub(crate) mod closed_form;
pub(crate) mod curve;
#[allow(clippy::module_inception)] // the trait that the others implement
pub(crate) mod masking;
pub(crate) mod smith;
pub(crate) mod table;
