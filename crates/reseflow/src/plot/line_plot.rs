//! Plots of lines with labelled axes and bands, one or several in a picture under one legend.

use image::RgbImage;

use super::PlotError;
use super::axes::{Axis, Frame, Scale, TICK_SIZE};
use super::labels::beside;
use super::look::Look;
use super::picture::{INK, Lettering, Picture, text_width};

/// Size of titles.
pub const TITLE_SIZE: f64 = 18.5;
/// Size of legends and of the titles of panels.
pub const LEGEND_SIZE: f64 = 15.5;
const MARGIN: f64 = 14.0;
/// Room left of a panel's frame, for its ticks and label.
const LEFT: f64 = 68.0;
const RIGHT: f64 = 16.0;
const BELOW: f64 = 50.0;
const PANEL_TITLE: f64 = 26.0;
const LEGEND_LINE: f64 = 24.0;

/// One line.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Its name in the legend.
    pub label: String,
    /// Its points (x, y), in order of x.
    pub points: Vec<(f64, f64)>,
    /// The lower and the upper end of a band around it, one for each point.
    pub band: Option<Vec<(f64, f64)>>,
    /// What is written beside each point.
    pub names: Option<Vec<String>>,
    /// What tells it from the others.
    pub look: Look,
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
    /// Where x is ticked; round numbers where nothing is said.
    pub x_ticks: Option<Vec<f64>>,
    /// Its lines.
    pub series: Vec<Series>,
}

/// The range of the data: (low, high) of x and of y.
type Bounds = ((f64, f64), (f64, f64));

impl LinePlot {
    /// Draws the plot alone.
    ///
    /// # Errors
    /// When the drawing library fails, or when there is no point to draw.
    pub fn draw(&self) -> Result<RgbImage, PlotError> {
        let panel = Self { title: String::new(), ..self.clone() };
        let alone = Panels {
            title: self.title.clone(),
            columns: 1,
            panel_size: (700.0, 420.0),
            shared_y: false,
            panels: vec![panel],
        };
        alone.picture()?.image()
    }

    /// The ranges of both axes.
    fn bounds(&self) -> Option<Bounds> {
        let mut low = (f64::INFINITY, f64::INFINITY);
        let mut high = (f64::NEG_INFINITY, f64::NEG_INFINITY);
        for series in &self.series {
            for (index, &(x, y)) in series.points.iter().enumerate() {
                let band = series.band.as_ref().and_then(|band| band.get(index));
                let (below, above) = band.copied().unwrap_or((y, y));
                let bottom = if self.y_scale == Scale::Log { y.min(below.max(0.7 * y)) } else { below };
                low = (low.0.min(x), low.1.min(bottom));
                high = (high.0.max(x), high.1.max(above));
            }
        }
        let finite = [low.0, low.1, high.0, high.1].iter().all(|end| end.is_finite());
        finite.then_some(((low.0, high.0), (low.1, high.1)))
    }

    fn frame(&self, corner: (f64, f64), size: (f64, f64), (x, y): Bounds) -> Frame {
        let (x0, x1) = match self.x_scale {
            Scale::Linear if x.1 > x.0 => (x.0 - 0.02 * (x.1 - x.0), x.1 + 0.02 * (x.1 - x.0)),
            Scale::Linear => (x.0 - 0.5, x.0 + 0.5),
            Scale::Log => (x.0 / 1.15, x.1 * 1.15),
        };
        let (y0, y1) = match self.y_scale {
            Scale::Linear => (y.0.min(0.0), (1.06 * y.1).max(1e-9)),
            Scale::Log => (y.0 / 1.25, y.1 * 1.25),
        };
        let x = Axis::new(&self.x_label, self.x_scale, x0, x1);
        let x = match &self.x_ticks {
            Some(values) => x.ticked_at(values),
            None => x,
        };
        Frame { corner, size, x, y: Axis::new(&self.y_label, self.y_scale, y0, y1) }
    }

    fn paint(&self, picture: &mut Picture, frame: &Frame) {
        frame.draw(picture);
        for series in &self.series {
            let Some(band) = &series.band else { continue };
            let ends = || series.points.iter().zip(band);
            let above = ends().map(|((x, _), (_, above))| frame.place((*x, *above)));
            let below = ends().map(|((x, _), (below, _))| frame.place((*x, *below)));
            if band.iter().any(|(below, above)| above > below) && series.points.len() > 1 {
                picture.area(above.chain(below.rev()), series.look.ink, 0.18);
            }
        }
        for series in &self.series {
            let places: Vec<_> = series.points.iter().map(|&point| frame.place(point)).collect();
            if places.len() > 1 {
                picture.line(places.iter().copied(), series.look.stroke(2.0));
            }
            let alone = (places.len() == 1).then_some(super::Marker::Diamond);
            if let Some(marker) = series.look.marker.or(alone) {
                places.iter().for_each(|&place| picture.marker(place, marker, series.look.ink, 4.5));
            }
        }
        self.paint_names(picture, frame);
    }

