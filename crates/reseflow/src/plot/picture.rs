//! A picture as a list of marks, drawn by plotters as pixels or as SVG: what is laid out once looks the same in both.

use image::{RgbImage, imageops};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::{PlotError, encode_png, font};

/// A colour, sRGB.
pub use plotters::style::RGBColor as Ink;

/// Text and axes; a dark page turns it light.
pub const INK: Ink = RGBColor(0, 0, 0);
/// Remarks and ticks; a dark page turns it lighter.
pub const GREY: Ink = RGBColor(89, 89, 89);
/// Grid lines; a dark page turns it dark.
pub const GRID: Ink = RGBColor(225, 225, 225);
/// The background; a dark page leaves it out.
pub const PAPER: Ink = RGBColor(255, 255, 255);

/// Backend units for one of a picture's, whose coordinates are whole numbers.
const FINENESS: f64 = 4.0;
/// By how much of its size a bitmap's text is lowered: plotters centres its box there, which has more room above than below the
/// letters, and in SVG the letters themselves.
const LOWERED: f64 = 0.13;
/// How many of these make a pixel of a bitmap, a side: what smooths its edges.
const SMOOTHING: u32 = 2;

/// What a line looks like.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Dash {
    /// Unbroken.
    Solid,
    /// Dashes.
    Dashed,
    /// Dots.
    Dotted,
    /// No line at all, where markers say everything.
    Absent,
}

/// A line's colour, width and dashes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stroke {
    /// The colour.
    pub ink: Ink,
    /// The width.
    pub width: f64,
    /// The dashes.
    pub dash: Dash,
}

impl Stroke {
    /// An unbroken line.
    pub fn solid(ink: Ink, width: f64) -> Self {
        Self { ink, width, dash: Dash::Solid }
    }
}

/// How a text stands at its place.
#[derive(Debug, Clone, Copy)]
pub struct Lettering {
    size: f64,
    ink: Ink,
    side: Side,
    upright: bool,
}

#[derive(Debug, Clone, Copy)]
enum Side {
    About,
    After,
    Before,
}

impl Lettering {
    /// Text of this size, centred about its place.
    pub fn sized(size: f64) -> Self {
        Self { size, ink: INK, side: Side::About, upright: true }
    }

    /// In this colour.
    pub fn ink(self, ink: Ink) -> Self {
        Self { ink, ..self }
    }

    /// To the right of its place.
    pub fn from_left(self) -> Self {
        Self { side: Side::After, ..self }
    }

    /// To the left of its place.
    pub fn up_to(self) -> Self {
        Self { side: Side::Before, ..self }
    }

    /// Read from below.
    pub fn turned(self) -> Self {
        Self { upright: false, ..self }
    }
}

#[derive(Debug, Clone)]
enum Mark {
    Line { points: Vec<(f64, f64)>, stroke: Stroke },
    Area { points: Vec<(f64, f64)>, ink: Ink, opacity: f64 },
    Disc { centre: (f64, f64), radius: f64, ink: Ink, opacity: f64 },
    Text { at: (f64, f64), text: String, lettering: Lettering },
}

/// Marks on white paper; x to the right, y down.
#[derive(Debug, Clone)]
pub struct Picture {
    title: String,
    size: (f64, f64),
    marks: Vec<Mark>,
}

impl Picture {
    /// Empty paper; the title is what errors and screen readers call it.
    pub fn new(title: &str, width: f64, height: f64) -> Self {
        Self { title: title.to_owned(), size: (width, height), marks: Vec::new() }
    }

    /// What it is called.
    pub fn title(&self) -> &str {
        &self.title
    }

    /// Width and height.
    pub fn size(&self) -> (f64, f64) {
        self.size
    }

    /// A line through `points`.
    pub fn line(&mut self, points: impl IntoIterator<Item = (f64, f64)>, stroke: Stroke) {
        self.marks.push(Mark::Line { points: points.into_iter().collect(), stroke });
    }

    /// The area inside `points`.
    pub fn area(&mut self, points: impl IntoIterator<Item = (f64, f64)>, ink: Ink, opacity: f64) {
        self.marks.push(Mark::Area { points: points.into_iter().collect(), ink, opacity });
    }

    /// A rectangle.
    pub fn rectangle(&mut self, (left, top): (f64, f64), (width, height): (f64, f64), ink: Ink) {
        let (right, bottom) = (left + width, top + height);
        self.area([(left, top), (right, top), (right, bottom), (left, bottom)], ink, 1.0);
    }

