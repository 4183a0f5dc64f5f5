//! What tells lines apart: colour, dashes and marker together, so that grey print and colour-blind readers lose nothing.

use super::marker::Marker;
use super::picture::{Dash, GREY, Ink, Picture, Stroke};
use plotters::style::RGBColor;

/// Okabe and Ito's blue, bluish green, vermillion, reddish purple, orange and sky blue, which colour-blind readers tell apart (*Color
/// universal design*, 2008).
pub const PALETTE: [Ink; 6] = [
    RGBColor(0, 114, 178),
    RGBColor(0, 158, 115),
    RGBColor(213, 94, 0),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
];

/// How a line is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Look {
    /// Its colour.
    pub ink: Ink,
    /// Its dashes.
    pub dash: Dash,
    /// What stands at its points.
    pub marker: Option<Marker>,
}

impl Look {
    /// The look of a policy: the first, the second, …. The first one's markers are open, so that the second does not hide them where
    /// both are alike.
    pub fn policy(index: usize) -> Self {
        const MARKERS: [Marker; 5] =
            [Marker::Ring, Marker::Square, Marker::Triangle, Marker::Diamond, Marker::Cross];
        const DASHES: [Dash; 3] = [Dash::Dashed, Dash::Solid, Dash::Dotted];
        Self {
            ink: PALETTE[index % PALETTE.len()],
            dash: DASHES[index % DASHES.len()],
            marker: Some(MARKERS[index % MARKERS.len()]),
        }
    }

    /// An unbroken line without markers, for curves of many points.
    pub fn curve(index: usize) -> Self {
        Self { ink: PALETTE[index % PALETTE.len()], dash: Dash::Solid, marker: None }
    }

    /// The look of what policies are compared with.
    pub fn reference(index: usize) -> Self {
        let (ink, dash) = match index {
            0 => (GREY, Dash::Dotted),
            1 => (PALETTE[3], Dash::Dashed),
            _ => (PALETTE[4], Dash::Dotted),
        };
        Self { ink, dash, marker: None }
    }

    /// A line of this look.
    pub fn stroke(&self, width: f64) -> Stroke {
        Stroke { ink: self.ink, width, dash: self.dash }
    }

    /// A sample of it for a legend, from `left` on, 30 wide.
    pub fn sample(&self, picture: &mut Picture, (left, y): (f64, f64)) {
        picture.line([(left, y), (left + 30.0, y)], self.stroke(2.0));
        if let Some(marker) = self.marker {
            picture.marker((left + 15.0, y), marker, self.ink, 4.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_three_policies_differ_without_colour() {
        let looks = [0, 1, 2].map(Look::policy);
        for (index, look) in looks.iter().enumerate() {
            for other in &looks[..index] {
                assert!(look.dash != other.dash && look.marker != other.marker && look.ink != other.ink);
            }
        }
    }
}