    /// The names of points, clear of all points.
    fn paint_names(&self, picture: &mut Picture, frame: &Frame) {
        let points = || self.series.iter().flat_map(|series| &series.points);
        let markers: Vec<_> = points().map(|&point| frame.place(point)).collect();
        let named = self.series.iter().flat_map(|series| {
            let names = series.names.iter().flatten();
            series.points.iter().zip(names).map(|(&point, name)| (frame.place(point), name, series.look.ink))
        });
        let named: Vec<_> = named.collect();
        let wanted: Vec<_> =
            named.iter().map(|(place, name, _)| (*place, text_width(name, TICK_SIZE))).collect();
        for ((_, name, ink), place) in named.iter().zip(beside(&wanted, &markers, (frame.corner, frame.size)))
        {
            picture.text(place, *name, Lettering::sized(TICK_SIZE).ink(*ink));
        }
    }
}

/// Plots side by side under one title and one legend.
#[derive(Debug, Clone)]
pub struct Panels {
    /// Above everything.
    pub title: String,
    /// Plots in a row.
    pub columns: usize,
    /// Width and height of each, with its labels.
    pub panel_size: (f64, f64),
    /// Whether all have the same range of y.
    pub shared_y: bool,
    /// The plots.
    pub panels: Vec<LinePlot>,
}

impl Panels {
    /// Lays them out.
    ///
    /// # Errors
    /// When there is no point to draw in one of them.
    pub fn picture(&self) -> Result<Picture, PlotError> {
        let nothing =
            || PlotError { picture: self.title.clone(), reason: "there is nothing to draw".to_owned() };
        let mut bounds: Vec<Bounds> =
            self.panels.iter().map(LinePlot::bounds).collect::<Option<_>>().ok_or_else(nothing)?;
        if self.shared_y {
            let low = bounds.iter().map(|(_, y)| y.0).fold(f64::INFINITY, f64::min);
            let high = bounds.iter().map(|(_, y)| y.1).fold(f64::NEG_INFINITY, f64::max);
            bounds.iter_mut().for_each(|(_, y)| *y = (low, high));
        }
        let columns = self.columns.min(self.panels.len()).max(1);
        let rows = self.panels.len().div_ceil(columns);
        let width = 2.0 * MARGIN + columns as f64 * self.panel_size.0;
        let legend =
            Legend::new(&self.panels.iter().flat_map(|panel| &panel.series).collect::<Vec<_>>(), width);
        let top = 2.0 * MARGIN + TITLE_SIZE + legend.height();
        let height = top + rows as f64 * self.panel_size.1 + MARGIN;
        let mut picture = Picture::new(&self.title, width, height);
        picture.text(
            (MARGIN, MARGIN + 0.5 * TITLE_SIZE),
            &self.title,
            Lettering::sized(TITLE_SIZE).from_left(),
        );
        legend.draw(&mut picture, 1.5 * MARGIN + TITLE_SIZE);
        for (index, (panel, bounds)) in self.panels.iter().zip(bounds).enumerate() {
            let (column, row) = ((index % columns) as f64, (index / columns) as f64);
            let (left, above) = (MARGIN + column * self.panel_size.0, top + row * self.panel_size.1);
            let title = if panel.title.is_empty() { 0.0 } else { PANEL_TITLE };
            let corner = (left + LEFT, above + title + 4.0);
            let size = (self.panel_size.0 - LEFT - RIGHT, self.panel_size.1 - BELOW - title - 4.0);
            let middle = (corner.0 + 0.5 * size.0, above + 0.5 * PANEL_TITLE);
            picture.text(middle, &panel.title, Lettering::sized(LEGEND_SIZE).ink(INK));
            panel.paint(&mut picture, &panel.frame(corner, size, bounds));
        }
        Ok(picture)
    }
}

/// Names beside samples of their looks, in as many lines as they need.
pub struct Legend {
    entries: Vec<(String, Look, (f64, f64))>,
    lines: usize,
}

