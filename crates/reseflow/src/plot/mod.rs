//! Pictures as PNG and as SVG, with a font of our own, so that they look the same on a machine without fonts.

mod axes;
mod curves;
mod film;
mod font;
mod labels;
mod line_plot;
mod look;
mod marker;
mod picture;
mod strip;

pub use axes::{Axis, Frame, Scale, TICK_SIZE};
pub use curves::{PredictorCurve, d_geo_against_steps, per_action_error, training_curve};
pub use film::encode_gif;
pub use line_plot::{LEGEND_SIZE, Legend, LinePlot, Panels, Series, TITLE_SIZE};
pub use look::{Look, PALETTE};
pub use marker::Marker;
pub use picture::{Dash, GREY, GRID, INK, Ink, Lettering, PAPER, Picture, Stroke, text_width};
pub use strip::{Strip, StripRow};

use image::RgbImage;

/// An error of the drawing library or of the PNG encoder: never the user's fault.
#[derive(Debug, thiserror::Error)]
#[error("cannot draw {picture}: {reason}")]
pub struct PlotError {
    /// The picture.
    pub picture: String,
    /// What the library said.
    pub reason: String,
}

impl PlotError {
    fn new(picture: &str, reason: impl std::fmt::Debug) -> Self {
        Self { picture: picture.to_owned(), reason: format!("{reason:?}") }
    }
}

/// Encodes `image` as PNG.
///
/// # Errors
/// When the encoder fails.
pub fn encode_png(image: &RgbImage, picture: &str) -> Result<Vec<u8>, PlotError> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    image.write_to(&mut bytes, image::ImageFormat::Png).map_err(|reason| PlotError::new(picture, reason))?;
    Ok(bytes.into_inner())
}
