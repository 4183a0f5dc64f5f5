//! The one font of every picture: Ubuntu Light, bundled by the `epaint_default_fonts` crate (Ubuntu Font Licence 1.0).

use std::sync::OnceLock;

use plotters::style::{FontStyle, register_font};

use super::PlotError;

/// The family's name in plotters' registry.
pub(super) const FAMILY: &str = "reseflow";

/// Registers the font; only the first call does anything.
pub(super) fn register() -> Result<(), PlotError> {
    static REGISTERED: OnceLock<bool> = OnceLock::new();
    let font = epaint_default_fonts::UBUNTU_LIGHT;
    let registered = REGISTERED.get_or_init(|| register_font(FAMILY, FontStyle::Normal, font).is_ok());
    if *registered { Ok(()) } else { Err(PlotError::new("text", "the bundled font cannot be read")) }
}