impl Legend {
    /// The legend of `series`, each name once, in lines at most `width` wide.
    fn new(series: &[&Series], width: f64) -> Self {
        let names = series.iter().map(|series| (series.label.clone(), series.look));
        Self::of(names, width)
    }

    /// The legend of these names.
    pub fn of(names: impl IntoIterator<Item = (String, Look)>, width: f64) -> Self {
        let mut known: Vec<(String, Look)> = Vec::new();
        for (label, look) in names {
            if !known.iter().any(|(other, _)| *other == label) {
                known.push((label, look));
            }
        }
        let widths: Vec<f64> =
            known.iter().map(|(label, _)| 36.0 + text_width(label, LEGEND_SIZE) + 22.0).collect();
        let lines = |places: &[(f64, usize)]| places.last().map_or(0, |(_, line)| line + 1);
        let needed = lines(&broken(&widths, width));
        // As narrow as it goes without another line, so that no line is left nearly empty.
        let narrower = (1..=100).map(|percent| broken(&widths, 0.01 * f64::from(percent) * width));
        let places = narrower.into_iter().find(|places| lines(places) == needed).unwrap_or_default();
        let entries = known.into_iter().zip(places);
        let entries = entries.map(|((label, look), (x, line))| (label, look, (x, line as f64 * LEGEND_LINE)));
        Self { entries: entries.collect(), lines: needed }
    }

    /// How high it is.
    pub fn height(&self) -> f64 {
        self.lines as f64 * LEGEND_LINE
    }

    /// Draws it from `top` down.
    pub fn draw(&self, picture: &mut Picture, top: f64) {
        for (label, look, (x, y)) in &self.entries {
            let y = top + y + 0.5 * LEGEND_LINE;
            look.sample(picture, (*x, y));
            picture.text((x + 36.0, y), label, Lettering::sized(LEGEND_SIZE).from_left());
        }
    }
}

/// Where each of things of these widths begins, and in which line, broken into lines at most `width` wide.
fn broken(widths: &[f64], width: f64) -> Vec<(f64, usize)> {
    let (mut x, mut line) = (MARGIN, 0);
    let place = |wide: &f64| {
        if x + wide > width && x > MARGIN {
            (x, line) = (MARGIN, line + 1);
        }
        let place = (x, line);
        x += wide;
        place
    };
    widths.iter().map(place).collect()
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
            x_ticks: None,
            series: vec![Series {
                label: "a".to_owned(),
                band: None,
                names: None,
                points,
                look: Look::curve(0),
            }],
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
        let image = plot(vec![(1.0, 0.2)]).draw().unwrap();
        assert!(
            image.pixels().filter(|pixel| pixel.0 == [0, 114, 178]).count() > 100,
            "its marker is missing"
        );
        assert!(plot(Vec::new()).draw().unwrap_err().to_string().contains("a title"));
    }

    #[test]
    fn a_legend_takes_as_few_lines_as_it_can_and_fills_them_alike() {
        let names =
            ["one", "two", "three", "four", "five", "six"].map(|name| format!("the policy called {name}"));
        let wide = |name: &String| 58.0 + text_width(name, LEGEND_SIZE);
        let five: f64 = names[..5].iter().map(wide).sum();
        let legend = Legend::of(names.iter().map(|name| (name.clone(), Look::curve(0))), MARGIN + five + 1.0);
        let lines: Vec<f64> = legend.entries.iter().map(|(.., (_, y))| y / LEGEND_LINE).collect();
        assert_eq!((lines, legend.lines), (vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0], 2), "not five and an orphan");
        let one = Legend::of(names[..2].iter().map(|name| (name.clone(), Look::curve(0))), 1000.0);
        assert_eq!((one.lines, one.entries[1].2), (1, (MARGIN + wide(&names[0]), 0.0)));
    }

    #[test]
    fn panels_share_a_range_and_a_legend() {
        let panels = Panels {
            title: "all".to_owned(),
            columns: 2,
            panel_size: (300.0, 200.0),
            shared_y: true,
            panels: vec![plot(vec![(1.0, 0.2), (2.0, 0.1)]), plot(vec![(1.0, 50.0), (2.0, 40.0)])],
        };
        let svg = panels.picture().unwrap().svg().unwrap();
        assert_eq!(svg.matches("\na\n").count(), 1, "one name in the legend: {svg}");
        assert_eq!(svg.matches("\n40\n").count(), 2, "both panels are ticked to the larger range");
    }
}