    /// A disc.
    pub fn disc(&mut self, centre: (f64, f64), radius: f64, ink: Ink, opacity: f64) {
        self.marks.push(Mark::Disc { centre, radius, ink, opacity });
    }

    /// A text about `at`.
    pub fn text(&mut self, at: (f64, f64), text: impl Into<String>, lettering: Lettering) {
        self.marks.push(Mark::Text { at, text: text.into(), lettering });
    }

    /// The picture as pixels.
    ///
    /// # Errors
    /// When the drawing library fails.
    pub fn image(&self) -> Result<RgbImage, PlotError> {
        let size = self.backend_size();
        let mut pixels = vec![255; (size.0 * size.1 * 3) as usize];
        self.paint(BitMapBackend::with_buffer(&mut pixels, size), LOWERED)?;
        let image = RgbImage::from_raw(size.0, size.1, pixels)
            .ok_or_else(|| PlotError::new(&self.title, "the buffer has the wrong size"))?;
        Ok(imageops::thumbnail(&image, size.0 / SMOOTHING, size.1 / SMOOTHING))
    }

    /// The picture as a PNG file.
    ///
    /// # Errors
    /// When the drawing library or the encoder fails.
    pub fn png(&self) -> Result<Vec<u8>, PlotError> {
        encode_png(&self.image()?, &self.title)
    }

    /// The picture as an SVG file, with its texts as texts.
    ///
    /// # Errors
    /// When the drawing library fails.
    pub fn svg(&self) -> Result<String, PlotError> {
        let mut svg = String::new();
        self.paint(SVGBackend::with_string(&mut svg, self.backend_size()), 0.0)?;
        // The bundled font is not on the reader's machine; these are as wide.
        let family = format!("\"{}\"", font::FAMILY);
        let svg = svg.replace(&family, "\"Ubuntu, 'Segoe UI', Roboto, 'Helvetica Neue', Arial, sans-serif\"");
        let (width, height) = self.backend_size();
        let printed = format!("width=\"{width}\" height=\"{height}\"");
        Ok(svg.replacen(&printed, &format!("width=\"{}\" height=\"{}\"", self.size.0, self.size.1), 1))
    }

    fn backend_size(&self) -> (u32, u32) {
        // Whole pixels in the bitmap, so an even number of backend units.
        let units = |length: f64| ((FINENESS * length).round().max(1.0) as u32).next_multiple_of(SMOOTHING);
        (units(self.size.0), units(self.size.1))
    }

    fn paint<B: DrawingBackend>(&self, backend: B, lowered: f64) -> Result<(), PlotError> {
        font::register()?;
        let area = backend.into_drawing_area();
        let fail = |reason: DrawingAreaErrorKind<B::ErrorType>| PlotError::new(&self.title, reason);
        area.fill(&PAPER).map_err(fail)?;
        self.marks.iter().try_for_each(|mark| mark.paint(&area, lowered)).map_err(fail)?;
        area.present().map_err(fail)
    }
}

fn unit((x, y): (f64, f64)) -> (i32, i32) {
    ((FINENESS * x).round() as i32, (FINENESS * y).round() as i32)
}

fn length(length: f64) -> u32 {
    (FINENESS * length).round().max(1.0) as u32
}

impl Mark {
    fn paint<B: DrawingBackend>(
        &self,
        area: &DrawingArea<B, Shift>,
        lowered: f64,
    ) -> Result<(), DrawingAreaErrorKind<B::ErrorType>> {
        match self {
            Self::Line { points, stroke } => {
                let style = stroke.ink.stroke_width(length(stroke.width));
                let mut pieces = match stroke.dash {
                    Dash::Solid => vec![points.clone()],
                    Dash::Dashed => dashes(points, 7.0, 4.0),
                    Dash::Dotted => dashes(points, 2.0, 3.0),
                    Dash::Absent => Vec::new(),
                }
                .into_iter();
                let path = |piece: Vec<(f64, f64)>| piece.into_iter().map(unit).collect::<Vec<_>>();
                pieces.try_for_each(|piece| area.draw(&PathElement::new(path(piece), style)))
            }
            Self::Area { points, ink, opacity } => {
                let points: Vec<_> = points.iter().map(|&point| unit(point)).collect();
                area.draw(&Polygon::new(points, ink.mix(*opacity).filled()))
            }
            Self::Disc { centre, radius, ink, opacity } => {
                area.draw(&Circle::new(unit(*centre), length(*radius), ink.mix(*opacity).filled()))
            }
            Self::Text { at, text, lettering } => {
                let turn = if lettering.upright { FontTransform::None } else { FontTransform::Rotate270 };
                let horizontal = match lettering.side {
                    Side::About => HPos::Center,
                    Side::After => HPos::Left,
                    Side::Before => HPos::Right,
                };
                let style = (font::FAMILY, FINENESS * lettering.size)
                    .into_font()
                    .transform(turn)
                    .color(&lettering.ink)
                    .pos(Pos::new(horizontal, VPos::Center));
                let (x, y) = *at;
                let drop = lowered * lettering.size;
                let place = if lettering.upright { (x, y + drop) } else { (x + drop, y) };
                area.draw_text(text, &style, unit(place))
            }
        }
    }
}

