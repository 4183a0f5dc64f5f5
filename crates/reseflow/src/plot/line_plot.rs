//! A plot of lines with labelled axes, bands and reference lines.

use image::RgbImage;
use plotters::coord::Shift;
use plotters::coord::ranged1d::{AsRangedCoord, Ranged, ValueFormatter};
use plotters::prelude::*;

use super::{PlotError, font};

const SIZE_PX: (u32, u32) = (1400, 900);
const TITLE_PX: u32 = 40;
const AXIS_PX: u32 = 32;
const TICK_PX: u32 = 27;

/// Okabe and Ito's palette, which colour-blind readers tell apart (*Color universal design*, 2008).
const PALETTE: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(0, 0, 0),
];

/// How an axis is divided.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// Evenly.
    Linear,
    /// By powers of ten; every value must be positive.
    Log,
}

/// One line.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Its name in the legend.
    pub label: String,
    /// Its points (x, y), in order of x.
    pub points: Vec<(f64, f64)>,
    /// The half-width of a band around it, one for each point.
    pub half_band: Option<Vec<f64>>,
    /// Dashed, for what the others are compared with.
    pub dashed: bool,
}

/// A plot. Axis labels carry the units.
#[derive(Debug, Clone, PartialEq)]
pub struct LinePlot {
    /// Above the plot.
    pub title: String,
    /// Below it.
    pub x_label: String,
    /// To its left.
    pub y_label: String,
    /// How x is divided.
    pub x_scale: Scale,
    /// How y is divided.
    pub y_scale: Scale,
    /// Its lines.
    pub series: Vec<Series>,
}

impl LinePlot {
    /// Draws the plot.
    ///
    /// # Errors
    /// When the drawing library fails, or when there is no point to draw.
    pub fn draw(&self) -> Result<RgbImage, PlotError> {
        font::register()?;
        let (width, height) = SIZE_PX;
        let mut pixels = vec![255; (width * height * 3) as usize];
        let fail = |reason| PlotError { picture: self.title.clone(), reason };
        {
            let area = BitMapBackend::with_buffer(&mut pixels, SIZE_PX).into_drawing_area();
            self.draw_on(&area).map_err(fail)?;
            area.present().map_err(|reason| fail(format!("{reason:?}")))?;
        }
        RgbImage::from_raw(width, height, pixels)
            .ok_or_else(|| fail("the buffer has the wrong size".to_owned()))
    }

    fn draw_on(&self, area: &DrawingArea<BitMapBackend<'_>, Shift>) -> Result<(), String> {
        let bounds = self.bounds().ok_or("there is nothing to draw")?;
        let ((x0, x1), (y0, y1)) = bounds;
        let (x, y) = (x0..x1, y0..y1);
        match (self.x_scale, self.y_scale) {
            (Scale::Linear, Scale::Linear) => self.draw_axes(area, x, y, bounds),
            (Scale::Log, Scale::Linear) => self.draw_axes(area, x.log_scale(), y, bounds),
            (Scale::Linear, Scale::Log) => self.draw_axes(area, x, y.log_scale(), bounds),
            (Scale::Log, Scale::Log) => self.draw_axes(area, x.log_scale(), y.log_scale(), bounds),
        }
    }

    /// The ranges of both axes with some air around the data; a linear y axis starts at zero.
    fn bounds(&self) -> Option<Bounds> {
        let mut low = (f64::INFINITY, f64::INFINITY);
        let mut high = (f64::NEG_INFINITY, f64::NEG_INFINITY);
        for series in &self.series {
            for (index, &(x, y)) in series.points.iter().enumerate() {
                let half = series.half_band.as_ref().and_then(|band| band.get(index)).copied().unwrap_or(0.0);
                let bottom = if self.y_scale == Scale::Log { y } else { y - half };
                low = (low.0.min(x), low.1.min(bottom));
                high = (high.0.max(x), high.1.max(y + half));
            }
        }
        if !(low.0.is_finite() && low.1.is_finite() && high.0.is_finite() && high.1.is_finite()) {
            return None;
        }
        let x = match self.x_scale {
            Scale::Linear if high.0 > low.0 => (low.0, high.0),
            Scale::Linear => (low.0 - 0.5, high.0 + 0.5),
            Scale::Log => (low.0 / 1.15, high.0 * 1.15),
        };
        // Room above the data for the legend: the data fill so much of the height.
        let filled = 1.0 - (34.0 * self.series.len() as f64 + 50.0) / 700.0;
        let y = match self.y_scale {
            Scale::Linear => (low.1.min(0.0), (high.1 / filled).max(1e-9)),
            Scale::Log => (low.1 / 1.3, high.1 * (high.1 / low.1).powf(1.0 / filled - 1.0).max(1.5)),
        };
        Some((x, y))
    }

