//! Pictures of episodes side by side: one row an episode, one column a moment.

use image::{RgbImage, imageops};
use plotters::prelude::*;

use super::{PlotError, font};

const MARGIN_PX: u32 = 12;
const LABEL_PX: u32 = 44;
const TEXT_PX: u32 = 24;
/// Room for a label, however few pictures there are.
const MIN_WIDTH_PX: u32 = 900;

/// A labelled row of equally large pictures.
#[derive(Debug, Clone)]
pub struct StripRow {
    /// Written above the pictures.
    pub label: String,
    /// The pictures, left to right.
    pub images: Vec<RgbImage>,
}

/// Rows of pictures.
#[derive(Debug, Clone, Default)]
pub struct Strip {
    /// The rows, top to bottom.
    pub rows: Vec<StripRow>,
}

impl Strip {
    /// Puts the pictures on one sheet.
    ///
    /// # Errors
    /// When there is no picture, or when the drawing library fails.
    pub fn draw(&self) -> Result<RgbImage, PlotError> {
        const PICTURE: &str = "the episode strip";
        font::register()?;
        let row_width =
            |row: &StripRow| row.images.iter().map(|image| image.width() + MARGIN_PX).sum::<u32>();
        let row_height =
            |row: &StripRow| row.images.iter().map(RgbImage::height).max().unwrap_or(0) + LABEL_PX;
        let pictures = self.rows.iter().map(row_width).max().unwrap_or(0);
        let width = (pictures + MARGIN_PX).max(MIN_WIDTH_PX);
        let height = self.rows.iter().map(row_height).sum::<u32>() + MARGIN_PX;
        if pictures == 0 {
            return Err(PlotError::new(PICTURE, "there is no picture"));
        }
        let mut pixels = vec![255; (width * height * 3) as usize];
        {
            let area = BitMapBackend::with_buffer(&mut pixels, (width, height)).into_drawing_area();
            let mut top = 0;
            for row in &self.rows {
                let style = (font::FAMILY, TEXT_PX).into_font().color(&BLACK);
                let corner = (MARGIN_PX as i32, (top + MARGIN_PX) as i32);
                area.draw_text(&row.label, &style, corner)
                    .map_err(|reason| PlotError::new(PICTURE, reason))?;
                top += row_height(row);
            }
            area.present().map_err(|reason| PlotError::new(PICTURE, reason))?;
        }
        let mut sheet = RgbImage::from_raw(width, height, pixels)
            .ok_or_else(|| PlotError::new(PICTURE, "the buffer has the wrong size"))?;
        let mut top = LABEL_PX;
        for row in &self.rows {
            let mut left = MARGIN_PX;
            for image in &row.images {
                imageops::replace(&mut sheet, image, i64::from(left), i64::from(top));
                left += image.width() + MARGIN_PX;
            }
            top += row_height(row);
        }
        Ok(sheet)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::Rgb;

    #[test]
    fn every_picture_is_whole_and_none_overlaps() {
        let image = |shade| RgbImage::from_pixel(40, 30, Rgb([shade, 10, 10]));
        let rows = [(100, 110), (200, 210)]
            .map(|(a, b)| StripRow { label: "an episode".to_owned(), images: vec![image(a), image(b)] });
        let sheet = Strip { rows: rows.to_vec() }.draw().unwrap();
        for shade in [100, 110, 200, 210] {
            assert_eq!(sheet.pixels().filter(|pixel| pixel.0 == [shade, 10, 10]).count(), 40 * 30);
        }
        assert!(Strip::default().draw().is_err());
    }
}