/// The pieces of a line that are drawn: `on` long, `off` apart, around corners.
fn dashes(points: &[(f64, f64)], on: f64, off: f64) -> Vec<Vec<(f64, f64)>> {
    let mut pieces = Vec::new();
    let mut piece: Vec<(f64, f64)> = points.first().copied().into_iter().collect();
    let (mut drawing, mut left) = (true, on);
    for (from, to) in points.iter().zip(points.iter().skip(1)) {
        let along = (to.0 - from.0, to.1 - from.1);
        let total = along.0.hypot(along.1);
        let mut done = 0.0;
        while total - done > left {
            done += left;
            let corner = (from.0 + along.0 * done / total, from.1 + along.1 * done / total);
            if drawing {
                piece.push(corner);
                pieces.push(std::mem::take(&mut piece));
            } else {
                piece = vec![corner];
            }
            drawing = !drawing;
            left = if drawing { on } else { off };
        }
        left -= total - done;
        if drawing {
            piece.push(*to);
        }
    }
    pieces.extend((piece.len() > 1).then_some(piece));
    pieces
}

/// How wide a text of this size is.
pub fn text_width(text: &str, size: f64) -> f64 {
    let measured = font::register().ok().and_then(|()| {
        let font = (font::FAMILY, FINENESS * size).into_font();
        font.layout_box(text).ok()
    });
    measured
        .map_or(0.5 * size * text.len() as f64, |((left, _), (right, _))| f64::from(right - left) / FINENESS)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture() -> Picture {
        let mut picture = Picture::new("a picture", 80.0, 50.0);
        picture.rectangle((10.0, 10.0), (20.0, 5.0), RGBColor(0, 114, 178));
        picture.line([(0.0, 30.0), (80.0, 30.0)], Stroke { ink: INK, width: 1.0, dash: Dash::Dashed });
        picture.text((40.0, 42.0), "a < b & c", Lettering::sized(12.0));
        picture
    }

    #[test]
    fn a_rectangle_has_its_size_in_pixels_and_in_svg() {
        let image = picture().image().unwrap();
        assert_eq!(image.dimensions(), (160, 100), "two pixels a unit");
        let blue = image.pixels().filter(|pixel| pixel.0 == [0, 114, 178]).count();
        assert!((400..=460).contains(&blue), "20 × 5 units are 400 pixels, got {blue}");
        let svg = picture().svg().unwrap();
        assert!(svg.contains("points=\"40,40 120,40 120,60 40,60 \""), "{svg}");
        assert!(svg.starts_with("<svg width=\"80\" height=\"50\" viewBox=\"0 0 320 200\""), "{svg}");
    }

    #[test]
    fn texts_are_escaped_and_dashes_leave_gaps() {
        let svg = picture().svg().unwrap();
        assert!(svg.contains("a &lt; b &amp; c") && !svg.contains(font::FAMILY), "{svg}");
        let image = picture().image().unwrap();
        let dark = (0..160).filter(|&x| image.get_pixel(x, 60).0[0] < 100).count();
        assert!((70..=130).contains(&dark), "7 of 11 units are drawn: {dark} of 160 pixels");
    }

    #[test]
    fn dashes_go_around_corners_and_keep_their_length() {
        let pieces = dashes(&[(0.0, 0.0), (3.0, 0.0), (3.0, 9.0)], 5.0, 2.0);
        let expected = [vec![(0.0, 0.0), (3.0, 0.0), (3.0, 2.0)], vec![(3.0, 4.0), (3.0, 9.0)]];
        assert_eq!(pieces, expected);
        assert!(dashes(&[(1.0, 1.0)], 5.0, 2.0).is_empty());
    }

    #[test]
    fn a_longer_text_is_wider() {
        assert!(text_width("mean D_geo", 12.0) > 1.5 * text_width("mean", 12.0));
        assert!((text_width("mean", 24.0) - 2.0 * text_width("mean", 12.0)).abs() < 1.0);
    }
}