    fn draw_axes<X, Y>(
        &self,
        area: &DrawingArea<BitMapBackend<'_>, Shift>,
        x: X,
        y: Y,
        bounds: Bounds,
    ) -> Result<(), String>
    where
        X: AsRangedCoord<Value = f64>,
        Y: AsRangedCoord<Value = f64>,
        X::CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>,
        Y::CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>,
    {
        let debug = |reason: DrawingAreaErrorKind<_>| format!("{reason:?}");
        let mut chart = ChartBuilder::on(area)
            .caption(&self.title, (font::FAMILY, TITLE_PX))
            .margin(24)
            .margin_right(40)
            .x_label_area_size(86)
            .y_label_area_size(124)
            .build_cartesian_2d(x, y)
            .map_err(debug)?;
        let x_tick = tick_format(bounds.0, self.x_scale);
        let x_format = |value: &f64| trimmed(&x_tick(value));
        let y_format = tick_format(bounds.1, self.y_scale);
        chart
            .configure_mesh()
            .x_desc(&self.x_label)
            .y_desc(&self.y_label)
            .axis_desc_style((font::FAMILY, AXIS_PX))
            .label_style((font::FAMILY, TICK_PX))
            .x_label_formatter(&x_format)
            .y_label_formatter(&y_format)
            .light_line_style(WHITE)
            .bold_line_style(RGBColor(225, 225, 225))
            .draw()
            .map_err(debug)?;
        for (index, series) in self.series.iter().enumerate() {
            let color = PALETTE[index % PALETTE.len()];
            if let Some(band) = &series.half_band {
                let floor = if self.y_scale == Scale::Log { bounds.1.0 } else { f64::NEG_INFINITY };
                let upper = series.points.iter().zip(band).map(|(&(x, y), half)| (x, y + half));
                let lower =
                    series.points.iter().zip(band).rev().map(|(&(x, y), half)| (x, (y - half).max(floor)));
                let outline: Vec<(f64, f64)> = upper.chain(lower).collect();
                chart.draw_series([Polygon::new(outline, color.mix(0.15))]).map_err(debug)?;
            }
            let style = color.stroke_width(3);
            let points = series.points.iter().copied();
            let drawn = if series.dashed {
                chart.draw_series(DashedLineSeries::new(points, 12, 8, style)).map_err(debug)?
            } else {
                if series.points.len() <= 20 {
                    let dots = series.points.iter().map(|&point| Circle::new(point, 6, color.filled()));
                    chart.draw_series(dots).map_err(debug)?;
                }
                chart.draw_series(LineSeries::new(points, style)).map_err(debug)?
            };
            let dash = if series.dashed { 10 } else { 44 };
            drawn.label(&series.label).legend(move |(x, y)| {
                let first = PathElement::new(vec![(x, y), (x + dash, y)], style);
                let last = PathElement::new(vec![(x + 44 - dash, y), (x + 44, y)], style);
                EmptyElement::at((0, 0)) + first + last
            });
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperRight)
            .legend_area_size(60)
            .margin(16)
            .label_font((font::FAMILY, TICK_PX))
            .background_style(WHITE.mix(0.85))
            .border_style(RGBColor(180, 180, 180))
            .draw()
            .map_err(debug)
    }
}

type Bounds = ((f64, f64), (f64, f64));

/// Tick labels with the digits that the range needs; on a logarithmic axis only 1, 2 and 5 times a power of ten, lest they overlap.
fn tick_format((low, high): (f64, f64), scale: Scale) -> impl Fn(&f64) -> String {
    let span = high - low;
    let digits = if span > 10.0 { 0 } else { (1.5 - span.log10()).ceil().clamp(0.0, 6.0) as usize };
    move |value: &f64| match scale {
        Scale::Linear => format!("{value:.digits$}"),
        Scale::Log => {
            let leading = (value / 10f64.powf(value.log10().floor())).round();
            let text = format!("{value:.6}");
            if [1.0, 2.0, 5.0, 10.0].contains(&leading) { trimmed(&text) } else { String::new() }
        }
    }
}

/// The number without zeros that say nothing.
fn trimmed(number: &str) -> String {
    if number.contains('.') {
        number.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        number.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plot(points: Vec<(f64, f64)>) -> LinePlot {
        LinePlot {
            title: "a title".to_owned(),
            x_label: "steps".to_owned(),
            y_label: "D_geo".to_owned(),
            x_scale: Scale::Log,
            y_scale: Scale::Linear,
            series: vec![Series { label: "a".to_owned(), half_band: None, points, dashed: false }],
        }
    }

    #[test]
    fn draws_ink_on_paper_and_the_same_every_time() {
        let image = plot(vec![(1.0, 0.2), (100.0, 0.1)]).draw().unwrap();
        let ink = image.pixels().filter(|pixel| pixel.0 == [0, 114, 178]).count();
        assert!(ink > 1000, "{ink} pixels of the line's colour");
        let dark = image.pixels().filter(|pixel| pixel.0.iter().all(|&channel| channel < 60)).count();
        assert!(dark > 2000, "{dark} dark pixels of text and axes");
        assert_eq!(image, plot(vec![(1.0, 0.2), (100.0, 0.1)]).draw().unwrap());
    }

    #[test]
    fn a_single_point_is_drawn_and_no_point_is_an_error() {
        assert!(plot(vec![(1.0, 0.2)]).draw().is_ok());
        assert!(plot(Vec::new()).draw().unwrap_err().to_string().contains("a title"));
    }
}
