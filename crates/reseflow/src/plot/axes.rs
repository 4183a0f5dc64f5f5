//! A rectangle with axes: where numbers stand in it, its ticks and its grid.

use super::picture::{GREY, GRID, INK, Lettering, Picture, Stroke, text_width};

/// Size of tick labels.
pub const TICK_SIZE: f64 = 14.0;
/// Size of axis labels.
pub(super) const LABEL_SIZE: f64 = 15.0;

/// How an axis is divided.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// Evenly.
    Linear,
    /// By powers of ten; every value must be positive.
    Log,
}

/// One axis: its range and what is written along it.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// What it measures, with its unit.
    pub label: String,
    scale: Scale,
    low: f64,
    high: f64,
    ticks: Vec<(f64, String)>,
}

impl Axis {
    /// An axis from `low` to `high` with ticks at round numbers.
    pub fn new(label: &str, scale: Scale, low: f64, high: f64) -> Self {
        let ticks = match scale {
            Scale::Linear => linear_ticks(low, high),
            Scale::Log => log_ticks(low, high),
        };
        Self { label: label.to_owned(), scale, low, high, ticks }
    }

    /// With ticks at these values, in their own words.
    pub fn with_ticks(self, ticks: Vec<(f64, String)>) -> Self {
        Self { ticks, ..self }
    }

    /// With ticks at these numbers.
    pub fn ticked_at(self, values: &[f64]) -> Self {
        self.with_ticks(values.iter().map(|&value| (value, plain(value))).collect())
    }

    /// Where `value` lies: 0 at the low end, 1 at the high one.
    pub fn share(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Linear => (value - self.low) / (self.high - self.low),
            Scale::Log => {
                let value = if value > 0.0 { value } else { self.low };
                (value / self.low).ln() / (self.high / self.low).ln()
            }
        }
    }

    /// The labelled values.
    pub fn ticks(&self) -> &[(f64, String)] {
        &self.ticks
    }

    /// Its low end.
    pub fn low(&self) -> f64 {
        self.low
    }
}

/// A rectangle of a picture with two axes.
#[derive(Debug, Clone)]
pub struct Frame {
    /// The upper left corner.
    pub corner: (f64, f64),
    /// Width and height.
    pub size: (f64, f64),
    /// Below it.
    pub x: Axis,
    /// To its left.
    pub y: Axis,
}

impl Frame {
    /// Where a point of the data stands; what is out of range stands on the edge.
    pub fn place(&self, (x, y): (f64, f64)) -> (f64, f64) {
        let (x, y) = (self.x.share(x).clamp(0.0, 1.0), self.y.share(y).clamp(0.0, 1.0));
        (self.corner.0 + x * self.size.0, self.corner.1 + (1.0 - y) * self.size.1)
    }

    /// Draws grid, axes, ticks and labels.
    pub fn draw(&self, picture: &mut Picture) {
        let ((left, top), (width, height)) = (self.corner, self.size);
        let (right, bottom) = (left + width, top + height);
        let grid = Stroke::solid(GRID, 0.75);
        let tick = Lettering::sized(TICK_SIZE).ink(GREY);
        let mut last = f64::NEG_INFINITY;
        for (value, text) in self.x.ticks() {
            let x = self.place((*value, self.y.low)).0;
            picture.line([(x, top), (x, bottom)], grid);
            let half = 0.5 * text_width(text, TICK_SIZE);
            if x - half > last + 3.0 {
                picture.text((x, bottom + 13.0), text, tick);
                last = x + half;
            }
        }
        let mut last = f64::INFINITY;
        for (value, text) in self.y.ticks() {
            let y = self.place((self.x.low, *value)).1;
            picture.line([(left, y), (right, y)], grid);
            if y + 14.0 < last {
                picture.text((left - 6.0, y), text, tick.up_to());
                last = y;
            }
        }
        picture.line([(left, top), (left, bottom), (right, bottom)], Stroke::solid(INK, 1.0));
        let label = Lettering::sized(LABEL_SIZE);
        picture.text((left + 0.5 * width, bottom + 33.0), &self.x.label, label);
        let widths = self.y.ticks().iter().map(|(_, text)| text_width(text, TICK_SIZE));
        let clear = widths.fold(30.0, f64::max) + 18.0;
        picture.text((left - clear, top + 0.5 * height), &self.y.label, label.turned());
    }
}

/// Four to seven multiples of 1, 2 or 5 times a power of ten.
fn linear_ticks(low: f64, high: f64) -> Vec<(f64, String)> {
    let span = high - low;
    if !(span.is_finite() && span > 0.0) {
        return vec![(low, plain(low))];
    }
    let power = 10f64.powf((span / 5.0).log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|digit| digit * power).into_iter().find(|step| span / step <= 6.0);
    let step = step.unwrap_or(10.0 * power);
    let digits = (-step.log10().floor()).clamp(0.0, 9.0) as usize;
    let (first, last) = ((low / step - 1e-9).ceil() as i64, (high / step + 1e-9).floor() as i64);
    (first..=last)
        .map(|index| index as f64 * step)
        .map(|value| (value, format!("{value:.digits$}")))
        .collect()
}

/// Powers of ten, with 2 and 5 times them where there are few.
fn log_ticks(low: f64, high: f64) -> Vec<(f64, String)> {
    if !(low > 0.0 && high > low && high.is_finite()) {
        return vec![(low, plain(low))];
    }
    let decades = (high / low).log10();
    let digits: &[f64] = match decades {
        ..0.5 => &[1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0],
        ..3.2 => &[1.0, 2.0, 5.0],
        _ => &[1.0],
    };
    let (first, last) = (low.log10().floor() as i32, high.log10().ceil() as i32);
    let all = (first..=last).flat_map(|power| digits.iter().map(move |digit| digit * 10f64.powi(power)));
    all.filter(|value| (low * 0.999..=high * 1.001).contains(value))
        .map(|value| (value, plain(value)))
        .collect()
}

/// The number in as few digits as say it.
pub(super) fn plain(value: f64) -> String {
    if value != 0.0 && value.abs() < 1e-4 {
        return format!("{value:.0e}");
    }
    let text = format!("{value:.4}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(axis: &Axis) -> Vec<&str> {
        axis.ticks().iter().map(|(_, text)| text.as_str()).collect()
    }

    #[test]
    fn ticks_stand_at_round_numbers_within_the_range() {
        assert_eq!(
            texts(&Axis::new("", Scale::Linear, 0.0, 0.11)),
            ["0.00", "0.02", "0.04", "0.06", "0.08", "0.10"]
        );
        assert_eq!(texts(&Axis::new("", Scale::Linear, 0.0, 2000.0)), ["0", "500", "1000", "1500", "2000"]);
        assert_eq!(texts(&Axis::new("", Scale::Log, 0.03, 2.0)), ["0.05", "0.1", "0.2", "0.5", "1", "2"]);
        assert_eq!(
            texts(&Axis::new("", Scale::Log, 1e-6, 1.0)),
            ["1e-6", "1e-5", "0.0001", "0.001", "0.01", "0.1", "1"]
        );
    }

    #[test]
    fn a_frame_places_numbers_by_their_scale() {
        let (x, y) = (Axis::new("", Scale::Log, 1.0, 100.0), Axis::new("", Scale::Linear, 0.0, 2.0));
        let frame = Frame { corner: (10.0, 20.0), size: (200.0, 100.0), x, y };
        assert_eq!(frame.place((10.0, 0.5)), (110.0, 95.0), "half-way by powers of ten, a quarter up");
        assert_eq!(frame.place((1e6, -3.0)), (210.0, 120.0), "the edge");
    }
}
